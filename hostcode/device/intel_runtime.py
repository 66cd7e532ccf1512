"""Makes the ICD loader find Intel's CPU runtime where pip installed it.

The packages ``intel-opencl-rt`` and ``intel-cmplr-lib-rt`` put the runtime's libraries into ``lib``
of the environment, and a registration into its ``etc/OpenCL/vendors``, where no loader looks and
which names a folder of the machine that built it. A loader asks once, when platforms are first
listed: for that call it is given a folder with links to what the system registers and one
registration more. What PyPI's PoCL brings it finds beside itself as ever.

Nothing is done where the environment says which registrations to read, or where the system
registers a runtime of Intel's for the CPU: that one is used.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
import sys
import tempfile
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

__all__ = ["LIBRARY", "PLATFORM", "intel_is_installed", "intel_library", "registered", "trouble"]

PLATFORM: Final = "Intel(R) OpenCL"
"""Name of the platform of the CPU runtime; those of Intel's GPUs are longer."""

LIBRARY: Final = "libintelocl.so"
_PACKAGE: Final = "intel-opencl-rt"
_SYSTEM: Final = Path("/etc/OpenCL/vendors")
_VENDORS: Final = "OCL_ICD_VENDORS"
_NAMES: Final = (_VENDORS, "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES")
"""What tells a loader where registrations are."""
_unwritable: list[str] = []
"""Why no folder could be made, if so."""


def intel_library() -> Path | None:
    """Return the runtime's library that pip installed, or None."""
    try:
        files = importlib.metadata.files(_PACKAGE) or ()
    except importlib.metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.name == LIBRARY:
            place = Path(str(file.locate())).resolve()
            return place if place.is_file() else None
    return None


def intel_is_installed() -> bool:
    """Return whether Intel's CPU runtime is here, by pip or registered; asks no loader."""
    return intel_library() is not None or _system_has_one()


@contextmanager
def registered() -> Iterator[None]:
    """See that platforms which are first listed in this block include pip's Intel runtime."""
    with ExitStack() as stack:
        folder = _folder(stack)
        if folder:
            os.environ[_VENDORS] = folder
            # processes that this one starts look for themselves
            stack.callback(os.environ.pop, _VENDORS, None)
        yield


def _folder(stack: ExitStack) -> str:
    """Make a folder with what the system registers and Intel's runtime; empty for none."""
    library = intel_library()
    _unwritable.clear()
    named = any(os.environ.get(name) for name in _NAMES)
    if sys.platform != "linux" or library is None or named or _system_has_one():
        return ""
    try:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="photizon-vendors-"))
        for registration in _registrations():
            (Path(folder) / registration.name).symlink_to(registration)
        (Path(folder) / "photizon-intel.icd").write_text(f"{library}\n", encoding="utf-8")
    except OSError as error:  # no place to write: the other platforms are there as ever
        _unwritable[:] = [str(error)]
        return ""
    return folder


def trouble(platforms: Collection[str]) -> str:
    """Say why the runtime that pip installed is not among the platforms; empty where it is.

    Parameters
    ----------
    platforms : collection of str
        Names of the platforms that the loader listed.
    """
    library = intel_library()
    named = any(os.environ.get(name) for name in _NAMES)
    if library is None or PLATFORM in platforms or named:
        return ""
    try:
        ctypes.CDLL(str(library))
    except OSError as error:
        return (
            f"Intel's OpenCL runtime is installed and does not load ({error}): "
            "pip install intel-opencl-rt intel-cmplr-lib-rt"
        )
    if _system_has_one():
        return (
            "Intel's OpenCL runtime is installed by pip and registered by the system, and what the "
            f"system registers does not load: mend or remove its file in {_SYSTEM}"
        )
    if _unwritable:
        return (
            "Intel's OpenCL runtime is installed and cannot be registered without a temporary "
            f"directory ({_unwritable[0]}): set TMPDIR to one that can be written"
        )
    return (
        "Intel's OpenCL runtime is installed and was not found, since this process had listed its "
        "platforms before: call photizon_cl before other code that uses OpenCL"
    )


def _registrations() -> list[Path]:
    try:
        return sorted(path for path in _SYSTEM.iterdir() if path.suffix == ".icd")
    except OSError:  # a machine on which nothing is registered
        return []


def _system_has_one() -> bool:
    for registration in _registrations():
        with suppress(OSError, UnicodeDecodeError):
            named = registration.read_text(encoding="utf-8").strip()
            if Path(named).name.startswith(LIBRARY):
                return True
    return False
