"""SIGKILL at fifty random moments, and every bit as if nothing had happened."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import photizon_cl as pz
from photizon_cl.atomic import TEMPORARY
from photizon_cl.result_directory import unfinished

SCRIPT = Path(__file__).with_name("killed_run.py")
ROOT = Path(__file__).resolve().parents[2]
KILLS = 50
BATCHES = 3000


def start(folder: Path, verb: str, until: str) -> subprocess.Popen[str]:
    """Start the run and return when it has said a word."""
    made = subprocess.Popen(
        [sys.executable, SCRIPT, folder, str(BATCHES), verb],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert made.stdout is not None
    for word in ("ready", "tracing"):
        assert made.stdout.readline() == f"{word}\n"
        if word == until:
            break
    return made


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_killed_at_fifty_random_moments(tmp_path):
    # Each wave is one batch and ends in a checkpoint, so many moments fall into writing one. Every
    # run goes on from the one killed before it.
    chance = random.Random(20261122)
    folder = tmp_path / "run"
    batches, torn = [], 0
    for k in range(KILLS):
        begun = (folder / "checkpoint.nc").exists()
        # one in five while it starts up, the others while it traces
        until = "tracing" if k % 5 else "ready"
        process = start(folder, "resume" if begun else "run", until)
        time.sleep(chance.uniform(0.0, 0.25))
        assert process.poll() is None, "it was done before it could be killed: raise BATCHES"
        process.kill()
        process.communicate()
        torn += any(folder.glob(f"{TEMPORARY}*"))
        if not (folder / "checkpoint.nc").exists():
            continue  # before the very first one was there
        left = unfinished(folder)  # never half a file
        assert left is not None
        batches.append(left.batches)
    assert batches == sorted(batches)  # nothing that was kept is ever lost
    assert len(set(batches)) > KILLS // 2  # kills fell into the run
    assert torn > 0  # ... and into the writing of a checkpoint
    result = pz.resume(folder)
    assert result.batches == BATCHES
    whole = pz.trace("box-room", rays_per_batch=512, batches=BATCHES)
    assert result.tally_digest == whole.tally_digest
    result.save(folder, figures=False)
    assert not list(folder.glob(f"{TEMPORARY}*"))
    assert pz.open_result(folder).tally_digest == whole.tally_digest
