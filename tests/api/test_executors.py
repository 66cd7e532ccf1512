"""Executors that misbehave: the right digest, or one clear line, and never beyond the time."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import executors
import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import RunWarning
from photizon_cl.run import window, workers
from photizon_cl.run.chunks import Task, checked, tables_digest
from photizon_cl.run.task import run_task

pytestmark = pytest.mark.usefixtures("built_quickly")

RAYS = 512
BATCHES = 16
SCENE = "cosine-fourth"


@pytest.fixture(scope="module")
def right():
    return pz.trace(SCENE, batches=BATCHES, rays_per_batch=RAYS)


@pytest.fixture(autouse=True)
def two_batches_a_task(monkeypatch):
    monkeypatch.setattr(window, "RAYS_OF_A_TASK", 2 * RAYS)
    monkeypatch.setattr(window, "_QUICK", 0.0)


def traced(executor, **more):
    """Return what comes out, and the lines that were said."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        result = pz.trace(SCENE, batches=BATCHES, rays_per_batch=RAYS, executor=executor, **more)
    lines = [str(w.message) for w in said if issubclass(w.category, RunWarning)]
    assert all(line.isprintable() for line in lines)
    assert len(lines) <= 4
    return result, lines


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("what", executors.WRONG)
def test_a_wrong_answer_is_refused_and_said(what, every, right):
    executor = executors.Doing(executors.WRONG[what](), every)
    result, lines = traced(executor)
    assert result.tally_digest == right.tally_digest
    assert result.summary()["ledger"] == right.summary()["ledger"]
    assert any("an answer was refused, as it" in line for line in lines)


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("what", executors.LOST)
def test_a_lost_task_is_asked_for_again(what, every, right):
    executor = executors.Doing(executors.LOST[what](), every)
    result, lines = traced(executor)
    assert result.tally_digest == right.tally_digest
    # where the second try succeeds, nobody needs to know
    assert bool(lines) == (every == 1)
    if every == 1:
        assert "it is not asked any more, and the rest is traced in this process" in lines[-1]
        assert executor.asked < 2 * BATCHES


@pytest.mark.parametrize("pool", [executors.Broken, executors.BrokenLate])
def test_a_broken_pool_does_not_end_the_run(pool, right):
    result, lines = traced(pool())
    assert result.tally_digest == right.tally_digest
    assert "a child process terminated abruptly" in lines[-1]
    assert "the rest is traced in this process" in lines[-1]


@pytest.mark.parametrize("what", [None, 5, object()])
def test_what_is_no_future_is_told(what, right):
    result, lines = traced(executors.Not(what))
    assert result.tally_digest == right.tally_digest
    assert f"submit gave a {type(what).__name__} and no Future" in lines[-1]


def test_what_is_checked_is_what_is_kept():
    compiled = compile_scene(pz.load(SCENE), pz.RunSettings(rays_per_batch=RAYS))
    tables = compiled.tables
    task = Task("key", "scene", tables_digest(tables), tables, None, None, 3, 2)
    chunk = run_task(task)
    kept = checked(chunk, task)
    for mine, others in zip(kept.cells, chunk.cells, strict=True):
        assert (mine == others).all()
        assert not np.shares_memory(mine, others)


def test_what_was_right_is_added_once(right):
    # nothing but its number tells a batch that comes twice from a new one
    result, lines = traced(executors.Doing(executors.First(), every=3))
    assert result.tally_digest == right.tally_digest
    assert "batches 6 to 7: an answer was refused, as it holds batches 0 to 1" in lines[0]
    assert not any("the rest is traced" in line for line in lines)


@pytest.mark.parametrize("executor", [executors.Silent, executors.Blocking])
def test_an_executor_that_never_answers_does_not_hang(executor, right):
    started = time.perf_counter()
    result, lines = traced(executor(), max_seconds=3)
    assert time.perf_counter() - started < 1.2 * 3 + 2
    assert result.tally_digest == right.tally_digest
    assert "the executor has not answered for" in lines[0]


def test_without_a_limit_silence_ends_too(right, monkeypatch):
    monkeypatch.setattr(workers, "_FIRST_ANSWER", 0.5)
    result, lines = traced(executors.Silent())
    assert result.tally_digest == right.tally_digest
    assert "the executor has not answered for" in lines[0]


@pytest.mark.parametrize(
    ("batch", "times"),
    [(0, 9), (4, 1), *(pytest.param(*p, marks=pytest.mark.slow) for p in ((0, 1), (4, 9)))],
)
def test_one_task_that_is_never_answered(batch, times, right):
    started = time.perf_counter()
    result, _ = traced(executors.LosingOne(batch, times), max_seconds=3)
    assert time.perf_counter() - started < 1.2 * 3 + 2
    assert result.tally_digest == right.tally_digest


def test_nobody_answers_and_this_process_cannot(monkeypatch):
    def cannot(*arguments):
        raise pz.RunError("no usable device")

    monkeypatch.setattr(workers, "Local", cannot)
    with pytest.raises(pz.RunError, match=r"not compute .*, and this process cannot: no usa"):
        traced(executors.Silent(), max_seconds=0.5)


def test_no_time_for_a_single_batch(monkeypatch):
    monkeypatch.setattr(workers.Executed, "_look_at_silence", lambda *_: None)
    started = time.perf_counter()
    with pytest.raises(pz.RunError, match="no worker of the executor answered within") as caught:
        traced(executors.Silent(), max_seconds=0.5)
    assert "\n" not in str(caught.value)
    assert time.perf_counter() - started < 1.2 * 0.5 + 2


@pytest.mark.parametrize("executor", [executors.Silent, executors.Blocking])
def test_what_a_signals_handler_raises_is_not_the_executors(executor):
    def handler(number, frame):
        raise TimeoutError("the user's own alarm")

    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(TimeoutError, match="the user's own alarm"):
            traced(executor())
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_ctrl_c_ends_the_wait_for_an_executor(right):
    def press(now):
        signal.raise_signal(signal.SIGINT)

    executor = executors.LosingOne(4, 99)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = pz.trace(
            SCENE, batches=BATCHES, rays_per_batch=RAYS, executor=executor, progress=press
        )
    assert 1 <= result.batches < BATCHES
    assert result.info.stopped == "interrupt"


def test_ctrl_c_before_the_first_answer():
    before = signal.getsignal(signal.SIGALRM)
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            pz.trace(SCENE, batches=2, rays_per_batch=RAYS, executor=executors.Silent())
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_worker_that_is_killed_breaks_a_pool_and_not_the_run(right):
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        pool.submit(os.getpid).result()
        os.kill(next(iter(pool._processes)), signal.SIGKILL)
        result, lines = traced(pool)
    assert result.tally_digest == right.tally_digest
    assert "the executor broke" in lines[-1] or "could not be submitted" in lines[-1]


@pytest.mark.slow
def test_workers_do_not_trace_on_when_nobody_waits():
    # Glass with half mirrors inside splits without end: no batch of it ever ends.
    ball = pz.Sphere(
        name="ball", position=(0, 0, 0), axis="+z", radius=1,
        surface=pz.Mixed(specular=0.5, diffuse=0.5),
    )  # fmt: skip
    lamp = pz.IsotropicPoint(name="lamp", flux=1, position=(0, 0, 0))
    run = pz.RunSettings(generation_cap=60, max_seconds=1.0, rays_per_batch=64)
    scene = pz.Scene(name="endless", source=(lamp,), element=(ball,), run=run)
    started = time.perf_counter()
    with (
        ThreadPoolExecutor(2) as pool,  # its end waits for its threads
        pytest.warns(RunWarning, match="has not answered"),
        pytest.raises(pz.RunError, match="no worker of the executor answered"),
    ):
        pz.trace(scene, executor=pool)
    assert time.perf_counter() - started < 30.0
