"""Makes the PoCL of PyPI work on CPUs that are younger than its compiler.

The package ``pocl-binary-distribution`` 3.0, which ``pyopencl[pocl]`` installs, carries LLVM 14.
On a CPU that LLVM 14 does not know by name (AMD Zen 5, for example) it asks its own compiler for
the target CPU ``generic``, which that compiler refuses: ``unknown target CPU 'generic'``, for every
kernel (PoCL issue 1049). AMD Zen 4 it takes for ``znver3``, which has no AVX-512, while it links
its built-in library for AVX-512: calls pass vectors of eight doubles differently. PoCL 3.1 and
later fall back to the CPU that their built-in library was compiled for. For want of a newer release
on PyPI the same fall-back is made here: the one function that names the CPU, exported by that
library, is replaced in this process' memory. No file is changed. Where anything is not as expected
nothing is done, and the device is then refused by the self-test with the compiler's words.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import importlib.util
import mmap
import os
import platform
import sys
from functools import cache
from pathlib import Path
from typing import Final

__all__ = ["mend_pypi_pocl", "pypi_pocl_icd"]

_VERSION: Final = "3.0"
_EXPORT: Final = "pocl_get_llvm_cpu_name"

# What PoCL 3.0 looks at to pick a built-in library, and the CPU that this library was compiled
# for; kernels must be compiled for the very same, or calls between them pass vectors differently.
_AVX512: Final = {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}
_AVX512_CPU: Final = "skylake-avx512"
_WITHOUT_AVX512: Final = {b"znver1", b"znver2", b"znver3"}
_AVX2: Final = {"avx", "avx2", "cx16", "popcnt", "abm", "f16c", "fma", "bmi1", "bmi2", "movbe"}

_keep: list[object] = []  # what the replaced code points to must live as long as the process


def pypi_pocl_icd() -> Path | None:
    """Return the ICD file of the PoCL that ``pyopencl[pocl]`` installs, or None."""
    found = importlib.util.find_spec("pyopencl")
    if found is None or found.origin is None:
        return None
    icd = Path(found.origin).parent / ".libs" / "pocl.icd"
    return icd if icd.is_file() else None


@cache
def mend_pypi_pocl() -> str:
    """Let PyPI's PoCL 3.0 compile on a CPU that it does not know; call before listing platforms.

    Returns
    -------
    str
        The CPU that kernels will be compiled for, or ``""`` where nothing was done: not that
        package and version, not Linux on x86-64, a CPU that it knows, or memory that may not be
        changed.
    """
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return ""
    icd = pypi_pocl_icd()
    if icd is None or not _will_be_loaded(icd):
        return ""
    try:
        if importlib.metadata.version("pocl-binary-distribution") != _VERSION:
            return ""
        library = ctypes.CDLL(str(icd.parent / icd.read_text(encoding="utf-8").strip()))
        function = getattr(library, _EXPORT)
        function.restype = ctypes.c_char_p
        taken_for, name = function(), _library_cpu()
        wrong = taken_for == b"generic" or (name == _AVX512_CPU and taken_for in _WITHOUT_AVX512)
        replaced = wrong and bool(name) and _replace(function, name)
    except (OSError, AttributeError, ValueError, importlib.metadata.PackageNotFoundError):
        return ""
    return name if replaced else ""


def _will_be_loaded(icd: Path) -> bool:
    only = os.environ.get("OCL_ICD_VENDORS", "")
    # A file names one platform; a directory adds to the loader's own, as if it were not there.
    return not only.endswith(".icd") or Path(only).resolve() == icd.resolve()


def _library_cpu() -> str:
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    flags = set(next(line for line in lines if line.startswith("flags")).split())
    if "avx512f" in flags:
        return _AVX512_CPU if flags >= _AVX512 | _AVX2 else ""
    return "haswell" if flags >= _AVX2 else ""


def _replace(function: ctypes._FuncPointer, name: str) -> bool:
    """Make an exported function return a copy of a name, which its caller owns and frees."""
    process = ctypes.CDLL(None, use_errno=True)
    address = ctypes.cast(function, ctypes.c_void_p).value or 0
    strdup = ctypes.cast(process.strdup, ctypes.c_void_p).value or 0
    text = ctypes.create_string_buffer(name.encode())
    _keep.append(text)
    # mov rdi, text; mov rax, strdup; jmp rax
    code = b"\x48\xbf" + ctypes.addressof(text).to_bytes(8, "little")
    code += b"\x48\xb8" + strdup.to_bytes(8, "little") + b"\xff\xe0"
    start = address - address % mmap.PAGESIZE
    size = ctypes.c_size_t(-(-(address + len(code) - start) // mmap.PAGESIZE) * mmap.PAGESIZE)
    read_run = mmap.PROT_READ | mmap.PROT_EXEC
    # Systems that forbid changing code say so here.
    if process.mprotect(ctypes.c_void_p(start), size, read_run | mmap.PROT_WRITE) != 0:
        return False
    ctypes.memmove(address, code, len(code))
    process.mprotect(ctypes.c_void_p(start), size, read_run)
    return True
