"""Rays at the edges and corners of touching and crossing walls: none gets through, by count."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from oracles import gates
from oracles.chambers import KINDS, walls
from oracles.corners import (
    U,
    across,
    box,
    follow,
    from_inside,
    leaks,
    named,
    polyhedron,
    prism,
    rays_at_edges,
)
from oracles.engine import PLAN, open_device, trace_compiled, with_tree
from oracles.pairs import alternately

from hostcode.run.probe import LEFT_PLUS, element_of, follow_rays, probe_faces
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame
from photizon_cl.scene.model import Scene
from photizon_cl.scene.sources.collimated_disk import CollimatedDisk
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.families_mixed import room
from photizon_cl.stability.measure import compile_elements

SILVER, WHITE = Mirror(1.0), Lambertian(1.0)
BOTH = {"mirrors": SILVER, "matt": WHITE}
TILTS = [(0.0, 0.0), (33.3, 0.0), (0.0, -71.7), (1e-8, 0.0), (89.999999, 0.0)]
PLACES = [(1.0, 0.0), (1e-6, 0.0), (1e6, 1.3), (1e-6, 37.0), (1.0, 1e3)]
"""Size of a room, and its distance from the origin in that size."""
RAYS = 1000


@pytest.mark.parametrize(("kind", "surface"), alternately(KINDS, BOTH, every=2))
def test_no_ray_gets_through_where_walls_meet(kind: str, surface: Any) -> None:
    r = np.random.default_rng([11, KINDS.index(kind)])
    for (scale, away), tilt in zip(PLACES, TILTS, strict=True):
        at = away * scale * np.array([0.6, -0.7, 0.4])
        low, high = at - scale * r.uniform(0.2, 1, 3), at + scale * r.uniform(0.2, 1, 3)
        chamber = walls(kind, low, high, tilt, surface, r)
        starts, along = rays_at_edges(r, chamber, RAYS)
        assert leaks(chamber, starts, along) == (0, 0, 0), (scale, away, tilt)


@pytest.mark.parametrize(("sides", "surface"), alternately([4, 7], BOTH))
def test_no_ray_gets_out_of_a_polyhedron_of_crossing_plates(sides: int, surface: Any) -> None:
    """Plates at all angles, each going on far beyond the edges."""
    r = np.random.default_rng([12, sides])
    for scale, away in PLACES:
        at = away * scale * np.array([0.6, -0.7, 0.4])
        chamber = polyhedron(r, sides, scale, at, surface)
        starts, along = rays_at_edges(r, chamber, 2 * RAYS)
        assert leaks(chamber, starts, along) == (0, 0, 0), (scale, away)


@pytest.mark.parametrize(("degrees", "surface"), alternately([60.0, 10.0, 1.0, 1e-2, 1e-6], BOTH))
def test_no_ray_gets_out_of_a_sharp_wedge(degrees: float, surface: Any) -> None:
    """Of walls that end on each other at an angle, and at what it leaves of half a turn."""
    for number, (scale, away) in enumerate(PLACES):
        r = np.random.default_rng([16, number])
        chamber = prism(r, degrees, scale, away * scale * r.uniform(-1, 1, 3), surface)
        starts, along = from_inside(chamber, *rays_at_edges(r, chamber, 2 * RAYS))
        assert leaks(chamber, starts, along) == (0, 0, 0), (scale, away)


@pytest.mark.parametrize("degrees", [10.0, 1e-2])
def test_a_wedge_leaks_where_its_edges_do_not_know_their_angle(
    degrees: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The test above can fail."""
    monkeypatch.setattr(
        "photizon_cl.compile.draft.edge_factors", lambda near: np.ones((len(near.elements), 4))
    )
    lost = 0
    for number, (scale, away) in enumerate(PLACES * 4):
        r = np.random.default_rng([16, number])
        chamber = prism(r, degrees, scale, away * scale * r.uniform(-1, 1, 3), SILVER)
        starts, along = from_inside(chamber, *rays_at_edges(r, chamber, 2 * RAYS))
        lost += leaks(chamber, starts, along)[0]
    assert lost > 0


CUTS = {
    "level": ((0.0, 0.0), 0.0), "tilted": ((21.0, -34.0), 0.9),
    "at the top": ((21.0, -34.0), 0.999999),
}  # fmt: skip
"""Tilt of a plate in a ball and its height over the centre in radii."""


@pytest.mark.parametrize(
    ("shape", "cut", "surface"),
    [
        pytest.param(
            shape,
            cut,
            surface,
            id=f"{shape}-{cut}-{name}",
            marks=pytest.mark.slow if (n + k + m) % 2 else (),
        )
        for n, shape in enumerate(("disk to the wall", "plate through the wall"))
        for k, cut in enumerate(CUTS)
        for m, (name, surface) in enumerate(BOTH.items())
    ],
)
def test_no_ray_gets_past_a_plate_in_a_ball(shape: str, cut: str, surface: Any) -> None:
    """Aimed at the circle where plate and ball meet: it stays on its side of both."""
    tilt, height = CUTS[cut]
    r = np.random.default_rng(13)
    w = np.array(frame("+z", tilt))
    for scale, away in PLACES[:4]:
        at = away * scale * np.array([0.6, -0.7, 0.4])
        middle = at + height * scale * w[2]
        rim = math.sqrt(1.0 - height * height) * scale
        where: dict[str, Any] = {"axis": "+z", "surface": surface, "name": "plate"}
        where |= {"position": tuple(middle.tolist()), "tilt_deg": tilt}
        plate = (
            Disk(**where, radius=rim)
            if shape == "disk to the wall"
            else Rectangle(**where, half_width=1.5 * scale, half_height=1.5 * scale)
        )
        place = tuple(at.tolist())
        ball = Sphere(name="ball", position=place, axis="+z", radius=scale, surface=surface)
        phi = 2 * math.pi * r.random((2, RAYS))
        on = middle + rim * (np.cos(phi)[..., None] * w[0] + np.sin(phi)[..., None] * w[1])
        ends = on[0] + r.integers(-8, 9, (RAYS, 3)) * np.spacing(np.abs(on[0]))
        below = at - scale * w[2] * r.uniform(0.1, 0.9, (RAYS, 1))
        share = r.choice([1.0, 1e-3, 1e-6, 1e-9], (RAYS, 1))
        starts = on[1] + share * (below - on[1])
        apart = np.linalg.norm(ends - starts, axis=1)[:, None]
        keep = apart[:, 0] > 1e-3 * scale
        points, escaped, _ = follow(
            [ball, plate], starts[keep], ((ends - starts) / apart)[keep], 30
        )
        heights = (points - middle) @ w[2]
        far = float(np.abs(at).max() + scale)
        assert (int(escaped.sum()), int((heights > 512 * U * far).sum())) == (0, 0), (scale, away)


@pytest.mark.parametrize(
    "surface",
    [pytest.param(SILVER, id="mirrors"), pytest.param(WHITE, id="matt", marks=pytest.mark.slow)],
)
def test_rays_from_a_face_along_its_edges_stay_inside(surface: Any) -> None:
    """Started on a face, 0 to 1e-6 from its edges: along the edge, in the face, and diagonally."""
    r = np.random.default_rng(14)
    for tilt in TILTS:
        rows = np.array(frame("+z", tilt))
        low, high = np.array([0.1, 0.2, -0.3]), np.array([0.9, 0.7, 0.4])
        elements = list(room(low.tolist(), high.tolist(), tilt, surface))
        elements += [across(low - 1, high + 1, 0, 0.5, tilt, surface)]  # and one that crosses
        chamber = box(named(elements), low, [0.5, *high[1:]], tilt)
        n = 600
        # what counts as on two tilted faces is told by rounding which side of them it is on
        beside = r.choice([1e-12, 1e-9, 1e-6, *([] if any(tilt) else [0.0, 1e-16])], (n, 2))
        starts = np.column_stack([low[0] + beside[:, 0], low[1] + beside[:, 1], np.full(n, low[2])])
        starts[::2, 0] = r.uniform(0.15, 0.45, n // 2)  # beside an edge; else in the corner
        along = r.normal(size=(n, 3)) * r.choice([0.0, 1e-17, 1.0], (n, 3))
        along[np.abs(along).max(axis=1) < 0.1] = [1.0, 0.0, 0.0]
        along = np.abs(along) * [1.0, 1.0, 0.0] + np.abs(along) * [0.0, 0.0, 1.0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        compiled = compile_elements(chamber.elements)
        # what a ray has that was reflected by the floor
        down = np.array([[*(np.array([0.3, 0.4, 0.0]) @ rows), *-rows[2]]])
        _, state = probe_faces(open_device(), compiled.tables, down, 1)
        assert element_of(state)[0] == 4
        assert state[0] & LEFT_PLUS
        rays = np.hstack([starts @ rows, along @ rows])
        found = follow_rays(open_device(), compiled.tables, rays, 30, np.full(n, state[0]))
        assert np.isfinite(found.distance).all()
        heights = found.point @ chamber.normals.T.astype(float) - chamber.offsets.astype(float)
        assert (heights > -128 * U).all()


PLANS = (
    PLAN,
    replace(PLAN, max_bounces=1),
    replace(PLAN, lanes=1),
    replace(PLAN, composition="classical"),
)


@pytest.mark.slow  # six programs
def test_what_a_corner_does_to_a_ray_depends_on_no_schedule() -> None:
    """Scan and tree, one lane and many, waves and stages give the same bits, into the corners."""
    r = np.random.default_rng(15)
    low, high = np.array([-1.0, -0.75, -0.5]), np.array([0.5, 0.75, 1.0])
    chamber = walls("plates that cross", low, high, (0.0, 0.0), WHITE, r)
    cuts = [e.position for e in chamber.elements[6:9]]
    cut = [cuts[a][a] for a in range(3)]
    lamps = tuple(
        CollimatedDisk(
            name=f"lamp {n}",
            flux=1.0,
            position=tuple(cut[k] if k in aims else float(low[k]) + 0.1 for k in range(3)),
            axis="+" + "xyz"[axis],
            radius=1e-17,
        )
        for n, (axis, aims) in enumerate(
            [(2, (0,)), (0, (1,)), (1, (2,)), (2, (0, 1)), (1, (0, 2))]
        )
    )
    scene = Scene(name="corners", source=lamps, element=chamber.elements)
    run = replace(scene.run, rays_per_batch=2000, generation_cap=40)
    digests = set()
    for accelerate in (False, True):
        made = compile_scene(scene, run, **with_tree(accelerate))
        for plan in PLANS[:1] if accelerate else PLANS:  # through a tree rays go one by one
            found = trace_compiled(made, plan=plan)
            assert found.escaped == 0
            assert found.absorbed(chamber.elements[-1].name) == 0
            digests.add(found.digest)
    assert len(digests) == 1


def test_the_gate_of_the_mutants_holds() -> None:
    gates.corners_hold()


def test_walls_that_stand_far_apart_in_the_file() -> None:
    """What a ray remembers of a face has 15 bits: walls of one corner must not share them."""
    r = np.random.default_rng(5)
    low, high = np.array([-1.0, -0.8, -0.9]), np.array([0.7, 1.1, 0.6])
    chamber = walls("plates that cross", low, high, (33.3, 0.0), SILVER, r)
    size = float(np.linalg.norm(high - low))
    # apart from each other, too: what lies at one place are neighbours by the million
    between = (
        Rectangle(
            name=f"away {y} {z}", axis="+x", half_width=0.001 * size, half_height=0.001 * size,
            position=(1.7 * size, 0.003 * size * y, 0.003 * size * z), surface=SILVER,
        )
        for y in range(-100, 100) for z in range(-100, 100)
    )  # fmt: skip
    apart = [e for wall in chamber.elements for e in (wall, *islice(between, 2047))]
    assert next(between, None) is not None  # there were enough
    starts, along = rays_at_edges(r, chamber, RAYS)
    assert leaks(replace(chamber, elements=tuple(apart)), starts, along) == (0, 0, 0)
