"""Where compiled kernels are: kept ones in one place, and those in use in a directory of a process.

PoCL writes what it compiles into a directory and loads what it finds there, unseen. So each process
gives it a directory of its own, into which `hostcode.device.kept_kernels` puts only what it has
proved to be whole. Where nothing can be kept a temporary directory takes the place, and a run still
runs; without any, PoCL lists no device, or builds no program, and says nothing of the cause.

pyopencl keeps code of its calls and binaries as well, without a digest: that is switched off.
"""

from __future__ import annotations

import atexit
import os
import re
import shutil
import socket
import sys
import tempfile
import time
import warnings
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hostcode.errors import CacheWarning

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "KEPT",
    "TRYING",
    "Place",
    "cache_home",
    "hold",
    "host_prefix",
    "kept",
    "kept_files",
    "make_held",
    "place",
    "provide_cache",
    "remove_kept",
    "root",
]

_POCL: Final = "POCL_CACHE_DIR"
_HOME: Final = "XDG_CACHE_HOME"
_PYOPENCL: Final = "PYOPENCL_NO_CACHE"
RUNNING: Final = "photizon-running"
"""Directory of the directories of processes."""
_HELD: Final = "held"
"""File in such a directory that its process holds a lock of."""
_YOUNG: Final = 60.0
"""Seconds in which a directory that nobody holds may be one that is about to be held."""
_FORGOTTEN: Final = 7 * 86400.0
"""Seconds after which a directory is nobody's, where no lock tells (another host's, or none)."""
KEPT: Final = ".kernels"
"""How the names of files with kept kernels end."""
TRYING: Final = ".trying"
"""How the names of files end that stand there while kept kernels are loaded for the first time."""


@dataclass(frozen=True)
class Place:
    """Where the kernels of this process are.

    Parameters
    ----------
    kept : Path
        Directory of the kept ones.
    running : Path
        Directory that PoCL works in, of this process alone.
    """

    kept: Path
    running: Path


_place: Place | None = None
_held: list[int] = []


def place() -> Place | None:
    """Return where this process's kernels are; None before `provide_cache`."""
    return _place


def provide_cache() -> None:
    """See that kernels can be kept; call before pyopencl is first imported.

    Where they cannot, a temporary directory takes the place, which goes when this process ends, and
    a `CacheWarning` says so.

    Raises
    ------
    OSError
        Where no temporary directory can be made either.
    """
    global _place
    _without_pyopencls()
    kept, named_by = root(), _POCL if _given() else _HOME
    why = _refusal(kept) or _refusal(kept / RUNNING)
    if why:
        try:
            kept = Path(tempfile.mkdtemp(prefix="photizon-cache-"))
        except OSError as error:
            raise OSError(f"{why}, nor a temporary one: {error}") from error
        atexit.register(_remove, kept, os.getpid())
        warnings.warn(
            f"{why}: kernels are compiled anew and kept in a temporary directory until the process "
            f"ends; to keep them, set {named_by} to a directory that can be written",
            CacheWarning,
            stacklevel=2,
        )
    running = kept / RUNNING
    running.mkdir(parents=True, exist_ok=True)
    _sweep(running)
    mine = Path(tempfile.mkdtemp(prefix=host_prefix(), dir=running))
    try:
        _held.append(make_held(mine / _HELD, mine))  # as long as the process lives
    except OSError:  # without locks its age tells whether it is in use
        (mine / _HELD).touch()
    atexit.register(_remove, mine, os.getpid())
    os.environ[_POCL] = str(mine)
    _place = Place(kept, mine)


def root() -> Path:
    """Return the directory in which kernels are kept; it need not be there."""
    given = _given()
    return given if given is not None else cache_home() / "photizon_cl" / "kernels"


def cache_home() -> Path:
    """Return the user's directory for caches; it need not be there."""
    base = os.environ.get(_HOME, "")
    # The specification says to ignore a relative path.
    return Path(base) if os.path.isabs(base) else Path("~/.cache").expanduser()


def kept_files() -> Iterator[Path]:
    """Give the files of kept kernels, in no order."""
    with suppress(OSError):
        yield from (file for file in root().iterdir() if file.suffix == KEPT)


def kept() -> tuple[int, int]:
    """Return how many programs are kept, and in how many bytes."""
    sizes = []
    for file in kept_files():
        with suppress(OSError):
            sizes.append(file.stat().st_size)
    return len(sizes), sum(sizes)


def remove_kept() -> tuple[int, int]:
    """Remove every kept program; return how many went, and their bytes.

    Processes that run meanwhile are not disturbed: what they use is their own.
    """
    sizes = []
    for file in list(kept_files()):
        with suppress(OSError):
            size = file.stat().st_size
            file.unlink()
            sizes.append(size)
    with suppress(OSError):
        for mark in list(root().glob(f"*{TRYING}")):  # each is about what is no longer there
            mark.unlink(missing_ok=True)
    _sweep(root() / RUNNING)
    return len(sizes), sum(sizes)


def hold(handle: int) -> bool:
    """Lock an open file until it is closed; False where another has it.

    Raises
    ------
    OSError
        Where there are no locks.
    """
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except ImportError as error:
        raise OSError(str(error)) from error
    return True


def make_held(path: Path, folder: Path) -> int:
    """Make an empty file that this process holds a lock of, until the handle given back is closed.

    It is locked before it has its name, so that nobody finds it there without its lock.

    Parameters
    ----------
    path : Path
        The file.
    folder : Path
        Where it is made: a directory of this process alone, in the same file system.

    Raises
    ------
    OSError
        Where it cannot be made, or there are no locks.
    """
    handle, name = tempfile.mkstemp(dir=folder)
    try:
        if not hold(handle):
            raise BlockingIOError(f"another process holds {name}")
        os.replace(name, path)
    except OSError:
        os.close(handle)
        Path(name).unlink(missing_ok=True)
        raise
    return handle


def host_prefix() -> str:
    """Return how the names of what this host's processes hold begin.

    Hosts may share a home whose locks are each host's own: one does not judge another's.
    """
    return re.sub(r"[^A-Za-z0-9.-]", "-", socket.gethostname())[:64] + "_"


def _given() -> Path | None:
    """Return the directory that the user gave PoCL; a parent process may have put its own there."""
    given = os.environ.get(_POCL, "")
    if not given:
        return None
    path = Path(given)
    if path.parent.name != RUNNING:
        return path
    kept = path.parent.parent
    return None if kept == cache_home() / "photizon_cl" / "kernels" else kept


def _without_pyopencls() -> None:
    loaded = sys.modules.get("pyopencl")
    if loaded is None:
        os.environ[_PYOPENCL] = "1"  # read when it is imported
    else:
        loaded._PYOPENCL_NO_CACHE = True  # type: ignore[attr-defined]


def _refusal(folder: Path) -> str:
    """Say why nothing can be written into a directory, which need not be there; empty if it can."""
    above = folder
    while not os.path.lexists(above) and above != above.parent:
        above = above.parent
    try:
        tempfile.TemporaryDirectory(dir=above).cleanup()
    except OSError as error:
        return f"the kernel cache {folder} cannot be written ({error.strerror or error})"
    return ""


def _sweep(running: Path) -> None:
    """Remove the directories of processes that died; another host's only when long forgotten."""
    folders: list[Path] = []
    with suppress(OSError):
        folders += running.iterdir()
    for folder in folders:
        with suppress(OSError):
            age = time.time() - folder.stat().st_mtime
            if not folder.name.startswith(host_prefix()) and age <= _FORGOTTEN:
                continue
            try:
                handle = os.open(folder / _HELD, os.O_RDWR)
            except FileNotFoundError:
                left = age > _YOUNG
            else:
                try:
                    left = hold(handle)
                except OSError:
                    left = age > _FORGOTTEN
                finally:
                    os.close(handle)
            if left:
                shutil.rmtree(folder, ignore_errors=True)


def _remove(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # a process that was forked leaves it to the one that made it
        shutil.rmtree(folder, ignore_errors=True)
