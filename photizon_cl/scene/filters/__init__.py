"""Filters: what a detector's tallies divide arrivals by. One class a file.

A tally's cells are the product of its filters', the first one changing fastest.
"""
