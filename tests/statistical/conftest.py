"""Makes the shared references importable."""

import pathlib
import sys

_tests = pathlib.Path(__file__).resolve().parents[1]
for _folder in (str(_tests.parent), str(_tests)):  # scenes of benchmarks, shared references
    if _folder not in sys.path:
        sys.path.insert(0, _folder)
