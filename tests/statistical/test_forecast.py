"""How long a run takes is told from its first batches, and kept beside what it took."""

from __future__ import annotations

import math

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.result.forecast import Forecast
from photizon_cl.result.stopping import Goal

WALL = "ledger.absorbed.wall"


def forecast(result, batches, goal):
    """Return what a run would have said that has so many of a result's batches, one a second."""
    part = pz.trace(result.scene, batches=batches, target_on=[WALL])
    return Forecast.of(part.compiled.layout, part.tally, goal, float(batches), 0.0)


@pytest.mark.slow
def test_of_many_runs_nearly_all_end_within_what_was_told():
    """One second a batch: the batches that a target takes, told after 8, 16 and 32 of them."""
    scene = pz.load("integrating-sphere").replace({"run.rays_per_batch": 64})
    target, within, told = 0.01, 0, []
    for seed in range(14):
        run = scene.replace({"run.seed": seed})
        whole = pz.trace(run, target=target, target_on=[WALL], max_seconds=50.0)
        took = float(whole.batches)
        for batches in (8, 16, 32):
            if batches >= took:
                continue
            found = forecast(whole, batches, Goal(None, target, None))
            within += found.low <= took <= found.high
            told.append(found.seconds / took)
    assert len(told) > 25
    # 95 of 100 would be; 88 or fewer of those would be one set of seeds in a thousand
    assert within / len(told) > 0.85, (within, len(told))
    assert 0.8 < np.median(told) < 1.25


def test_a_number_of_batches_is_told_by_the_pace():
    found = pz.trace("box-room", batches=9, rays_per_batch=512)
    told = Forecast.of(found.compiled.layout, found.tally, Goal(90, None, None), 3.0, 0.0)
    assert (told.after_batches, told.seconds) == (9, pytest.approx(30.0))
    assert told.low == pytest.approx(30.0 * math.exp(-0.2))
    assert told.high == pytest.approx(30.0 * math.exp(0.2))


def test_time_ends_it():
    found = pz.trace("box-room", batches=9, rays_per_batch=512)
    goal = Goal(None, 1e-6, 5.0)
    told = Forecast.of(found.compiled.layout, found.tally, goal, 3.0, 1.0)
    assert (told.seconds, told.low, told.high) == (6.0, 6.0, 9.0)
    few = pz.trace("box-room", batches=7, rays_per_batch=512)
    assert Forecast.of(few.compiled.layout, few.tally, goal, 3.0, 1.0) is None


def test_it_is_kept(tmp_path):
    seen = []
    found = pz.trace("box-room", target=0.05, rays_per_batch=256, progress=seen.append)
    told = found.info.forecast
    assert told is not None
    assert seen[-1].forecast == told
    assert found.summary()["forecast"] == told.summary()
    assert set(told.summary()) == {"after_batches", "seconds", "low", "high"}
    found.save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).info.forecast == told
    assert Forecast.read(told.text()) == told
    for wrong in ("[]", "[1, 2, 3]", "[8, 2.0, 3.0, 4.0]", "[0, 1.0, 1.0, 1.0]", "x", 7):
        with pytest.raises(ValueError, match="its forecast"):
            Forecast.read(wrong)
