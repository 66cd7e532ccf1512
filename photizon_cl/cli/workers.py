"""The options of verbs whose batches other processes and machines may compute."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import integer

if TYPE_CHECKING:
    import argparse
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

__all__ = ["add_workers", "open_workers"]


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Declare ``--workers`` and ``--scheduler``."""
    who = parser.add_mutually_exclusive_group()
    who.add_argument(
        "--workers", type=integer, metavar="N", help="compute in N processes of this machine"
    )
    who.add_argument(
        "--scheduler", metavar="ADDRESS",
        help="compute on the Dask cluster with this scheduler, tcp://HOST:PORT",
    )  # fmt: skip


def open_workers(arguments: argparse.Namespace) -> AbstractContextManager[Executor | None]:
    """Return a context that gives who computes, None where that is this process.

    Without either option these are the ranks of ``mpiexec … python -m mpi4py.futures``, where the
    command was started so.
    """
    from photizon_cl.run.engines import open_executor

    return open_executor(arguments.workers, arguments.scheduler, ranks=True)
