"""How many tasks of an executor are under way at a time, and how many batches each has.

Enough that no worker waits for its next task, and that what a task costs beside its batches (a few
milliseconds of pickling and of the engine that carries it) does not count; so few that tallies that
wait for their turn have room, and that workers end together.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final

from hostcode.device.memory import room
from hostcode.run.tally import CELL, is_sparse

if TYPE_CHECKING:
    from hostcode.run.tables import DeviceTables

__all__ = ["Window", "bytes_on_the_way"]

RAYS_OF_A_TASK: Final = 1 << 18
"""At first; a GPU does them in a hundredth of a second."""
_MOST_TIMES: Final = 16
"""So many times as large tasks may become."""
_BYTES_OF_A_TASK: Final = 1 << 26
"""Tallies that travel together, where there is more than one."""
_BYTES_OF_A_LARGER_ONE: Final = 1 << 24
_QUICK: Final = 0.5
"""Seconds from asking to the answer, below which the next tasks are twice as large."""
TASKS_OF_A_WORKER: Final = 2
"""Under way, so that none waits for the next one."""
_PART_OF_ROOM: Final = 0.25
"""Of the memory that is left, what answers that wait for their turn may take."""


class Window:
    """Of an executor and a scene.

    Parameters
    ----------
    executor : Executor
        Where it has an attribute ``_max_workers``, that is how many workers it has now.
    tables : DeviceTables
        The compiled scene.
    """

    def __init__(self, executor: object, tables: DeviceTables) -> None:
        self._executor, self._tables = executor, tables
        self._seen, self._tasks = 0, 0
        self._usual, self._most = _batches(tables)
        self._size = self._usual
        self._least = 0

    @property
    def tasks(self) -> int:
        """Under way at a time; follows the number of workers, which may come and go."""
        workers = _workers(self._executor)
        if workers != self._seen:
            self._seen, self._tasks = workers, _tasks(workers, self._tables)
        return self._tasks

    def batches(self, left: int | None) -> int:
        """Return how many batches the next task has, of those that are left where that is known."""
        if left is None:
            return self._size
        # Shared out among the workers rather than given whole to a few of them; no larger than
        # those at first in the end, so that they end together.
        share = max(-(-left // self.tasks), 1)
        self._least = self._least or min(self._usual, share)
        return max(min(self._size, share), self._least)

    def note(self, batches: int, seconds: float) -> None:
        """Take down how long a task took, from asking to the answer."""
        if batches == self._size and seconds < _QUICK:
            self._size = min(2 * self._size, self._most)


def bytes_on_the_way(executor: object, tables: DeviceTables) -> int:
    """Return what answers that wait for their turn take at most."""
    return _tasks(_workers(executor), tables) * _bytes_of_an_answer(tables)


def _workers(executor: object) -> int:
    workers = getattr(executor, "_max_workers", None)
    return workers if type(workers) is int and workers > 0 else os.cpu_count() or 1


def _tasks(workers: int, tables: DeviceTables) -> int:
    tasks, left = TASKS_OF_A_WORKER * workers, room()
    if left is None:
        return tasks
    fit = int(_PART_OF_ROOM * left.left) // _bytes_of_an_answer(tables)
    return max(min(tasks, fit), TASKS_OF_A_WORKER)


def _batches(tables: DeviceTables) -> tuple[int, int]:
    """Return how many batches a task has at first, and at most."""
    rays, cells = int(tables.launch["rays_per_batch"]), 8 * CELL * tables.n_cells
    usual = max(min(RAYS_OF_A_TASK // rays, _BYTES_OF_A_TASK // cells), 1)
    most = min(_MOST_TIMES * RAYS_OF_A_TASK // rays, _BYTES_OF_A_LARGER_ONE // cells)
    return usual, max(most, usual)


def _bytes_of_an_answer(tables: DeviceTables) -> int:
    """Return what an answer takes at most, with what it came in."""
    cells = tables.n_cells
    if is_sparse(cells):
        cells = min(cells, int(tables.launch["rays_per_batch"]))
    return 2 * _batches(tables)[1] * 8 * (CELL + 1) * cells
