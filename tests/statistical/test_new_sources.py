"""Cones, rectangles and beams that diverge: their directions and places, by χ² and by exact limits.

Each gate's false alarms are at most 1e-6 with its fixed seed; no reruns.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles.chance import ALPHA
from oracles.engine import compiled, scene_of, trace
from oracles.scenes import BLACK, wall
from oracles.statistics import chi_square

import photizon_cl as pz

BINS = {"n_mu": 40, "n_phi": 8}


def directions(source, rays=1 << 16):
    lamp = {"flux": 1.0, "position": [0.1, 0.2, 0.3], "axis": "+z", **source}
    found = trace(scene_of([lamp], [], far_field=BINS), rays_per_batch=rays)
    return found.far_field_counts


def rows_of(density):
    """Probability of each bin from the integral of a density over cos θ, even in φ."""
    edges = np.linspace(-1.0, 1.0, BINS["n_mu"] + 1)
    return np.repeat(np.diff(density(edges))[:, np.newaxis] / BINS["n_phi"], BINS["n_phi"], axis=1)


@pytest.mark.parametrize("angle", [20.0, 90.0, 135.0, 180.0])
def test_a_cone_has_uniform_intensity(angle):
    least = math.cos(math.radians(angle))
    below = lambda mu: np.clip((mu - least) / (1.0 - least), 0.0, 1.0)  # noqa: E731
    chi_square(directions({"kind": "cone-point", "half_angle_deg": angle}), rows_of(below), ALPHA)


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.2665])
def test_a_narrow_cone_is_as_wide_as_it_says(angle):
    """Uniform over the disk that it lights far away, however narrow."""
    radius = math.tan(math.radians(angle))
    target = {"kind": "disk", "position": [0, 0, 1], "axis": "-z", "radius": radius, **BLACK}
    target["detector"] = {"map": [4, 4]}
    lamp = {"kind": "cone-point", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
    found = trace(scene_of([{**lamp, "half_angle_deg": angle}], [target]), rays_per_batch=1 << 16)
    # a ray at the very edge may round outside
    assert found.escaped <= 4
    areas = found.compiled.scene.element[0].map_bins(4, 4).areas
    chi_square(found.detector("element 0").map_counts, areas / areas.sum(), ALPHA)


def test_the_whole_sphere_is_the_isotropic_point():
    whole = pz.ConePoint(name="s", flux=2.0, position=(0, 0, 0), axis="+z", half_angle_deg=180)
    same = pz.IsotropicPoint(name="s", flux=2.0, position=(0, 0, 0))
    assert whole.height == 2.0
    assert whole.radiant_intensity == same.radiant_intensity


def test_a_rectangle_shines_with_a_cosine_lobe_uniform_by_area():
    source = {"kind": "lambertian-rectangle", "half_width": 0.3, "half_height": 0.1}
    below = lambda mu: np.clip(mu, 0.0, None) ** 2  # noqa: E731
    chi_square(directions(source), rows_of(below), ALPHA)
    # caught where it starts: what leaves within a hair of the chip is uniform over it
    lamp = {"flux": 1.0, "position": [0, 0, 0], "axis": "+z", **source}
    near = {**wall((0, 0, 1e-9), "-z", 0.3), **BLACK, "detector": {"map": [6, 6]}}
    found = trace(scene_of([lamp], [near]), rays_per_batch=1 << 16)
    # the frame of -z has u along +y and v along +x
    counts = found.detector("element 0").map_counts
    assert not counts[:, :2].any()
    assert not counts[:, 4:].any()
    chi_square(counts[:, 2:4], np.full((6, 2), 1.0 / 12), ALPHA)


def test_a_rectangle_is_tilted_as_a_whole():
    lamp = {
        "kind": "lambertian-rectangle", "flux": 1.0, "position": [0, 0, 0], "axis": "+x",
        "tilt_deg": [10.0, 20.0], "half_width": 0.3, "half_height": 0.1,
    }  # fmt: skip
    near = {
        "kind": "rectangle", "position": [0, 0, 0], "axis": "+x", "tilt_deg": [10.0, 20.0],
        "half_width": 0.3001, "half_height": 0.1001, "surface": {"kind": "clear"}, "detector": {},
    }  # fmt: skip
    scene = scene_of([lamp], [near])
    shifted = np.array(scene.element[0].frame[2]) * 1e-6
    near["position"] = shifted.tolist()
    found = trace(scene_of([lamp], [{**near, "detector": {"side": "back"}}]), rays_per_batch=4096)
    assert found.detector("element 0").count == 4096


@pytest.mark.parametrize("divergence", [1e-6, 0.2665, 10.0, 80.0])
def test_a_beam_diverges_with_uniform_radiance(divergence):
    """Power goes as cos θ within the cone: uniform in sin² θ up to sin² δ, none beyond."""
    beam = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+z",
        "radius": 1e-12, "divergence_deg": divergence,
    }  # fmt: skip
    radius = math.tan(math.radians(divergence))
    target = {"kind": "disk", "position": [0, 0, 1], "axis": "-z", "radius": radius, **BLACK}
    target["detector"] = {"map": [8, 8]}
    found = trace(scene_of([beam], [target]), rays_per_batch=1 << 16)
    assert found.escaped <= 4
    # in rings of tan θ the share is sin² θ / sin² δ; the map's quadrants are even
    counts = found.detector("element 0").map_counts
    quadrants = [counts[i : i + 4, j : j + 4].sum() for i in (0, 4) for j in (0, 4)]
    chi_square(np.array([quadrants]), np.full((1, 4), 0.25), ALPHA)
    inner = {**target, "radius": 0.5 * radius, "detector": {}}
    half = trace(scene_of([beam], [inner]), rays_per_batch=1 << 16).detector("element 0").count
    theta = math.atan(0.5 * radius)
    share = (math.sin(theta) / math.sin(math.radians(divergence))) ** 2
    sigma = math.sqrt(share * (1.0 - share) * (1 << 16))
    assert abs(half - share * (1 << 16)) < 5.0 * sigma  # one in 1.7e6


def test_a_beam_without_divergence_is_what_it_was():
    beam = {
        "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 0], "axis": "+z", "radius": 0.1,
    }  # fmt: skip
    target = {**wall((0, 0, 1), "-z", 0.2), **BLACK, "detector": {"map": [8, 8]}}
    runs = [
        trace(scene_of([{**beam, **more}], [target]), rays_per_batch=4096)
        for more in ({}, {"divergence_deg": 0})
    ]
    assert runs[0].digest == runs[1].digest
    specs = [run.compiled.tables.spec for run in runs]
    assert specs[0] == specs[1]
    assert specs[0].sources[0].option == ""
    wide = compiled(scene_of([{**beam, "divergence_deg": 1.0}], [target])).tables.spec
    assert wide.sources[0].option == "diverging"


@pytest.mark.parametrize("value", [-1.0, 90.0, math.nan])
def test_a_divergence_that_is_none_is_refused(value):
    with pytest.raises(pz.SceneError, match="divergence_deg"):
        pz.CollimatedDisk(
            name="s", flux=1, position=(0, 0, 0), axis="+z", radius=1, divergence_deg=value
        )


@pytest.mark.parametrize("value", [0.0, -1.0, 180.1])
def test_a_cone_that_is_none_is_refused(value):
    with pytest.raises(pz.SceneError, match="half_angle_deg"):
        pz.ConePoint(name="s", flux=1, position=(0, 0, 0), axis="+z", half_angle_deg=value)
