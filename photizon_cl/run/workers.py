"""Batches on the workers of an executor: processes, threads or hosts that may fail or misbehave.

A task is a range of batch numbers. It is a pure function of the compiled scene and that range, so
it may run anywhere, more than once, and in any order. What a worker answers is checked before it
counts (`photizon_cl.run.chunks`); a task that is lost, or answered wrongly, is asked for again, and
at last traced in this process, so that the outcome has the same bits whatever the executor does.
"""

from __future__ import annotations

import pickle
import time
import warnings
from collections import OrderedDict
from concurrent.futures import BrokenExecutor, CancelledError
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from hostcode.errors import Abandoned, HostError
from photizon_cl.errors import (
    ArgumentError,
    NoRoomError,
    PhotizonError,
    RunError,
    RunWarning,
    printable,
    show,
)
from photizon_cl.run.chunks import RefusedError, Task, checked, numbers, tables_digest
from photizon_cl.run.desk import Answer, Desk, NotSubmittedError
from photizon_cl.run.distribution import Local, compute
from photizon_cl.run.task import run_task
from photizon_cl.run.window import Window

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables
    from photizon_cl.run.chunks import Chunk
    from photizon_cl.run.progress import Clock

__all__ = ["Executed"]

_TICK: Final = 0.05
"""Seconds after which a wait looks at the clock."""
_TRIES: Final = 2
"""How often an executor is asked for a task before it is traced in this process."""
_MOST_FAILED: Final = 3
"""Tasks that an executor may fail at before it is not asked any more."""
_FIRST_ANSWER: Final = 60.0
"""Seconds in which the first answer may come: processes start, and build the program."""
_LATER_ANSWER: Final = 10.0
_TIMES: Final = 8.0
"""Later ones have so many seconds, or so many times the longest that one took."""


@dataclass(eq=False)
class _Asked:
    """A task and what has come of it."""

    task: Task
    asked_at: float
    tries: int = 0
    here: bool = False
    full: str = ""
    chunk: Chunk | None = None

    def one_by_one(self) -> Iterator[Task]:
        """Give tasks of a single batch each."""
        for k in range(self.task.n):
            yield replace(self.task, first=self.task.first + k, n=1)


class Executed:
    """Runs batches on the workers of an executor.

    Parameters
    ----------
    executor : Executor
        Anything with the interface of `concurrent.futures.Executor`; processes, threads, hosts.
    scene : str
        Digest of the scene, for the workers' caches and their seals.
    tables : DeviceTables
        The compiled scene.
    device : DeviceRecord, str or None
        What each worker chooses its device by.
    plan : ExecutionPlan or None
        How; changes no bit.
    """

    def __init__(
        self,
        executor: Executor,
        scene: str,
        tables: DeviceTables,
        device: DeviceRecord | str | None,
        plan: ExecutionPlan | None,
    ) -> None:
        if not callable(getattr(executor, "submit", None)):
            raise ArgumentError(
                f"executor: found {show(executor)}, expected something with the interface of "
                "concurrent.futures.Executor (it has no method submit)"
            )
        self.executor = executor
        self._whole = Task(
            f"{scene} {device} {plan}", scene, tables_digest(tables), tables, device, plan, 0, 1
        )
        self.window = Window(executor, tables)
        self._clock: Clock | None = None
        self._interrupted: Callable[[], bool] = lambda: False
        self._local: Local | None = None
        self._trusted = self._roomy = True
        self._failed = self._answers = 0
        self._longest = 0.0
        self._tickets: dict[int, _Asked] = {}
        self._next_ticket = 0
        self._said: set[str] = set()
        self._full = ""

    def watch(self, clock: Clock, interrupted: Callable[[], bool]) -> None:
        """Wait no longer than the clock allows, nor beyond Ctrl-C."""
        self._clock, self._interrupted = clock, interrupted

    def full(self) -> bool:
        """Say whether batches ended because a worker had no room."""
        return bool(self._full)

    def complaint(self) -> str:
        """Say that there was no room, or that nobody answered, where that is so."""
        if self._full:
            return self._full
        if self._answers or self._clock is None:
            return ""
        return (
            f"no worker of the executor answered within {self._clock.elapsed():.0f} s (max_seconds "
            f"is {self._clock.limit:g}), so there is nothing to report: workers need some seconds "
            "to start and to build the program; raise max_seconds, or see whether they run"
        )

    # -- in order ------------------------------------------------------------------------------

    def chunks(
        self, first: int, last: int | None, size: Callable[[], int | None]
    ) -> Iterator[Chunk]:
        """Give batches in order, see `Runner.chunks`."""
        asked: OrderedDict[int, _Asked] = OrderedDict()
        self._heard_at = time.perf_counter()
        desk = Desk(self.executor, run_task)
        try:
            while asked or last is None or first < last:
                while (last is None or first < last) and (not asked or self._room(asked)):
                    limit = size()
                    n = self.window.batches(None if last is None else last - first)
                    n = n if limit is None else min(n, limit)
                    asked[first] = _Asked(replace(self._whole, first=first, n=n), 0.0)
                    if self._room(()):
                        self._ask(desk, asked[first])
                    else:  # it is silent, or not asked any more
                        asked[first].here = True
                    first += n
                item = next(iter(asked.values()))
                chunk = self._await(desk, item)
                if chunk is None and not item.full:
                    return
                asked.popitem(last=False)
                if chunk is not None:
                    yield chunk
                    del chunk, item  # others are computed before the caller lets go of this one
                    continue
                for task in item.one_by_one():  # those that there is room for count
                    chunk = self._trace_here(task)
                    if chunk is None:
                        return
                    self._say(
                        "full",
                        f"{numbers(item.task.first, item.task.n)}: a worker of the executor has no "
                        f"room ({item.full}): it is given no more tasks, and the rest is traced in "
                        "this process",
                    )
                    yield chunk
                    del chunk
        finally:
            desk.close()

    def _room(self, asked: Collection[object]) -> bool:
        """Say whether another task may be asked for; neither those nor their answers pile up."""
        return (
            self._trusted
            and self._roomy
            and max(len(asked), len(self._tickets)) < self.window.tasks
        )

    def _ask(self, desk: Desk, item: _Asked) -> None:
        item.tries += 1
        item.asked_at = time.perf_counter()
        seconds = self._clock.seconds_for_workers() if self._clock else None
        self._tickets[self._next_ticket] = item
        desk.ask(self._next_ticket, replace(item.task, seconds=seconds))
        self._next_ticket += 1

    def _await(self, desk: Desk, item: _Asked) -> Chunk | None:
        """Return a task's batches, None where there is no time left for them."""
        while (answer := desk.hear(0.0)) is not None:
            self._take(desk, answer)
        while item.chunk is None:
            if self._over():
                return None
            if item.full:
                return None
            if item.here or not self._trusted:
                return self._trace_here(item.task)
            answer = desk.hear(_TICK)
            if answer is not None:
                self._take(desk, answer)
            else:
                self._look_at_silence(desk, item)
        return item.chunk

    def _over(self) -> bool:
        return self._interrupted() or (self._clock is not None and self._clock.waited_enough())

    # -- answers -------------------------------------------------------------------------------

    def _take(self, desk: Desk, answer: Answer) -> None:
        """Note what came of a task."""
        item = self._tickets.pop(answer.ticket, None)
        if item is None:
            return  # it is not trusted any more
        now = time.perf_counter()
        self._heard_at = now
        error = answer.error
        if error is None:
            if item.chunk is not None:
                return  # the task was asked for twice
            try:
                item.chunk = checked(answer.value, item.task)
            except RefusedError as refused:
                self._fail(desk, item, f"an answer was refused, as it {refused}", wrong=True)
                return
            self._answers += 1
            self._longest = max(self._longest, now - item.asked_at)
            self.window.note(item.task.n, now - item.asked_at)
        elif isinstance(error, BrokenExecutor):
            self._give_up_on(f"the executor broke ({_told(error)})")
        elif isinstance(error, NotSubmittedError):
            self._fail(desk, item, f"a task could not be submitted ({_told(error.__cause__)})")
        elif isinstance(error, NoRoomError):
            item.full, self._roomy = str(error), False
        elif isinstance(error, PhotizonError | HostError):
            raise error
        elif isinstance(error, pickle.PicklingError):
            raise RunError(f"the executor cannot send a task to its workers: {_told(error)}")
        elif not isinstance(error, Abandoned):  # its time is over, as ours is in a moment
            self._fail(desk, item, f"a task was lost ({_told(error)})")

    def _fail(self, desk: Desk, item: _Asked, what: str, *, wrong: bool = False) -> None:
        """Ask for a task again, here at last."""
        if item.chunk is not None or item.here or not self._trusted:
            return
        where = f"{numbers(item.task.first, item.task.n)}: {what}"
        if item.tries < _TRIES and self._roomy:
            if wrong:  # losing a task is what workers do; answering wrongly is not
                self._say("wrong", f"{where}; it is asked for again")
            self._ask(desk, item)
            return
        item.here = True
        self._failed += 1
        if self._failed >= _MOST_FAILED:
            self._give_up_on(f"the executor failed at {self._failed} tasks, the last one {where}")
        else:
            twice = ", twice" if item.tries >= _TRIES else ""
            self._say("here", f"{where}{twice}; the batches are traced in this process")

    def _give_up_on(self, why: str) -> None:
        if self._trusted:
            self._trusted = False
            self._tickets.clear()
            rest = "it is not asked any more, and the rest is traced in this process"
            self._say("given up", f"{why}: {rest}")

    def _look_at_silence(self, desk: Desk, item: _Asked) -> None:
        """Do something about a task whose answer does not come."""
        now = time.perf_counter()
        patience = _FIRST_ANSWER
        if self._answers:
            patience = max(_LATER_ANSWER, _TIMES * self._longest)
        limit = None if self._clock is None else self._clock.limit
        if limit is not None:
            patience = min(patience, limit / (4.0 if self._answers else 2.0))
        waited = now - max(item.asked_at, self._heard_at)
        if waited > patience:
            item.here = True
            self._say(
                "silent",
                f"the executor has not answered for {waited:.0f} s: "
                f"{numbers(item.task.first, item.task.n)} and, until it does, what follows are "
                "traced in this process",
            )
        elif self._answers and now - item.asked_at > patience:
            self._fail(desk, item, f"no answer in {now - item.asked_at:.0f} s")

    def _say(self, kind: str, text: str) -> None:
        """Warn, once of each kind of thing."""
        if kind not in self._said:
            self._said.add(kind)
            warnings.warn(text, RunWarning, stacklevel=2)

    # -- in this process -----------------------------------------------------------------------

    def _trace_here(self, task: Task) -> Chunk | None:
        if self._local is None:
            try:
                self._local = Local(task.tables, task.device, task.plan)
            except NoRoomError as error:  # the batches so far count
                them = "it" if task.n == 1 else "them"
                self._full = (
                    f"the executor did not compute {numbers(task.first, task.n)}, and this process "
                    f"has no room for {them}: {error}"
                )
                return None
            except PhotizonError as error:
                raise RunError(
                    f"the executor did not compute {numbers(task.first, task.n)}, and this "
                    f"process cannot: {error}"
                ) from error
            self._local.engine.give_up = self._over
        try:
            return compute(self._local.engine, task.first, task.n)
        except Abandoned:
            return None
        except NoRoomError as error:
            self._full = str(error)
            return None


def _told(error: BaseException | None) -> str:
    """Return what an executor raised, in a line that is fit to be shown."""
    name = type(error).__name__
    if isinstance(error, CancelledError):
        return "it was cancelled"
    try:
        text = " ".join(str(error).split())
    except Exception:  # the exception's own text may fail
        text = ""
    text = text if len(text) <= 200 else f"{text[:200]}…"
    return printable(f"{name}: {text}" if text else name)
