"""Files that are replaced in one step: a crash leaves the old one or the new one, never half."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["TEMPORARY", "reason", "replacing", "sweep"]

TEMPORARY: Final = ".photizon-"
"""How the names of files that are being written begin."""


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path beside `target` that takes its place when all went well."""
    handle, name = tempfile.mkstemp(prefix=TEMPORARY, suffix=target.suffix, dir=target.parent)
    os.close(handle)
    temporary = target.parent / os.path.basename(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        with open(temporary, "rb+") as written:
            os.fsync(written.fileno())  # the name must not reach the disk before the bytes do
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def sweep(folder: Path) -> None:
    """Remove what a killed process left half written in a directory."""
    with suppress(OSError):
        for left in folder.glob(f"{TEMPORARY}*"):
            left.unlink(missing_ok=True)


def reason(error: Exception) -> str:
    """Return why a file could not be used, in a few words."""
    return getattr(error, "strerror", None) or str(error)
