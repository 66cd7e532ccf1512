"""View factors of coaxial disks, annuli, and of a tube's wall and base, against closed forms.

The one formula is that of two coaxial parallel disks (J. R. Howell, A Catalog of Radiation Heat
Transfer Configuration Factors, C-41); the others follow from it by reciprocity and summation (the
view-factor algebra of its introduction). The seeds are fixed; false alarms at most `ALPHA` a test.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, matt
from oracles.statistics import chi_square, z_limit

ALPHA = 1e-6
RAYS = 1 << 18
ORIGIN = [0.0, 0.0, 0.0]


def disk_to_disk(r1: float, r2: float, h: float) -> float:
    """Return the view factor from a disk of radius r1 to a coaxial one of r2 at a height h."""
    x = 1.0 + (h * h + r2 * r2) / (r1 * r1)
    return 0.5 * (x - math.sqrt(x * x - 4.0 * (r2 / r1) ** 2))


def exchanged(r1: float, r2: float, h: float) -> float:
    """Return π r1² times that view factor, in m²; 0 for a disk without area."""
    return math.pi * r1 * r1 * disk_to_disk(r1, r2, h) if r1 and r2 else 0.0


def annulus_to_annulus(a: tuple[float, float], b: tuple[float, float], h: float) -> float:
    """Return the view factor between coaxial annuli given by inner and outer radius."""
    total = sum(
        sign * exchanged(r1, r2, h)
        for r1, r2, sign in ((a[1], b[1], 1), (a[1], b[0], -1), (a[0], b[1], -1), (a[0], b[0], 1))
    )
    return total / (math.pi * (a[1] - a[0]) * (a[1] + a[0]))


@pytest.mark.parametrize(("r1", "r2", "h"), [(1.0, 1.0, 1.0), (0.5, 1.3, 0.7), (2.0, 0.6, 1.5)])
def test_the_closed_form_is_the_double_integral(r1: float, r2: float, h: float) -> None:
    """∬ cos θ₁ cos θ₂ / (π d²) dA₁ dA₂ / A₁, by Gauss's rule in both radii, evenly in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    a, b = ((nodes + 1.0) / 2.0 * r for r in (r1, r2))
    phi = 2.0 * math.pi * np.arange(256) / 256.0
    rho, sigma, angle = np.meshgrid(a, b, phi, indexing="ij")
    squared = h * h + rho**2 + sigma**2 - 2.0 * rho * sigma * np.cos(angle)
    inner = (h * h * rho * sigma / (math.pi * squared**2)).mean(axis=2) * 2.0 * math.pi
    integral = weights @ inner @ weights * (r1 / 2.0) * (r2 / 2.0) * 2.0 * math.pi
    assert integral / (math.pi * r1 * r1) == pytest.approx(disk_to_disk(r1, r2, h), rel=1e-12)


def is_share(count: int, total: int, share: float) -> None:
    """Assert that a count is binomial with a given share: a z-test."""
    z = (count - total * share) / math.sqrt(total * share * (1.0 - share))
    assert abs(z) < z_limit(ALPHA), f"{count} of {total}, not {share:.6f}: z = {z:.2f}"


def bright_disk(radius: float) -> dict[str, Any]:
    """Return a source of uniform radiance that shines up the axis."""
    where = {"position": ORIGIN, "axis": "+z", "radius": radius}
    return {"kind": "lambertian-disk", "flux": 1.0, **where}


@pytest.mark.parametrize("h", [0.2, 1.0, 3.0])
@pytest.mark.parametrize(
    ("a", "b"), [((0.3, 1.0), (0.4, 0.8)), ((0.5, 0.6), (0.0, 0.7)), ((0.0, 1.0), (0.9, 1.1))]
)
def test_coaxial_annuli(a: tuple[float, float], b: tuple[float, float], h: float) -> None:
    """A beam lights one matt annulus evenly, the other one counts what comes from there."""
    flat = {"kind": "disk", "position": ORIGIN, "axis": "+z"}
    lit = {**flat, "radius": a[1], "inner_radius": a[0], **matt()}
    seen = {**flat, "position": [0.0, 0.0, h], "axis": "-z", "radius": b[1], "inner_radius": b[0]}
    lamp = beam((0.0, 0.0, 0.5 * h), "-z", a[1])
    scene = scene_of([lamp], [lit, {**seen, **BLACK, "detector": {}}])
    found = trace(scene, rays_per_batch=RAYS)
    arrived = found.detector("element 1").count
    scattered = found.interactions - arrived
    if a[0]:
        is_share(scattered, RAYS, (a[1] - a[0]) * (a[1] + a[0]) / a[1] ** 2)
    is_share(arrived, scattered, annulus_to_annulus(a, b, h))


@pytest.mark.parametrize(("radius", "length"), [(1.0, 0.3), (1.0, 2.0), (0.1, 3.0)])
def test_base_and_wall_of_a_tube(radius: float, length: float) -> None:
    """What leaves the base meets the wall or the top; along the wall as the disks' formula says."""
    rows = 12
    tube = {"kind": "cylinder", "position": ORIGIN, "axis": "+z", "radius": radius}
    tube |= {"length": length, **BLACK, "detector": {"map": [8, rows]}}
    found = trace(scene_of([bright_disk(radius)], [tube]), rays_per_batch=RAYS)
    wall = found.detector("element 0")
    is_share(int(wall.map_counts.sum()), RAYS, 1.0 - disk_to_disk(radius, radius, length))
    passes = [1.0] + [disk_to_disk(radius, radius, length * (k + 1) / rows) for k in range(rows)]
    shares = np.repeat(-np.diff(passes)[:, None] / (1.0 - passes[-1]) / 8.0, 8, axis=1)
    chi_square(wall.map_counts, shares, ALPHA)


@pytest.mark.parametrize("length", [0.3, 1.0, 1.7])
def test_what_a_matt_wall_sends_back_to_its_base(length: float) -> None:
    """Base to ring and back: of a ring at z, the base takes what reciprocity says, R/2 dF/dz.

    -dF/dz of the disks' formula is what the base sends to a ring; the product is integrated.
    """
    radius = 0.5
    tube = {"kind": "cylinder", "position": ORIGIN, "axis": "+z", "radius": radius}
    tube |= {"length": length, **matt()}
    base = {"kind": "disk", "position": ORIGIN, "axis": "+z", "radius": radius, **BLACK}
    lamp = {**bright_disk(radius), "position": [0.0, 0.0, 1e-9]}
    scene = scene_of([lamp], [tube, {**base, "detector": {"generations": 3}}])
    found = trace(scene, rays_per_batch=RAYS, generation_cap=2)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    z = 0.5 * length * (1.0 + nodes)
    x = 2.0 + (z / radius) ** 2
    to_ring = z / radius**2 * (x / np.sqrt(x * x - 4.0) - 1.0)
    back = to_ring * radius / 2.0  # reciprocity: π R² dF = 2 π R dz F
    want = float((weights * to_ring * back).sum() * 0.5 * length)
    is_share(found.detector("element 1").ladder_counts[1], RAYS, want)


@pytest.mark.parametrize(("r1", "r2", "h"), [(1.0, 0.4, 0.7), (0.4, 1.0, 0.7), (0.2, 0.2, 2.0)])
def test_base_and_wall_of_a_frustum(r1: float, r2: float, h: float) -> None:
    """Inside a cone what does not reach the other end meets the wall."""
    cone = {"kind": "cone", "position": ORIGIN, "axis": "+z", "length": h, **BLACK, "detector": {}}
    cone |= {"entrance_radius": r1, "exit_radius": r2}
    found = trace(scene_of([bright_disk(r1)], [cone]), rays_per_batch=RAYS)
    is_share(found.detector("element 0").count, RAYS, 1.0 - disk_to_disk(r1, r2, h))
