"""How an OpenCL device runs a compiled scene.

This package knows devices, programs, buffers, waves and exact tallies; it knows nothing of scenes,
elements or statistics, and never imports `photizon_cl`. Importing it touches no OpenCL.
"""
