"""A sweep of the tube, run once for the tests that look at it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import photizon_cl as pz

sys.path.insert(0, str(Path(__file__).parent))

from tubes import WIDE, a_sweep


@pytest.fixture(scope="session")
def swept() -> pz.Sweep:
    """Return twelve angles, 0 among them, in memory."""
    return pz.sweep(a_sweep())


@pytest.fixture(scope="session")
def _kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweeps") / "kept"
    pz.sweep(a_sweep(WIDE), out=folder)
    return folder


@pytest.fixture
def kept(_kept: Path, tmp_path: Path) -> Path:
    """Return a copy of the directory of a sweep over three angles."""
    import shutil

    return Path(shutil.copytree(_kept, tmp_path / "kept"))
