"""Which sources fix the bits of a result."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hostcode.assets import kernels_dir

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["engine_digest"]

_MODULES: Final = (
    "compile",
    "contact",
    "edges",
    "frames",
    "layout",
    "neighbours",
    "packing",
    "statistics",
    "tree",
    "tree_nodes",
    "wedges",
)
_PACKAGES: Final = ("detectors", "elements", "sources", "surfaces")


@cache
def engine_digest() -> str:
    """Return a short digest of the sources on which every bit depends.

    The kernels' text, and of the host what makes the tables that they read and sums what they
    write. Another digest does not mean other bits; the same one means the same.
    """
    total = hashlib.sha256()
    for name, path in _sources():
        total.update(name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def _sources() -> Iterator[tuple[str, Path]]:
    here, kernels = Path(__file__).parent, kernels_dir()
    found = [(path.relative_to(kernels).as_posix(), path) for path in kernels.rglob("*.mako")]
    found += [(f"{name}.py", here / f"{name}.py") for name in _MODULES]
    for package in _PACKAGES:
        found += [(f"{package}/{path.name}", path) for path in (here / package).glob("*.py")]
    yield from sorted(found)
