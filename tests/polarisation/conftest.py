"""Makes the shared references importable."""

import pathlib
import sys

_tests = str(pathlib.Path(__file__).resolve().parents[1])
if _tests not in sys.path:
    sys.path.insert(0, _tests)

from narrow import four_lanes as four_lanes  # noqa: E402
