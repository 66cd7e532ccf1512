"""Fixtures of the tests of the public interface."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

# The table of malformed scenes is a plain module beside the tests of the scene layer.
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scene"))
# So are executors that misbehave, and scenes of plates.
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from narrow import four_lanes as four_lanes

QUICK = 2048
"""Rays of a batch where a test asks for bookkeeping and not for accuracy."""


@pytest.fixture(scope="session")
def room():
    """Return a result of the box room: map, ladder, several elements; 10 batches."""
    import photizon_cl as pz

    return pz.trace("box-room", batches=10, rays_per_batch=QUICK)


@pytest.fixture(scope="session")
def sphere():
    """Return a result of the integrating sphere: far field, no detector; 10 batches."""
    import photizon_cl as pz

    return pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK)


@pytest.fixture
def limited(monkeypatch):
    """Return a function that sets what a process may still take; the device has room for all."""
    from dataclasses import replace

    from plates import GB

    from hostcode.device.memory import Room
    from photizon_cl.run import memory

    # what PoCL gives depends on the machine's memory, at times on a part of it
    ample, too_large = {"max_allocation": 1 << 40, "global_memory": 1 << 42}, memory.too_large
    monkeypatch.setattr(memory, "too_large", lambda r, *a: too_large(replace(r, **ample), *a))

    def limit(left):
        found = Room(left, 4 * GB, "`ulimit -v`")
        monkeypatch.setattr(memory, "room", lambda: found)
        return found

    return limit
