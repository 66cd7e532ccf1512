"""Asking an executor and hearing of it, without ever waiting inside its code.

What an executor does in ``submit`` and what its futures do is its own: either may block, or raise
anything. So a thread of its own submits, and answers come through a queue. What is raised in the
thread that waits for them is then never the executor's: the handler of a signal may raise what it
likes there.
"""

from __future__ import annotations

import os
import queue
import threading
from concurrent.futures import BrokenExecutor, CancelledError
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.run.chunks import Chunk, Task

__all__ = ["Answer", "Desk", "NotSubmittedError"]

_LEAVING: Final = 1.0
"""Seconds that the end of a run waits for the last submission."""


class NotSubmittedError(Exception):
    """The executor did not take a task."""


@dataclass(frozen=True)
class Answer:
    """What came of a task.

    Parameters
    ----------
    ticket : int
        Of the task, see `Desk.ask`.
    value : object
        What it returned, not checked.
    error : BaseException or None
        What was raised instead.
    """

    ticket: int
    value: object = None
    error: BaseException | None = None


class _Thread:
    """Does what it is told, one thing after the other; kept from run to run."""

    def __init__(self) -> None:
        self.jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.thread = threading.Thread(target=self._work, name="photizon-submit", daemon=True)
        self.thread.start()

    def _work(self) -> None:
        while True:
            self.jobs.get()()


_idle: list[_Thread] = []
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # threads do not survive that


class Desk:
    """Where a run's tasks are handed out and answers come in.

    Parameters
    ----------
    executor : Executor
        Who computes.
    call : callable
        What it is to call with each task.
    """

    def __init__(self, executor: Any, call: Callable[[Task], Chunk]) -> None:
        self._executor, self._call = executor, call
        self._answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        self._futures: dict[int, Any] = {}
        self._closed = False
        try:
            self._thread = _idle.pop()
        except IndexError:
            self._thread = _Thread()

    def ask(self, ticket: int, task: Task) -> None:
        """Have a task submitted; the answer comes under its ticket."""
        self._thread.jobs.put(lambda: self._submit(ticket, task))

    def hear(self, seconds: float) -> Answer | None:
        """Return the next answer, None where none came in time."""
        try:
            return self._answers.get(timeout=seconds) if seconds else self._answers.get_nowait()
        except queue.Empty:
            return None

    def close(self) -> None:
        """Cancel what was not begun; what goes on is not waited for."""
        self._closed = True
        left = threading.Event()
        self._thread.jobs.put(lambda: self._cancel(left))
        left.wait(_LEAVING)  # an executor that does not return from `submit` keeps its thread

    def _submit(self, ticket: int, task: Task) -> None:
        if self._closed:
            return
        try:
            future = self._executor.submit(self._call, task)
            when_done = getattr(future, "add_done_callback", None)
            if not callable(when_done):
                raise TypeError(f"submit gave a {type(future).__name__} and no Future")
            self._futures[ticket] = future
            when_done(lambda done: self._done(ticket, done))
        except BrokenExecutor as broken:
            self._answers.put(Answer(ticket, error=broken))
        except BaseException as error:
            wrapped = NotSubmittedError()
            wrapped.__cause__ = error
            self._answers.put(Answer(ticket, error=wrapped))

    def _done(self, ticket: int, future: Any) -> None:
        self._futures.pop(ticket, None)
        try:
            error = CancelledError() if future.cancelled() else future.exception()
            answer = Answer(ticket, future.result() if error is None else None, error)
        except BaseException as error:
            answer = Answer(ticket, error=error)
        self._answers.put(answer)

    def _cancel(self, left: threading.Event) -> None:
        try:
            for future in list(self._futures.values()):
                try:
                    future.cancel()
                except Exception:
                    continue
        finally:
            _idle.append(self._thread)
            left.set()
