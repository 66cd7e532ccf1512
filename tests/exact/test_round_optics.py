"""Optics of conics and walls of revolution whose outcome is known to the last ray."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracles import tracer
from oracles.engine import probe, scene_of, trace
from oracles.scenes import AXES, BLACK, beam, glass, mirror

import photizon_cl as pz
from photizon_cl.errors import SceneError
from photizon_cl.scene.elements.conic import equator

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

RAYS = 4096
SCALES = (1e-9, 1.0, 1e9)
ORIGIN = [0.0, 0.0, 0.0]


def along(axis: str, h: float) -> tuple[float, float, float]:
    """Return the point at a height over the origin along a signed axis."""
    x, y, z = tracer.axis_vector(axis)
    return (h * x, h * y, h * z)


def turned(axis: str) -> str:
    """Return the opposite axis."""
    return axis.translate(str.maketrans("+-", "-+"))


def conic(radius: float, k: float, rim: float, **more: Any) -> dict[str, Any]:
    """Return a conic with its vertex at the origin."""
    sizes = {"curvature_radius": radius, "conic_constant": k, "aperture_radius": rim}
    return {"kind": "conic", "position": ORIGIN, "axis": "+z", **sizes, **more}


def counter(position: Any, axis: str, radius: float) -> dict[str, Any]:
    """Return a black disk that counts what arrives against its normal."""
    where = {"kind": "disk", "position": position, "axis": axis, "radius": radius}
    return {**where, **BLACK, "detector": {}}


# along z in all others below
@pytest.mark.parametrize(
    "axis", [pytest.param(a, marks=pytest.mark.slow if a[1] == "z" else ()) for a in AXES]
)
@pytest.mark.parametrize("scale", SCALES)
def test_a_paraboloid_collects_a_beam_in_its_focus(scale: float, axis: str) -> None:
    """Every ray, in a disk of 10^-14 of the radius of curvature."""
    dish = {**conic(scale, -1.0, 0.9 * scale, **mirror()), "axis": axis}
    lamp = beam(along(axis, 2.0 * scale), turned(axis), 0.9 * scale)
    focus = counter(along(axis, 0.5 * scale), turned(axis), 1e-14 * scale)
    found = trace(scene_of([lamp], [dish, focus]), rays_per_batch=RAYS)
    assert found.detector("element 1").count == RAYS
    assert found.interactions == 2 * RAYS


@pytest.mark.parametrize("k", [-0.25, -0.6, -0.9])
@pytest.mark.parametrize("scale", SCALES)
def test_an_ellipsoid_images_one_focus_on_the_other(scale: float, k: float) -> None:
    """All of 4π through two halves that share their rim, into a ball of 10^-13 of its size."""
    e = math.sqrt(-k)
    rim = equator(scale, k)
    half = conic(scale, k, rim, **mirror())
    top = {**half, "axis": "-z", "position": [0.0, 0.0, 2.0 * scale / (1.0 + k)]}
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, scale / (1.0 + e)]}
    image = {"kind": "sphere", "axis": "+z", "position": [0.0, 0.0, scale / (1.0 - e)], **BLACK}
    image |= {"radius": 1e-13 * scale / (1.0 + k), "detector": {"side": "outside"}}
    found = trace(scene_of([lamp], [half, top, image]), rays_per_batch=RAYS)
    assert found.detector("element 2").count == RAYS
    assert found.interactions == 2 * RAYS
    assert found.escaped == 0


@pytest.mark.parametrize("scale", SCALES)
def test_a_cassegrain_has_its_focus_where_the_formula_says(scale: float) -> None:
    """Of a hyperboloid of eccentricity e at d, f1 − d in front of the primary's focus.

    Its magnification is m = (e + 1)/(e − 1) and the image stands m (f1 − d) behind it (D. J.
    Schroeder, Astronomical Optics, ch. 2). What the secondary's black cap does not stop arrives,
    through the hole in the primary.
    """
    f1, d, e = 1.0, 0.75, 1.7
    image = d - (f1 - d) * (e + 1.0) / (e - 1.0)
    primary = conic(2.0 * f1 * scale, -1.0, 0.4 * scale, inner_radius=0.06 * scale, **mirror())
    secondary = conic((f1 - d) * (1.0 + e) * scale, -e * e, 0.12 * scale, **mirror())
    secondary["position"] = [0.0, 0.0, d * scale]
    cap = counter([0.0, 0.0, 0.8 * scale], "+z", 0.13 * scale)
    sensor = counter([0.0, 0.0, image * scale], "+z", 1e-13 * scale)
    lamp = beam((0.0, 0.0, 2.0 * scale), "-z", 0.4 * scale)
    found = trace(scene_of([lamp], [primary, secondary, cap, sensor]), rays_per_batch=RAYS)
    stopped, arrived = (found.detector(f"element {n}").count for n in (2, 3))
    assert stopped + arrived == RAYS
    assert stopped == pytest.approx(RAYS * (0.13 / 0.4) ** 2, abs=5.0 * math.sqrt(RAYS * 0.1))
    assert found.escaped == 0


@pytest.mark.parametrize("n", [1.5, 2.4])
@pytest.mark.parametrize("scale", SCALES)
def test_an_ellipsoid_of_glass_focuses_a_beam(scale: float, n: float) -> None:
    """The convex side in air, k = −1/n²: the focus is n R/(n − 1) behind the vertex (Descartes).

    `index` is on the convex side, `index_outside` on the concave one.
    """
    face = conic(scale, -1.0 / n**2, 0.5 * scale, **glass(1.0, n))
    lamp = beam((0.0, 0.0, -scale), "+z", 0.5 * scale)
    focus = counter([0.0, 0.0, n / (n - 1.0) * scale], "-z", 1e-14 * scale)
    found = trace(scene_of([lamp], [face, focus]), rays_per_batch=RAYS)
    assert found.detector("element 1").count == RAYS
    most = 4.0 * n / (n + 1.0) ** 2  # what passes at normal incidence
    assert 0.8 * most < float(found.absorbed("element 1") / found.emitted) < most


def test_a_ray_may_stay_in_a_round_light_pipe_for_good() -> None:
    """A mirror keeps |d_z| and the distance of the chord from the axis."""
    pipe = {"kind": "cylinder", "position": ORIGIN, "axis": "+z", "radius": 0.3, "length": 1e4}
    lid = {"kind": "disk", "axis": "+z", "radius": 0.3, **BLACK, "detector": {}}
    start, end = ({**lid, "position": [0.0, 0.0, z]} for z in (0.0, 1e4))
    lamp = beam((0.1, 0.05, 1.0), "+z", 1e-3, tilt_deg=[30.0, 0.0])
    scene = scene_of([lamp], [{**pipe, **mirror()}, start, {**end, "axis": "-z"}])
    found = trace(scene, rays_per_batch=16, generation_cap=20000)
    assert found.detector("element 2").count == 16
    assert found.interactions > 16 * 9000


@pytest.mark.parametrize("tilt", [[0.0, 0.0], [33.0, -12.0]])
def test_a_map_on_a_cylinder_adds_up_to_its_power(tilt: list[float]) -> None:
    pipe = {"kind": "cylinder", "position": [0.3, 0.1, -0.2], "axis": "+y", "tilt_deg": tilt}
    pipe |= {"radius": 0.3, "length": 1.1, **BLACK, "detector": {"map": [7, 5]}}
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.3, 0.2, -0.2]}
    found = trace(scene_of([lamp], [pipe]), rays_per_batch=RAYS)
    counted = found.detector("element 0")
    assert counted.map_total == found.absorbed("element 0")
    assert counted.map_total + found.escaped == found.emitted
    assert counted.map_counts.sum() == found.interactions


def test_bins_of_a_cylinder_run_along_phi_and_from_the_entrance() -> None:
    """A pencil from the axis lights the very bin that its direction says."""
    n, m = 8, 4
    for i in range(n):
        for j in range(m):
            pipe = {"kind": "cylinder", "position": [1.0, 2.0, 3.0], "axis": "-x", "radius": 0.5}
            pipe |= {"length": 2.0, **BLACK, "detector": {"map": [n, m]}}
            u, v, w = (np.array(tracer.axis_vector(a)) for a in (*tracer.FRAMES["-x"], "-x"))
            phi, height = 2.0 * math.pi * (i + 0.5) / n, 2.0 * (j + 0.5) / m
            start = np.array([1.0, 2.0, 3.0]) + height * w
            d = math.cos(phi) * u + math.sin(phi) * v
            tilt = [math.degrees(math.asin(-d[1])), math.degrees(math.atan2(d[0], d[2]))]
            lamp = beam(tuple(start.tolist()), "+z", 1e-140, tilt_deg=tilt)
            found = trace(scene_of([lamp], [pipe]), rays_per_batch=4)
            assert found.detector("element 0").map_counts[j, i] == 4


WALLS = {
    "cylinder": {"radius": 0.5, "length": 1.0},
    "cone": {"entrance_radius": 0.5, "exit_radius": 0.2, "length": 1.0},
    "conic": {"curvature_radius": 0.5, "conic_constant": -1.0, "aperture_radius": 0.7},
}
PIPE, FUNNEL, SHEET = ({"kind": kind, **sizes} for kind, sizes in WALLS.items())
COUNTED = {**BLACK, "detector": {"map": [2, 2]}}


@pytest.mark.parametrize("kind", WALLS)
@pytest.mark.parametrize("side", [None, "inside", "outside"])
def test_detectors_count_the_side_that_they_name(kind: str, side: str | None) -> None:
    """By default the inside, which of a conic is the concave side."""
    wall = {"kind": kind, "position": ORIGIN, "axis": "+z", **WALLS[kind], **BLACK}
    wall["detector"] = {} if side is None else {"side": side}
    for place, sees in (([0.0, 0.0, 0.3], "inside"), ([-2.0, 0.0, 0.2], "outside")):
        axis = "-x" if sees == "inside" else "+x"
        found = trace(scene_of([beam(tuple(place), axis, 0.01)], [wall]), rays_per_batch=64)
        assert float(found.absorbed("element 0")) == 64.0
        assert found.detector("element 0").count == (64 if sees == (side or "inside") else 0)


def test_normals_point_away_from_the_axis_and_into_a_sheet() -> None:
    for kind, sizes in WALLS.items():
        scene = scene_of(
            [beam((0.0, 0.0, 9.0), "+z")],
            [{"kind": kind, "position": ORIGIN, "axis": "+z", **sizes, **BLACK}],
        )
        both = probe(
            scene, [[0.0, 0.0, 0.3], [-2.0, 0.0, 0.3]], [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
        )
        assert both.normal[0] == pytest.approx(both.normal[1], abs=1e-15)
        assert (both.normal[0, 0] < 0.0) == (kind != "conic")
        assert pz.probe(scene, [[0, 0, 0.3]], [[-1, 0, 0]]).face[0] == (
            "sheet" if kind == "conic" else "wall"
        )
    vertex = probe(scene, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], [[0, 0, -1.0], [0, 0, 1.0]])
    assert (vertex.normal == [[0.0, 0.0, 1.0]] * 2).all()
    assert (vertex.point == 0.0).all()


def test_a_ray_along_a_straight_line_of_a_wall_does_not_hit_it() -> None:
    pipe = {"kind": "cylinder", "position": ORIGIN, "axis": "+z", "radius": 0.5, "length": 1.0}
    cone = {"kind": "cone", "position": ORIGIN, "axis": "+z", "length": 1.0, **BLACK}
    cone |= {"entrance_radius": 1.0, "exit_radius": 0.0}
    lamp = [beam((0.0, 0.0, 9.0), "+z")]
    for wall, d in (({**pipe, **BLACK}, [0.0, 0.0, 1.0]), (cone, [-1.0, 0.0, 1.0])):
        start = [0.5, 0.0, -1.0] if d[0] == 0.0 else [2.0, 0.0, -1.0]
        assert probe(scene_of(lamp, [wall]), [start], [d / np.linalg.norm(d)]).element[0] == -1


@pytest.mark.parametrize(
    ("row", "path", "hint"),
    [
        ({**PIPE, **glass(1.5)}, "surface.kind", "wall"),
        ({**FUNNEL, **glass(1.5)}, "surface.kind", "wall"),
        ({**FUNNEL, **COUNTED}, "detector.map", ""),
        ({**SHEET, **COUNTED}, "detector.map", ""),
        ({**FUNNEL, "entrance_radius": 0, "exit_radius": 0, **BLACK}, "exit_radius", "nothing is"),
        ({**SHEET, "conic_constant": 0, **BLACK}, "aperture_radius", "equator"),
        ({"kind": "conic", "curvature_radius": 1, "aperture_radius": 2, **BLACK},
         "aperture_radius", "equator"),
        ({**SHEET, "inner_radius": 0.7, **BLACK}, "inner_radius", "hole"),
        ({"kind": "disk", "radius": 1, "inner_radius": 1, **BLACK}, "inner_radius", "hole"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(row: dict[str, Any], path: str, hint: str) -> None:
    lamp = beam((0.0, 0.0, 9.0), "+z")
    with pytest.raises(SceneError) as refused:
        scene_of([lamp], [{"position": ORIGIN, "axis": "+z", **row}])
    assert [p.path for p in refused.value.problems] == [f"element[0].{path}"]
    assert hint in refused.value.problems[0].hint


@pytest.mark.parametrize("k", [0.0, 1.0, 3.7, -0.3])
def test_a_conic_may_end_at_its_equator(k: float) -> None:
    made = pz.Conic(
        name="half", position=(0, 0, 0), axis="+z", surface=pz.Mirror(1.0), curvature_radius=0.7,
        conic_constant=k, aperture_radius=equator(0.7, k),
    )  # fmt: skip
    assert made.heights[1] == pytest.approx(0.7 / (1.0 + k), rel=1e-7)


def test_areas_of_walls() -> None:
    """Against closed forms of the cap, the paraboloid and the half of an ellipsoid."""
    one = pz.Conic(
        name="one", position=(0, 0, 0), axis="+z", surface=pz.Mirror(1.0), curvature_radius=2.0,
        aperture_radius=1.5,
    )  # fmt: skip
    assert one.area == pytest.approx(4.0 * math.pi * (2.0 - math.sqrt(1.75)), rel=1e-14)
    for a in (1e-6, 1.0, 1e4):
        dish = replace(one, conic_constant=-1.0, aperture_radius=a)
        want = 8.0 * math.pi / 3.0 * math.expm1(1.5 * math.log1p(a * a / 4.0))
        assert dish.area == pytest.approx(want, rel=1e-13)
    k = -0.64  # semi-axes R/(1 + k) along and R/sqrt(1 + k) across, eccentricity 0.8
    half = replace(one, conic_constant=k, aperture_radius=equator(2.0, k))
    across, tall = equator(2.0, k), 2.0 / (1.0 + k)
    want = math.pi * across**2 * (1.0 + tall / (across * 0.8) * math.asin(0.8))
    assert half.area == pytest.approx(want, rel=1e-10)
    parts = [replace(one, aperture_radius=1.5, inner_radius=r).area for r in (0.0, 1.0)]
    assert parts[0] - parts[1] == pytest.approx(replace(one, aperture_radius=1.0).area, rel=1e-13)
