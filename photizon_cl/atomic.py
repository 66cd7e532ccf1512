"""Files that are replaced in one step: a crash leaves the old one or the new one, never half.

Nothing here writes through a link: a file is made under a new name and then takes its place, and
the one file with a fixed name, the lock, is refused where it is a link or anything but a file.
"""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["TEMPORARY", "Lock", "in_any_locale", "reason", "replacing", "sweep"]

TEMPORARY: Final = ".photizon-"
"""How the names of files that are being written begin."""
_WRITTEN: Final = re.compile(re.escape(TEMPORARY) + r"[a-z0-9_]{8}(\.\w+)?")
_LOCKS_ITSELF: Final = ".nc"
"""Files that HDF5 writes, which locks them itself and finds them taken where others do."""
_YOUNG: Final = 10.0
"""Seconds in which a file that nobody holds may be one that its writer is about to hold."""
_FORGOTTEN: Final = 3600.0
"""Seconds after which nobody writes to a file any more, on file systems without locks."""


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path beside `target` that takes its place when all went well."""
    handle, name = tempfile.mkstemp(prefix=TEMPORARY, suffix=target.suffix, dir=target.parent)
    temporary = target.parent / os.path.basename(name)
    try:
        try:
            if target.suffix != _LOCKS_ITSELF:
                _take(handle)  # held until it is done: `sweep` of another process leaves it alone
            yield temporary
            umask = os.umask(0)
            os.umask(umask)
            temporary.chmod(0o666 & ~umask)
            with open(temporary, "rb+") as written:
                os.fsync(written.fileno())  # the name must not reach the disk before the bytes do
        finally:
            os.close(handle)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def in_any_locale(name: str) -> str:
    """Return the name of a file whose bytes are the same in every locale: those of UTF-8.

    Without this a name that the locale cannot write, as Ω under ``LC_ALL=C``, makes no file.
    """
    return name.encode("utf-8").decode(sys.getfilesystemencoding(), "surrogateescape")


def sweep(folder: Path, *, held: bool) -> None:
    """Remove what killed processes left half written in a directory.

    Parameters
    ----------
    folder : Path
        The directory; it need not be there.
    held : bool
        Whether the caller holds its `Lock`: whoever writes HDF5 there holds that as well.
    """
    with suppress(OSError):
        for left in list(folder.iterdir()):
            if _WRITTEN.fullmatch(left.name):
                with suppress(OSError):
                    if left.suffix == _LOCKS_ITSELF:
                        forsaken = held and stat.S_ISREG(left.lstat().st_mode)
                    else:
                        forsaken = _forsaken(left)
                    if forsaken:
                        left.unlink(missing_ok=True)


def _forsaken(path: Path) -> bool:
    """Say whether a file that was being written has lost its writer."""
    handle = _open(path, os.O_RDONLY)
    try:
        age = time.time() - os.fstat(handle).st_mtime
        try:
            taken = _take(handle)
        except BlockingIOError:
            return False
        return age > (_YOUNG if taken else _FORGOTTEN)
    finally:
        os.close(handle)


def _open(path: Path, flags: int) -> int:
    """Open a file by the name itself: no link is followed, no pipe waited for.

    Raises
    ------
    OSError
        Where it is a link, or something else than a file.
    """
    for more in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC"):
        flags |= getattr(os, more, 0)
    try:
        handle = os.open(path, flags, 0o666)
    except OSError as error:
        if path.is_symlink():
            raise OSError(errno.ELOOP, f"{path.name} there is a symbolic link") from error
        raise
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, f"{path.name} there is no regular file")
    return handle


def _take(handle: int) -> bool:
    """Lock an open file until it is closed; False where the system has no locks.

    Raises
    ------
    BlockingIOError
        Where another holds it.
    """
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except (ImportError, OSError):  # a system, or a file system, without locks
        return False
    return True


class Lock:
    """Holds a directory for one process that writes to it; freed when the process dies.

    Nothing is ever written to the file of the lock.

    Parameters
    ----------
    folder : Path
        An existing directory.

    Raises
    ------
    BlockingIOError
        Where another process holds it.
    OSError
        Where its file cannot be made, or something else has its name.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / f"{TEMPORARY}lock"
        while True:
            self._handle = _open(self._path, os.O_RDWR | os.O_CREAT)
            try:
                _take(self._handle)
            except BlockingIOError:
                os.close(self._handle)
                raise
            if self._there():  # else the one before removed it while this one waited to lock it
                return
            os.close(self._handle)

    def _there(self) -> bool:
        try:
            return os.path.samestat(os.fstat(self._handle), self._path.lstat())
        except FileNotFoundError:
            return False

    def free(self) -> None:
        """Let others have the directory."""
        if self._handle >= 0:
            with suppress(OSError):
                if self._there():
                    self._path.unlink(missing_ok=True)
            os.close(self._handle)
            self._handle = -1


def reason(error: Exception) -> str:
    """Return why a file could not be used, in a few words."""
    return getattr(error, "strerror", None) or str(error)
