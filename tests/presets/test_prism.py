"""The preset `dispersing-prism` against Snell's law and Fresnel's formulas, line by line."""

from __future__ import annotations

import mpmath
import pytest
from oracles.spectra import index_of_bk7

import photizon_cl as pz

pytestmark = pytest.mark.usefixtures("one_lane")


def through(nm: float) -> tuple[float, float]:
    """Return by how much a line is turned, in degrees, and which part of it comes through."""
    with mpmath.workdps(30):
        n = index_of_bk7(nm)
        i = mpmath.radians(50)
        j = mpmath.asin(mpmath.sin(i) / n)
        k = mpmath.radians(60) - j
        out = mpmath.asin(n * mpmath.sin(k))

        def part(a, b, one, two):
            ca, cb = mpmath.cos(a), mpmath.cos(b)
            rs = (one * ca - two * cb) / (one * ca + two * cb)
            rp = (one * cb - two * ca) / (one * cb + two * ca)
            return 1 - (rs**2 + rp**2) / 2

        turned = mpmath.degrees(i + out) - 60
        return float(turned), float(part(i, j, 1, n) * part(k, out, n, 1))


def test_anchor_numbers():
    scene = pz.load("dispersing-prism")
    lines = scene.spectrum.wavelengths_nm
    wanted = [through(nm) for nm in lines]
    for k in (0, 6):
        assert f"{wanted[k][0]:.4f} degrees" in scene.notes
        assert f"{wanted[k][1] / 7:.9f} W" in scene.notes
        assert f"n = {float(index_of_bk7(lines[k])):.6f}" in scene.notes
    assert f"{sum(part for _, part in wanted) / 7:.9f} W of 1 W" in scene.notes


def test_each_line_arrives_where_and_as_it_should():
    scene = pz.load("dispersing-prism")
    result = pz.trace(scene, batches=1, rays_per_batch=700)
    screen = result.detectors["screen"]
    wanted = [through(nm) for nm in scene.spectrum.wavelengths_nm]
    for part, (_, power) in zip(screen.power.by_wavelength, wanted, strict=True):
        assert part == pytest.approx(power / 7, rel=1e-12)
    assert screen.power == pytest.approx(0.884152122707, abs=1e-12)
    middles = 0.5 * (screen.map.y_edges[1:] + screen.map.y_edges[:-1])
    places = []
    for one in screen.map.by_wavelength:
        weights = one.irradiance[:, 0]
        places.append(float(middles @ weights / weights.sum()))
    # 1 m away: a degree is 17.5 mm, and the yellow line is in the middle
    for place, (turned, _) in zip(places, wanted, strict=True):
        assert place == pytest.approx(0.01745 * (turned - wanted[4][0]), abs=6e-4)
    assert result.ledger.depth_capped < 1e-6
