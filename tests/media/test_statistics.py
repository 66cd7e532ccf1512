"""Absorption against quadrature, by z-tests with fixed seeds; a false alarm once in 10^6 a test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles.engine import PLAN, scene_of, trace
from oracles.media import Layer, stack
from oracles.statistics import batch_values, z_limit
from scipy.integrate import quad

pytestmark = pytest.mark.statistical

ALPHA = 1e-6
FAST = PLAN.with_(wave_rays=1 << 16)
RADIUS, PLACE = 1.0, 0.6


def z_of(found, cell, expected):
    """Return how far the batches' mean of a cell is from what it should be, in standard errors."""
    rays = found.compiled.settings.rays_per_batch
    parts = batch_values(found)[:, cell] / rays
    sigma = parts.std(ddof=1) / math.sqrt(len(parts))
    return float((parts.mean() - expected) / sigma)


def agrees(found, cell, expected):
    assert abs(z_of(found, cell, expected)) < z_limit(ALPHA, len(found.batches) - 1)


def ball(index, absorption, **run):
    """A lamp in a ball of glass, off its middle."""
    lamp = {
        "kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, PLACE], "medium": "glass",
    }  # fmt: skip
    glass = {"name": "glass", "index": index, "absorption_per_m": absorption}
    sphere = {
        "kind": "sphere", "position": [0.0, 0.0, 0.0], "axis": "+z", "radius": RADIUS,
        "surface": {"kind": "fresnel", "medium": "glass"},
    }  # fmt: skip
    return scene_of([lamp], [sphere], medium=[glass], run=run)


def let_out(index, absorption):
    """Return what leaves the ball: over the lamp's directions, with every reflection inside.

    The way to the wall is s(μ) from the lamp; every chord after it is 2 r cos θ long, θ the angle
    to the normal, which stays the same. R is Fresnel's; beyond the critical angle nothing leaves.
    """

    def part(mu):
        closest = PLACE * PLACE * (1.0 - mu * mu)
        half = math.sqrt(RADIUS * RADIUS - closest)
        cosine, way = half / RADIUS, half - PLACE * mu
        sine = index * math.sqrt(max(1.0 - cosine * cosine, 0.0))
        if sine >= 1.0:
            return 0.0
        outer = math.sqrt(1.0 - sine * sine)
        rs = (index * cosine - outer) / (index * cosine + outer)
        rp = (cosine - index * outer) / (cosine + index * outer)
        back = 0.5 * (rs * rs + rp * rp)
        kept = math.exp(-absorption * 2.0 * half)
        return 0.5 * math.exp(-absorption * way) * (1.0 - back) / (1.0 - back * kept)

    critical = 1.0 - (RADIUS / (index * PLACE)) ** 2
    edges = [-math.sqrt(critical), math.sqrt(critical)] if critical > 0.0 else []
    return quad(part, -1.0, 1.0, points=edges or None, limit=400, epsabs=1e-10)[0]


@pytest.mark.parametrize(("index", "absorption"), [(1.0, 0.7), (1.33, 0.2), (1.9, 0.5), (2.4, 3.0)])
def test_a_ball_that_is_lit_from_inside(index, absorption):
    scene = ball(index, absorption, generation_cap=400, roulette_floor=1e-6)
    found = trace(scene, rays_per_batch=1 << 13, batches=32, plan=FAST)
    out = let_out(index, absorption)
    layout = found.compiled.layout
    agrees(found, layout.escaped, out)
    agrees(found, layout.row("absorbed_in.glass"), 1.0 - out)
    assert float(found.depth_capped / found.emitted) < 1e-9


@pytest.mark.parametrize("kind", ["plano-convex", "biconvex"])
def test_a_lens_that_bends_nothing(kind):
    """Of index 1, so that a parallel beam crosses it straight: exp(−α × way) over its disk."""
    radius, aperture, alpha = 1.0, 0.6, 1.5
    shape = {"curvature_radius": radius}
    if kind == "biconvex":
        shape = {"front_radius": radius, "back_radius": radius}
    lens = {
        "kind": kind, "position": [0, 0, 0], "axis": "+x", "tilt_deg": [20.0, -40.0],
        "aperture_radius": aperture, "surface": {"kind": "fresnel", "medium": "gel"}, **shape,
    }  # fmt: skip
    lamp = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+x",
        "tilt_deg": [20.0, -40.0], "radius": aperture, "medium": "gel",
    }  # fmt: skip
    gel = {"name": "gel", "index": 1.0, "absorption_per_m": alpha}
    found = trace(scene_of([lamp], [lens], medium=[gel]), rays_per_batch=1 << 13, batches=32)

    def ring(r):
        # from the plane of the rim to the front; what lies behind it the lamp does not light
        thickness = math.sqrt(radius**2 - r * r) - math.sqrt(radius**2 - aperture**2)
        return 2.0 * r / aperture**2 * math.exp(-alpha * thickness)

    agrees(found, found.compiled.layout.escaped, quad(ring, 0.0, aperture)[0])
    assert found.closures() == [0] * 32


def test_one_child_for_two():
    """Without splitting, of a slab that absorbs, what comes through is right on average."""
    layers = [Layer("vacuum", 1.0), Layer("glass", 1.9, 40.0), Layer("vacuum", 1.0)]
    run = {"splitting": False, "generation_cap": 200}
    parts = stack(layers, [0.0, 0.01], -0.02, 0.05, rays_per_batch=1 << 12, **run)
    found = trace(scene_of(**parts), batches=32)
    part, kept = (0.9 / 2.9) ** 2, math.exp(-0.4)
    through = (1 - part) ** 2 * kept / (1 - (part * kept) ** 2)
    back = part + through * part * kept
    layout = found.compiled.layout
    agrees(found, layout.row("absorbed_in.glass"), 1.0 - through - back)
    agrees(found, layout.escaped, back)
    assert found.closures() == [0] * 32


def test_importance_sampling_changes_no_mean():
    """A matt floor under water, and a small sensor that it lights: far fewer arrivals without."""
    matt = {
        "kind": "disk", "name": "floor", "position": [0, 0, 0], "axis": "+z", "radius": 1.0,
        "surface": {"kind": "lambertian", "reflectance": 0.8},
    }  # fmt: skip
    sensor = {
        "kind": "disk", "name": "sensor", "position": [0.3, 0, 0.5], "axis": "-z", "radius": 0.05,
        "surface": {"kind": "absorber"}, "detector": {},
    }  # fmt: skip
    lamp = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 0.4], "axis": "-z",
        "radius": 1e-6, "medium": "water",
    }  # fmt: skip
    water = {"name": "water", "index": 1.33, "absorption_per_m": 1.5}
    toward = {"toward": ["sensor"], "fraction": 0.5}
    scene = scene_of([lamp], [matt, sensor], medium=[water], importance=toward)
    found = trace(scene, rays_per_batch=1 << 12, batches=32)

    def arrives(x, y):
        """Of what the floor's middle sends out: cos cos' / (π d²), less what the water takes."""
        d2 = (0.3 + x) ** 2 + y * y + 0.25
        return 0.25 / (math.pi * d2 * d2) * math.exp(-1.5 * math.sqrt(d2))

    turns = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)

    def ring(r):
        around = [arrives(r * math.cos(t), r * math.sin(t)) for t in turns]
        return r * 2.0 * math.pi * np.mean(around)

    expected = 0.8 * math.exp(-1.5 * 0.4) * quad(ring, 0.0, 0.05)[0]
    agrees(found, found.detector("sensor").cells.power, expected)
    assert found.detector("sensor").count > 1 << 15
    assert found.closures() == [0] * 32
