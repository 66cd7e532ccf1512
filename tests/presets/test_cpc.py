"""The preset `cpc-concentrator` against a tracer that shares no formula with the engine."""

from __future__ import annotations

import pytest

import photizon_cl as pz
from benchmarks.cpc_curve import measured, pairs_that_differ, scene_at
from benchmarks.cpc_reference import transmission


def test_geometry_follows_from_exit_and_acceptance():
    cpc = pz.load("cpc-concentrator").element[0]
    assert f"{cpc.entrance_radius * 1e3:.2f}" == "73.10"
    assert f"{cpc.length * 1e3:.1f}" == "269.5"
    assert f"{cpc.concentration:.3f}" == "8.549"


def test_the_preset_is_the_curve_s_scene_at_19_degrees():
    preset, made = pz.load("cpc-concentrator").source[0], scene_at(19.0).source[0]
    assert made.flux == pytest.approx(preset.flux, rel=1e-15)
    assert made.radius == preset.radius == pz.load("cpc-concentrator").element[0].entrance_radius
    assert made.tilt_deg == preset.tilt_deg


@pytest.mark.slow  # of the curve at the same angle: below
def test_default_run_meets_the_anchor():
    result = pz.trace("cpc-concentrator")
    power = result.detectors["exit"].power
    assert result.converged
    assert power.sigma <= 0.001
    other, sigma, unfinished = transmission(19.0, side=200, repeats=4)
    assert unfinished == 0
    assert abs(power.value - other) < 4.0 * (power.sigma**2 + sigma**2) ** 0.5
    assert abs(power.value - 0.8646) < 4.0 * power.sigma
    assert result.ledger.absorbed["concentrator"].value == 0.0
    assert result.ledger.closure == 0.0


@pytest.mark.parametrize(("angle", "known"), [(19.0, 0.865), (21.0, 0.135)])
def test_cut_off(angle, known):
    # σ̂ just below 0.001: the known numbers have three digits, and 0.135 is 0.1335 rounded up
    result = pz.trace(scene_at(angle), batches=26, rays_per_batch=1 << 13)
    power = result.detectors["exit"].power
    assert power.sigma <= 0.001
    assert abs(power.value - known) < 3.0 * power.sigma


def test_dark_beyond_and_whole_within():
    value, sigma = measured(15.0, 2)
    assert abs(value - 1.0) < 5.0 * max(sigma, 2e-4)
    assert measured(23.0, 2)[0] < 1e-5


@pytest.mark.parametrize("angle", [19.0, 20.5])
def test_every_ray_ends_as_the_reference_says(angle):
    entered, other_end, other_number = pairs_that_differ(angle, 4000)
    assert entered > 3000
    assert (other_end, other_number) == (0, 0)
