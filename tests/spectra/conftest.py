"""Makes the shared references importable."""

import pathlib
import sys

import pytest

_tests = str(pathlib.Path(__file__).resolve().parents[1])
if _tests not in sys.path:
    sys.path.insert(0, _tests)

from narrow import four_lanes as four_lanes  # noqa: E402


@pytest.fixture(autouse=True, scope="module")
def _quickly(built_quickly):
    """Each test has a program or more, for few rays."""
