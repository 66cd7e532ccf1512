"""Finds a GPU's OpenCL driver that is installed but not registered, as in many containers.

The ICD loader knows a driver by a file in /etc/OpenCL/vendors. Where a container lacks it the
driver's library may still be there: then a registration in a temporary directory, named by
``OCL_ICD_VENDORS``, brings the GPU back. The loader reads that once, so the program starts anew.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

LIBRARY: Final = "libnvidia-opencl.so.1"
FOLDERS: Final = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/nvidia/lib64",
    "/usr/local/nvidia/lib",
    "/usr/local/cuda/lib64",
    "/usr/lib64/nvidia",
    "/usr/lib/nvidia",
    "/opt/nvidia/lib64",
    "/run/nvidia/driver/usr/lib/x86_64-linux-gnu",
    "/usr/lib/wsl/lib",
)
_TRIED: Final = "PHOTIZON_ICD_TRIED"
_PREFIX: Final = "photizon-icd-"
_COUNT: Final = (
    "import pyopencl as cl; print(sum(bool(d.type & cl.device_type.GPU) "
    "for p in cl.get_platforms() for d in p.get_devices()))"
)


def libraries(folders: tuple[str, ...] = FOLDERS) -> Iterator[Path]:
    """Give every place where the driver's library lies: the linker's first, then usual folders."""
    seen: set[Path] = set()
    listing = ""
    for command in ("ldconfig", "/sbin/ldconfig", "/usr/sbin/ldconfig"):
        with suppress(OSError, subprocess.SubprocessError):
            said = subprocess.run([command, "-p"], capture_output=True, text=True, timeout=20)
            listing = said.stdout
            break
    named = [line.split("=>")[-1].strip() for line in listing.splitlines() if LIBRARY in line]
    paths = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    for place in [*named, *(os.path.join(f, LIBRARY) for f in (*paths, *folders) if f)]:
        path = Path(place)
        if path.is_file() and path.resolve() not in seen:
            seen.add(path.resolve())
            yield path


def environments(library: Path, folder: Path) -> Iterator[dict[str, str]]:
    """Give environments that make a loader find a library, the gentlest first.

    The first keeps what is registered already, for example a CPU device to compare with.
    """
    system = Path("/etc/OpenCL/vendors")
    if system.is_dir():
        for registered in system.glob("*.icd"):
            with suppress(OSError):
                (folder / registered.name).write_bytes(registered.read_bytes())
    alone = folder / "photizon-nvidia.icd"
    alone.write_text(f"{library}\n", encoding="utf-8")
    # The driver's other libraries lie beside it and are found by the linker's path alone.
    beside = os.pathsep.join(filter(None, [str(library.parent), os.environ.get("LD_LIBRARY_PATH")]))
    for vendors in (f"{folder}{os.sep}", str(folder), str(alone)):
        yield {"OCL_ICD_VENDORS": vendors}
        yield {"OCL_ICD_VENDORS": vendors, "LD_LIBRARY_PATH": beside}
    yield {"OCL_ICD_FILENAMES": str(library), "LD_LIBRARY_PATH": beside}


def gpus(environment: Mapping[str, str]) -> int:
    """Return how many GPUs a fresh process with this environment sees."""
    with suppress(OSError, subprocess.SubprocessError, ValueError):
        said = subprocess.run(
            [sys.executable, "-c", _COUNT],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        return int(said.stdout.split()[-1])
    return 0


def start_anew_with_gpu(arguments: list[str]) -> None:
    """Start this program anew where a driver that is not registered shows a GPU; else return."""
    if os.environ.get(_TRIED) or gpus({}):
        return
    for library in libraries():
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
        for environment in environments(library, folder):
            if gpus(environment):
                print(f"registered {library.name} for this run by {', '.join(environment)}")
                sys.stdout.flush()
                os.environ.update({**environment, _TRIED: str(folder)})
                os.execv(sys.executable, [sys.executable, *arguments])
        shutil.rmtree(folder, ignore_errors=True)


def clean() -> None:
    """Remove the registration that this run was started with."""
    folder = os.environ.pop(_TRIED, "")
    if Path(folder).name.startswith(_PREFIX):
        shutil.rmtree(folder, ignore_errors=True)
