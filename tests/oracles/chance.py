"""Gates on random estimates; the seeds are fixed, the false alarms at most `ALPHA` a gate."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from oracles.engine import PLAN, scene_of, trace
from oracles.gates import closes
from oracles.scenes import BLACK, beam, matt, wall
from oracles.statistics import batch_mean, batch_z, chi_square, z_limit

ALPHA = 1e-6


def cosine_lobe(n_mu: int, n_phi: int, normal: str) -> np.ndarray:
    """Return the probability of each far-field bin for a cosine lobe about a world axis."""
    mu = np.linspace(-1.0, 1.0, n_mu + 1)
    sign = 1.0 if normal[0] == "+" else -1.0
    if normal[1] == "z":
        rows = np.diff(np.clip(sign * mu, 0.0, None) ** 2) * sign
        return np.repeat(rows[:, np.newaxis] / n_phi, n_phi, axis=1)
    # the integral of sin(theta) cos(phi - phi0) / pi over the half where it is positive; edges at
    # the quarter turns, since 4 divides n_phi
    assert n_phi % 4 == 0
    rows = np.diff(0.5 * (mu * np.sqrt(1.0 - mu * mu) + np.arcsin(mu)))
    start = {"+x": 0.0, "+y": 0.5, "-x": 1.0, "-y": 1.5}[normal] * math.pi
    phi = np.linspace(0.0, 2.0 * math.pi, n_phi + 1) - start
    columns = np.where(np.cos(0.5 * (phi[1:] + phi[:-1])) > 0.0, np.diff(np.sin(phi)), 0.0)
    return rows[:, np.newaxis] * columns[np.newaxis] / math.pi


def lambertian_scatter(normal: str = "+z", side: str = "front", rays: int = 1 << 17) -> None:
    """Scattered directions have the cosine density about the side that was hit (χ² over bins)."""
    opposite = normal.translate(str.maketrans("+-", "-+"))
    place = [0.0, 0.0, 0.0]
    place["xyz".index(normal[1])] = 1.0 if normal[0] == "+" else -1.0
    axis = normal if side == "front" else opposite
    elements = [{**wall((0, 0, 0), axis), **matt()}]
    scene = scene_of([beam(tuple(place), opposite)], elements, far_field={"n_mu": 12, "n_phi": 16})
    found = trace(scene, rays_per_batch=rays)
    chi_square(found.far_field_counts, cosine_lobe(12, 16, normal), ALPHA)


def source_directions(kind: str, axis: str = "+z", rays: int = 1 << 17) -> None:
    """Launched directions have the density of their kind (χ² over far-field bins)."""
    source: dict[str, Any] = {"kind": kind, "flux": 1.0, "position": [0.1, 0.2, 0.3]}
    if kind in ("cosine-point", "lambertian-disk"):
        source["axis"] = axis
        wanted = cosine_lobe(12, 16, axis)
    else:
        wanted = np.full((12, 16), 1.0 / 192)
    if not kind.endswith("point"):
        source["radius"] = 0.5
    found = trace(scene_of([source], [], far_field={"n_mu": 12, "n_phi": 16}), rays_per_batch=rays)
    chi_square(found.far_field_counts, wanted, ALPHA)


def roulette_is_unbiased(rays: int = 1 << 14, batches: int = 40) -> None:
    """killed − boosted is zero on average, and no row moves: z-tests from the batches' scatter."""
    run = {"rays_per_batch": rays, "generation_cap": 400}
    played = trace("integrating-sphere", batches=batches, roulette_floor=0.5, **run)
    layout = played.compiled.layout
    closes(played)
    balance = batch_z(played, lambda x: x[layout.killed] - x[layout.boosted], 0.0)
    rho, f = 0.9, 0.05
    escaped = 1.0 - (1.0 - f) * (1.0 - rho) / (1.0 - rho * (1.0 - f))
    out = batch_z(played, lambda x: x[layout.escaped], escaped * rays)
    limit = z_limit(ALPHA / 2, batches - 1)
    assert abs(balance) < limit
    assert abs(out) < limit


def integrating_sphere(rays: int = 1 << 16, batches: int = 64, sigma: float = 2e-4) -> None:
    """Wall 0.6552 Φ and escape 0.3448 Φ within 4 σ̂, with σ̂ at most `sigma`."""
    plan = PLAN.with_(wave_rays=1 << 18)
    found = trace("integrating-sphere", batches=batches, rays_per_batch=rays, plan=plan)
    layout = found.compiled.layout
    rho, f = 0.9, 0.05
    wall_share = (1.0 - f) * (1.0 - rho) / (1.0 - rho * (1.0 - f))
    for cell, want in ((0, wall_share), (layout.escaped, 1.0 - wall_share)):
        mean, error = batch_mean(found, lambda x, cell=cell: x[cell] / rays)
        assert error <= sigma
        assert abs(mean - want) < 4.0 * error
    assert found.depth_capped / found.emitted < 1e-100


def disk_positions(kind: str, rays: int = 1 << 17) -> None:
    """A disk source shines uniformly by area: χ² over rings and sectors just in front of it."""
    radius = 0.5
    source = {"kind": kind, "flux": 1.0, "position": [0, 0, 0], "axis": "+z", "radius": radius}
    n = 16
    target = {"kind": "disk", "position": [0, 0, 1e-9], "axis": "-z", "radius": 0.6, **BLACK}
    target["detector"] = {"map": [n, n]}
    found = trace(scene_of([source], [target]), rays_per_batch=rays)
    edges = np.linspace(-0.6, 0.6, n + 1)
    wanted = circle_areas(edges, edges, radius)
    # +v of a disk that faces -z is world +x, +u is world +y; the areas are symmetric
    chi_square(found.detector("element 0").map_counts, wanted / wanted.sum(), ALPHA)


def circle_areas(x: np.ndarray, y: np.ndarray, radius: float) -> np.ndarray:
    """Return the area of each bin within a circle by fine quadrature, shape (ny, nx)."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    areas = np.zeros((len(y) - 1, len(x) - 1))
    for i in range(len(x) - 1):
        half = 0.5 * (x[i + 1] - x[i])
        at = 0.5 * (x[i + 1] + x[i]) + half * nodes
        height = np.sqrt(np.clip(radius * radius - at * at, 0.0, None))
        for j in range(len(y) - 1):
            width = np.clip(np.minimum(y[j + 1], height) - np.maximum(y[j], -height), 0.0, None)
            areas[j, i] = half * (weights * width).sum()
    return areas


def lone_source(source: dict[str, Any], rows: dict[int, float], rays: int = 1 << 14) -> None:
    """Directions of a source alone: χ² over eight equal parts of cos θ; parts not named are 0."""
    found = trace(scene_of([source], [], far_field={"n_mu": 8, "n_phi": 4}), rays_per_batch=rays)
    shares = np.zeros((8, 4))
    for row, share in rows.items():
        shares[row] = share / 4.0
    chi_square(found.far_field_counts, shares, ALPHA)


def cone_is_uniform() -> None:
    """A cone of 60° has equal parts of its rays in equal parts of cos θ."""
    lamp = {"kind": "cone-point", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
    lone_source({**lamp, "half_angle_deg": 60.0}, {6: 0.5, 7: 0.5})


def beam_has_uniform_radiance() -> None:
    """Of a beam that diverges by 60°, sin² θ is uniform up to 3/4."""
    lamp = {**beam((0, 0, 0), "+z", 0.1), "divergence_deg": 60.0}
    lone_source(lamp, {6: 5 / 12, 7: 7 / 12})


def rectangle_lamp_is_even(rays: int = 1 << 14) -> None:
    """A black plate on a quarter of a shining rectangle gets a quarter of its rays."""
    lamp = {
        "kind": "lambertian-rectangle", "flux": 1.0, "position": [0, 0, 0], "axis": "+z",
        "half_width": 2.0, "half_height": 2.0,
    }  # fmt: skip
    plate = {**wall((1.0, 1.0, 1e-9), "-z", 1.0), **BLACK, "detector": {}}
    count = trace(scene_of([lamp], [plate]), rays_per_batch=rays).detector("element 0").count
    assert abs(count - rays / 4) < z_limit(ALPHA) * math.sqrt(rays * 3 / 16)
