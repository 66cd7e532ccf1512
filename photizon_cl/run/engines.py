"""Where batches can be computed beside this process, opened and closed as executors.

`photizon_cl.run.workers` takes anything with the interface of `concurrent.futures.Executor`; this
makes those that a user names by a number, by an address, or by starting the command under MPI.
"""

from __future__ import annotations

import operator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError, show
from photizon_cl.run.ranks import leads_ranks, of_mpi

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

__all__ = ["open_executor", "taken"]

_MOST: Final = 1024
"""Processes of one machine."""


def open_executor(
    workers: int | None = None, scheduler: str | None = None, *, ranks: bool = False
) -> AbstractContextManager[Executor | None]:
    """Return a context that gives an executor, and closes it in the end.

    Every error is raised before anything is started, but for what a scheduler says.

    Parameters
    ----------
    workers : int, optional
        Processes of this machine, started when they are first needed.
    scheduler : str, optional
        Address of a Dask scheduler.
    ranks : bool, optional
        Whether to take the ranks of ``mpiexec … python -m mpi4py.futures`` where this is rank 0.

    Returns
    -------
    context manager
        Of an executor; of None where nothing is named: this process computes.

    Raises
    ------
    ArgumentError
        Where both are given, either beside MPI ranks, or one is none of these.
    RunError
        Where a scheduler does not answer or has no workers, or there is a single rank.
    """
    if workers is not None and scheduler is not None:
        raise ArgumentError(
            f"workers: found {show(workers)} and scheduler {show(scheduler)}, expected one of them"
        )
    led = ranks and leads_ranks()
    for name, value in (("workers", workers), ("scheduler", scheduler)):
        if led and value is not None:
            raise ArgumentError(
                f"{name}: found {show(value)}, expected nothing: this was started under MPI "
                "(mpi4py.futures), whose ranks compute"
            )
    if led:
        return of_mpi()
    if scheduler is not None:
        from photizon_cl.run.dask import connected

        return connected(scheduler)
    if workers is not None:
        return _processes(_number(workers))
    return nullcontext()


def taken(
    executor: Executor | None, workers: int | None, scheduler: str | None
) -> AbstractContextManager[Executor | None]:
    """Return a context that gives an executor that a caller has, or the one that it names.

    Raises
    ------
    ArgumentError, RunError
        As `open_executor`, and where there is an executor and another is named.
    """
    if executor is None:
        return open_executor(workers, scheduler)
    for name, value in (("workers", workers), ("scheduler", scheduler)):
        if value is not None:
            raise ArgumentError(
                f"{name}: found {show(value)}, expected nothing beside executor, which says who "
                "computes"
            )
    return nullcontext(executor)


def _number(workers: int) -> int:
    try:
        number = operator.index(workers)
    except TypeError:
        number = 0
    if isinstance(workers, bool) or not 1 <= number <= _MOST:
        raise ArgumentError(
            f"workers: found {show(workers)}, expected an integer from 1 to {_MOST}, the processes "
            "of this machine that compute"
        )
    return number


@contextmanager
def _processes(workers: int) -> Iterator[Executor]:
    from photizon_cl.run.processes import Processes

    executor = Processes(workers)
    try:
        yield executor
    finally:
        executor.close()
