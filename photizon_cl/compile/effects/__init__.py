"""Effects: the named pieces of physics and bookkeeping that cost time. One class a file.

A scene compiles exactly the effects that it needs. `photizon_cl.compile.effects.table` lists every
one that exists.
"""
