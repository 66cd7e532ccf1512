"""Distributions of what is drawn: sources and scatter, by χ² over bins of known probability.

Seeds are fixed and nothing is rerun. Each test's false-alarm rate is `chance.ALPHA` = 1e-6, for a
seed chosen without looking; about 30 tests make a family of 3e-5.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles import chance
from oracles.engine import scene_of, trace
from oracles.scenes import AXES, BLACK, beam, matt
from oracles.statistics import chi_square

pytestmark = pytest.mark.statistical


def test_isotropic_points_shine_alike_in_all_directions() -> None:
    chance.source_directions("isotropic-point")


def test_lambertian_spheres_shine_alike_in_all_directions() -> None:
    chance.source_directions("lambertian-sphere")


@pytest.mark.parametrize("axis", AXES)
def test_cosine_points_have_a_cosine_lobe(axis: str) -> None:
    chance.source_directions("cosine-point", axis)


@pytest.mark.parametrize("axis", ["+z", "-x"])
def test_lambertian_disks_have_a_cosine_lobe(axis: str) -> None:
    chance.source_directions("lambertian-disk", axis)


@pytest.mark.parametrize("kind", ["collimated-disk", "lambertian-disk"])
def test_disk_sources_are_uniform_by_area(kind: str) -> None:
    chance.disk_positions(kind)


@pytest.mark.parametrize("side", ["front", "back"])
@pytest.mark.parametrize("normal", ["+z", "-z", "+x", "-y"])
def test_scatter_has_a_cosine_lobe_about_the_side_that_was_hit(normal: str, side: str) -> None:
    chance.lambertian_scatter(normal, side)


@pytest.mark.parametrize("position", ["top", "side"])
def test_scatter_off_a_sphere_has_a_cosine_lobe(position: str) -> None:
    """A thin beam onto the pole or the equator from outside; the far field of what comes back."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0, **matt()}
    lamp = beam((0, 0, 2), "-z") if position == "top" else beam((0, -2, 0), "+y")
    scene = scene_of([lamp], [ball], far_field={"n_mu": 12, "n_phi": 16})
    found = trace(scene, rays_per_batch=1 << 17)
    lobe = chance.cosine_lobe(12, 16, "+z" if position == "top" else "-y")
    chi_square(found.far_field_counts, lobe, chance.ALPHA)


def test_scatter_inside_a_sphere_is_uniform_over_the_sphere() -> None:
    """Lambert's law from any point of a sphere lights the whole of it evenly."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0}
    inner = {**ball, "radius": 1.0 - 1e-9, "port_fraction": 0.5, **matt()}
    # one lit point on a half sphere; the other half lets light through to a black shell behind it
    outer = {**ball, **BLACK, "detector": {"map": [16, 12], "side": "inside"}}
    lamp = beam((0.3, 0.1, 0.2), "-z")
    found = trace(scene_of([lamp], [inner, outer]), rays_per_batch=1 << 17, generation_cap=2)
    counts = found.detector("element 1").map_counts
    assert (counts[:6] == 0).all()
    chi_square(counts[6:], np.full((6, 16), 1 / 96), chance.ALPHA)
    arrived = counts.sum() / (1 << 17)
    assert abs(arrived - 0.5) < 5.0 * 0.5 / math.sqrt(1 << 17)


def test_sphere_sources_are_uniform_by_area() -> None:
    """A detector that clings to the shell sees where its rays start."""
    lamp = {"kind": "lambertian-sphere", "flux": 1.0, "position": [0, 0, 0], "radius": 1.0}
    shell = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0 + 1e-12, **BLACK}
    shell["detector"] = {"map": [16, 12], "side": "inside"}
    found = trace(scene_of([lamp], [shell]), rays_per_batch=1 << 17)
    counts = found.detector("element 0").map_counts
    assert counts.sum() == 1 << 17
    chi_square(counts, np.full((12, 16), 1 / 192), chance.ALPHA)


def test_place_and_direction_of_a_disk_source_are_independent() -> None:
    """A black screen far away sees directions; a hole's worth of the disk at a time."""
    lamp = {"kind": "lambertian-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
    lamp["radius"] = 0.5
    # a disk in front covers the middle half of the area: what passes has the lobe all the same
    cover = {"kind": "disk", "position": [0, 0, 1e-9], "axis": "-z", **BLACK}
    cover["radius"] = 0.5 * math.sqrt(0.5)
    far_field = {"n_mu": 12, "n_phi": 16}
    found = trace(scene_of([lamp], [cover], far_field=far_field), rays_per_batch=1 << 17)
    passed = found.far_field_counts.sum() / (1 << 17)
    assert abs(passed - 0.5) < 5.0 * 0.5 / math.sqrt(1 << 17)
    chi_square(found.far_field_counts, chance.cosine_lobe(12, 16, "+z"), chance.ALPHA)


def test_lambertian_disk_lights_a_coaxial_disk_by_the_view_factor() -> None:
    """Coaxial disks: F = (X − √(X² − 4 R2²/R1²))/2, X = 1 + (1 + R2²)/R1² (Howell C-41)."""
    a, b, h = 0.5, 0.8, 0.7
    lamp = {"kind": "lambertian-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
    target = {"kind": "disk", "position": [0, 0, h], "axis": "-z", "radius": b, **BLACK}
    rays = 1 << 19
    found = trace(scene_of([{**lamp, "radius": a}], [target]), rays_per_batch=rays)
    r1, r2 = a / h, b / h
    x = 1.0 + (1.0 + r2 * r2) / (r1 * r1)
    factor = 0.5 * (x - math.sqrt(x * x - 4.0 * (r2 / r1) ** 2))
    share = float(found.absorbed("element 0")) / rays
    assert abs(share - factor) < 4.9 * math.sqrt(factor * (1.0 - factor) / rays)  # two-sided 1e-6
