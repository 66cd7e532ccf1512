"""What a worker of an executor does with a task, in its own process or thread."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from hostcode.errors import Abandoned
from photizon_cl.errors import NoRoomError
from photizon_cl.run.chunks import sealed, tables_digest
from photizon_cl.run.distribution import compute, make_engine

if TYPE_CHECKING:
    from hostcode.run.wavefront import Engine
    from photizon_cl.run.chunks import Chunk, Task

__all__ = ["run_task"]

_KEPT_ENGINES: Final = 2
"""Engines that a worker keeps: enough for two traces that take turns."""

_mine = threading.local()


def run_task(task: Task) -> Chunk:
    """Compute a task's batches; what an executor is given.

    Opens a device in the worker at the first task and keeps it, with the last few scenes' programs.

    Raises
    ------
    Abandoned
        Where the time is over that the task had.
    """
    engines: OrderedDict[tuple[str, str], Engine] | None = getattr(_mine, "engines", None)
    if engines is None:
        engines = _mine.engines = OrderedDict()
    digest = tables_digest(task.tables)
    key = task.key, digest
    engine = engines.pop(key, None) or _made(task, engines)
    until = None if task.seconds is None else time.perf_counter() + task.seconds
    engine.give_up = None if until is None else lambda: time.perf_counter() > until
    try:
        chunk = compute(engine, task.first, task.n)
    except Abandoned:
        engines[key] = engine
        raise
    # one that failed is not kept: after a full queue it is of no more use, and large
    engines[key] = engine
    while len(engines) > _KEPT_ENGINES:
        engines.popitem(last=False)
    return sealed(chunk, task, digest)


def _made(task: Task, kept: OrderedDict[tuple[str, str], Engine]) -> Engine:
    """Make an engine; those that are kept go where it has no room beside them."""
    if kept:
        try:
            return make_engine(task.device, task.tables, task.plan)
        except NoRoomError:
            kept.clear()
    return make_engine(task.device, task.tables, task.plan)
