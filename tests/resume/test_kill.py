"""SIGKILL at any moment, and every bit as if nothing had happened."""

from __future__ import annotations

import random
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from oracles.kills import Kills

import photizon_cl as pz
from photizon_cl.atomic import TEMPORARY
from photizon_cl.run.directory import unfinished

if TYPE_CHECKING:
    from collections.abc import Iterator

SCRIPT = Path(__file__).with_name("killed_run.py")
PER_KILL = 60
TORN = f"{TEMPORARY}*.nc"

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")


@pytest.fixture
def runs() -> Iterator[Kills]:
    made = Kills(SCRIPT)
    yield made
    made.close()


def ends_as_if_nothing_had_happened(folder: Path, batches: int) -> None:
    result = pz.resume(folder)
    assert result.batches == batches
    whole = pz.trace("box-room", rays_per_batch=512, batches=batches)
    assert result.tally_digest == whole.tally_digest
    result.save(folder, figures=False)
    assert not list(folder.glob(f"{TEMPORARY}*"))
    assert pz.open_result(folder).tally_digest == whole.tally_digest


def test_killed_at_named_moments(tmp_path, runs):
    # Each wave is one batch and ends in a checkpoint. Every run goes on from the one killed before
    # it, and begins with a checkpoint of where that was: the n-th holds n − 1 batches more.
    folder, batches = tmp_path / "run", 30
    runs.start(str(folder), batches, "run", ("writing", 1), until="held")
    assert not runs.kill()
    assert not (folder / "checkpoint.nc").exists()  # before the very first one was there
    assert len(list(folder.glob(TORN))) == 1
    moments = [("batches", 3, 3), ("writing", 5, 3), ("writing", 1, 0)]
    verb, reached = "run", 0
    for kind, number, more in moments:
        runs.start(str(folder), batches, verb, (kind, number), until="held")
        assert not runs.kill()
        left = unfinished(folder)  # never half a file
        assert left is not None
        reached += more
        assert left.batches == reached  # and nothing that was kept is ever lost
        assert len(list(folder.glob(TORN))) == (kind == "writing")
        verb = "resume"
    ends_as_if_nothing_had_happened(folder, batches)


@pytest.mark.slow
def test_killed_at_random_moments(tmp_path, runs):
    kills = 50
    chance = random.Random(20261122)
    batches = kills * PER_KILL
    folder = tmp_path / "run"
    kept, torn = [], 0
    for k in range(kills):
        begun = (folder / "checkpoint.nc").exists()
        # one in five while it starts up, the others while it traces
        until = "tracing" if k % 5 else "ready"
        runs.start(str(folder), batches, "resume" if begun else "run", ("anywhere",), until=until)
        time.sleep(chance.uniform(0.0, 0.25))
        assert not runs.kill(), "it was done before the kill: raise PER_KILL"
        torn += any(folder.glob(TORN))
        if not (folder / "checkpoint.nc").exists():
            continue  # before the very first one was there
        left = unfinished(folder)
        assert left is not None
        kept.append(left.batches)
    assert kept == sorted(kept)
    assert len(set(kept)) > kills // 2  # kills fell into the run
    assert torn > 0  # ... and into the writing of a checkpoint
    ends_as_if_nothing_had_happened(folder, batches)
