"""What a subprocess' environment tells PoCL: which platform it sees, how many threads it uses.

Two PoCLs in one process (Debian's 3.1 and the one of PyPI) were tried: both list, build and run.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from hostcode.device.pocl_mend import pypi_pocl_icd

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "cores",
    "limited_thread_environment",
    "only_platform_environment",
    "pocl_icd_files",
    "pocl_thread_environment",
]


def cores() -> frozenset[int]:
    """Return the numbers of the processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return frozenset(os.sched_getaffinity(0))
    return frozenset(range(os.cpu_count() or 1))


def pocl_thread_environment(threads: int) -> dict[str, str]:
    """Return what to set in a subprocess' environment for PoCL to use so many threads.

    PoCL reads its environment once, when its first device is listed: set these before a process
    starts. They limit and do not raise; each version ignores the variable of the others.

    Parameters
    ----------
    threads : int
        At least 1.

    Returns
    -------
    dict
        ``POCL_MAX_PTHREAD_COUNT`` (PoCL up to 3.1) and ``POCL_CPU_MAX_CU_COUNT`` (from 4.0 on).
    """
    if threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return {"POCL_MAX_PTHREAD_COUNT": str(threads), "POCL_CPU_MAX_CU_COUNT": str(threads)}


def limited_thread_environment(threads: int, environment: Mapping[str, str]) -> dict[str, str]:
    """Return `pocl_thread_environment`, but for limits in an environment that are lower already.

    Parameters
    ----------
    threads : int
        At least 1.
    environment : mapping of str to str
        What may hold limits.
    """
    limits = pocl_thread_environment(threads)
    for name in limits:
        there = environment.get(name, "")
        if there.isdecimal() and 1 <= int(there) < threads:
            limits[name] = there
    return limits


def pocl_icd_files() -> dict[str, Path]:
    """Return the ICD files of the PoCLs installed here.

    Returns
    -------
    dict
        ``debian`` → the system's registration, ``pypi`` → the one that ``pyopencl[pocl]`` puts
        beside pyopencl's own ICD loader; each only where it exists.
    """
    places = {"debian": Path("/etc/OpenCL/vendors/pocl.icd"), "pypi": pypi_pocl_icd()}
    return {name: place for name, place in places.items() if place is not None and place.is_file()}


def only_platform_environment(icd: Path) -> dict[str, str]:
    """Return what to set in a subprocess' environment for it to see one ICD's platform only.

    Parameters
    ----------
    icd : Path
        An ICD file, for example a value of `pocl_icd_files`.

    Returns
    -------
    dict
        ``OCL_ICD_VENDORS``. It must name the file: given a directory, pyopencl's loader still adds
        the PoCL of PyPI that lies beside it.
    """
    return {"OCL_ICD_VENDORS": str(icd)}
