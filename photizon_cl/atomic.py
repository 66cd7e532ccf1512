"""Files that are replaced in one step: a crash leaves the old one or the new one, never half."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["TEMPORARY", "Lock", "in_any_locale", "reason", "replacing", "sweep"]

TEMPORARY: Final = ".photizon-"
"""How the names of files that are being written begin."""
_WRITTEN: Final = re.compile(re.escape(TEMPORARY) + r"[a-z0-9_]{8}(\.\w+)?")


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


def in_any_locale(name: str) -> str:
    """Return the name of a file whose bytes are the same in every locale: those of UTF-8.

    Without this a name that the locale cannot write, as Ω under ``LC_ALL=C``, makes no file.
    """
    return name.encode("utf-8").decode(sys.getfilesystemencoding(), "surrogateescape")


def sweep(folder: Path) -> None:
    """Remove what a killed process left half written in a directory."""
    with suppress(OSError):
        for left in folder.iterdir():
            if _WRITTEN.fullmatch(left.name) and left.is_file():
                left.unlink(missing_ok=True)


class Lock:
    """Holds a directory for one process that writes to it; freed when the process dies.

    Parameters
    ----------
    folder : Path
        An existing directory.

    Raises
    ------
    BlockingIOError
        Where another process holds it.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / f"{TEMPORARY}lock"
        self._file = open(self._path, "wb")  # noqa: SIM115  (open as long as the lock is held)
        try:
            import fcntl

            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:  # no such locks on this system
            pass
        except BlockingIOError:
            self._file.close()
            raise
        except OSError:  # a file system without locks
            pass

    def free(self) -> None:
        """Let others have the directory."""
        if not self._file.closed:
            self._path.unlink(missing_ok=True)
            self._file.close()


def reason(error: Exception) -> str:
    """Return why a file could not be used, in a few words."""
    return getattr(error, "strerror", None) or str(error)
