"""What people call gives what the engine gives: the same digest, watts from the same integers."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, probe, trace

import photizon_cl as pz
from photizon_cl.result.statistics import Accumulator, complete

PLANS = {
    "narrow waves": PLAN.with_(wave_rays=1 << 10),
    "wide waves": PLAN.with_(wave_rays=1 << 20),
    "one bounce": PLAN.with_(max_bounces=1),
    "classical": PLAN.with_(composition="classical"),
}


def test_tally_digest_is_the_chain_of_the_engines_batches() -> None:
    result = pz.trace("box-room", batches=5, rays_per_batch=1000, seed=7)
    found = trace("box-room", batches=5, rays_per_batch=1000, seed=7)
    chain = Accumulator.of(found.compiled.layout)
    for cells in found.batches:
        chain.add(complete(found.compiled.layout, cells))
    assert result.summary()["tally_digest"] == chain.digest


@pytest.mark.parametrize("plan", PLANS)
def test_tally_digest_does_not_know_the_plan(plan: str) -> None:
    run = {"batches": 4, "rays_per_batch": 1000}
    want = pz.trace("box-room", **run).summary()["tally_digest"]
    assert pz.trace("box-room", plan=PLANS[plan], **run).summary()["tally_digest"] == want


def test_rows_of_the_summary_are_the_exact_sums_in_watts() -> None:
    result = pz.trace("box-room", batches=4, rays_per_batch=2000)
    found = trace("box-room", batches=4, rays_per_batch=2000)
    unit = found.compiled.unit_power / 4
    for name, row in result.ledger.absorbed.items():
        assert row.value == pytest.approx(float(found.absorbed(name)) * unit, rel=1e-15)
    detector = result.detectors["floor"]
    counts = found.detector("floor").map_counts
    assert (np.asarray(detector.map.count) == counts).all()
    irradiance = np.asarray(detector.map.irradiance)
    area = (2.0 / 32) ** 2
    assert irradiance.shape == (32, 32)
    total = float(found.detector("floor").map_total) * unit
    assert irradiance.sum() * area == pytest.approx(total, rel=1e-13)
    assert abs(result.ledger.closure) <= 1e-15


def test_far_field_intensity_is_power_over_solid_angle() -> None:
    result = pz.trace("integrating-sphere", batches=4, rays_per_batch=2000)
    intensity = np.asarray(result.far_field.intensity)
    assert intensity.shape == (40, 32)
    solid_angle = (2.0 / 40) * (2.0 * np.pi / 32)
    total = intensity.sum() * solid_angle
    assert total == pytest.approx(result.ledger.escaped.value, rel=1e-13)


def test_probe_runs_the_kernels_of_the_trace() -> None:
    scene = compiled("integrating-sphere").scene
    r = np.random.default_rng(8)
    origins = 0.2 * r.normal(size=(200, 3))
    directions = r.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    hits, want = pz.probe(scene, origins, directions), probe(scene, origins, directions)
    hit = want.element >= 0
    assert (hits.element == want.element).all()
    assert np.isinf(hits.distance[~hit]).all()
    for name in ("distance", "point", "normal"):
        difference = getattr(hits, name)[hit] - getattr(want, name)[hit]
        assert np.abs(difference).max() < 1e-15
