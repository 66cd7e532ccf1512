"""The preset `aspheric-condenser` against the integral of its anchor, and its focus."""

from __future__ import annotations

import numpy as np
import pytest

import photizon_cl as pz

R, N, B = 0.05, 1.5, 0.02


def transmittance(cosine):
    """Unpolarised Fresnel transmittance out of the glass in its textbook form."""
    refracted = np.sqrt(1.0 - N * N * (1.0 - cosine**2))
    rs = (N * cosine - refracted) / (N * cosine + refracted)
    rp = (N * refracted - cosine) / (N * refracted + cosine)
    return 1.0 - 0.5 * (rs**2 + rp**2)


def through(h):
    """Transmittance of both faces at height h."""
    slope = (h / R) / np.sqrt(1.0 + (N * N - 1.0) * (h / R) ** 2)
    return 0.96 * transmittance(1.0 / np.hypot(1.0, slope))


def direct():
    nodes, weights = np.polynomial.legendre.leggauss(40)
    h = 0.5 * B * (1.0 + nodes)
    return float(np.sum(0.5 * B * weights * h * through(h)) * 2.0 / B**2)


def test_anchor_numbers():
    scene = pz.load("aspheric-condenser")
    lens, disk = scene.element
    assert (lens.back_radius, lens.back_conic) == (R, -N * N)
    assert disk.position[2] == pytest.approx(-lens.vertices[1] + R / (N - 1.0), rel=1e-15)
    assert f"{direct():.9f}" in scene.notes
    sphere = B - (0.1 + R - np.sqrt(R * R - B * B)) * np.tan(
        np.arcsin(N * B / R) - np.arcsin(B / R)
    )
    assert f"{-sphere * 1e3:.1f} mm" in scene.notes


@pytest.mark.slow  # the bits of its first batches are stored
def test_default_run_meets_the_anchor():
    result = pz.trace("aspheric-condenser", batches=8)
    rung = result.detectors["focus"].ladder[2]
    assert rung.sigma < 1e-6
    assert abs(rung.value - direct()) < 4.0 * rung.sigma
    assert abs(result.ledger.closure) <= 1e-15
    assert all(result.detectors["focus"].ladder[g].value == 0.0 for g in (0, 1, 3))


def test_every_ray_comes_to_the_focus():
    found = pz.paths("aspheric-condenser", rays=60)
    arrives = np.flatnonzero((found.element == 1) & (found.generation == 2))
    assert len(arrives) == 60
    launched = found.start[found.generation == 0]
    h = np.hypot(launched[:, 0], launched[:, 1])
    np.testing.assert_allclose(found.weight[arrives], through(h), rtol=1e-14)
    assert np.hypot(*found.end[arrives, :2].T).max() < 1e-16
