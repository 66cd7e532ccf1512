"""Fixtures of the tests of figures."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

# Made-up results are a plain module beside the tests.
sys.path.insert(0, str(Path(__file__).resolve().parent))


@pytest.fixture(scope="session")
def result():
    """Return a result with a map of 9 × 7 bins, a ladder, a disk's map, and a far field."""
    from made_up import make, rectangle, some_lit, tables

    from photizon_cl.result.stopping import Goal

    scene = tables(
        rectangle(name="target", half_height=0.5, detector={"map": [9, 7], "generations": 1}),
        {"kind": "disk", "axis": "+z", "radius": 0.02, "name": "rim", "detector": {"map": [8, 8]}},
        title="A made-up scene",
        far_field={"n_mu": 10, "n_phi": 8},
    )
    return make(scene, some_lit, goal=Goal(target=0.05))
