"""How many batches are on the way: as many as the workers need, and never more than fit."""

from __future__ import annotations

import threading
from concurrent.futures import Future

import pytest

import photizon_cl as pz
from hostcode.device.memory import Room
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.run import window as windows
from photizon_cl.run.task import run_task
from photizon_cl.run.window import Window, _bytes_of_an_answer, bytes_on_the_way


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


def made(executor, rays=512):
    compiled = compile_scene(pz.load("cosine-fourth"), pz.RunSettings(rays_per_batch=rays))
    return Window(executor, compiled.tables)


def test_the_window_follows_the_number_of_workers(traced):
    executor = Growing(2)
    window = made(executor)
    assert window.tasks == 4
    executor._max_workers = 5
    assert window.tasks == 10
    executor._max_workers = 1
    assert window.tasks == 2
    assert traced(executor=Growing(2), batches=64)[0].batches == 64


def test_the_window_is_less_where_there_is_no_room(monkeypatch):
    executor = Growing(100)
    tables = made(executor)._tables
    answer = _bytes_of_an_answer(tables)
    left = 40 * answer
    monkeypatch.setattr(windows, "room", lambda: Room(left, left, "this machine"))
    assert made(executor).tasks == 10
    assert bytes_on_the_way(executor, tables) == 10 * answer
    left = 0
    assert made(executor).tasks == 2  # with none at all the run is refused as a whole
    monkeypatch.setattr(windows, "room", lambda: None)
    assert made(executor).tasks == 200


@pytest.mark.parametrize("said", [None, 0, -1, 2.0, True, "8"])
def test_an_executor_that_does_not_say_how_many(said, monkeypatch):
    monkeypatch.setattr(windows.os, "cpu_count", lambda: 3)
    assert made(Growing(said)).tasks == 6


def test_quick_tasks_become_larger_and_the_last_ones_not():
    window = made(Growing(2), 1 << 15)
    usual = 8
    assert window.batches(None) == usual
    window.note(usual, 0.1)
    assert window.batches(None) == 2 * usual
    window.note(usual, 0.1)  # asked for before
    window.note(2 * usual, 0.6)
    assert window.batches(None) == 2 * usual
    for _ in range(9):
        window.note(window.batches(None), 0.01)
    assert window.batches(None) == 16 * usual
    assert made(Growing(2))._most == 512  # whose tallies take more than 16 MiB as it is
    left, sizes = 100 * usual, []
    while left > 0:
        sizes.append(min(window.batches(left), left))
        left -= sizes[-1]
    assert sizes[0] == 16 * usual
    assert sizes == sorted(sizes, reverse=True)
    assert min(sizes[:-1]) == usual


def test_few_batches_are_shared_out():
    assert made(Growing(2)).batches(16) == 4
    assert made(Growing(2)).batches(3) == 1
