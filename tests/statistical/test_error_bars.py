"""Error bars say what they mean: their coverage over many groups, and how fast they fall."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.engine import trace
from oracles.statistics import batch_values

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from photizon_cl.result.estimates import Estimates, RunInfo
from photizon_cl.result.statistics import Accumulator, complete
from photizon_cl.result.stopping import Goal

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.statistical

GROUPS, BATCHES, RAYS = 600, 32, 512
PLAN = ExecutionPlan(lanes=8, items=64, wave_rays=BATCHES * RAYS)


def primitive(x: float, y: float) -> float:
    """∫∫ of 1/(π (x² + y² + 1)²) from the origin: what a parallel rectangle 1 m away receives."""
    a, b = np.hypot(x, 1.0), np.hypot(y, 1.0)
    return float((x / a * np.arctan(y / a) + y / b * np.arctan(x / b)) / (2.0 * np.pi))


def groups(tables: dict[str, Any]) -> Iterator[Estimates]:
    """Give what each of many groups of batches makes known: as many independent runs."""
    tables.pop("far_field", None)
    found = trace(pz.load(tables), batches=GROUPS * BATCHES, rays_per_batch=RAYS, plan=PLAN, seed=7)
    layout = found.compiled.layout
    for first in range(0, GROUPS * BATCHES, BATCHES):
        tally = Accumulator.of(layout)
        for cells in found.batches[first : first + BATCHES]:
            tally.add(complete(layout, cells))
        yield Estimates(found.compiled, tally, RunInfo(goal=Goal(batches=BATCHES)))


@cache
def plates() -> dict[str, np.ndarray]:
    """Return (value − truth)/σ̂ over the groups: of a bin of a plate's map, and of its total."""
    tables = pz.load("cosine-fourth").to_dict()
    tables["element"][0]["detector"] = {"map": [4, 4]}
    in_bin = primitive(0.5, 0.5) / 0.25  # the innermost of the bins, W; 0.25 m² each
    total = 4.0 * primitive(1.0, 1.0)
    z: dict[str, list[float]] = {"a map's bin": [], "a detector's total": []}
    for plate in groups(tables):
        detector = plate.detectors["target"]
        assert detector.map is not None
        bins, power = detector.map, detector.power
        z["a map's bin"].append((bins.irradiance[2, 2] - in_bin) / bins.sigma[2, 2])
        z["a detector's total"].append((power.value - total) / power.sigma)
    return {name: np.array(x) for name, x in z.items()}


def rows() -> np.ndarray:
    """Return the same of a row of the ledger: what the integrating sphere's wall absorbs."""
    found = [one.ledger.absorbed["wall"] for one in groups(pz.load("integrating-sphere").to_dict())]
    return np.array([(wall.value - 0.655172413793103448) / wall.sigma for wall in found])


@pytest.mark.parametrize(
    "what",
    [
        "a map's bin",
        "a detector's total",
        pytest.param("a ledger's row", marks=pytest.mark.slow),
    ],
)
def test_two_sigma_hold_the_truth_in_95_of_100_groups(what):
    """With 32 batches the share within ±2σ̂ is 0.9457; over 600 groups it scatters by 0.0093.

    ±0.02 is 2.2 of that: a right engine misses it for one in 30 choices of the seed, and never for
    this one, whose bits are fixed.
    """
    z = rows() if what == "a ledger's row" else plates()[what]
    assert abs(np.mean(np.abs(z) < 2.0) - 0.9457) <= 0.02
    # z² has the mean 31/29 and scatters by 1.6 about it: five times 1.6/sqrt(600) is 0.33
    assert abs(np.mean(z * z) - 31.0 / 29.0) < 0.33
    # error bars a fifth too small, or a third too large, would be found
    assert np.mean(np.abs(z) < 2.0 * 0.8) < 0.93
    assert np.mean(np.abs(z) < 2.0 * 1.33) > 0.97


@pytest.mark.slow
def test_the_error_falls_as_one_over_the_root_of_the_rays():
    """The exponent of the true error (not σ̂) against rays, over a factor of 64.

    The root mean square of 1024 groups scatters by 2.2 % at the end, where it decides: 0.02 in the
    exponent is more than three times what that makes of the fit.
    """
    tables = pz.load("cosine-fourth").to_dict()
    tables["element"][0]["detector"] = {}
    groups, most = 1024, 64
    found = trace(pz.load(tables), rays_per_batch=64, batches=groups * most, plan=PLAN, seed=11)
    cell = found.detector("target").cells.power
    values = batch_values(found)[:, cell] / 64.0
    truth = 4.0 * primitive(1.0, 1.0)
    numbers = 2 ** np.arange(7)
    error = [np.sqrt(np.mean((values.reshape(-1, n).mean(axis=1) - truth) ** 2)) for n in numbers]
    order = np.polyfit(np.log(numbers), np.log(error), 1)[0]
    assert abs(order + 0.5) <= 0.02
