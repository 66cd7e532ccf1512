"""Which sources fix the bits of a result."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hostcode import assets
from hostcode.assets import kernels_dir

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["engine_digest"]

_HOST: Final = ("program", "run")
_PACKAGES: Final = ("scene", "geometry", "compile", "result")


@cache
def engine_digest() -> str:
    """Return a short digest of the sources on which every bit depends.

    Whole folders, so that no file that decides bits can be missed: the kernels, and of the host
    what makes the tables that they read, runs them and sums what they write. Another digest does
    not mean other bits; the same one means the same.
    """
    total = hashlib.sha256()
    for name, path in _sources():
        total.update(name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def _sources() -> Iterator[tuple[str, Path]]:
    product, kernels = Path(__file__).resolve().parents[1], kernels_dir()
    host = Path(assets.__file__).resolve().parent
    found = [
        (f"kernels/{path.relative_to(kernels).as_posix()}", path)
        for path in kernels.rglob("*.mako")
    ]
    for root, folders in ((host, _HOST), (product, _PACKAGES)):
        for path in (path for folder in folders for path in (root / folder).rglob("*.py")):
            found.append((f"{root.name}/{path.relative_to(root).as_posix()}", path))
    yield from sorted(found)
