"""The workers of a Dask cluster, as an executor.

Against `distributed.Client.get_executor`: a task that is asked for again is computed again (Dask
else gives the answer that it has, were it a damaged one); one whose answer cannot be fetched is
answered with why, and not never; the number of workers is told; and each
worker process computes one task at a time, always in the same thread, with as many threads for a
CPU device as Dask gives that worker, so that it opens one device and keeps its programs.
"""

from __future__ import annotations

import logging
import os
import re
import threading
import time
import warnings
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from hostcode.device.pocl_environment import limited_thread_environment
from photizon_cl.errors import ArgumentError, RunError, printable, show

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["DaskWorkers", "connected", "of_dask"]

_ADDRESS: Final = re.compile(
    r"((tcp|tls|ws|wss|ucx)://)?([^\s/:@\[\]]+|\[[0-9A-Fa-f:.%]+\]):\d{1,5}"
)
_LOGGERS: Final = ("distributed", "tornado")
_CONNECT: Final = 10.0
"""Seconds for a scheduler to answer, and to have a worker."""
_RECONNECT: Final = 10.0
"""Seconds for a connection that was lost to be there again."""
_LOOK: Final = 1.0
"""Seconds for which a count of workers holds, and which it may take."""


class DaskWorkers(Executor):
    """An executor of a Dask client's workers.

    Parameters
    ----------
    client : distributed.Client
        Connected; whoever made it closes it.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._count, self._looked = 0, -_LOOK
        self.look()

    @property
    def _max_workers(self) -> int:
        """Worker processes, as last seen."""
        return max(self._count, 1)

    def look(self) -> int:
        """Return how many workers there are, counted anew where that was not done just now."""
        if time.monotonic() - self._looked >= _LOOK:
            with suppress(Exception):  # a scheduler that is slow or gone: as they were
                ask = self._client.scheduler.ncores
                self._count = len(self._client.sync(ask, callback_timeout=_LOOK))
            self._looked = time.monotonic()
        return self._count

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Have a call made by some worker."""
        until = time.monotonic() + _RECONNECT
        while self._client.status == "connecting" and time.monotonic() < until:
            time.sleep(0.05)
        if self._client.status != "running":
            raise BrokenExecutor("the connection to the Dask scheduler is lost")
        self.look()
        # else what was computed once, and refused, would be what is answered again
        asked = self._client.submit(_in_one_thread, call, arguments, named, pure=False)
        future: Future[Any] = Future()
        future.add_done_callback(lambda done: asked.cancel() if done.cancelled() else None)
        asked.add_done_callback(lambda done: _hand_over(done, future))
        return future


def _hand_over(asked: Any, future: Future[Any]) -> None:
    """Let a future have what came of one of Dask's, which the cluster need not keep any more."""
    try:
        if future.set_running_or_notify_cancel():
            future.set_result(asked.result())
    except BaseException as error:  # of the call, or of fetching what it gave
        future.set_exception(error)
    finally:
        asked.release()


def of_dask(executor: Any) -> Any:
    """Return what runs on a Dask cluster as `DaskWorkers`, and anything else as it is."""
    kind = type(executor)
    if kind.__module__.partition(".")[0] != "distributed":
        return executor
    if kind.__name__ == "ClientExecutor":
        return DaskWorkers(executor._client)
    return DaskWorkers(executor) if kind.__name__ == "Client" else executor


@contextmanager
def connected(address: object) -> Iterator[DaskWorkers]:
    """Give the workers of the cluster whose scheduler has an address.

    Raises
    ------
    ArgumentError
        Where that is no address, or Dask is not installed.
    RunError
        Where no scheduler answers there, or it has no workers.
    """
    if not isinstance(address, str) or not _ADDRESS.fullmatch(address):
        raise ArgumentError(
            f"scheduler: found {show(address)}, expected the address of a Dask scheduler, as it "
            "prints it itself: tcp://HOST:PORT"
        )
    try:
        distributed = import_module("distributed")
        config = import_module("dask.config")
    except ImportError as error:
        raise ArgumentError(
            f"scheduler: found {show(address)}, and Dask cannot be imported ({error}): install it "
            "with `pip install 'photizon-cl[dask]'`"
        ) from None
    # Scenes of many elements are large, and travel with every task.
    with _quiet(), config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"}):
        try:
            client = _client(distributed.Client, address)
        except Exception as error:  # whatever may answer at an address
            text = " ".join(str(error).split())[:200]
            raise RunError(
                f"scheduler: no Dask scheduler answers at {show(address)} "
                f"({type(error).__name__}: {printable(text)}): see whether it runs, and whether "
                "this machine may reach it"
            ) from None
        try:
            workers = DaskWorkers(client)
            _wait_for_one(workers, address)
            yield workers
        finally:
            with suppress(Exception):  # a scheduler that does not answer any more
                client.close(timeout=2)


def _client(make: Callable[..., Any], address: str) -> Any:
    """Return a client; raise whatever is in its way, and TimeoutError where nothing answers.

    Its own time-out does not hold where something listens at the address and says nothing.
    """
    made: Future[Any] = Future()

    def connect() -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # other versions: answers are checked in any case
                client = make(address, timeout=_CONNECT, set_as_default=False, name="photizon")
            if made.set_running_or_notify_cancel():
                made.set_result(client)
            else:  # too late
                client.close(timeout=2)
        except Exception as error:
            if made.set_running_or_notify_cancel():
                made.set_exception(error)

    threading.Thread(target=connect, name="photizon-connect", daemon=True).start()
    wait((made,), _CONNECT + 1.0)
    if made.cancel():
        raise TimeoutError(f"nothing was said in {_CONNECT:g} s")
    return made.result()


def _wait_for_one(workers: DaskWorkers, address: str) -> None:
    until = time.monotonic() + _CONNECT
    while not workers.look():
        if time.monotonic() > until:
            raise RunError(
                f"scheduler: {show(address)} has no workers: start some with `dask worker "
                f"{printable(address)}`"
            )
        time.sleep(0.1)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Dask from logging that a connection was lost: what follows from it is said."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith(_LOGGERS)]
    ours = [logger for logger in map(logging.getLogger, names) if not logger.disabled]
    for logger in ours:
        logger.disabled = True
    try:
        yield
    finally:
        for logger in ours:
            logger.disabled = False


# -- in the worker -----------------------------------------------------------------------------

_starting = threading.Lock()
_thread: ThreadPoolExecutor | None = None


def _in_one_thread(call: Callable[..., Any], arguments: Any, named: Any) -> Any:
    """Make a call in the one thread of this process that has the device."""
    global _thread
    with _starting:
        if _thread is None:
            worker = import_module("distributed").get_worker()
            os.environ.update(limited_thread_environment(worker.state.nthreads, os.environ))
            _thread = ThreadPoolExecutor(1, thread_name_prefix="photizon")
    return _thread.submit(call, *arguments, **named).result()
