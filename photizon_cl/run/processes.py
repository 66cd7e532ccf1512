"""Worker processes of this machine, as an executor.

Against `concurrent.futures.ProcessPoolExecutor`: a process that dies takes its own task along and
no other's, and another one takes its place; a process has its share of the processor's threads from
its start; it ends with the one that began it, however that ends; Ctrl-C in a terminal does not
reach it; and it imports nothing of the script that began it, which so needs no
``if __name__ == "__main__"``.

A thread for each process writes a call to its standard input and reads the answer from its standard
output, both as pickles behind their length.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from hostcode.device.pocl_environment import cores, limited_thread_environment

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future
    from typing import BinaryIO

__all__ = ["Processes", "WorkerLostError", "serve"]

_LENGTH: Final = struct.Struct("<Q")
_START: Final = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from photizon_cl.run.processes import serve; serve()"
)
_ENDING: Final = 5.0
"""Seconds for a process to be gone that has closed its output, before it is killed."""


class WorkerLostError(Exception):
    """A worker process ended before it answered."""


class Processes(ThreadPoolExecutor):
    """An executor whose calls are made in processes of their own, started at the first ones.

    Parameters
    ----------
    workers : int
        How many processes, at least 1.
    threads : int, optional
        Threads that each may give a CPU device; default an equal share of this process's
        processors, at least 1. A lower limit in the environment holds.
    """

    def __init__(self, workers: int, threads: int | None = None) -> None:
        super().__init__(workers, thread_name_prefix="photizon-worker")
        self.threads = threads or max(len(cores()) // workers, 1)
        self._mine = threading.local()
        self._lock = threading.Lock()
        self._children: set[_Child] = set()
        self._closed = False

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Have a call made in one of the processes."""
        return super().submit(self._through, call, arguments, named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """As of any executor; where it waits, no process is left."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        if wait:
            self._end_all()

    def close(self) -> None:
        """End all processes now; what they have begun is lost."""
        self._end_all()
        self.shutdown(cancel_futures=True)

    def processes(self) -> list[int]:
        """Return the numbers of the processes that there are now."""
        with self._lock:
            return sorted(child.process.pid for child in self._children)

    # -- in a thread of its own for each process --------------------------------------------------

    def _through(self, call: Any, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        asked = pickle.dumps((call, arguments, named), pickle.HIGHEST_PROTOCOL)
        child: _Child | None = getattr(self._mine, "child", None)
        if child is None:
            child = self._mine.child = self._start()
        try:
            child.write(asked)
            answer = child.read()
        except (OSError, EOFError, ValueError) as error:  # ValueError: a pipe closed meanwhile
            self._mine.child = None
            raise WorkerLostError(self._end(child)) from error
        done, value = pickle.loads(answer)
        if not done:
            raise value
        return value

    def _start(self) -> _Child:
        with self._lock:
            if self._closed:
                raise WorkerLostError("the worker processes are being ended")
            child = _Child(self.threads)
            self._children.add(child)
            return child

    def _end(self, child: _Child) -> str:
        """See a process off; return how it ended."""
        how = child.end()
        with self._lock:
            self._children.discard(child)
        return how

    def _end_all(self) -> None:
        with self._lock:
            self._closed = True
            children = list(self._children)
        for child in children:  # all first, so that none waits for another
            child.process.kill()
        for child in children:
            self._end(child)


class _Child:
    """A process, seen from the one that began it."""

    def __init__(self, threads: int) -> None:
        limits = limited_thread_environment(threads, os.environ)
        self.process = subprocess.Popen(
            [sys.executable, "-c", _START],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **limits},
            start_new_session=True,  # Ctrl-C in the terminal is for the process that saves
        )
        self._send(pickle.dumps(sys.path))

    @property
    def _pipes(self) -> tuple[BinaryIO, BinaryIO]:
        sent, received = self.process.stdin, self.process.stdout
        assert sent is not None
        assert received is not None
        return sent, received  # type: ignore[return-value]

    def _send(self, *parts: bytes) -> None:
        pipe = self._pipes[0]
        with suppress(OSError):  # it is gone, which the next read tells
            for part in parts:
                pipe.write(part)
            pipe.flush()

    def write(self, data: bytes) -> None:
        """Send a call."""
        self._send(_LENGTH.pack(len(data)), data)

    def read(self) -> bytes:
        """Wait for an answer."""
        return _read(self._pipes[1])

    def end(self) -> str:
        """Reap the process, killed where it lingers; return how it ended."""
        try:
            status = self.process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        for pipe in self._pipes:
            with suppress(OSError):
                pipe.close()
        if status >= 0:
            return f"a worker process ended with status {status}"
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        return f"a worker process was ended by {name}"


def _read(pipe: BinaryIO) -> bytes:
    """Return the next pickle.

    Raises
    ------
    EOFError
        Where the other side is gone.
    """
    (length,) = _LENGTH.unpack(_exactly(pipe, _LENGTH.size))
    return _exactly(pipe, length)


def _exactly(pipe: BinaryIO, n: int) -> bytes:
    data = pipe.read(n)
    if len(data) < n:
        raise EOFError
    return data


# -- in the process --------------------------------------------------------------------------------


def serve() -> None:
    """Make the calls that come on standard input, one after the other, until it ends."""
    # What a library prints must not come between answers.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, waiting), daemon=True).start()
    while True:
        answer = _answer(waiting.get())
        try:
            answers.write(_LENGTH.pack(len(answer)) + answer)
            answers.flush()
        except OSError:
            os._exit(1)


def _listen(calls: BinaryIO, waiting: queue.SimpleQueue[bytes]) -> None:
    """Put calls into a queue; end the process at once when nobody is there any more."""
    try:
        while True:
            waiting.put(_read(calls))
    except BaseException:
        os._exit(0)


def _answer(asked: bytes) -> bytes:
    """Make a call; return the pickle of what came of it."""
    try:
        call, arguments, named = pickle.loads(asked)
        answer: tuple[bool, Any] = True, call(*arguments, **named)
    except BaseException as error:
        answer = False, error
    try:
        return pickle.dumps(answer, pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        said = f"{type(answer[1]).__name__}, which cannot be sent ({type(error).__name__})"
        return pickle.dumps((False, RuntimeError(said)))
