"""Reverse against forward: the same transmittance, by traces that share nothing but the scene."""

from __future__ import annotations

import math

import pytest

import photizon_cl as pz
from benchmarks.reverse import BINS, forward, reverse, tube


@pytest.mark.statistical
@pytest.mark.parametrize("window", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_reverse_gives_what_forward_gives(window: bool) -> None:
    """|z| ≤ 3.7 at six angles: a false alarm in 770 seeds, and the seeds are fixed."""
    elements = tube(window=window)
    back = reverse(elements, BINS, batches=16, rays_per_batch=1 << 15, seed=3)
    for ends, one in zip(BINS, back, strict=True):
        other = forward(elements, ends, batches=16, rays_per_batch=1 << 13, seed=4)
        assert one.count > 100
        assert other.count > 100
        z = (one.value - other.value) / math.hypot(one.sigma, other.sigma)
        assert abs(z) <= 3.7, ends
        assert math.hypot(one.sigma / one.value, other.sigma / other.value) < 0.3


@pytest.mark.statistical
def test_a_detector_in_glass_has_the_square_of_its_index() -> None:
    """PST = n² π I/Φ = cos θ T(θ); two bins at 5 σ: a false alarm in 900,000 seeds."""
    n, edges = 1.5, [20.0, 22.0, 50.0, 52.0]
    detector = pz.Disk(
        name="detector", position=(0, 0, 0), axis="+z", radius=0.01, surface=pz.Absorber()
    )
    face = pz.Disk(
        name="face", position=(0, 0, 0.005), axis="+z", radius=2.0, surface=pz.Fresnel(n)
    )
    lamp = pz.LambertianDisk(name="lamp", flux=1.0, position=(0, 0, 0), axis="+z", radius=0.01)
    far_field = pz.FarField(axis="+z", theta_edges_deg=edges, n_phi=1)
    scene = pz.Scene("immersed", (lamp,), (detector, face), far_field=far_field)
    far = pz.trace(scene, batches=16, rays_per_batch=1 << 16).far_field
    assert far is not None
    for j, theta in ((0, 21.0), (2, 51.0)):
        outside = math.radians(theta)
        inside = math.asin(math.sin(outside) / n)
        a, b = math.cos(outside), math.cos(inside)
        reflected = ((a - n * b) / (a + n * b)) ** 2, ((n * a - b) / (n * a + b)) ** 2
        want = a * (1.0 - 0.5 * sum(reflected))
        found, sigma = (n * n * math.pi * float(x[j, 0]) for x in (far.intensity, far.sigma))
        assert abs(found - want) < 5.0 * sigma
        assert sigma < 0.02 * found
