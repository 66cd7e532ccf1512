"""MPI ranks under mpi4py.futures, started as a user starts them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

import photizon_cl as pz
from benchmarks.mpi import Mpi, NoMpiError
from photizon_cl.run.checkpoint import latest

pytestmark = pytest.mark.usefixtures("built_quickly")

RUN = ["run", "cosine-fourth", "--rays-per-batch", "512"]
EAGER = str(Path(__file__).with_name("eager.py"))
LONG = ["run", "cosine-fourth", "--rays-per-batch", "65536", "--batches", "1000000"]


@pytest.fixture(scope="module")
def mpi(tmp_path_factory):
    """Return a function that starts ranks; skips where there is no MPI to be had."""
    try:
        found = Mpi(tmp_path_factory.mktemp("mpi"))
    except NoMpiError as error:
        pytest.skip(str(error))

    def start(ranks, *arguments, command=("-m", "photizon_cl")):
        return subprocess.Popen(
            found.command(ranks, *command, *arguments),
            env=found.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip

    start.open_mpi = found.is_open_mpi
    return start


def ranks(mpiexec):
    """Return the ranks of an mpiexec by number: those of its children that run Python."""
    found, look = {}, [mpiexec.pid]
    while look:
        pid = look.pop()
        for task in Path(f"/proc/{pid}/task").iterdir():
            look += map(int, (task / "children").read_text().split())
        environment = Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
        pairs = dict(item.partition(b"=")[::2] for item in environment)
        rank = pairs.get(b"PMI_RANK") or pairs.get(b"OMPI_COMM_WORLD_RANK")
        if rank is not None:
            found.setdefault(int(rank), pid)
    return found


def tracing(begun, folder):
    """Wait until a run has a checkpoint with batches."""
    end = time.monotonic() + 60.0
    while not ((folder / "checkpoint.nc").exists() and latest(folder).batches):
        assert begun.poll() is None, begun.communicate()
        assert time.monotonic() < end, list(folder.iterdir())
        time.sleep(0.1)


def test_the_same_bits(mpi, right):
    done = mpi(3, *RUN, "--batches", "16", "--json")
    said, errors = done.communicate(timeout=120)
    assert done.returncode == 0, errors
    assert json.loads(said)["tally_digest"] == right.tally_digest
    assert not errors


@pytest.mark.parametrize(
    ("n", "more", "line"),
    [
        (1, (), "MPI: found 1 rank, expected at least 2, since rank 0 hands out and the others"),
        (2, ("--workers", "2"), "workers: found 2, expected nothing: this was started under MPI"),
        (2, ("--scheduler", "h:1"), 'scheduler: found "h:1", expected nothing: this was star'),
    ],
)
def test_what_cannot_be(mpi, n, more, line):
    done = mpi(n, *RUN, "--batches", "1", *more)
    said, errors = done.communicate(timeout=120)
    assert done.returncode != 0
    assert errors.startswith(line)  # then MPI says that it ends the ranks
    assert "Traceback" not in errors
    assert not said


@pytest.mark.slow
def test_ctrl_c_saves(mpi, tmp_path):
    begun = mpi(3, *LONG, "--out", str(tmp_path), "--no-figures", command=[EAGER])
    try:
        tracing(begun, tmp_path)
        os.killpg(begun.pid, signal.SIGINT)
        said, errors = begun.communicate(timeout=60)
    finally:
        begun.kill()
    assert "Traceback" not in errors
    if mpi.open_mpi:  # which ends the ranks at once: there is the checkpoint
        kept = latest(tmp_path).batches
        assert kept >= 1
        result = pz.resume(tmp_path, batches=kept)
    else:
        assert "stopped by Ctrl-C or another signal" in " ".join(said.split()), errors
        result = pz.open_result(tmp_path)
    again = pz.trace("cosine-fourth", rays_per_batch=65536, batches=result.batches)
    assert again.tally_digest == result.tally_digest


@pytest.mark.slow
def test_a_rank_that_is_killed_costs_what_the_checkpoint_has_not(mpi, tmp_path):
    begun = mpi(3, *LONG, "--out", str(tmp_path), "--no-figures", command=[EAGER])
    try:
        tracing(begun, tmp_path)
        os.kill(ranks(begun)[2], signal.SIGKILL)
        begun.communicate(timeout=60)
    finally:
        begun.kill()
    assert begun.returncode != 0
    kept = latest(tmp_path).batches
    assert kept >= 1
    result = pz.resume(tmp_path, batches=kept + 8)
    again = pz.trace("cosine-fourth", rays_per_batch=65536, batches=kept + 8)
    assert again.tally_digest == result.tally_digest
