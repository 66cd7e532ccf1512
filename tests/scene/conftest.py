"""Fixtures of the scene tests."""

import pathlib
import sys

# The table of malformed scenes is a plain module beside the tests.
sys.path.insert(0, str(pathlib.Path(__file__).parent))
