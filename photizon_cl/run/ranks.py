"""The ranks of an MPI world, as an executor: ``mpiexec … python -m mpi4py.futures -m …``.

There rank 0 runs the command, and the others wait for what it hands out; mpi4py does all of it.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

from hostcode.device.pocl_environment import cores, limited_thread_environment
from photizon_cl.errors import RunError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Executor

__all__ = ["leads_ranks", "of_mpi"]


def leads_ranks() -> bool:
    """Say whether this is the process of ``python -m mpi4py.futures`` that hands out tasks."""
    pool = getattr(sys.modules.get("mpi4py.futures._core"), "SharedPool", None)
    return pool is not None and bool(getattr(pool, "on_root", False))


@contextmanager
def of_mpi() -> Iterator[Executor]:
    """Give the ranks behind this one.

    Raises
    ------
    RunError
        Where there are none.
    """
    size = import_module("mpi4py.MPI").COMM_WORLD.Get_size()
    if size < 2:
        raise RunError(
            "MPI: found 1 rank, expected at least 2, since rank 0 hands out and the others "
            "compute: start with `mpiexec -n 3` or more, or without mpi4py.futures"
        )
    executor: Any = import_module("mpi4py.futures").MPIPoolExecutor(initializer=_begin, main=False)
    try:
        yield executor
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Prepare a rank that computes."""
    # mpiexec passes them on to all ranks: rank 0 saves what there is, then the others end.
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # Ranks of one machine that were not bound to processors of their own share all of them.
    mpi = import_module("mpi4py.MPI")
    ranks = import_module("mpi4py.futures").get_comm_workers()
    near = ranks.Split_type(mpi.COMM_TYPE_SHARED)
    mine = cores()
    others = near.allgather(sorted(mine))
    sharing = sum(bool(mine.intersection(theirs)) for theirs in others)
    near.Free()
    share = max(len(mine) // sharing, 1)
    os.environ.update(limited_thread_environment(share, os.environ))
