"""Starts a module on MPI ranks with ``mpi4py.futures``, where there is an MPI."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


class NoMpiError(Exception):
    """There is no MPI to be had; says why."""


class Mpi:
    """The MPI of this machine.

    Parameters
    ----------
    names : Path
        A directory of the caller's, for the name that a library is looked for by.

    Raises
    ------
    NoMpiError
        Where something is not installed or does not load.
    """

    def __init__(self, names: Path) -> None:
        places = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        program = shutil.which("mpiexec", path=places)
        if program is None:
            raise NoMpiError("mpiexec is not installed: `apt install mpich`")
        if find_spec("mpi4py") is None:
            raise NoMpiError("mpi4py is not installed")
        said = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
        self.program = program
        self.is_open_mpi = "Open MPI" in said.stdout or "OpenRTE" in said.stdout
        # Debian names MPICH's library otherwise than all that was linked elsewhere asks for.
        for library in Path("/usr/lib").glob("*/libmpich.so.12"):
            (names / "libmpi.so.12").symlink_to(library)
            break
        libraries = [str(names), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
            "LD_LIBRARY_PATH": os.pathsep.join(libraries),
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        }
        loads = subprocess.run(
            [sys.executable, "-c", "import mpi4py.MPI"], env=self.environment,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        if loads.returncode:
            raise NoMpiError(f"mpi4py does not load: {loads.stderr.strip().splitlines()[-1]}")

    def command(self, ranks: int, *arguments: str) -> Sequence[str]:
        """Return the command line that starts ``python -m mpi4py.futures ARGUMENTS`` on ranks."""
        flags = ["--oversubscribe"] if self.is_open_mpi else []
        start = [self.program, "-n", str(ranks), *flags]
        return [*start, sys.executable, "-m", "mpi4py.futures", *arguments]
