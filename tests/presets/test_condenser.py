"""The preset `plano-convex-condenser` against the refraction chain written out."""

from __future__ import annotations

import numpy as np
import pytest

import photizon_cl as pz

R, A, N, B = 0.05, 0.025, 1.5, 0.02


def transmittance(cos_i, n1, n2):
    """Unpolarised Fresnel transmittance in its textbook form."""
    sin_t = n1 / n2 * np.sqrt(1.0 - cos_i**2)
    cos_t = np.sqrt(1.0 - sin_t**2)
    rs = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t)
    rp = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t)
    return 1.0 - 0.5 * (rs**2 + rp**2)


def chain(h, focus):
    """Transmittance of both faces, and the height in the focal plane, of a ray at height h."""
    i = np.arcsin(h / R)
    j = np.arcsin(h / (N * R))
    bent = i - j
    depth = np.sqrt(R * R - A * A)
    into_glass = R * np.cos(i) - depth  # from the flat face to where the ray enters
    at_flat = h - into_glass * np.tan(bent)
    out = np.arcsin(N * np.sin(bent))
    through = transmittance(np.cos(i), 1.0, N) * transmittance(np.cos(bent), N, 1.0)
    return through, at_flat - focus * np.tan(out)


def direct(focus):
    nodes, weights = np.polynomial.legendre.leggauss(40)
    h = 0.5 * B * (1.0 + nodes)
    return float(np.sum(0.5 * B * weights * h * chain(h, focus)[0]) * 2.0 / B**2)


def test_anchor_numbers():
    scene = pz.load("plano-convex-condenser")
    lens, disk = scene.element
    focus = disk.position[2]
    assert (lens.curvature_radius, lens.aperture_radius) == (R, A)
    assert focus == pytest.approx(R / (N - 1.0) - lens.thickness / N, rel=1e-15)
    assert f"{direct(focus):.9f}" in scene.notes
    assert f"{-chain(np.array([B]), focus)[1][0] * 1e3:.4f} mm" in scene.notes
    assert chain(np.array([1e-6]), focus)[0][0] == pytest.approx(0.9216, abs=1e-12)
    assert abs(chain(np.array([1e-4]), focus)[1][0]) < 1e-9  # it is the paraxial focus


def test_default_run_meets_the_anchor():
    result = pz.trace("plano-convex-condenser", batches=8)
    rung = result.detectors["focus"].ladder[2]
    assert rung.sigma < 1e-6
    assert abs(rung.value - direct(pz.load("plano-convex-condenser").element[1].position[2])) < (
        4.0 * rung.sigma
    )
    assert all(result.detectors["focus"].ladder[g].value == 0.0 for g in (0, 1, 3))
    assert abs(result.ledger.closure) <= 1e-15
    assert 0.0 < result.ledger.depth_capped.value < 1e-8


def test_every_ray_goes_the_way_of_the_chain():
    found = pz.paths("plano-convex-condenser", rays=40)
    focus = found.scene.element[1].position[2]
    arrives = np.flatnonzero((found.element == 1) & (found.generation == 2))
    assert len(arrives) == 40
    launched = found.start[found.generation == 0]
    h = np.hypot(launched[:, 0], launched[:, 1])
    through, height = chain(h, focus)
    np.testing.assert_allclose(found.weight[arrives], through, rtol=1e-14)
    end = found.end[arrives]
    # the height is signed along the launch's own azimuth
    signed = (end[:, 0] * launched[:, 0] + end[:, 1] * launched[:, 1]) / h
    np.testing.assert_allclose(signed, height, rtol=0.0, atol=1e-15)
