"""Drawings of a scene with traced ray paths."""
