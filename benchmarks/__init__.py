"""Benchmarks of the engine; see README.md in this directory.

Everything here needs numpy, mako and pyopencl only, so that `gpu.py` runs on a bare GPU machine.
"""
