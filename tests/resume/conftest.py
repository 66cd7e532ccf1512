"""Where stored files lie."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data():
    return Path(__file__).resolve().parents[1] / "data"
