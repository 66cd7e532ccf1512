"""How long a run takes is told from its first batches, and kept beside what it took."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.result.forecast import Forecast, Outlook
from photizon_cl.result.needed import batches_needed, sampling_step
from photizon_cl.result.stopping import Goal

WALL = "ledger.absorbed.wall"


def told(result, goal, elapsed, before=0.0):
    """Return what a run tells all of whose batches came at once."""
    outlook = Outlook(goal, before, 0, None)
    outlook.note(result.compiled.layout, result.tally, elapsed)
    return outlook.latest


@pytest.fixture(scope="module")
def room():
    return pz.trace("box-room", batches=9, rays_per_batch=512)


@pytest.mark.slow
def test_of_many_runs_nearly_all_end_within_what_was_told():
    """One second a batch: the batches that a target takes, told after 8, 16 and 32 of them."""
    scene = pz.load("integrating-sphere").replace({"run.rays_per_batch": 64})
    target, within, ratios = 0.01, 0, []
    for seed in range(14):
        run = scene.replace({"run.seed": seed})
        whole = pz.trace(run, target=target, target_on=[WALL], max_seconds=50.0)
        took = float(whole.batches)
        for batches in (8, 16, 32):
            if batches >= took:
                continue
            part = pz.trace(run, batches=batches, target_on=[WALL])
            # a batch came last, so that whole batches are told
            outlook = Outlook(Goal(None, target, None), 0.0, batches - 1, None)
            outlook.note(part.compiled.layout, part.tally, float(batches))
            found = outlook.latest
            within += found.low <= took <= found.high
            ratios.append(found.seconds / took)
    assert len(ratios) > 25
    # 95 of 100 would be; 88 or fewer of those would be one set of seeds in a thousand
    assert within / len(ratios) > 0.85, (within, len(ratios))
    assert 0.8 < np.median(ratios) < 1.25


# -- how many batches ----------------------------------------------------------------------------


class Bins:
    """A tally of bins: arrivals in so many batches, and the relative variance of one."""

    def __init__(self, batches, count, variance):
        self.batches = batches
        self.count, self.variance = np.array(count), np.array(variance, np.float64)

    def reached(self, first, n, every=1):
        part = slice(first, first + n, every)
        lit = self.count[part] > 0
        ones = np.ones(np.count_nonzero(lit))
        return self.count[part][lit], ones, np.sqrt(self.variance[part][lit] / self.batches)

    def mean(self, first, n):
        return np.ones(n)

    def standard_error(self, first, n):
        return np.sqrt(self.variance[first : first + n] / self.batches)

    def counts(self, first, n):
        return self.count[first : first + n]


def watching(*quantities):
    return SimpleNamespace(
        watched=[SimpleNamespace(first=first, bins=bins) for first, bins in quantities]
    )


def low(batches):
    """Median of the variance that so many normal batches show."""
    return (1.0 - 2.0 / (9.0 * (batches - 1))) ** 3


def test_bins_that_will_be_lit_count():
    """Half of the bins have few arrivals and five times the variance: from batch 25 on they count.

    Of those that are lit at batch 10 alone the median would stand at 1, and 30 batches be told.
    """
    tally = Bins(10, [20] * 20 + [4] * 20 + [0] * 9, [1.0] * 20 + [5.0] * 20 + [0.0] * 9)
    layout = watching((0, 49))
    for wanted, median in ((20, 1.0), (90, 3.0)):
        # the batches at which bins of that variance meet it
        target = math.sqrt(median / wanted * low(wanted) / low(10))
        found, _ = batches_needed(layout, tally, target)
        assert found == pytest.approx(wanted, rel=1e-2)


def test_of_bins_in_light_and_in_shadow_an_interval_stays_a_number():
    """Half of the bins a million times dimmer: the median lies anywhere, and e^spread is finite."""
    tally = Bins(40, [1000] * 40, [1.0] * 21 + [1e6] * 19)
    found, spread = batches_needed(watching((0, 40)), tally, 0.1)
    assert math.isfinite(found)
    assert spread <= 3.0
    assert math.isfinite(math.exp(2.0 * math.hypot(spread, 0.2)))


def test_nothing_is_lit_yet():
    """A bin of 2 arrivals in 10 batches is lit at the 50th, and meets 0.5 long before."""
    found, _ = batches_needed(watching((0, 3)), Bins(10, [2, 0, 1], [5.0, 0.0, 5.0]), 0.5)
    assert found == pytest.approx(20.0 * low(20) / low(10), rel=0.05)
    nothing = Bins(10, [0, 0, 0], [0.0, 0.0, 0.0])
    assert batches_needed(watching((0, 3)), nothing, 0.5) == (math.inf, 0.0)


def test_what_takes_longest_is_told_with_its_own_spread():
    tally = Bins(9, [9] * 100, [1.0] * 50 + [16.0] * 50)
    found, spread = batches_needed(watching((0, 0), (60, 0)), tally, 0.1)
    alone = batches_needed(watching((60, 0)), tally, 0.1)
    assert (found, spread) == alone
    assert spread == pytest.approx(math.sqrt(2.0 / 8.0) * math.sqrt(1.0 - 9.0 / found))


def test_the_median_of_many_bins_is_known_well():
    """By 25 draws of normal batches; a single number is known to √(2/(n − 1))."""
    off, spreads = [], []
    for seed in range(25):
        draws = np.random.default_rng(seed).normal(1.0, 0.4, size=(10, 900))
        mean = draws.mean(axis=0)
        tally = Bins(10, [50] * 900, draws.var(axis=0, ddof=1) / mean**2)
        found, spread = batches_needed(watching((0, 900)), tally, 0.01)
        off.append(found / 1600.0 - 1.0)
        spreads.append(spread)
    assert np.std(off) < np.mean(spreads) < 0.05
    assert abs(np.mean(off)) < 0.03


def test_of_very_many_bins_some_of_every_column_are_looked_at():
    assert [sampling_step(n, 65536) for n in (1, 65536, 65537, 200_000, 2048 * 2048)] == [
        1,
        1,
        2,
        5,
        67,
    ]
    n = 2048 * 2048
    tally = Bins(10, [50] * n, np.tile([1.0, 2.0, 2.0, 3.0], n // 4))
    found, _ = batches_needed(watching((0, n)), tally, 0.1)
    assert found == pytest.approx(200.0 * low(200) / low(10), rel=1e-3)


# -- how many seconds ----------------------------------------------------------------------------


def test_a_number_of_batches_is_told_by_the_pace(room):
    found = told(room, Goal(90, None, None), 3.0)
    assert (found.after_batches, found.seconds) == (9, pytest.approx(30.0))
    # what passed is known; the pace of what is left is, to 10 %
    assert found.low == pytest.approx(3.0 + 27.0 * math.exp(-0.2))
    assert found.high == pytest.approx(3.0 + 27.0 * math.exp(0.2))


def test_the_interval_holds_what_batches_and_pace_may_do(room):
    """Of a target both, in quadrature, and where in a step of 3 batches it is met."""
    layout = room.compiled.layout
    wanted, spread = batches_needed(layout, room.tally, 0.03)
    outlook = Outlook(Goal(None, 0.03, None), 0.0, 6, None)
    outlook.note(layout, room.tally, 9.0)
    found = outlook.latest
    middle = wanted - 9.0 + 1.0
    for sign, later, end in ((-1.0, 0.0, found.low), (1.0, 2.0, found.high)):
        other = max(wanted * math.exp(sign * 2.0 * spread) - 9.0, 0.0) + later
        off = math.hypot(other - middle, middle * (math.exp(sign * 0.2) - 1.0))
        assert end == pytest.approx(9.0 + middle + sign * off)
    assert found.low < found.seconds < found.high


def test_the_first_batches_say_nothing_of_the_pace(room):
    """One batch in 5 s, which warmed everything up, and 8 in as many seconds."""
    layout, first = room.compiled.layout, pz.trace(room.scene, batches=1)
    outlook = Outlook(Goal(90, None, None), 0.0, 0, None)
    outlook.note(layout, first.tally, 5.0)
    assert outlook.latest is None
    outlook.note(layout, room.tally, 13.0)
    assert outlook.latest.seconds == pytest.approx(13.0 + 81.0)


def test_batches_under_way_together_end_together(room):
    """Up to 3 batches late in steps of 4, half of that on average; a fixed number cuts the last."""
    layout = room.compiled.layout
    wanted, _ = batches_needed(layout, room.tally, 0.02)
    outlook = Outlook(Goal(None, 0.02, None), 0.0, 5, None)
    outlook.note(layout, room.tally, 9.0)
    assert outlook.latest.seconds == pytest.approx(wanted + 1.5)
    outlook = Outlook(Goal(15, None, None), 0.0, 5, None)
    outlook.note(layout, room.tally, 9.0)
    assert outlook.latest.seconds == pytest.approx(15.0)


def test_time_ends_it(room):
    found = told(room, Goal(None, 1e-6, 5.0), 2.0, before=1.0)
    assert (found.seconds, found.low, found.high) == (6.0, 6.0, 9.0)
    few = pz.trace("box-room", batches=7, rays_per_batch=512)
    assert told(few, Goal(None, 1e-6, 5.0), 2.0) is None


# -- which one is kept ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("seconds", "high", "passed", "kept"),
    [
        (20.0, 25.0, 1.9, False),  # too early for a pace
        (20.0, 25.0, 2.0, True),
        (20.0, 27.0, 6.0, False),  # wide
        (20.0, 27.0, 6.7, True),  # and no use later
        (3600.0, 4000.0, 9.0, False),
        (3600.0, 4000.0, 10.0, True),
    ],
)
def test_it_is_kept_when_it_is_narrow_or_a_third_has_passed(seconds, high, passed, kept):
    assert Forecast(8, seconds, 1.0, high).settled(passed) == kept


def test_the_latest_is_shown_and_an_early_one_kept(room):
    layout, goal = room.compiled.layout, Goal(90, None, None)
    more = pz.trace(room.scene, batches=18)
    outlook = Outlook(goal, 0.0, 0, None)
    outlook.note(layout, room.tally, 9.0)
    kept = outlook.kept
    outlook.note(layout, more.tally, 36.0)
    assert outlook.kept is kept
    assert (kept.after_batches, outlook.latest.after_batches) == (9, 18)
    assert outlook.latest.seconds == pytest.approx(36.0 + 72.0 * 3.0)
    # an earlier call's stays where it came late enough in the run, and is made anew where not
    for before, anew in ((9.0, False), (8.9, True)):
        again = Outlook(goal, before, 9, kept)
        again.note(layout, more.tally, 9.0)
        assert (again.kept is not kept) == anew


def test_a_run_that_is_over_at_once_is_told_at_its_end(room):
    kept = room.info.forecast
    assert kept == Forecast(9, *[room.info.seconds] * 3)
    assert room.summary()["forecast"]["seconds"] == room.summary()["seconds"]
    assert Forecast.read(kept.text()) == kept
    # where it goes on that is no forecast of the rest
    goal = Goal(90, None, None)
    assert Outlook(goal, kept.seconds, 9, kept).kept is None
    assert Outlook(goal, kept.seconds, 8, kept).kept is kept


def test_where_nothing_is_run_it_stays(room):
    assert room.refine(max_seconds=100.0).info.forecast == room.info.forecast
    assert room.refine(batches=9).info.forecast == room.info.forecast
    assert room.refine(batches=10).info.forecast.after_batches == 10


def test_what_is_left_is_the_rest_of_what_was_told():
    seen = []
    pz.trace("box-room", batches=400, rays_per_batch=2048, progress=seen.append)
    told = [now for now in seen if now.forecast is not None]
    assert told
    for now in told:
        if now.batches == 400:
            break
        rest = max(now.forecast.seconds - now.seconds, 0.0)
        assert now.eta_seconds == pytest.approx(rest)
    assert seen[-1].eta_seconds == 0.0


def test_it_is_kept(tmp_path):
    seen = []
    found = pz.trace("box-room", target=0.05, rays_per_batch=2048, progress=seen.append)
    kept = found.info.forecast
    assert kept in [now.forecast for now in seen]
    assert seen[-1].forecast.after_batches >= kept.after_batches
    assert found.summary()["forecast"] == kept.summary()
    assert set(kept.summary()) == {"after_batches", "seconds", "low", "high"}
    found.save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).info.forecast == kept
    assert Forecast.read(kept.text()) == kept
    for wrong in ("[]", "[1, 2, 3]", "[8, 2.0, 3.0, 4.0]", "[0, 1.0, 1.0, 1.0]", "x", 7):
        with pytest.raises(ValueError, match="its forecast"):
            Forecast.read(wrong)
