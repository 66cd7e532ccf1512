"""Memory that runs short in mid-run: one line, and the batches that are whole."""

from __future__ import annotations

import pickle
import threading
import warnings
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from plates import GB, line_of, parts, scene

import photizon_cl as pz
from benchmarks.limits import endless
from hostcode.device.memory import Room
from hostcode.program.plan import ExecutionPlan
from hostcode.run import queue, tally
from hostcode.run.sizes import Sizes
from photizon_cl.cli.main import main
from photizon_cl.errors import NoRoomError, RunWarning
from photizon_cl.run import batches, distribution, memory, task, window, workers
from photizon_cl.run.chunks import Task, tables_digest
from photizon_cl.run.needs import Needs


def no_more_after(monkeypatch, n, where=lambda: True):
    """Have the queue be full in all batches from the n-th on, wherever they are traced."""
    usual = distribution.Engine.run

    def run(self, first, count):
        for batch in range(first, first + count):
            if batch >= n and where():
                raise queue.QueueFull("more rays split off than may wait")
            yield from usual(self, batch, 1)

    monkeypatch.setattr(distribution.Engine, "run", run)


def only_one_at_a_time(monkeypatch):
    """Have the queue be full where several batches are in flight; return the engines made."""
    usual, make = distribution.Engine.run, distribution.make_engine
    engines = []

    def run(self, first, count):
        if count > 1 and first:
            raise queue.QueueFull("more rays split off than may wait")
        yield from usual(self, first, count)

    def made(*arguments):
        # as a run finds it: what is waiting to be collected takes memory all the same
        alive = sum(engine() is not None for engine in engines)
        engines.append(weakref.ref(engine := make(*arguments)))
        assert not alive, "an engine was made while another one held as much"
        return engine

    monkeypatch.setattr(distribution.Engine, "run", run)
    monkeypatch.setattr(distribution, "make_engine", made)
    return engines


SEVERAL = {
    "batches": 6,
    "rays_per_batch": 64,
    "plan": ExecutionPlan(lanes=8, items=8, wave_rays=128),
}
"""Two batches in flight at a time."""


def test_an_engine_has_gone_before_the_next_one_takes_as_much(monkeypatch):
    whole = pz.trace("cosine-fourth", **SEVERAL)
    engines = only_one_at_a_time(monkeypatch)
    found = pz.trace("cosine-fourth", **SEVERAL)
    assert len(engines) == 2
    assert found.tally_digest == whole.tally_digest


def test_batches_count_where_there_is_no_room_for_an_engine_any_more(monkeypatch):
    two = pz.trace("cosine-fourth", **{**SEVERAL, "batches": 2})
    engines = only_one_at_a_time(monkeypatch)
    check = distribution._check_buffers

    def once(*arguments):
        if engines:
            raise NoRoomError("the buffers take 2 GB, and 1 GB are left")
        check(*arguments)

    monkeypatch.setattr(distribution, "_check_buffers", once)
    with pytest.warns(RunWarning, match="the buffers take 2 GB, and 1 GB are left"):
        found = pz.trace("cosine-fourth", **SEVERAL)
    assert (found.info.stopped, found.batches) == ("memory", 2)
    assert found.tally_digest == two.tally_digest


def in_a_worker():
    """Say whether this thread is one of an executor's."""
    return threading.current_thread() is not threading.main_thread()


def with_workers(pool, **how):
    """Trace with an executor; return the result and the warnings."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = pz.trace("cosine-fourth", executor=pool, **how)
    return found, [line_of(w.message) for w in said if issubclass(w.category, RunWarning)]


HOW = {"batches": 16, "rays_per_batch": 512}


def small_tasks(monkeypatch, rays=512):
    """Have tasks of so many rays, however quickly they are answered."""
    monkeypatch.setattr(window, "RAYS_OF_A_TASK", rays)
    monkeypatch.setattr(window, "_QUICK", 0.0)


@pytest.mark.parametrize("rays_of_a_task", [512, 4 * 512])
def test_a_worker_without_room_ends_a_run_as_this_process_does(monkeypatch, rays_of_a_task):
    no_more_after(monkeypatch, 7)
    small_tasks(monkeypatch, rays_of_a_task)
    with pytest.warns(RunWarning, match="more rays split off than may wait"):
        here = pz.trace("cosine-fourth", **HOW)
    with ThreadPoolExecutor(2) as pool:
        there, said = with_workers(pool, **HOW)
    assert said[-1] == "more rays split off than may wait"
    # batches 4 to 6 of the task of four are traced here, one by one
    first = ["batches 4 to 7: a worker of the executor has no room"] if rays_of_a_task > 512 else []
    assert [line.split(" (")[0] for line in said[:-1]] == first
    assert here.info.stopped == there.info.stopped == "memory"
    assert here.batches == there.batches == 7
    assert here.tally_digest == there.tally_digest


class Counting(ThreadPoolExecutor):
    """Counts the tasks that it is given."""

    tasks = 0

    def submit(self, *arguments, **more):
        self.tasks += 1
        return super().submit(*arguments, **more)


def test_where_workers_have_no_room_and_this_process_has(monkeypatch):
    whole = pz.trace("cosine-fourth", **HOW)
    no_more_after(monkeypatch, 3, in_a_worker)
    small_tasks(monkeypatch)
    with Counting(1) as pool:
        found, said = with_workers(pool, **HOW)
        tasks = pool.tasks
    assert (found.batches, found.tally_digest) == (16, whole.tally_digest)
    (line,) = said
    assert line == (
        "batch 3: a worker of the executor has no room (more rays split off than may wait): it is "
        "given no more tasks, and the rest is traced in this process"
    )
    assert tasks <= 4 + window.TASKS_OF_A_WORKER


def test_where_neither_workers_nor_this_process_have_room(monkeypatch):
    five = pz.trace("cosine-fourth", **{**HOW, "batches": 5})
    no_more_after(monkeypatch, 5, in_a_worker)
    small_tasks(monkeypatch)

    def none(*_):
        raise NoRoomError("the device's buffers take 2 GB")

    monkeypatch.setattr(workers, "Local", none)
    with ThreadPoolExecutor(2) as pool:
        found, said = with_workers(pool, **HOW)
    (line,) = said
    assert line == (
        "the executor did not compute batch 5, and this process has no room for it: the device's "
        "buffers take 2 GB"
    )
    assert (found.info.stopped, found.batches) == ("memory", 5)
    assert found.tally_digest == five.tally_digest


def test_a_worker_lets_kept_engines_go_where_another_has_no_room(monkeypatch):
    made, _, plan = parts(scene(8))
    one = Task("a", "a", tables_digest(made.tables), made.tables, None, plan, 0, 1)
    kept, check = [], distribution._check_buffers

    def beside_none(*arguments):
        if any(engine() is not None for engine in kept):
            raise NoRoomError("there is one already")
        check(*arguments)

    monkeypatch.setattr(task, "_mine", threading.local())
    task.run_task(one)
    kept += map(weakref.ref, task._mine.engines.values())
    assert len(kept) == 1
    monkeypatch.setattr(distribution, "_check_buffers", beside_none)
    task.run_task(one)  # with the engine that is kept
    found = task.run_task(replace(one, key="b"))
    assert list(task._mine.engines) == [("b", one.digest)]
    assert found.cells[0].tobytes() == task.run_task(replace(one, key="b")).cells[0].tobytes()
    no_more_after(monkeypatch, 0)
    with pytest.raises(NoRoomError):
        task.run_task(replace(one, key="b"))
    assert not task._mine.engines  # its queue is of no more use


def test_workers_without_room_for_a_single_batch_end_in_a_line(monkeypatch):
    monkeypatch.setattr(queue, "BUDGET", 1 << 22)
    with ThreadPoolExecutor(2) as pool, pytest.raises(pz.RunError) as caught:
        pz.trace(endless("glass in mirrors", 16), max_seconds=20.0, executor=pool)
    assert "set roulette_floor (1e-6, say)" in line_of(caught.value)


@pytest.mark.parametrize(
    ("changes", "left", "said"),
    [
        ({"max_allocation": 10**7}, None, "in one piece, and {label} gives at most 10 MB"),
        ({"global_memory": 10**7}, None, "and {label} has 10 MB"),
        ({}, 10**7, "and 10 MB are left of `ulimit -v` (1 GB)"),
    ],
)
def test_a_worker_looks_at_what_it_has(changes, left, said, monkeypatch):
    made, record, plan = parts(scene(1500), **changes)
    sizes = Sizes.of(made.tables, plan)
    monkeypatch.setattr(
        distribution, "room", lambda: None if left is None else Room(left, GB, "`ulimit -v`")
    )
    with pytest.raises(NoRoomError) as caught:
        distribution._check_buffers(record, sizes)
    line = line_of(caught.value)
    assert said.format(label=record.label) in line
    assert "the tally of a batch on the device" in line
    if changes:  # and a run is refused in the same words
        why = memory.refusal(made, Needs.of(made, record, plan), record, None)
        assert why.rpartition(": take fewer bins")[0] == line.rpartition(": `photizon check`")[0]


def test_the_error_of_a_worker_travels():
    error = pickle.loads(pickle.dumps(NoRoomError("no room")))
    assert type(error) is NoRoomError
    assert str(error) == "no room"


def test_sums_that_cannot_grow_end_a_run_with_what_is_whole(monkeypatch, tmp_path):
    monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)
    whole = pz.trace(scene(), batches=2, rays_per_batch=512)
    looks = []

    def less_and_less():
        looks.append(1)
        return Room(GB if len(looks) < 3 else 1 << 20, 2 * GB, "`ulimit -v`")

    monkeypatch.setattr(batches, "no_room_for", lambda *a: memory.no_room_for(*a, less_and_less))
    with pytest.warns(RunWarning, match="are left of `ulimit -v`") as said:
        found = pz.trace(scene(), batches=8, rays_per_batch=512, checkpoint=tmp_path)
    line_of(said[0].message)
    assert (found.info.stopped, found.batches) == ("memory", 2)
    assert found.tally_digest == whole.tally_digest
    monkeypatch.undo()
    assert pz.resume(tmp_path, batches=3).batches == 3  # where there is more


def test_no_memory_at_all_is_a_line(monkeypatch, capsys, tmp_path):
    def gone(*_):
        raise MemoryError("Unable to allocate 2.00 GiB for an array with shape (67108864, 4)")

    monkeypatch.setattr(batches, "complete", gone)
    out = tmp_path / "out"
    assert main(["run", "cosine-fourth", "--batches", "2", "--out", str(out)]) == 1
    said = line_of(capsys.readouterr().err.strip())
    assert "no memory was left in mid-run" in said
    assert "photizon resume" in said
    monkeypatch.undo()
    result = pz.trace("cosine-fourth", batches=2, rays_per_batch=64)
    monkeypatch.setattr("photizon_cl.run.directory.write_arrays", gone)
    with pytest.raises(pz.ResultError, match="no memory is left for its arrays"):
        result.save(tmp_path / "other")
    monkeypatch.setattr("photizon_cl.cli.check._print", gone)
    assert main(["check", "cosine-fourth"]) == 1
    assert "no memory is left" in line_of(capsys.readouterr().err.strip())
