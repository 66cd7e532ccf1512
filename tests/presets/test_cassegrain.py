"""The preset `cassegrain`: the light of a star, to the last ray."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import photizon_cl as pz

pytestmark = pytest.mark.usefixtures("one_lane")


@pytest.fixture(scope="module")
def star() -> pz.Result:
    scene = pz.load("cassegrain")
    return pz.trace(replace(scene, source=scene.source[:1]), batches=8, rays_per_batch=8192)


def test_all_that_the_cap_leaves_goes_through_the_focus(star):
    """Deterministic but for the cap's share: both mirrors take their tenth of every other ray."""
    ledger, focus = star.ledger, star.detectors["focus"]
    shaded = ledger.absorbed["cap"].value
    assert focus.power.value == pytest.approx((1.0 - shaded) * 0.81, rel=1e-14)
    assert focus.ladder[2].count == focus.power.count == star.rays - round(shaded * star.rays)
    assert ledger.absorbed["primary"].value == pytest.approx((1.0 - shaded) * 0.1, rel=1e-14)
    assert ledger.absorbed["secondary"].value == pytest.approx((1.0 - shaded) * 0.09, rel=1e-14)
    assert ledger.escaped.value == ledger.depth_capped.value == 0.0
    # one in 1.7e6: the cap takes 0.0441 of the beam
    sigma = np.sqrt(0.0441 * 0.9559 / star.rays)
    assert abs(shaded - 0.0441) < 5.0 * sigma


def test_the_counting_plane_sees_the_same_light(star):
    assert star.detectors["hole"].power == star.detectors["focus"].power
    assert star.detectors["hole"].ladder == star.detectors["focus"].ladder


def test_the_lamp_does_not_reach_the_focus():
    scene = pz.load("cassegrain")
    lamp = replace(scene, source=scene.source[1:])
    result = pz.trace(lamp, batches=4, rays_per_batch=16384)
    assert result.detectors["focus"].power.count == 0
    assert result.ledger.absorbed["tube"].value > 0.2
    assert result.detectors["tube"].power.count > 1000


def test_the_anchor_holds():
    result = pz.trace("cassegrain", batches=8, rays_per_batch=16384)
    power = result.detectors["focus"].power
    assert abs(power.value - 0.774279) < 5.0 * power.sigma
    assert abs(result.ledger.closure) < 1e-15 * 2.0


def test_the_derived_optics_are_those_of_the_notes():
    scene = pz.load("cassegrain")
    primary, secondary, focus = (
        next(e for e in scene.element if e.name == name)
        for name in ("primary", "secondary", "focus")
    )
    p = 0.5 * primary.curvature_radius - secondary.position[2]
    m = 5.0
    assert secondary.curvature_radius == pytest.approx(2.0 * p * m / (m - 1.0))
    assert secondary.conic_constant == pytest.approx(-(((m + 1.0) / (m - 1.0)) ** 2))
    assert focus.position[2] == pytest.approx(secondary.position[2] - m * p)
