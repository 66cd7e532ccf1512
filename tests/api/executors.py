"""Executors that misbehave, each in one way."""

from __future__ import annotations

import copy
import dataclasses
import threading
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import numpy as np

from photizon_cl.run.chunks import Chunk
from photizon_cl.run.task import run_task


class Doing:
    """An executor whose answers come from a function of the task.

    Parameters
    ----------
    answer : callable
        What it does instead of `run_task`.
    every : int
        1: for all tasks, each time; more: for every so many tasks of two batches, the first time.
    """

    _max_workers = 2

    def __init__(self, answer, every=1):
        self.answer, self.every = answer, every
        self.asked = 0
        self.seen = set()

    def right(self, task):
        again = task.first in self.seen
        self.seen.add(task.first)
        return self.every > 1 and (again or task.first // 2 % self.every)

    def submit(self, call, task):
        assert call is run_task
        self.asked += 1
        future = Future()
        if self.right(task):
            future.set_result(call(task))
            return future
        try:
            future.set_result(self.answer(task))
        except BaseException as error:
            future.set_exception(error)
        return future


class First:
    """Answers every task with what it computed for the first one."""

    def __init__(self):
        self.kept = None

    def __call__(self, task):
        if self.kept is None:
            self.kept = run_task(task)
        return self.kept


def altered(**changes):
    """Return an answer whose chunk has members changed by functions of it."""

    def answer(task):
        chunk = run_task(task)
        return dataclasses.replace(chunk, **{k: f(chunk) for k, f in changes.items()})

    return answer


def resealed(**changes):
    """Return an answer whose seal has members changed."""
    return altered(seal=lambda chunk: dataclasses.replace(chunk.seal, **changes))


def of_task(**changes):
    """Return the answer to a task that was changed on the way."""
    return lambda task: run_task(
        dataclasses.replace(task, **{k: f(task) for k, f in changes.items()})
    )


def other_seed(task):
    tables = copy.copy(task.tables)
    object.__setattr__(tables, "launch", {**tables.launch, "seed": 77})
    return tables


def other_numbers(task):
    tables = copy.copy(task.tables)
    geometry = tables.geometry.copy()
    geometry.flat[-1] += 1.0
    object.__setattr__(tables, "geometry", geometry)
    return tables


def one_bit(chunk):
    cells = [tally.copy() for tally in chunk.cells]
    cells[-1].flat[1] ^= 1
    return tuple(cells)


class Evil:
    """Raises at every touch."""

    def __getattribute__(self, name):
        raise RuntimeError("touched")


WRONG = {
    "always the first chunk": First,
    "shifted": lambda: of_task(first=lambda t: t.first + 1),
    "shifted label": lambda: altered(first=lambda c: c.first + 1),
    "reversed": lambda: altered(cells=lambda c: c.cells[::-1]),
    "short": lambda: altered(cells=lambda c: c.cells[:-1]),
    "short and sealed so": lambda: of_task(n=lambda t: t.n - 1),
    "long": lambda: altered(cells=lambda c: (*c.cells, c.cells[0])),
    "long and sealed so": lambda: of_task(n=lambda t: t.n + 1),
    "empty": lambda: altered(cells=lambda c: ()),
    "a bit flipped": lambda: altered(cells=one_bit),
    "cells of another shape": lambda: altered(cells=lambda c: tuple(x[:-1] for x in c.cells)),
    "cells as doubles": lambda: altered(cells=lambda c: tuple(x * 1.0 for x in c.cells)),
    "cells as lists": lambda: altered(cells=lambda c: tuple(x.tolist() for x in c.cells)),
    "another seed": lambda: of_task(tables=other_seed),
    "tables damaged": lambda: of_task(tables=other_numbers),
    "another scene": lambda: of_task(scene=lambda t: "sha256:" + 64 * "0"),
    "another engine": lambda: resealed(engine="0123456789abcdef"),
    "no seal": lambda: altered(seal=lambda c: None),
    "a seal of text": lambda: resealed(first="0", n=[], n_cells=None),
    "no checksum": lambda: resealed(checksum=""),
    "a device to fool a terminal": lambda: altered(device=lambda c: "cpu\x1b[2J"),
    "a time that is none": lambda: altered(build_seconds=lambda c: float("nan")),
    "nothing": lambda: lambda task: None,
    "a number": lambda: lambda task: 5,
    "text": lambda: lambda task: "batches",
    "a list": lambda: lambda task: [run_task(task)],
    "an array": lambda: lambda task: np.zeros((4, 4), np.int64),
    "a chunk of nothing": lambda: lambda task: Chunk(None, None, None, None),
    "what raises at every touch": lambda: lambda task: Evil(),
}
"""Answers that are wrong, by what is wrong."""


def raising(error):
    def answer(task):
        raise error

    return answer


LOST = {
    "a time-out": lambda: raising(TimeoutError("the host did not answer")),
    "a lost connection": lambda: raising(ConnectionError("gone")),
    "out of memory": lambda: raising(MemoryError()),
    "a worker's exit": lambda: raising(SystemExit(1)),
    "Ctrl-C in the worker": lambda: raising(KeyboardInterrupt()),
    "control characters": lambda: raising(ValueError("\x1b[2Jgone\u202e")),
}
"""Tasks that are lost, by what is raised."""


class Broken(Doing):
    """A pool that breaks at the third task and refuses every later one."""

    def __init__(self):
        super().__init__(None, every=1 << 30)
        self.seen.add(0)

    def submit(self, call, task):
        if self.asked >= 2:
            raise BrokenProcessPool("a child process terminated abruptly")
        return super().submit(call, task)


class BrokenLate(Broken):
    """A pool that breaks while it has tasks."""

    def submit(self, call, task):
        if self.asked < 2:
            return super().submit(call, task)
        future = Future()
        future.set_exception(BrokenProcessPool("a child process terminated abruptly"))
        return future


class Silent:
    """Never answers."""

    def submit(self, call, task):
        return Future()


class Blocking:
    """Never returns from submit."""

    def submit(self, call, task):
        threading.Event().wait()


class Not:
    """Gives something that is no future."""

    def __init__(self, what):
        self.what = what

    def submit(self, call, task):
        return self.what


class LosingOne(Doing):
    """Never answers the task that begins with a batch, the first time; answers all others."""

    def __init__(self, batch, times=1):
        super().__init__(None, every=1 << 30)
        self.seen.add(0)
        self.batch, self.times = batch, times

    def submit(self, call, task):
        if task.first == self.batch and self.times:
            self.times -= 1
            return Future()
        return super().submit(call, task)
