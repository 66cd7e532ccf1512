"""Worker processes of this machine: the same bits, and nothing left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import inside
import pytest

import photizon_cl as pz
from hostcode.device.pocl_environment import cores, limited_thread_environment
from photizon_cl.cli.main import main
from photizon_cl.run.checkpoint import latest
from photizon_cl.run.engines import open_executor
from photizon_cl.run.processes import Processes, WorkerLostError

linux = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks into /proc")
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


def children(pid):
    """Return the processes that one has begun, dead ones that nobody waited for among them."""
    found = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        found += map(int, (task / "children").read_text().split())
    return found


def until(true, seconds=20.0):
    """Wait for something to be so."""
    end = time.monotonic() + seconds
    while not (found := true()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return found


def gone(pids):
    return not any(Path(f"/proc/{pid}").is_dir() for pid in pids)


@pytest.fixture(scope="module")
def two():
    """Two processes for all tests that leave them as they were."""
    with open_executor(2) as executor:
        yield executor


def test_the_same_bits(right, traced):
    result, lines = traced(workers=2)
    assert result.tally_digest == right.tally_digest
    assert result.summary()["ledger"] == right.summary()["ledger"]
    assert not lines


def test_go_on_with_workers(right, tmp_path):
    first = pz.trace("cosine-fourth", batches=4, rays_per_batch=right.scene.run.rays_per_batch)
    first.save(tmp_path, figures=False)
    assert first.refine(batches=16, workers=1).tally_digest == right.tally_digest
    assert pz.resume(tmp_path, batches=16, workers=1).tally_digest == right.tally_digest


def test_each_opens_one_device_and_keeps_its_engine(two, right, traced):
    def look():
        futures = [two.submit(inside.pause, 0.3) for _ in range(2)]
        assert len({future.result() for future in futures}) == 2
        found = {}
        while len(found) < 2:
            told = two.submit(inside.seen).result()
            found[told["pid"]] = told
        return found

    assert traced(executor=two)[0].tally_digest == right.tally_digest
    before = look()
    assert traced(executor=two)[0].tally_digest == right.tally_digest
    after = look()
    assert before == after
    for told in after.values():
        assert told["devices"] == 1
        assert len(told["engines"]) == 1
        share = max(len(cores()) // 2, 1)
        assert told["units"] == [share]
        assert told["limits"] == [str(share)] * 2
        assert told["script"] is None


def test_a_lower_limit_holds():
    assert limited_thread_environment(4, {"POCL_MAX_PTHREAD_COUNT": "2"}) == {
        "POCL_MAX_PTHREAD_COUNT": "2",
        "POCL_CPU_MAX_CU_COUNT": "4",
    }
    for there in ("8", "0", "many", ""):
        limits = limited_thread_environment(4, {"POCL_MAX_PTHREAD_COUNT": there})
        assert limits["POCL_MAX_PTHREAD_COUNT"] == "4"


def test_one_that_is_killed_costs_its_task_only(right, traced):
    with open_executor(2) as executor:
        began = []

        def kill(now):
            if not began and len(executor.processes()) == 2:
                began.extend(executor.processes())
                os.kill(began[0], signal.SIGKILL)

        result, lines = traced(executor=executor, progress=kill, batches=64)
        assert len(began) == 2
        assert began[1] in executor.processes()
        assert began[0] not in executor.processes()
    assert result.tally_digest == pz.trace(right.scene, batches=64).tally_digest
    assert not lines  # it was asked for again, of which nobody needs to know


def test_all_that_die_at_every_task(right, traced, monkeypatch):
    usual = Processes.submit
    monkeypatch.setattr(Processes, "submit", lambda self, *_: usual(self, inside.ends))
    result, lines = traced(workers=2)
    assert result.tally_digest == right.tally_digest
    assert "a worker process ended with status 7" in lines[-1]
    assert "the rest is traced in this process" in lines[-1]


def test_what_is_answered(two):
    assert two.submit(inside.said).result() == "answer"
    with pytest.raises(KeyError, match="what was asked"):
        two.submit(inside.fails).result()
    with pytest.raises(RuntimeError, match="lock, which cannot be sent"):
        two.submit(inside.no_pickle).result()
    with pytest.raises(AttributeError):
        two.submit(lambda: 1).result()  # cannot be sent there
    assert len(two.processes()) <= 2


@linux
def test_the_end_leaves_nothing():
    with Processes(2) as executor:  # waits, as an executor does
        futures = [executor.submit(inside.pause, 0.2) for _ in range(3)]
        pids = executor.processes()
    assert all(future.done() for future in futures)
    with open_executor(2) as executor:  # does not
        futures = [executor.submit(inside.pause, 60.0) for _ in range(3)]
        pids += until(executor.processes)
    assert pids
    assert gone(pids)
    with pytest.raises(WorkerLostError, match=r"SIGKILL|being ended"):
        futures[0].result()
    assert futures[2].done()


RUN = ["run", "cosine-fourth", "--batches", "1000000", "--rays-per-batch", "65536"]


@pytest.fixture
def running(tmp_path):
    """Start a run with two workers; give it, its workers and its directory once it traces."""
    begun = subprocess.Popen(
        [sys.executable, Path(__file__).with_name("eager.py"), *RUN, "--workers", "2",
         "--no-figures", "--out", tmp_path],
        env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    until(lambda: (tmp_path / "checkpoint.nc").exists() and latest(tmp_path).batches)
    pids = until(lambda: len(found := children(begun.pid)) == 2 and found)
    yield begun, pids, tmp_path
    begun.kill()
    for pid in pids:  # where a test failed: they hold the pipes that are read below
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    begun.communicate()


@linux
def test_ctrl_c_saves_and_leaves_nothing(running):
    begun, pids, folder = running
    os.killpg(begun.pid, signal.SIGINT)  # as a terminal does
    said, errors = begun.communicate(timeout=30)
    assert begun.returncode == 0, errors
    assert "stopped by Ctrl-C or another signal" in " ".join(said.split())
    assert "Traceback" not in errors
    assert gone(pids)
    batches = json.loads((folder / "summary.json").read_text())["batches"]
    assert batches >= 1
    assert not (folder / "checkpoint.nc").exists()


@linux
def test_workers_end_with_the_process_that_began_them(running):
    begun, pids, _ = running
    begun.kill()
    begun.wait()
    until(lambda: gone(pids) or all(_is_zombie(pid) for pid in pids), 5.0)


def _is_zombie(pid):
    """Say whether a process is dead, and whoever inherited it has only not looked yet."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_a_script_needs_no_guard(tmp_path, right):
    script = tmp_path / "script.py"
    script.write_text(
        "import photizon_cl as pz\n"
        "r = pz.trace('cosine-fourth', batches=16, rays_per_batch=512, workers=2)\n"
        "print(r.tally_digest)\n"
    )
    done = subprocess.run(
        [sys.executable, script], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [right.tally_digest]
    assert not done.stderr


def test_the_command_line(right, capsys):
    batches = ["--rays-per-batch", "512", "--batches", "16"]
    assert main(["run", "cosine-fourth", *batches, "--workers", "1", "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["tally_digest"] == right.tally_digest
    assert not said.err
    assert main(["run", "--recipe", right.recipe, "--workers", "1", "--json"]) == 0
    assert "reproduced: every bit is the recipe's" in capsys.readouterr().err


def test_workers_that_hang_do_not_hold_a_run_up(right, traced, monkeypatch):
    usual = Processes.submit
    monkeypatch.setattr(Processes, "submit", lambda self, *_: usual(self, inside.pause, 60.0))
    started = time.perf_counter()
    result, lines = traced(workers=2, max_seconds=3)
    assert time.perf_counter() - started < 1.2 * 3 + 2
    assert result.tally_digest == right.tally_digest
    assert "the executor has not answered for" in lines[0]
