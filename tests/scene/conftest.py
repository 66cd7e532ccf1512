"""Fixtures of the scene tests."""

import pathlib
import sys

# The table of malformed scenes is a plain module beside the tests.
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))

from narrow import four_lanes as four_lanes
