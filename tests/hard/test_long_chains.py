"""Thousands of bounces through the functions of the trace: invariants hold, nothing leaks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.engine import PLAN, open_device, trace

from hostcode.probe import NO_FACE, follow_rays
from photizon_cl.elements import BaffledTube, Biconvex, Cpc, Disk, PlanoConvex, Sphere
from photizon_cl.frames import frame
from photizon_cl.scene import Scene
from photizon_cl.sources import IsotropicPoint
from photizon_cl.stability.families_mixed import room
from photizon_cl.stability.measure import compile_elements
from photizon_cl.surfaces import Fresnel, Lambertian, Mirror

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hostcode.probe import Followed
    from photizon_cl.elements import Element
    from photizon_cl.surfaces import Surface

U = 2.0**-53
TILT = (33.3, -71.7)
SILVER, WHITE = Mirror(1.0), Lambertian(1.0)
PLACES = [((0.0, 0.0, 0.0), (0.0, 0.0)), ((0.3, -0.2, 0.1), TILT)]


def follow(
    elements: Sequence[Element], starts: Any, along: Any, steps: int, **how: Any
) -> Followed:
    compiled = compile_elements(elements)
    rays = np.hstack([np.subtract(starts, compiled.shift), along])
    found = follow_rays(open_device(), compiled.tables, rays, steps, **how)
    return replace(found, point=found.point + np.array(compiled.shift))


def unit(v: Any) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def local(element: Element, found: Followed) -> tuple[np.ndarray, np.ndarray]:
    """Return points and directions in an element's frame."""
    rows = np.array(element.frame).T
    missed = ~np.isfinite(found.distance)[..., None]
    points = np.where(missed, 0.0, found.point)
    along = np.where(missed, 0.0, found.direction)
    return (points - np.array(element.position)) @ rows, along @ rows


def off_unit(found: Followed) -> float:
    return float(np.nanmax(np.abs((found.direction**2).sum(axis=-1) - 1.0)))


@pytest.mark.parametrize("start", [0.1, 0.9, 0.999999])
def test_chords_of_a_sphere_keep_their_length(start: float) -> None:
    """Whispering gallery included: 5000 chords of one length, in one plane."""
    ball = Sphere(name="ball", position=(0.3, -0.2, 0.1), axis="+z", radius=0.7, surface=SILVER)
    origin = np.add(ball.position, (start * 0.7, 0.0, 0.0))
    along = unit(np.array([[0.0, 0.6, 0.8], [0.1, 0.9, -0.3], [0.0, 1.0, 0.0]]))
    found = follow([ball], np.tile(origin, (3, 1)), along, 5000)
    chords = found.distance[:, 1:]
    # the sine of the angle to the wall is kept to a few roundings a bounce
    relative = np.abs(chords / chords[:, :1] - 1.0).max(axis=1)
    grazing = chords[:, 0] / 1.4
    assert (relative * grazing < 4 * U * 5000).all()
    assert off_unit(found) < 8 * U
    centred = found.point - np.array(ball.position)
    assert np.abs(np.linalg.norm(centred, axis=-1) - 0.7).max() < 8 * U
    turn = np.cross(centred[:, 0], found.direction[:, 0])
    later = np.cross(centred[:, -1], found.direction[:, -1])
    assert np.abs(turn - later).max() < 4 * U * 5000


def test_a_box_of_mirrors_keeps_the_size_of_each_component() -> None:
    walls = room((-0.3, -0.5, -0.7), (0.4, 0.6, 0.9), surface=SILVER)
    along = unit(np.random.default_rng(1).normal(size=(20, 3)))
    found = follow(walls, np.zeros((20, 3)), along, 5000)
    assert (found.left >= 0).all()
    assert np.abs(np.abs(found.direction) - np.abs(along)[:, None, :]).max() < 4 * U
    assert off_unit(found) < 8 * U


@pytest.mark.parametrize(("at", "tilt"), PLACES)
def test_a_light_pipe_keeps_the_size_of_each_component(at: Any, tilt: Any) -> None:
    pipe = BaffledTube(
        name="pipe",
        position=at,
        axis="+z",
        tilt_deg=tilt,
        half_width=0.05,
        length=400.0,
        surface=SILVER,
    )
    rows = np.array(pipe.frame)
    r = np.random.default_rng(2)
    aside = unit(r.normal(size=(20, 2)))
    along = unit(np.hstack([aside, np.full((20, 1), 0.1)])) @ rows
    starts = np.array(at) + np.array([0.01, 0.02, 0.0]) @ rows
    found = follow([pipe], np.tile(starts, (20, 1)), along, 4000)
    inside = found.left >= 0
    assert inside[:, 3000].all()  # thousands of bounces
    _, d = local(pipe, found)
    start = along @ rows.T
    drift = np.abs(np.abs(d) - np.abs(start)[:, None, :])[inside]
    assert drift.max() < 1e-13
    assert off_unit(found) < 8 * U


def skew(p: np.ndarray, d: np.ndarray) -> np.ndarray:
    return p[..., 0] * d[..., 1] - p[..., 1] * d[..., 0]


@pytest.mark.parametrize(("at", "tilt"), PLACES)
@pytest.mark.parametrize("angle", [0.1, 20.0, 75.0])
def test_a_cpc_keeps_the_skew_invariant(at: Any, tilt: Any, angle: float) -> None:
    """h = x·dy − y·dx about the axis, ray by ray, to 1e-13 of the radius."""
    cpc = Cpc(
        name="cpc",
        position=at,
        axis="+z",
        tilt_deg=tilt,
        exit_radius=0.7,
        acceptance_deg=angle,
        surface=SILVER,
    )
    rows = np.array(cpc.frame)
    r = np.random.default_rng(3)
    n, wide = 300, cpc.entrance_radius
    phi, radius = 2 * math.pi * r.random(n), wide * np.sqrt(r.random(n))
    starts = np.stack([radius * np.cos(phi), radius * np.sin(phi), np.full(n, cpc.length)], axis=1)
    lean = np.radians(1.2 * angle) * r.random(n)
    psi = 2 * math.pi * r.random(n)
    along = np.stack(
        [np.sin(lean) * np.cos(psi), np.sin(lean) * np.sin(psi), -np.cos(lean)], axis=1
    )
    found = follow([cpc], starts @ rows + at, unit(along @ rows), 60)
    p, d = local(cpc, found)
    drift = np.abs(skew(p, d) - skew(starts, along)[:, None])
    hit = np.isfinite(found.distance)
    assert hit.sum() > 100
    assert np.nanmax(np.where(hit, drift, 0.0)) < 1e-13 * wide
    assert off_unit(found) < 8 * U
    assert np.isfinite(found.distance[:, :1]).any()
    assert (~(found.left[:, -1] >= 0)).all()  # every ray has left it, by one end or the other


def test_a_cpc_closed_at_both_ends_keeps_its_rays() -> None:
    """Thousands of bounces in a CPC with mirrors on both apertures: no ray is lost."""
    cpc = Cpc(
        name="cpc",
        position=(0.0, 0.0, 0.0),
        axis="+z",
        exit_radius=0.7,
        acceptance_deg=40.0,
        surface=SILVER,
    )
    ends = [
        Disk(name=name, position=(0.0, 0.0, z), axis="+z", radius=radius, surface=SILVER)
        for name, z, radius in (("exit", 0.0, 0.7), ("lid", cpc.length, cpc.entrance_radius))
    ]
    r = np.random.default_rng(4)
    along = unit(r.normal(size=(30, 3)))
    starts = np.tile([0.1, 0.2, 0.5], (30, 1))
    found = follow([cpc, *ends], starts, along, 3000)
    assert (found.left >= 0).all()
    drift = np.abs(skew(found.point, found.direction) - skew(starts, along)[:, None])
    assert drift.max() < 1e-13 * cpc.entrance_radius * 20  # 3000 bounces
    # at its rims, from inside: on the rim, and beside it by roundings
    phi = 2 * math.pi * r.random(2000)
    beside = 1 + r.choice([0.0, U, -U, 1e-15, -1e-15], 2000)
    lid = r.random(2000) < 0.5
    k = np.where(lid, cpc.entrance_radius, 0.7) * beside
    rims = np.stack([k * np.cos(phi), k * np.sin(phi), np.where(lid, cpc.length, 0.0)], axis=1)
    starts = np.array([0.1, 0.2, 0.5]) + 0.3 * r.random((2000, 3))
    found = follow([cpc, *ends], starts, unit(rims - starts), 30)
    assert (found.left >= 0).all()


LENSES: list[dict[str, Any]] = [
    {"front_radius": 1.5, "back_radius": 2.5},
    {"front_radius": 1.0, "back_radius": 1e6},
    {"front_radius": 40.0, "back_radius": 30.0},
]


@pytest.mark.parametrize(("at", "tilt"), PLACES)
def test_lenses_keep_the_skew_invariant(at: Any, tilt: Any) -> None:
    """n·h is kept from before the lens to behind it, ray by ray; so the étendue is."""
    glass = Fresnel(index=1.7)
    lenses: list[Element] = [
        Biconvex(
            name="lens",
            position=at,
            axis="+z",
            tilt_deg=tilt,
            aperture_radius=1.0,
            surface=glass,
            **shape,
        )
        for shape in LENSES
    ]
    lenses.append(
        PlanoConvex(
            name="lens",
            position=at,
            axis="+z",
            tilt_deg=tilt,
            surface=glass,
            aperture_radius=1.0,
            curvature_radius=1.5,
        )
    )
    r = np.random.default_rng(5)
    for lens in lenses:
        rows = np.array(lens.frame)
        ends = np.stack([*(0.6 * r.uniform(-1, 1, (2, 300))), np.zeros(300)], axis=1)
        starts = np.stack([*r.uniform(-1, 1, (2, 300)), np.full(300, 3.0)], axis=1)
        along = unit(ends - starts)
        found = follow([lens], starts @ rows + at, along @ rows, 2)
        p, d = local(lens, found)
        before = skew(starts, along)
        through = (found.left[:, 1] >= 0) & (found.weight[:, 1] > 0)
        assert through.sum() > 200
        for step, index in ((0, 1.7), (1, None)):
            now = skew(p[:, step], d[:, step])
            if index is None:  # behind it, or totally reflected inside
                index = np.where(found.left[:, 1] & 2, 1.0, 1.7)
            assert np.abs(now * index - before)[through].max() < 1e-13
        assert off_unit(found) < 8 * U


def closed() -> dict[str, tuple[list[Element], tuple[float, float, float]]]:
    """Closed bodies, with a point inside each."""
    where: dict[str, Any] = {"name": "body", "position": (0.3, -0.2, 0.1), "axis": "+z"}
    tilted: dict[str, Any] = {**where, "tilt_deg": TILT}
    middle = np.add(where["position"], np.array([0.1, 0.1, 0.02]) @ np.array(frame("+z", TILT)))
    inside = tuple(middle.tolist())
    bodies: dict[str, tuple[list[Element], tuple[float, float, float]]] = {}
    for name, surface in (("mirrors", SILVER), ("matt", WHITE)):
        bodies |= {
            f"room of {name}": (
                list(room((0.1, 0.1, 0.1), (0.4, 0.5, 0.7), surface=surface)),
                (0.2, 0.3, 0.4),
            ),
            f"tilted room of {name}": (
                list(room((0.0, 0.0, 0.0), (0.3, 1.1, 0.7), (33.3, 0.0), surface)),
                tuple((np.array([0.1, 0.3, 0.4]) @ np.array(frame("+z", (33.3, 0.0)))).tolist()),
            ),
            f"sphere, {name}": ([Sphere(**where, radius=0.7, surface=surface)], (0.3, -0.1, 0.2)),
            f"biconvex, {name}": (
                [
                    Biconvex(
                        **tilted,
                        aperture_radius=1.0,
                        front_radius=1.5,
                        back_radius=1e6,
                        surface=surface,
                    )
                ],
                inside,
            ),
            f"plano-convex, {name}": (
                [PlanoConvex(**tilted, aperture_radius=1.0, curvature_radius=1.5, surface=surface)],
                inside,
            ),
        }
    return bodies


def leak(name: str, interactions: int) -> None:
    elements, inside = closed()[name]
    source = IsotropicPoint(name="lamp", flux=1.0, position=inside)
    scene = Scene(name="leak", source=(source,), element=tuple(elements))
    cap = 2000
    rays = 500 if interactions <= 10**7 else 65536
    done = 0
    seed = 1
    while done < interactions:
        found = trace(scene, rays_per_batch=rays, generation_cap=cap, seed=seed, plan=PLAN)
        done += found.interactions
        seed += 1
        assert found.escaped == 0
        assert found.interactions == rays * cap


@pytest.mark.parametrize("name", list(closed()))
def test_nothing_leaks_out_of_closed_bodies(name: str) -> None:
    """10^7 interactions over the ten bodies, none escapes; 10^9 with ``-m slow``."""
    leak(name, 10**6)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(closed()))
def test_nothing_leaks_in_a_thousand_million_interactions(name: str) -> None:
    leak(name, 10**8)


ROOMS = [
    ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
    ((0.1, 0.1, 0.1), (0.4, 0.5, 0.7)),
    ((10.0, 20.0, 30.0), (10.3, 20.4, 31.0)),
    ((1e6, 2e6, -1e6), (1e6 + 0.7, 2e6 + 1.3, -1e6 + 0.2)),
]


def at_edges(low: Any, high: Any, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts inside a box and ends on its edges (0.6) and in its corners."""
    r = np.random.default_rng(seed)
    low, high = np.array(low), np.array(high)
    ends = low + (high - low) * r.integers(0, 2, (n, 3))
    edge, along = r.random(n) < 0.6, r.integers(0, 3, n)
    anywhere = low + (high - low) * r.random((n, 3))
    ends[edge, along[edge]] = anywhere[edge, along[edge]]
    share = np.where(r.random(n) < 0.4, 1e-6, r.random(n))  # some start beside another edge
    start = low + (high - low) * r.uniform(0.1, 0.9, (n, 3))
    other = ends[r.permutation(n)]
    return other + share[:, None] * (start - other), ends


@pytest.mark.parametrize("surface", [SILVER, WHITE], ids=["mirrors", "matt"])
@pytest.mark.parametrize(
    "tilt", [(0.0, 0.0), (33.3, 0.0), (0.0, -71.7), (1e-8, 0.0), (89.999999, 0.0)]
)
def test_rays_at_edges_and_corners_stay_inside(tilt: Any, surface: Surface) -> None:
    """Aimed at every edge and corner, then 30 bounces: no ray gets out."""
    rows = np.array(frame("+z", tilt))
    for low, high in ROOMS:
        starts, ends = at_edges(low, high, 3000, 6)
        apart = np.linalg.norm(ends - starts, axis=1) > 1e-3
        starts, ends = starts[apart] @ rows, ends[apart] @ rows
        found = follow(room(low, high, tilt, surface), starts, unit(ends - starts), 30)
        assert (found.left != NO_FACE).all()
        assert not np.isnan(found.point).any()


@pytest.mark.parametrize("surface", [SILVER, WHITE], ids=["mirrors", "matt"])
def test_rays_at_the_junction_of_walls_on_a_larger_floor_stay_inside(surface: Surface) -> None:
    """The walls end on a floor that goes on beyond them."""
    for tilt in ((0.0, 0.0), (33.3, 0.0)):
        rows = np.array(frame("+z", tilt))
        for low, high in ROOMS[:3]:
            walls: list[Any] = list(room(low, high, tilt, surface))
            walls[4] = replace(walls[4], half_width=3.0, half_height=3.0)
            r = np.random.default_rng(7)
            size = np.subtract(high, low)
            starts = low + size * r.uniform(0.1, 0.9, (3000, 3))
            ends = low + size * r.uniform(0.1, 0.9, (3000, 3)) * [1, 1, 0]
            across = r.integers(0, 2, 3000)
            k = np.arange(3000)
            ends[k, across] = np.where(
                r.random(3000) < 0.5, np.array(low)[across], np.array(high)[across]
            )
            found = follow(walls, starts @ rows, unit((ends - starts) @ rows), 30)
            assert (found.left != NO_FACE).all()


def test_rays_at_the_rims_of_lenses_stay_inside() -> None:
    r = np.random.default_rng(8)
    phi = 2 * math.pi * r.random(3000)
    beside = 1 + r.choice([0.0, U, -U, 1e-15, -1e-15, 1e-12, -1e-12], 3000)
    rim = np.stack([beside * np.cos(phi), beside * np.sin(phi), np.zeros(3000)], axis=1)
    for at, tilt in PLACES:
        for shape in LENSES:
            lens = Biconvex(
                name="lens",
                position=at,
                axis="+z",
                tilt_deg=tilt,
                surface=SILVER,
                aperture_radius=1.0,
                **shape,
            )
            rows = np.array(lens.frame)
            start = np.stack([*(0.3 * r.uniform(-1, 1, (2, 3000))), np.zeros(3000)], axis=1)
            found = follow([lens], start @ rows + at, unit((rim - start) @ rows), 30)
            assert (found.left != NO_FACE).all()


def test_rays_at_the_joints_of_baffles_stay_in_their_chamber() -> None:
    """A tube whose baffles have no hole: what starts between two of them stays there."""
    tube = BaffledTube(
        name="tube",
        position=(0.3, -0.2, 0.1),
        axis="+z",
        half_width=0.7,
        length=3.0,
        baffles=3,
        clear_half_width=0.0,
        surface=SILVER,
    )
    low, high = (-0.7, -0.7, 0.75), (0.7, 0.7, 1.5)
    for tilt in ((0.0, 0.0), TILT):
        rows = np.array(replace(tube, tilt_deg=tilt).frame)
        starts, ends = at_edges(low, high, 3000, 9)
        apart = np.linalg.norm(ends - starts, axis=1) > 1e-3
        starts, ends = starts[apart] @ rows, ends[apart] @ rows
        found = follow(
            [replace(tube, tilt_deg=tilt)], starts + tube.position, unit(ends - starts), 30
        )
        assert (found.left != NO_FACE).all()
        heights = (found.point - tube.position) @ rows[2]
        assert heights.min() > 0.75 - 1e-14
        assert heights.max() < 1.5 + 1e-14
