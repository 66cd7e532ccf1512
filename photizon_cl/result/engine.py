"""Which sources fix the bits of a result."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hostcode import assets

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["engine_digest"]

_KERNELS: Final = ("**/*.mako",)
_HOST: Final = ("*.py", "program/**/*.py", "run/**/*.py")
_PRODUCT: Final = tuple(f"{name}/**/*.py" for name in ("scene", "geometry", "compile", "result"))


@cache
def engine_digest() -> str:
    """Return a short digest of the sources on which every bit depends.

    Whole folders, so that no file that decides bits can be missed: the kernels, and of the host
    what makes the tables that they read, renders and runs them and sums what they write. Another
    digest does not mean other bits; the same one means the same.
    """
    host = Path(assets.__file__).resolve().parent
    return _digest(assets.kernels_dir(), host, Path(__file__).resolve().parents[1])


def _digest(kernels: Path, host: Path, product: Path) -> str:
    total = hashlib.sha256()
    for name, path in sorted(_sources(kernels, host, product)):
        total.update(name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def _sources(kernels: Path, host: Path, product: Path) -> Iterator[tuple[str, Path]]:
    """Give the files with names that are the same wherever they are installed."""
    roots = (("kernels", kernels, _KERNELS), ("hostcode", host, _HOST))
    for name, root, patterns in (*roots, ("photizon_cl", product, _PRODUCT)):
        for path in (path for pattern in patterns for path in root.glob(pattern)):
            yield f"{name}/{path.relative_to(root).as_posix()}", path
