"""What the tests of processes, Dask and MPI share."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import pytest

import photizon_cl as pz
from photizon_cl.errors import RunWarning
from photizon_cl.run import window

HERE = Path(__file__).resolve().parent
# What workers are asked, and executors that misbehave, are plain modules.
sys.path[:0] = [str(HERE), str(HERE.parent / "api")]

SCENE = "cosine-fourth"
RAYS = 512
BATCHES = 16


@pytest.fixture(scope="module")
def right():
    """Return what one process gives."""
    return pz.trace(SCENE, batches=BATCHES, rays_per_batch=RAYS)


@pytest.fixture
def two_batches_a_task(monkeypatch):
    monkeypatch.setattr(window, "RAYS_OF_A_TASK", 2 * RAYS)
    monkeypatch.setattr(window, "_QUICK", 0.0)  # which they stay


@pytest.fixture
def traced(two_batches_a_task):
    """Return a function that traces the scene of `right`, and gives the lines that were said."""

    def trace(**how):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            result = pz.trace(SCENE, **{"batches": BATCHES, "rays_per_batch": RAYS, **how})
        return result, [str(w.message) for w in said if issubclass(w.category, RunWarning)]

    return trace
