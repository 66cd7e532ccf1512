"""SIGKILL at random moments, and every bit as if nothing had happened."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import photizon_cl as pz
from photizon_cl.atomic import TEMPORARY
from photizon_cl.run.directory import unfinished

if TYPE_CHECKING:
    from collections.abc import Iterator

SCRIPT = Path(__file__).with_name("killed_run.py")
ROOT = Path(__file__).resolve().parents[2]
PER_KILL = 60


class Runs:
    """Starts runs, one at a time, and kills them; see killed_run.py."""

    def __init__(self) -> None:
        self.batches = 0
        self.process = subprocess.Popen(
            [sys.executable, SCRIPT],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.number: int | None = None

    def say(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def hear(self) -> list[str]:
        assert self.process.stdout is not None
        return self.process.stdout.readline().split()

    def start(self, folder: Path, verb: str, until: str) -> None:
        """Start a run and return when it has said a word."""
        self.say(json.dumps([str(folder), self.batches, verb]))
        word, number = self.hear()
        assert word == "ready"
        self.number = int(number)
        if until == "tracing":
            assert self.hear() == ["tracing"]

    def kill(self) -> None:
        """Kill the run, whatever it is at."""
        assert self.number is not None
        os.kill(self.number, signal.SIGKILL)
        self.number = None
        self.say("")
        while (heard := self.hear())[0] != "ended":
            assert heard == ["tracing"]
        assert heard[1] == str(-signal.SIGKILL), "it was done before the kill: raise PER_KILL"


@pytest.fixture
def runs() -> Iterator[Runs]:
    made = Runs()
    yield made
    if made.number is not None:  # the test failed on the way
        os.kill(made.number, signal.SIGKILL)
    made.process.communicate()


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
@pytest.mark.parametrize("kills", [4, pytest.param(50, marks=pytest.mark.slow)])
def test_killed_at_random_moments(tmp_path, runs, kills):
    # Each wave is one batch and ends in a checkpoint, so many moments fall into writing one. Every
    # run goes on from the one killed before it.
    chance = random.Random(20261122)
    runs.batches = kills * PER_KILL
    folder = tmp_path / "run"
    batches, torn = [], 0
    for k in range(kills):
        begun = (folder / "checkpoint.nc").exists()
        # one in five while it starts up, the others while it traces
        until = "tracing" if k % 5 else "ready"
        runs.start(folder, "resume" if begun else "run", until)
        time.sleep(chance.uniform(0.0, 0.25))
        runs.kill()
        torn += any(folder.glob(f"{TEMPORARY}*"))
        if not (folder / "checkpoint.nc").exists():
            continue  # before the very first one was there
        left = unfinished(folder)  # never half a file
        assert left is not None
        batches.append(left.batches)
    assert batches == sorted(batches)  # nothing that was kept is ever lost
    assert len(set(batches)) > kills // 2  # kills fell into the run
    assert torn > 0  # ... and into the writing of a checkpoint
    result = pz.resume(folder)
    assert result.batches == runs.batches
    whole = pz.trace("box-room", rays_per_batch=512, batches=runs.batches)
    assert result.tally_digest == whole.tally_digest
    result.save(folder, figures=False)
    assert not list(folder.glob(f"{TEMPORARY}*"))
    assert pz.open_result(folder).tally_digest == whole.tally_digest
