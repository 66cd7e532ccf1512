"""Advice before a run: what is valid in a scene and yet probably not meant."""
