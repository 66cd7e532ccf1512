"""A Dask cluster of two worker processes on loopback: the same bits, whatever happens to it."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor

import inside
import pytest

import photizon_cl as pz
from hostcode.device.pocl_environment import cores
from photizon_cl.cli.main import main
from photizon_cl.run import dask, workers

distributed = pytest.importorskip("distributed", reason="Dask is not installed")

# Its own threads and sockets end when they do.
pytestmark = [
    pytest.mark.usefixtures("built_quickly"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]
# Dask would use both threads for a task each; a process has one device all the same.
HOW = {"threads_per_worker": 2, "dashboard_address": ":0", "host": "127.0.0.1"}
WRONG = [
    "other batches", "a bit flipped", "short", "tables damaged", "another engine",
    "nothing",
]  # fmt: skip


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(n_workers=2, **HOW) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    with distributed.Client(cluster.scheduler_address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
        yield client


@pytest.fixture
def address(client, cluster):
    """Return the scheduler's address, with two workers."""
    return cluster.scheduler_address


def test_the_same_bits(address, right, traced):
    result, lines = traced(scheduler=address)
    assert result.tally_digest == right.tally_digest
    assert result.summary()["ledger"] == right.summary()["ledger"]
    assert not lines


def test_the_command_line(address, right, capsys):
    what = ["run", "cosine-fourth", "--rays-per-batch", "512", "--batches", "16", "--json"]
    assert main([*what, "--scheduler", address]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["tally_digest"] == right.tally_digest
    assert not said.err


@pytest.mark.parametrize("how", [lambda c: c, lambda c: c.get_executor()])
def test_a_client_is_an_executor(how, client, right, traced):
    result, lines = traced(executor=how(client))
    assert result.tally_digest == right.tally_digest
    assert not lines
    assert client.status == "running"


def test_each_opens_one_device_and_keeps_its_engine(client, right, traced):
    executor = dask.DaskWorkers(client)
    assert executor._max_workers == 2

    def look():
        asked = [
            client.submit(dask._in_one_thread, inside.seen, (), {}, workers=[name], pure=False)
            for name in client.nthreads()
        ]
        return {told["pid"]: told for told in client.gather(asked)}

    for _ in range(2):
        assert traced(executor=executor, batches=64)[0].batches == 64
    before = look()
    assert traced(executor=executor)[0].tally_digest == right.tally_digest
    assert look() == before
    assert len(before) == 2
    for told in before.values():
        assert told["devices"] == 1
        assert told["units"] == [min(2, len(cores()))]  # as many as Dask gives the worker threads
        assert told["limits"] == ["2", "2"]
        assert len(told["engines"]) == 1
    end = time.monotonic() + 10.0
    while any(client.run(inside.kept).values()):  # answers that were heard
        assert time.monotonic() < end
        time.sleep(0.1)


class Through(Executor):
    """Has every third task answered by another function, which does wrong at the first time."""

    def __init__(self, client, *instead):
        self.executor, self.instead = dask.DaskWorkers(client), instead
        self.asked = []

    @property
    def _max_workers(self):
        return self.executor._max_workers

    def submit(self, call, task):
        if task.first // 2 % 3:
            return self.executor.submit(call, task)
        self.asked.append(task.first)
        return self.executor.submit(*self.instead, task)


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_answer_is_refused_and_asked_for_again(what, client, right, traced, tmp_path):
    executor = Through(client, inside.wrong_at_first, str(tmp_path), what)
    result, lines = traced(executor=executor)
    assert result.tally_digest == right.tally_digest
    # what Dask answered once it must not answer again: nothing is traced in this process
    (line,) = lines
    assert "an answer was refused, as it" in line
    assert "it is asked for again" in line
    assert sorted(executor.asked) == [0, 0, 6, 6, 12, 12]


def test_an_answer_that_comes_late_and_twice(client, right, traced, monkeypatch):
    monkeypatch.setattr(workers, "_LATER_ANSWER", 0.2)
    monkeypatch.setattr(workers, "_TIMES", 0.0)
    executor = Through(client, inside.late, 1.0)
    result, lines = traced(executor=executor, batches=32)
    assert result.tally_digest == pz.trace(right.scene, batches=32).tally_digest
    # somebody did what the late one did as well: another worker, or this process
    assert len(executor.asked) > len(set(executor.asked)) or "has not answered for" in lines[0]


def test_a_worker_that_is_killed_costs_its_task_only(client, right, traced):
    pids = list(client.run(os.getpid).values())
    killed = []

    def kill(now):
        if not killed:
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)

    result, lines = traced(executor=client, batches=64, progress=kill)
    assert killed
    assert result.tally_digest == pz.trace(right.scene, batches=64).tally_digest
    assert not lines


def test_tasks_that_are_cancelled(client, right, traced):
    executor = dask.DaskWorkers(client)
    usual, some = executor.submit, iter([True, True, False, True])

    def submit(*what):
        future = usual(*what)
        if next(some, False):
            future.cancel()
        return future

    executor.submit = submit
    result, lines = traced(executor=executor)
    assert result.tally_digest == right.tally_digest
    assert len(lines) <= 1


@pytest.mark.parametrize("listens", [False, True])
def test_no_scheduler(listens, monkeypatch):
    monkeypatch.setattr(dask, "_CONNECT", 0.5)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        if listens:
            other.listen()
        address = f"tcp://127.0.0.1:{other.getsockname()[1]}"
        started = time.perf_counter()
        with pytest.raises(pz.RunError, match=r"no Dask scheduler answers at .*: see whet") as told:
            pz.trace("cosine-fourth", batches=1, scheduler=address)
    assert time.perf_counter() - started < 5.0
    assert "\n" not in str(told.value)


def test_a_scheduler_without_workers(monkeypatch):
    monkeypatch.setattr(dask, "_CONNECT", 2.0)
    with (
        distributed.LocalCluster(n_workers=0, **HOW) as empty,
        pytest.raises(pz.RunError, match="has no workers: start some with `dask worker tcp://"),
    ):
        pz.trace("cosine-fourth", batches=1, scheduler=empty.scheduler_address)


CLUSTER = """
import sys, time
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@pytest.mark.slow
def test_the_scheduler_dies(tmp_path, right, traced, monkeypatch):
    monkeypatch.setattr(dask, "_RECONNECT", 0.5)
    script = tmp_path / "cluster.py"
    script.write_text(CLUSTER)
    begun = subprocess.Popen(
        [sys.executable, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    killed = threading.Event()
    try:
        address = begun.stdout.readline().strip()

        def kill(now):
            if not killed.is_set():
                begun.kill()
                begun.wait()
                killed.set()

        result, lines = traced(scheduler=address, batches=64, progress=kill)
    finally:
        begun.kill()
        begun.communicate()
    assert killed.is_set()
    assert result.tally_digest == pz.trace(right.scene, batches=64).tally_digest
    assert "the connection to the Dask scheduler is lost" in lines[-1]
    assert "the rest is traced in this process" in lines[-1]
