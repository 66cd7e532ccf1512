"""The preset `baffled-telescope`: the star's light to the last ray, and in reverse."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import photizon_cl as pz
from benchmarks.telescope import DETECTOR, in_reverse, star_at

pytestmark = pytest.mark.usefixtures("one_lane")

SEEN = (100.0**2 - 30.0**2) / 102.0**2
"""Part of the beam between cap and rim."""


def test_the_anchor_holds():
    result = pz.trace("baffled-telescope", batches=8, rays_per_batch=8192)
    two = result.detectors["detector"].ladder[2]
    # one in 1.7e6
    assert abs(two.count - SEEN * result.rays) < 5.0 * math.sqrt(SEEN * (1 - SEEN) * result.rays)
    # what meets both mirrors and nothing else has one weight
    assert two.value == pytest.approx(two.count / result.rays * 0.81, rel=1e-9)
    assert abs(result.ledger.closure) < 1e-15


def test_the_notes_say_what_is_there():
    scene = pz.load("baffled-telescope")
    primary, secondary, detector, baffle, cap, entrance = (
        scene.element[name]
        for name in ("primary", "secondary", "detector", "main baffle", "cap", "vane 5")
    )
    p, m = 0.5 * primary.curvature_radius - secondary.position[2], 5.0
    assert secondary.curvature_radius == pytest.approx(2.0 * p * m / (m - 1.0))
    assert secondary.conic_constant == pytest.approx(-(((m + 1.0) / (m - 1.0)) ** 2))
    assert detector.position[2] == pytest.approx(secondary.position[2] - m * p)
    # past the baffle's rim the detector's rim sees the cap and not the sky
    slope = (baffle.radius + detector.radius) / baffle.length
    mouth = baffle.position[2] + baffle.length
    seen = baffle.radius + slope * (cap.position[2] - mouth)
    assert f"{1e3 * seen:.1f} mm" == "28.2 mm"
    assert "28.2 mm" in scene.notes
    assert cap.radius == 0.03
    assert entrance.inner_radius == scene.source["star"].radius == 0.102
    paint = {e.surface.reflectance for e in scene.element if e.surface.kind == "lambertian"}
    assert paint == {0.05}
    text = scene.notes
    assert f"{SEEN * 0.81:.6f} W" in text
    assert f"{SEEN * 0.81 * (102.0 / 5.0) ** 2:.3f}" in text


@pytest.fixture(scope="module")
def back() -> pz.Result:
    scene = in_reverse([0.0, 0.1, 0.4, 2.0, 20.0, 90.0])
    return pz.trace(scene, batches=16, rays_per_batch=1 << 15)


@pytest.mark.slow  # of a tube: tests/statistical/test_reverse.py
def test_in_reverse_the_field_has_the_same_transmittance(back):
    """A false alarm in 1.7e6 seeds."""
    far = back.far_field
    pst, sigma = math.pi * far.intensity[0, 0], math.pi * far.sigma[0, 0]
    assert abs(pst - SEEN * 0.81 * (102.0 / 5.0) ** 2) < 5.0 * sigma
    assert sigma < 0.05 * pst


def test_nothing_leaves_but_through_the_entrance(back):
    far = back.far_field
    assert far.power == pytest.approx(back.ledger.escaped.value, rel=1e-13)
    assert far.count.sum() > 1000
    assert (np.diff(far.intensity[:, 0]) < 0.0).all()


def test_the_star_starts_clear_of_the_tube_and_covers_the_entrance():
    for theta in (0.0, 0.5, 30.0, 80.0):
        star = star_at(theta)
        tilt = math.radians(theta)
        along = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
        assert np.array(star.frame[2]) == pytest.approx(-along, abs=1e-15)
        lowest = star.position[2] - star.radius * math.sin(tilt)
        assert lowest > 0.9
        away = np.array(star.position) - (0.0, 0.0, 0.9)
        assert away - (away @ along) * along == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.slow
def test_reverse_and_forward_agree_beside_the_field():
    """|z| ≤ 4 at 0.5°, where a forward trace without help sees something: one in 16,000."""
    scene = pz.load("baffled-telescope")
    low, high = 0.45, 0.55
    far = pz.trace(in_reverse([low, high]), batches=64, rays_per_batch=1 << 19).far_field
    one, error = math.pi * far.intensity[0, 0], math.pi * far.sigma[0, 0]
    forward = replace(scene, source=(star_at(0.5),))
    power = pz.trace(forward, batches=64, rays_per_batch=1 << 20).detectors[DETECTOR].power
    scale = (0.102 / 0.005) ** 2
    assert power.count > 100
    assert abs(one - scale * power.value) <= 4.0 * math.hypot(error, scale * power.sigma)
