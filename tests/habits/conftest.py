"""Fixtures of the tests of what people are used to: names, numbers, files, shells."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from narrow import four_lanes as four_lanes


@pytest.fixture(scope="session")
def room():
    """Return a result of the box room: map, ladder, several elements; 3 batches."""
    import photizon_cl as pz

    return pz.trace("box-room", batches=3, rays_per_batch=2048)
