"""A sweep of the tube, run once for the tests that look at it."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import photizon_cl as pz

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tubes import WIDE, a_sweep

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager


@contextmanager
def _narrow() -> Iterator[None]:
    """Do as `one_lane` does, for what is made once for all modules."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hostcode.run.usual.preferred_lanes", lambda *_: 1)
        yield


@pytest.fixture(scope="module", autouse=True)
def _one_lane(one_lane: None) -> None:
    """Have all sweeps of the directory take one lane."""


@pytest.fixture(scope="session")
def swept(quickly: Callable[[], AbstractContextManager[None]]) -> pz.Sweep:
    """Return twelve angles, 0 among them, in memory."""
    with _narrow(), quickly():
        return pz.sweep(a_sweep())


@pytest.fixture(scope="session")
def _kept(
    tmp_path_factory: pytest.TempPathFactory, quickly: Callable[[], AbstractContextManager[None]]
) -> Path:
    folder = tmp_path_factory.mktemp("sweeps") / "kept"
    with _narrow(), quickly():
        pz.sweep(a_sweep(WIDE), out=folder)
    return folder


@pytest.fixture
def kept(_kept: Path, tmp_path: Path) -> Path:
    """Return a copy of the directory of a sweep over three angles."""
    import shutil

    return Path(shutil.copytree(_kept, tmp_path / "kept"))
