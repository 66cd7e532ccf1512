"""The report of a run: one HTML page that needs nothing but itself, on screen and on paper.

`tables` holds what is tabulated, `story` and `claims` what is said in words, `figures` the drawings
with the text that stands in for them, `page` puts them into ``page.mako``, and `writing` writes the
file. `notebook` renders the short form that notebooks show.
"""
