"""Makes the shared references, and the benchmarks at the root of the checkout, importable."""

import pathlib
import sys

_tests = pathlib.Path(__file__).resolve().parents[1]
for _folder in (_tests, _tests.parent):
    if str(_folder) not in sys.path:
        sys.path.insert(0, str(_folder))
