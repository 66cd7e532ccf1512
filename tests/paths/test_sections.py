"""Sections lie on the elements and in the plane; what is open stays open."""

from __future__ import annotations

import math

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.registry import ELEMENTS

BLACK = pz.Absorber()
TILTS = [(0.0, 0.0), (25.0, -40.0), (90.0, 0.0)]


def elements(tilt=(0.0, 0.0), axis="+z"):
    common = {"position": (0.3, -0.2, 0.1), "axis": axis, "tilt_deg": tilt, "surface": BLACK}
    return [
        pz.Rectangle(name="rectangle", half_width=0.5, half_height=0.2, **common),
        pz.Disk(name="disk", radius=0.4, **common),
        pz.Sphere(name="sphere", radius=0.5, **common),
        pz.Sphere(name="ported", radius=0.5, port_fraction=0.2, **common),
        pz.Cpc(name="cpc", exit_radius=0.1, acceptance_deg=25.0, **common),
        pz.BaffledTube(
            name="tube", half_width=0.2, length=1.0, baffles=2, clear_half_width=0.1, **common
        ),
        pz.PlanoConvex(name="plano", curvature_radius=0.5, aperture_radius=0.3, **common),
        pz.PlanoConvex(name="half", curvature_radius=0.5, aperture_radius=0.5, **common),
        pz.Biconvex(
            name="biconvex", front_radius=0.5, back_radius=0.8, aperture_radius=0.3, **common
        ),
        pz.Cylinder(name="cylinder", radius=0.3, length=0.6, **common),
        pz.Cone(name="cone", entrance_radius=0.4, exit_radius=0.1, length=0.6, **common),
        pz.Cone(name="full cone", entrance_radius=0.0, exit_radius=0.3, length=0.6, **common),
        pz.Conic(
            name="paraboloid",
            curvature_radius=0.2,
            conic_constant=-1.0,
            aperture_radius=0.4,
            **common,
        ),
        pz.Conic(
            name="ellipsoid",
            curvature_radius=0.2,
            conic_constant=-0.5,
            aperture_radius=0.28,
            inner_radius=0.1,
            **common,
        ),
        pz.Conic(
            name="hyperboloid",
            curvature_radius=0.3,
            conic_constant=-3.0,
            aperture_radius=0.5,
            **common,
        ),
        pz.Disk(name="annulus", radius=0.4, inner_radius=0.2, **common),
        pz.Lens(
            name="meniscus",
            front_radius=-0.6,
            back_radius=0.5,
            back_conic=-1.5,
            thickness=0.3,
            aperture_radius=0.4,
            **common,
        ),
    ]


NAMES = [element.name for element in elements()]


@pytest.mark.parametrize("tilt", TILTS, ids=str)
@pytest.mark.parametrize("number", range(len(NAMES)), ids=NAMES)
def test_curves_lie_on_the_element_and_in_the_plane(number, tilt):
    element = elements(tilt, "-y")[number]
    found = 0
    for axis in range(3):
        for at in element.position[axis] + np.linspace(-0.9, 0.9, 13):
            for line in cut(element, axis, float(at)):
                found += 1
                assert len(line) >= 2
                assert np.abs(line[:, axis] - at).max() < 1e-12
                for point in line[:: max(len(line) // 20, 1)]:
                    assert element.touches(element.local(tuple(point)), 1e-9)
    assert found > 3


@pytest.mark.parametrize("number", range(len(NAMES)), ids=NAMES)
def test_edges_and_facets_lie_on_the_element(number):
    element = elements((25.0, -40.0))[number]
    for line in (*edges(element), *facets(element)[::7]):
        for point in line:
            assert element.touches(element.local(tuple(point)), 1e-9)


def by_name(name):
    return elements()[NAMES.index(name)]


def test_a_whole_sphere_gives_closed_circles():
    sphere = by_name("sphere")
    (line,) = cut(sphere, 0, 0.6)
    radius = math.sqrt(0.25 - 0.09)
    assert np.linalg.norm(line - [0.6, -0.2, 0.1], axis=1) == pytest.approx(radius, rel=1e-9)
    assert line[0] == pytest.approx(line[-1])
    assert len(cut(sphere, 0, 0.81)) == 0
    (level,) = cut(sphere, 2, 0.1)
    assert np.linalg.norm(level - sphere.position, axis=1) == pytest.approx(0.5)


def test_the_port_is_open():
    (line,) = cut(by_name("ported"), 0, 0.3)
    top = 0.1 + 0.5 * 0.6
    assert line[:, 2].max() == pytest.approx(top)
    assert line[[0, -1], 2] == pytest.approx(top)  # both ends on the rim, and nothing between
    assert np.linalg.norm(line[0] - line[-1]) == pytest.approx(2 * 0.5 * 0.8)


def test_the_holes_are_open():
    lines = cut(by_name("tube"), 0, 0.3)
    walls = [line for line in lines if np.ptp(line[:, 2]) > 0.5]
    plates = [line for line in lines if np.ptp(line[:, 2]) < 1e-12]
    assert (len(walls), len(plates)) == (2, 4)
    for line in plates:
        assert sorted(np.abs(line[:, 1] + 0.2)) == pytest.approx([0.1, 0.2])
    # beside the hole a plate is whole
    beside = cut(by_name("tube"), 0, 0.45)
    assert len([line for line in beside if np.ptp(line[:, 2]) < 1e-12]) == 2


def test_a_cpc_is_two_curves_and_open_at_its_ends():
    cpc = by_name("cpc")
    lines = cut(cpc, 1, -0.2)
    assert len(lines) == 2
    for line in lines:
        r = np.abs(line[:, 0] - 0.3)
        assert r.min() == pytest.approx(cpc.exit_radius)
        assert r.max() == pytest.approx(cpc.entrance_radius)


def test_a_flat_face_in_the_plane_gives_its_rim():
    (line,) = cut(by_name("rectangle"), 2, 0.1)
    assert len(line) == 5
    assert len(cut(by_name("tube"), 2, 0.1 + 1.0 / 3.0)) >= 2


AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
FLAT = {
    "disk": lambda **at: pz.Disk(name="d", surface=pz.Absorber(), radius=0.7, **at),
    "annulus": lambda **at: pz.Disk(
        name="d", surface=pz.Absorber(), radius=0.7, inner_radius=0.3, **at
    ),
    "rectangle": lambda **at: pz.Rectangle(
        name="d", surface=pz.Absorber(), half_width=0.7, half_height=0.4, **at
    ),
}


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.25])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (90.0, 0.0), (0.0, 30.0)])
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("kind", FLAT)
def test_a_flat_face_crosses_every_section_that_cuts_it(kind, axis, tilt, offset):
    """Through its middle and beside it, along its axes and across them."""
    element = FLAT[kind](position=(0.5, -0.25, 1.0), axis=axis, tilt_deg=tilt)
    for across in range(3):
        # how far the face reaches along the section's normal
        reach = 0.4 * math.hypot(*(element.frame[row][across] for row in (0, 1)))
        if reach <= abs(offset):
            continue
        lines = cut(element, across, element.position[across] + offset)
        assert lines, f"no line in the section across {'xyz'[across]}"
        length = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)
        assert length > 0.3


# -- every face, in any pose ---------------------------------------------------------------------


def test_every_kind_of_element_is_drawn_here():
    assert {element.kind for element in elements()} == set(ELEMENTS)


def samples(face):
    """Return rings of points on a face, shape (rings, k, 3), in local coordinates.

    Neighbours along a ring are joined by the face itself: of a plane face its rim and smaller ones,
    of a surface of revolution its circles.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    if isinstance(face, Plane):
        if face.empty:
            return np.empty((0, 2, 3))
        inner = 0.0 if face.hole is None else face.hole.reach / face.outline.reach
        parts = np.linspace(max(0.05, inner), 1.0, 12)
        rims = face.outline.towards(turn)
        return np.array([face.points(part * rims) for part in parts])
    r, w = face.profile(np.linspace(0.0, 1.0, 40))
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.array(
        [np.column_stack([a * ring, np.full(len(turn), b)]) for a, b in zip(r, w, strict=True)]
    )


def crossings(rings, heights):
    """Return points of rings between whose neighbours a height changes its sign."""
    found = []
    for ring, height in zip(rings, heights, strict=True):
        at = np.flatnonzero((height[:-1] < 0.0) != (height[1:] < 0.0))
        part = (height[at] / (height[at] - height[at + 1]))[:, np.newaxis]
        found.append(ring[at] + part * (ring[at + 1] - ring[at]))
    return np.vstack(found) if found else np.empty((0, 3))


def distance(points, line):
    """Return how far each point is from a polyline."""
    a, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum((along * along).sum(axis=1), 1e-300)
    part = np.clip(((points[:, np.newaxis] - a) * along).sum(axis=2) / length, 0.0, 1.0)
    gap = points[:, np.newaxis] - a - part[..., np.newaxis] * along
    return np.sqrt((gap**2).sum(axis=2)).min(axis=1)


POSES = [("+z", (0.0, 0.0), 0.0), ("-x", (0.0, 0.0), 0.0), ("+y", (90.0, 0.0), 0.0)]
_RANDOM = np.random.default_rng(5)
POSES += [
    (AXES[_RANDOM.integers(6)], tuple(_RANDOM.uniform(-90.0, 90.0, 2)), _RANDOM.uniform(-0.8, 0.8))
    for _ in range(5)
]


@pytest.mark.parametrize("number", range(len(NAMES)), ids=NAMES)
def test_every_face_crosses_every_section_that_cuts_it(number):
    """Wherever a plane cuts a face there is a line, through its middle and beside it."""
    met = set()
    for axis, tilt, beside in POSES:
        element = elements(tilt, axis)[number]
        for n, face in enumerate(element.faces):
            rings = samples(face)
            if not rings.size:
                continue
            world = rings @ np.array(element.frame) + np.array(element.position)
            size = np.ptp(world.reshape(-1, 3), axis=0).max()
            for across in range(3):
                low, high = world[..., across].min(), world[..., across].max()
                if high - low < 1e-9 * size:
                    continue  # the plane of the section and that of the face are one
                at = 0.5 * (low + high) + 0.5 * beside * (high - low)
                if beside == 0.0:
                    at = element.position[across] if low < element.position[across] < high else at
                heights = world[..., across] - at
                along = crossings(world, heights)
                points = np.vstack([along, crossings(world.swapaxes(0, 1), heights.T)])
                assert len(points)
                points = points[:: max(len(points) // 25, 1)]
                lines = cut(element, across, float(at))
                assert lines, (face.name, axis, tilt, "xyz"[across])
                gap = np.min([distance(points, line) for line in lines if len(line) > 1], axis=0)
                assert gap.max() < 0.01 * size, (face.name, axis, tilt, "xyz"[across])
                met.add(n)
    assert met == {n for n, face in enumerate(elements()[number].faces) if samples(face).size}
