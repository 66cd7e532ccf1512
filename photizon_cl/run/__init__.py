"""Tracing, probing and following rays; stopping, resuming, sharing among workers."""
