"""Makes the shared references importable; where stored files lie."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

_tests = str(Path(__file__).resolve().parents[1])
if _tests not in sys.path:
    sys.path.insert(0, _tests)


@pytest.fixture(scope="session")
def data():
    return Path(_tests) / "data"
