"""Makes the shared references importable, and breaks the engine."""

from __future__ import annotations

import pathlib
import re
import sys
from typing import TYPE_CHECKING

import pytest

_tests = str(pathlib.Path(__file__).resolve().parents[1])
if _tests not in sys.path:
    sys.path.insert(0, _tests)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mutants.mutant import Mutant


@pytest.fixture(scope="session")
def points() -> frozenset[str]:
    """Return the names of all points of the kernels."""
    from hostcode.assets import kernels_dir

    texts = (path.read_text(encoding="utf-8") for path in kernels_dir().rglob("*.mako"))
    return frozenset(re.findall(r'point\("([\w.]+)"', "".join(texts)))


@pytest.fixture
def engine(
    monkeypatch: pytest.MonkeyPatch, points: frozenset[str]
) -> Iterator[Callable[[Mutant], None]]:
    """Return a function that breaks the engine until the test ends."""
    from oracles import kernels

    from hostcode import templates
    from hostcode.program import build

    def break_it(mutant: Mutant) -> None:
        assert mutant.points.keys() <= points, "no such point"
        monkeypatch.setattr(templates, "MUTATIONS", dict(mutant.points))
        monkeypatch.setattr(build, "_CACHE", {})
        kernels._program.cache_clear()

    yield break_it
    monkeypatch.undo()
    kernels._program.cache_clear()
