"""A place for compiled kernels: the usual one, or a temporary one where nothing can be written.

Without a cache directory PoCL lists no device, or builds no program, and says nothing of the cause;
pyopencl, which keeps the code of its calls beside it, raises an error of the file system.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Final

from hostcode.errors import CacheWarning

__all__ = ["provide_cache"]

_POCL: Final = "POCL_CACHE_DIR"
_HOME: Final = "XDG_CACHE_HOME"


def provide_cache() -> None:
    """See that kernels can be cached; call before pyopencl is first imported.

    Where they cannot, the variables that name the cache are set to a directory that goes when this
    process ends, for this process and those that it starts, and a `CacheWarning` says so.

    Raises
    ------
    OSError
        Where no temporary directory can be made either.
    """
    if os.environ.get(_POCL) == "":
        del os.environ[_POCL]  # PoCL ends the process at an empty name
    refused = {name: why for name, folders in _places().items() if (why := _refusal(folders))}
    if not refused:
        return
    try:
        made = tempfile.mkdtemp(prefix="photizon-cache-")
    except OSError as error:
        raise OSError(f"{'; '.join(refused.values())}, nor a temporary one: {error}") from error
    atexit.register(_remove, made, os.getpid())
    for name in refused:
        os.environ[name] = made
    warnings.warn(
        f"{'; '.join(refused.values())}: kernels are compiled anew and kept in a temporary "
        f"directory until the process ends; to keep them, set {' and '.join(refused)} to a "
        "directory that can be written",
        CacheWarning,
        stacklevel=2,
    )


def _places() -> dict[str, list[Path]]:
    """Return where PoCL and pyopencl will write, by the variable that says so."""
    home = Path(os.environ.get(_HOME) or os.path.expanduser("~/.cache"))
    pocl, pyopencl = home / "pocl" / "kcache", home / "pytools"
    if _POCL in os.environ:
        return {_POCL: [Path(os.environ[_POCL])], _HOME: [pyopencl]}
    return {_HOME: [pocl, pyopencl]}


def _refusal(folders: list[Path]) -> str:
    """Say why nothing can be written into directories, which need not be there; empty if it can."""
    for folder in folders:
        place = folder
        while not os.path.lexists(place) and place != place.parent:
            place = place.parent
        try:
            tempfile.TemporaryDirectory(dir=place).cleanup()
        except OSError as error:
            return f"the kernel cache {folder} cannot be written ({error.strerror or error})"
    return ""


def _remove(folder: str, owner: int) -> None:
    if os.getpid() == owner:  # a process that was forked leaves it to the one that made it
        shutil.rmtree(folder, ignore_errors=True)
