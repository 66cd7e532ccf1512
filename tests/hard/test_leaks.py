"""Closed bodies and rays at their edges over many bounces: nothing leaks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.engine import PLAN, trace
from oracles.walks import LENSES, PLACES, SILVER, TILT, WHITE, U, follow, unit

from benchmarks.leaks import LENSES as SHAPES
from benchmarks.leaks import closed_bodies
from hostcode.run.probe import NO_FACE
from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.frames import frame
from photizon_cl.stability.families_mixed import room

if TYPE_CHECKING:
    from photizon_cl.scene.surfaces import Surface


CAP = 2000
LIKE_OTHERS = (
    "cylinder,", "frustum", "paraboloid", "plano-convex", "thin meniscus", "cemented", "hyperboloid"
)  # fmt: skip


def bodies() -> list[Any]:
    """Return every body's name with mirrors or matt walls in turn; the others are slow tests.

    So are bodies whose joints are in test_curved_corners.py as well, or in another of these.
    """
    names = list(closed_bodies())
    half = len(names) // 2  # the same bodies follow with the other walls
    slow = [
        (n % half + n // half) % 2 or name.startswith(LIKE_OTHERS) for n, name in enumerate(names)
    ]
    return [
        pytest.param(name, marks=pytest.mark.slow if is_slow else ())
        for name, is_slow in zip(names, slow, strict=True)
    ]


@pytest.mark.parametrize("name", bodies())
def test_nothing_leaks_out_of_closed_bodies(name: str) -> None:
    """10^6 interactions in each body; ``python -m benchmarks.leaks`` makes 10^9 in each."""
    found = trace(
        closed_bodies()[name], rays_per_batch=500, generation_cap=CAP, seed=1, plan=PLAN,
        splitting=False, roulette_floor=0.0,
    )  # fmt: skip
    assert found.interactions == 500 * CAP
    assert found.escaped == 0


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


@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.1)], ids=["origin", "aside"])
def test_rays_at_both_rims_of_lenses_with_edges_stay_inside(at: Any) -> None:
    """From the glass to a rim, or to what an edge like a knife leaves of two, then 30 bounces."""
    r = np.random.default_rng(9)
    for n, shape in enumerate(SHAPES.values()):
        for surface in (SILVER, WHITE):
            lens = Lens(
                name="lens", position=at, axis="+z", tilt_deg=TILT if n % 2 else (0.0, 0.0),
                aperture_radius=1.0, **shape, surface=surface, edge=WHITE,
            )  # fmt: skip
            phi = 2 * math.pi * r.random(2000)
            beside = 1 + r.choice([0.0, U, -U, 1e-15, -1e-15, 1e-12, -1e-12], 2000)
            z = 0.5 * lens.edge_thickness * r.choice([1.0, -1.0], 2000)
            rim = np.stack([beside * np.cos(phi), beside * np.sin(phi), z], axis=1)
            rows = np.array(lens.frame)
            low, high = lens.vertices[1], lens.vertices[0]
            middle = low + (high - low) * r.uniform(0.3, 0.7, 2000)
            start = np.stack([*(0.02 * r.uniform(-1, 1, (2, 2000))), middle], axis=1)
            found = follow([lens], start @ rows + at, unit((rim - start) @ rows), 30)
            assert (found.left != NO_FACE).all()
            assert not np.isnan(found.point).any()
            away = np.linalg.norm(found.point - np.array(at), axis=-1)
            assert away.max() <= lens.reach * (1.0 + 1e-12)


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
