"""How many batches are on the way: as many as the workers need, and never more than fit."""

from __future__ import annotations

import threading
from concurrent.futures import Future

import pytest

import photizon_cl as pz
from hostcode.device.memory import Room
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.run import workers
from photizon_cl.run.task import run_task
from photizon_cl.run.workers import Executed


class FirstIsLate:
    """Answers all but the first task at once, and that one when nothing more is asked for."""

    def __init__(self, n_workers):
        self._max_workers = n_workers
        self.asked = 0
        self.while_late = None

    def submit(self, call, task):
        self.asked += 1
        future = Future()
        if self.asked > 1:
            future.set_result(call(task))
            return future

        def answer(before=-1):
            if self.asked != before:
                again = threading.Timer(0.3, answer, (self.asked,))
                again.daemon = True
                again.start()
                return
            self.while_late = self.asked
            future.set_result(run_task(task))

        answer()
        return future


@pytest.mark.parametrize("n", [1, 3])
def test_what_waits_for_one_late_batch_is_bounded(n, right, traced):
    executor = FirstIsLate(n)
    result, lines = traced(executor=executor, batches=64)
    assert executor.while_late == 2 * n
    assert executor.asked == 32
    assert result.tally_digest == pz.trace(right.scene, batches=64).tally_digest
    assert not lines


class Growing(FirstIsLate):
    """Has another worker from some task on."""

    def submit(self, call, task):
        if self.asked == 8:
            self._max_workers = 5
        future = Future()
        self.asked += 1
        future.set_result(call(task))
        return future


def executed(executor, scene="cosine-fourth"):
    compiled = compile_scene(pz.load(scene), pz.RunSettings(rays_per_batch=512))
    return Executed(executor, "scene", compiled.tables, None, None)


def test_the_window_follows_the_number_of_workers(traced):
    executor = Growing(2)
    runner = executed(executor)
    assert runner.window == 4
    executor._max_workers = 5
    assert runner.window == 10
    executor._max_workers = 1
    assert runner.window == 2
    assert traced(executor=Growing(2), batches=64)[0].batches == 64


def test_the_window_is_less_where_there_is_no_room(monkeypatch):
    executor = Growing(100)
    tables = executed(executor)._whole.tables
    answer = workers._bytes_of_an_answer(tables)
    left = 40 * answer
    monkeypatch.setattr(workers, "room", lambda: Room(left, left, "this machine"))
    assert executed(executor).window == 10
    assert workers.bytes_on_the_way(executor, tables) == 10 * answer
    left = 0
    assert executed(executor).window == 2  # with none at all the run is refused as a whole
    monkeypatch.setattr(workers, "room", lambda: None)
    assert executed(executor).window == 200


@pytest.mark.parametrize("said", [None, 0, -1, 2.0, True, "8"])
def test_an_executor_that_does_not_say_how_many(said, monkeypatch):
    monkeypatch.setattr(workers.os, "cpu_count", lambda: 3)
    executor = Growing(said)
    assert executed(executor).window == 6
