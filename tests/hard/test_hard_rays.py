"""Hard rays through the production intersection, against 60 digits.

Errors are counted against what a backward-stable solution may have: the origin's and the
direction's own rounding (one unit roundoff of their sizes each), carried through the condition of
the root. `BOUND` is the number of such units allowed.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest
from oracles import numbers, tracer
from oracles.engine import probe, scene_of
from oracles.scenes import BLACK, beam

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

U = 2.0**-53
BOUND = 8.0


def scene(*elements: dict[str, Any]) -> Scene:
    """Return a black scene of some elements near the origin of its first."""
    centre = elements[0]["position"]
    return scene_of([beam(tuple(centre), "+z")], [{**e, **BLACK} for e in elements])


def sphere(centre: Any, radius: float, **more: Any) -> dict[str, Any]:
    """Return a sphere without a surface."""
    where = {"position": [float(x) for x in centre], "axis": "+z"}
    return {"kind": "sphere", **where, "radius": radius, **more}


def unit(v: np.ndarray) -> np.ndarray:
    """Return rows of unit length."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def check_sphere(
    centre: np.ndarray, radius: float, origins: np.ndarray, directions: np.ndarray
) -> tuple[int, int]:
    """Compare rays with the truth; return how many hit and how many missed for certain."""
    found = probe(scene(sphere(centre, radius)), origins, directions)
    hits = misses = 0
    with mpmath.workdps(60):
        c = numbers.mp_vector(centre)
        for k in range(len(origins)):
            f = [a - b for a, b in zip(numbers.mp_vector(origins[k]), c, strict=True)]
            d = numbers.mp_vector(directions[k])
            length = mpmath.sqrt(numbers.mp_dot(d, d))
            d = [x / length for x in d]
            b = -numbers.mp_dot(f, d)
            ff = numbers.mp_dot(f, f)
            square = b * b - ff + mpmath.mpf(radius) ** 2
            far = float(mpmath.sqrt(ff)) + radius
            # |l| moves by u·far: the half chord by l/s times that, the distance by u·far besides
            slack = BOUND * U * far
            if abs(square) <= 4 * radius * slack:
                assert not np.isnan(found.point[k]).any() or found.element[k] < 0
                continue  # tangent within rounding: either answer is right
            roots = [b - mpmath.sqrt(square), b + mpmath.sqrt(square)] if square > 0 else []
            if any(abs(t) < slack for t in roots):
                continue  # starts on the surface within rounding: tested elsewhere
            ahead = [t for t in roots if t > 0]
            if not ahead:
                assert found.element[k] == -1
                assert math.isinf(found.distance[k])
                misses += 1
                continue
            hits += 1
            t = min(ahead)
            assert found.element[k] == 0
            steep = 1.0 + radius / float(mpmath.sqrt(square))
            assert abs(found.distance[k] - t) <= slack * steep
            place = [a + t * x for a, x in zip(numbers.mp_vector(origins[k]), d, strict=True)]
            off = max(abs(a - p) for a, p in zip(found.point[k], place, strict=True))
            assert off <= slack * steep
            size = radius + float(np.abs(centre).max())
            on = [a - p for a, p in zip(numbers.mp_vector(found.point[k]), c, strict=True)]
            assert abs(mpmath.sqrt(numbers.mp_dot(on, on)) - radius) <= 8 * U * size
            normal = numbers.mp_vector(found.normal[k])
            assert abs(numbers.mp_dot(normal, normal) - 1) < 16 * U
            aim = max(abs(a * radius - b) for a, b in zip(normal, on, strict=True))
            assert aim <= 4 * U * size
    return hits, misses


SCALES = [1e-9, 1e-3, 1.0, 1e6, 1e9]


@pytest.mark.parametrize("scale", SCALES)
def test_spheres_from_near_far_and_inside(scale: float) -> None:
    r = np.random.default_rng(1)
    centre = scale * np.array([0.3, -0.2, 0.1])
    radius = 0.7 * scale
    for distance in (0.1, 0.9, 1.1, 10.0, 1e4):
        origins = centre + distance * radius * unit(r.normal(size=(120, 3)))
        aims = centre + 1.2 * radius * unit(r.normal(size=(120, 3))) * r.random((120, 1))
        hits, _ = check_sphere(centre, radius, origins, unit(aims - origins))
        assert hits > 50


@pytest.mark.parametrize("miss", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_tangent_rays(side: float, miss: float) -> None:
    """Rays whose closest approach is R(1 ± miss), from several distances."""
    r = np.random.default_rng(2)
    for distance in (1.0, 30.0):
        along, across = unit(r.normal(size=(200, 3))), r.normal(size=(200, 3))
        across = unit(across - (across * along).sum(axis=1, keepdims=True) * along)
        origins = (1.0 + side * miss) * across - distance * along
        hits, misses = check_sphere(np.zeros(3), 1.0, origins, along)
        if miss >= 1e-9:
            assert (hits, misses) == ((0, 200) if side > 0 else (200, 0))


@pytest.mark.parametrize("radius", [1e-9, 1e-6, 1e6, 1e12])
def test_tiny_and_huge_spheres_in_a_scene_of_metres(radius: float) -> None:
    """The origin a metre off the surface of a huge sphere, or a metre away from a tiny one."""
    r = np.random.default_rng(3)
    centre = np.array([0.0, 0.0, -radius if radius > 1 else 0.0])
    start = np.array([0.1, 0.2, 1.0])
    if radius > 1:
        directions = unit(r.normal(size=(300, 3)) - [0, 0, 2])
        directions[:, 2] = -np.abs(directions[:, 2])
    else:
        aims = centre + 0.9 * radius * unit(r.normal(size=(300, 3)))
        directions = unit(aims - start)
    check_sphere(centre, radius, np.tile(start, (300, 1)), directions)


def test_distance_to_a_huge_sphere_keeps_its_digits() -> None:
    """A mirror of 10^8 m radius, a metre away, met head on: no digit of the metre is lost."""
    radius = 1e8
    found = probe(
        scene(sphere((0.0, 0.0, -radius), radius)),
        [[0.0, 0.0, 1.0], [0.5, 0.25, 1.0]],
        [[0.0, 0.0, -1.0], [0.0, 0.0, -1.0]],
    )
    with mpmath.workdps(60):
        sag = radius - mpmath.sqrt(mpmath.mpf(radius) ** 2 - mpmath.mpf(0.3125))
        assert found.distance[0] == 1.0
        # c by compensated products: far better than u·R
        assert abs(found.distance[1] - (1 + sag)) < 4e-16


def flat(kind: str, centre: Any, axis: str, tilt: tuple[float, float]) -> dict[str, Any]:
    """Return a flat element of size 1."""
    shape = {"half_width": 1.0, "half_height": 1.0} if kind == "rectangle" else {"radius": 1.0}
    return {"kind": kind, "position": list(centre), "axis": axis, "tilt_deg": list(tilt), **shape}


def mp_frame(tilt: tuple[float, float]) -> list[list[mpmath.mpf]]:
    """Return u, v, w of +z with a tilt, in many digits: rows of R_v(b)·R_u(a)."""
    a, b = (mpmath.radians(mpmath.mpf(x)) for x in tilt)
    sa, ca, sb, cb = mpmath.sin(a), mpmath.cos(a), mpmath.sin(b), mpmath.cos(b)
    zero = mpmath.mpf(0)
    return [[cb, zero, -sb], [sa * sb, ca, sa * cb], [ca * sb, -sa, ca * cb]]


TILTS = [(0.0, 0.0), (1e-8, 0.0), (0.0, 1e-8), (89.999999, 0.0), (0.0, -89.999999), (30.0, 60.0)]


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("kind", ["rectangle", "disk"])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_tilted_flats(kind: str, tilt: tuple[float, float], scale: float) -> None:
    """Distance, point and hit or miss, grazing rays included."""
    r = random.Random(4)
    centre = [0.3 * scale, -0.2 * scale, 0.1 * scale]
    row = flat(kind, centre, "+z", tilt)
    row.update({key: scale for key in ("radius", "half_width", "half_height") if key in row})
    axes = np.array(tracer.frame(row))
    origins, directions = [], []
    for _ in range(150):
        x, y, h = r.uniform(-1.3, 1.3), r.uniform(-1.3, 1.3), r.choice([1.0, 1e-3, 1e-9, 30.0])
        aim = np.array(centre) + scale * (x * axes[0] + y * axes[1])
        start = np.array([r.uniform(-2, 2), r.uniform(-2, 2), r.choice([-h, h])]) @ axes
        origins.append(np.array(centre) + scale * start)
        directions.append(aim - origins[-1])
    origins, directions = np.array(origins), unit(np.array(directions))
    found = probe(scene(row), origins, directions)
    with mpmath.workdps(60):
        u, v, w = mp_frame(tilt)
        for k in range(len(origins)):
            start = numbers.mp_vector(origins[k])
            d = numbers.mp_vector(directions[k])
            offset = [a - mpmath.mpf(c) for a, c in zip(start, centre, strict=True)]
            dh = numbers.mp_dot(d, w)
            t = -numbers.mp_dot(offset, w) / dh
            place = [a + t * b for a, b in zip(offset, d, strict=True)]
            x, y = numbers.mp_dot(place, u) / scale, numbers.mp_dot(place, v) / scale
            size = max(abs(x), abs(y)) if kind == "rectangle" else mpmath.hypot(x, y)
            far = float(np.abs(offset).max() + np.abs(origins[k]).max()) + float(abs(t))
            # the frame's entries and the direction are rounded: u·far across the plane
            slack = BOUND * U * (far + scale) * (1.0 + 1.0 / float(abs(dh)))
            if t < 0 or abs(size - 1) * scale < slack:
                continue
            assert found.element[k] == (0 if size < 1 else -1)
            if size < 1:
                assert abs(found.distance[k] - t) < slack
                off = [
                    a - b - mpmath.mpf(c)
                    for a, b, c in zip(found.point[k], place, centre, strict=True)
                ]
                assert max(map(abs, off)) < slack
                # on the plane much better than that
                assert abs(numbers.mp_dot(off, w)) < 4 * U * scale


def test_planes_at_small_angles_are_told_apart() -> None:
    """Two disks that cross at 1e-9°: the nearer is hit on either side of their line."""
    low, high = flat("disk", (0, 0, 0), "+z", (0, 0)), flat("disk", (0, 0, 0), "+z", (0, 1e-9))
    starts = [(x, 0.1, 1.0) for x in (-0.9, -0.5, -1e-3, 1e-3, 0.5, 0.9)]
    found = probe(scene(low, high), starts, np.tile([0.0, 0.0, -1.0], (6, 1)))
    # w = (sin b, 0, cos b): the plane x sin b + z cos b = 0 is higher where x < 0
    assert found.element.tolist() == [1, 1, 1, 0, 0, 0]


@pytest.mark.parametrize("radius", [1e-6, 0.7, 1e6])
@pytest.mark.parametrize("grazing", [1.0, 1e-3, 1e-7, 1e-12])
def test_rays_launched_on_a_sphere_leave_it(radius: float, grazing: float) -> None:
    """From a point on the surface: outwards nothing is hit, inwards the other end of the chord."""
    r = np.random.default_rng(6)
    normal, across = unit(r.normal(size=(100, 3))), r.normal(size=(100, 3))
    across = unit(across - (across * normal).sum(axis=1, keepdims=True) * normal)
    centre = np.array([0.1, 0.2, -0.3]) * radius
    origins = centre + radius * normal
    for sign in (1.0, -1.0):
        directions = unit(math.sqrt(1.0 - grazing**2) * across + sign * grazing * normal)
        found = probe(scene(sphere(centre, radius)), origins, directions)
        if sign > 0:
            assert (found.element == -1).all()
        elif grazing > 1e-10:
            chord = -2.0 * radius * (directions * normal).sum(axis=1)
            assert (found.element == 0).all()
            assert np.abs(found.distance - chord).max() < 16 * U * radius
        assert not np.isnan(found.distance).any()


@pytest.mark.parametrize(
    "lanes", [1, 8, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 4, 16))]
)
def test_no_nan_and_the_same_bits_at_every_width(lanes: int) -> None:
    """Everything at once: axis rays, zero components, far and near origins, tangents, edges."""
    elements = [
        sphere((0.0, 0.0, 0.0), 1.0, port_fraction=0.2),
        sphere((3.0, 0.0, 0.0), 1e-3),
        flat("rectangle", (0.0, 0.0, 2.0), "-z", (0, 0)),
        flat("disk", (0.0, 2.0, 0.0), "+y", (10, 1e-8)),
    ]
    r = np.random.default_rng(7)
    origins = np.concatenate([
        r.normal(size=(200, 3)),
        1e9 * r.normal(size=(50, 3)),
        np.array([[x, y, z] for x in (0, 1, -1) for y in (0, 1, 2) for z in (0.0, 1.0, 2.0)]),
        np.zeros((23, 3)),
    ])  # fmt: skip
    directions = unit(r.normal(size=(300, 3)))
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    directions[::3] = axes[np.arange(100) % 6]
    directions[200:250] = unit(-origins[200:250])
    found = probe(scene(*elements), origins, directions, lanes=lanes)
    want = probe(scene(*elements), origins, directions, lanes=1)
    for name in ("distance", "element", "point", "normal"):
        hit = found.element >= 0
        a, b = getattr(found, name), getattr(want, name)
        assert a[hit].tobytes() == b[hit].tobytes()
        assert not np.isnan(a[hit]).any()
    assert found.element.tobytes() == want.element.tobytes()
    assert np.isinf(found.distance[found.element < 0]).all()
    assert (found.element >= 0).sum() > 100
