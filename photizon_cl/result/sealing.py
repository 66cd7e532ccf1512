"""A checksum behind the last byte of a file, asked for before a library reads any of it.

HDF5 trusts what a file says of itself: in one of which a few bytes were lost it may follow links in
circles and never come back, deaf to signals. So a result's file ends in a line with the digest of
all bytes before it; readers of HDF5 pay no heed to what stands behind their data.
"""

from __future__ import annotations

import hashlib
import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["deaf_libraries_end", "seal", "sealed"]

_MARK: Final = b"\nphotizon sha256:"
_LENGTH: Final = len(_MARK) + 64 + 1
_BLOCK: Final = 1 << 20


def seal(path: Path) -> None:
    """Put the digest of a whole file behind it."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(_MARK + digest.encode("ascii") + b"\n")


def sealed(path: Path) -> bool:
    """Say whether a file has such a digest, as files of earlier versions have not.

    Raises
    ------
    ValueError
        Where it has, and the bytes are others.
    """
    size = path.stat().st_size - _LENGTH
    if size < 0:
        return False
    with path.open("rb") as file:
        file.seek(max(size - _LENGTH, 0))
        end = file.read(2 * _LENGTH)
    line = end[-_LENGTH:]
    if _MARK not in end:
        return False
    if (
        not line.startswith(_MARK)
        or line[len(_MARK) :] != _digest(path, size).encode("ascii") + b"\n"
    ):
        raise ValueError("its bytes are not those that were written")
    return True


def _digest(path: Path, size: int) -> str:
    total = hashlib.sha256()
    with path.open("rb") as file:
        while size > 0:
            block = file.read(min(_BLOCK, size))
            if not block:
                break
            total.update(block)
            size -= len(block)
    return total.hexdigest()


@contextmanager
def deaf_libraries_end() -> Iterator[None]:
    """Let signals end the process at once, as they do where no Python code would hear of them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {}
    try:
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)
            if number is not None and callable(signal.getsignal(number)):
                before[number] = signal.signal(number, signal.SIG_DFL)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
