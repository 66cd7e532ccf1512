"""Closed chambers of touching and crossing walls, and rays at their edges and corners."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.run.probe import follow_rays
from oracles.engine import open_device
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.frames import AXES, frame
from photizon_cl.stability.families_mixed import room
from photizon_cl.stability.measure import compile_elements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.surfaces import Surface

U = 2.0**-53
ROUNDING = 128.0
"""How far beyond a wall a point counts as beyond it, in roundings of the largest coordinate."""
Exact = np.longdouble


@dataclass(frozen=True, eq=False)
class Chamber:
    """A convex chamber among elements: the planes around it, normals inwards, and its corners.

    An edge joins each pair of corners in `edges`.
    """

    elements: tuple[Element, ...]
    normals: np.ndarray
    offsets: np.ndarray
    corners: np.ndarray
    edges: tuple[tuple[int, int], ...]

    @property
    def far(self) -> float:
        """Largest coordinate of a corner or of an element's position."""
        places = [e.position for e in self.elements]
        return float(max(np.abs(self.corners).max(), np.abs(places).max()))

    @property
    def size(self) -> float:
        """Least distance between two corners."""
        return float(min(np.linalg.norm(a - b) for a, b in combinations(self.corners, 2)))


def box(
    elements: Sequence[Element], low: Any, high: Any, tilt: tuple[float, float] = (0.0, 0.0)
) -> Chamber:
    """Return the box between two corners in a tilted frame as a chamber of some elements."""
    rows = np.array(frame("+z", tilt), Exact)
    ends = np.array([low, high], Exact)
    bits = [[k >> a & 1 for a in range(3)] for k in range(8)]
    corners = np.array([[ends[b[a], a] for a in range(3)] for b in bits]) @ rows
    edges = tuple((i, j) for i, j in combinations(range(8), 2) if (i ^ j).bit_count() == 1)
    normals = np.concatenate((rows, -rows))
    return Chamber(tuple(elements), normals, np.concatenate((ends[0], -ends[1])), corners, edges)


def across(
    low: Any, high: Any, axis: int, at: float, tilt: tuple[float, float], surface: Surface
) -> Rectangle:
    """Return the rectangle across an axis of the tilted frame, from low to high in the others."""
    ends = np.array([low, high], float)
    ends[:, axis] = at, at + float(ends[1, 0] - ends[0, 0])
    wall = room(ends[0].tolist(), ends[1].tolist(), tilt, surface)[2 * axis]
    assert isinstance(wall, Rectangle)
    return wall


def named(elements: Sequence[Element]) -> tuple[Element, ...]:
    """Return elements with names of their own."""
    return tuple(replace(e, name=f"wall {n}") for n, e in enumerate(elements))


def polyhedron(r: np.random.Generator, sides: int, scale: float, at: Any, surface: Any) -> Chamber:
    """Return a chamber that large tilted plates cut out: each crosses all its neighbours."""
    while True:
        frames = [
            (str(r.choice(AXES)), tuple(r.uniform(-90, 90, 2).tolist())) for _ in range(sides)
        ]
        rows = np.array([frame(*f) for f in frames])
        depth = r.uniform(0.3, 1.0, sides)
        aside = r.uniform(-0.5, 0.5, (sides, 2))
        feet = aside[:, :1] * rows[:, 0] + aside[:, 1:] * rows[:, 1] - depth[:, None] * rows[:, 2]
        plates = [
            Rectangle(
                name=f"plate {n}",
                position=tuple((scale * feet[n] + at).tolist()),
                axis=axis,
                tilt_deg=tilt,
                half_width=12.0 * scale,
                half_height=12.0 * scale,
                surface=surface,
            )
            for n, (axis, tilt) in enumerate(frames)
        ]
        normals = np.array([p.frame[2] for p in plates], Exact)
        places = np.array([p.position for p in plates], Exact) - at
        offsets = (normals * places).sum(axis=1)
        corners, planes = _corners(normals, offsets, 1e-9 * scale)
        open_sides = (_directions(r) @ rows[:, 2].T).min(axis=1) > -0.05
        if len(corners) < 4 or np.abs(corners).max() > 4.0 * scale or open_sides.any():
            continue
        edges = [
            c for c in combinations(range(len(planes)), 2) if len(planes[c[0]] & planes[c[1]]) == 2
        ]
        if len(corners) - len(edges) + len(set().union(*planes)) != 2:
            continue  # open to a side that no direction above happened to show
        return Chamber(tuple(plates), normals, offsets + normals @ at, corners + at, tuple(edges))


def _directions(r: np.random.Generator) -> np.ndarray:
    d = r.normal(size=(2000, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def _corners(n: np.ndarray, b: np.ndarray, slack: float) -> tuple[np.ndarray, list[set[int]]]:
    found, planes = [], []
    for i, j, k in combinations(range(len(n)), 3):
        normal = np.cross(n[j], n[k])
        volume = n[i] @ normal
        if abs(volume) < 1e-6:
            continue
        x = b[i] * normal + b[j] * np.cross(n[k], n[i]) + b[k] * np.cross(n[i], n[j])
        x = x / volume
        if (n @ x - b >= -slack).all():
            found.append(x)
            planes.append({i, j, k})
    return np.array(found, Exact).reshape(-1, 3), planes


def on_edges(r: np.random.Generator, chamber: Chamber, n: int) -> np.ndarray:
    """Return points in corners (0.4), on edges, and on edges a little way from a corner."""
    i, j = np.array(chamber.edges)[r.integers(0, len(chamber.edges), n)].T
    share = np.where(r.random(n) < 0.7, r.random(n), 10.0 ** -r.uniform(6, 17, n))
    share = np.where(r.random(n) < 0.4, 0.0, share)
    corners = chamber.corners
    return corners[i] + share[:, None].astype(Exact) * (corners[j] - corners[i])


def rays_at_edges(r: np.random.Generator, chamber: Chamber, n: int) -> tuple[Any, Any]:
    """Return rays from inside at edges and corners and up to 8 units in the last place beside them.

    They start anywhere, and beside other edges and corners by 1e-1 to 1e-12 of the chamber's size,
    so that many run along an edge, in a face or from corner to corner.
    """
    ends = on_edges(r, chamber, n)
    ends = (ends + r.integers(-8, 9, (n, 3)) * np.spacing(np.abs(ends).astype(float))).astype(float)
    # farther from the walls than what counts as on them
    least = 4096.0 * U * chamber.far / chamber.size
    share = np.maximum(r.choice([0.1, 1e-3, 1e-6, 1e-9, 1e-12], (n, 1)), least).astype(Exact)
    beside = on_edges(r, chamber, n)
    starts = (beside + share * (chamber.corners.mean(axis=0) - beside)).astype(float)
    apart = np.linalg.norm(ends - starts, axis=1)
    keep = apart > 1e-3 * chamber.size
    return starts[keep], ((ends - starts) / apart[:, None])[keep]


def follow(
    elements: Sequence[Element], starts: Any, along: Any, steps: int, *, reflected: bool = False
) -> Any:
    """Follow rays; return their points in world coordinates, and which of them ended where.

    Points behind the end are not numbers; of what ended, the place is infinite where it escaped.
    """
    compiled = compile_elements(tuple(elements))
    rays = np.hstack([np.subtract(starts, compiled.shift), along])
    found = follow_rays(open_device(), compiled.tables, rays, steps, reflected=reflected)
    points = found.point.astype(Exact) + np.array(compiled.shift, Exact)
    gone = ~np.isfinite(found.distance)
    points[gone] = np.nan
    return points, gone.any(axis=1), (found.left < 0).any(axis=1) & ~gone.any(axis=1)


def leaks(chamber: Chamber, starts: Any, along: Any, steps: int = 30) -> tuple[int, int, int]:
    """Return how many rays escaped, ended on an absorber, and met something outside the chamber."""
    points, escaped, absorbed = follow(chamber.elements, starts, along, steps)
    middle = chamber.corners.mean(axis=0)
    heights = (points - middle) @ chamber.normals.T - (chamber.offsets - chamber.normals @ middle)
    outside = (heights < -ROUNDING * U * chamber.far).any(axis=(1, 2))  # not a number: not outside
    return int(escaped.sum()), int(absorbed.sum()), int(outside.sum())


def prism(r: np.random.Generator, degrees: float, scale: float, at: Any, surface: Any) -> Chamber:
    """Return a chamber over a triangle with a given angle.

    Its walls end on each other, or go on beyond; two plates larger than it close its ends.
    """
    turn = np.radians(r.uniform(0, 360) + np.array([0.0, degrees]))
    arms = r.uniform(0.5, 1, 2)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    feet = scale * np.vstack([[0.0, 0.0], arms])
    x, y, z = (float(v) for v in at)
    walls: list[Rectangle] = []
    for i in range(3):
        along = feet[(i + 1) % 3] - feet[i]
        beyond = r.choice([0.0, 0.0, 0.3], 2)
        middle = feet[i] + along * (1.0 + beyond[1] - beyond[0]) / 2.0
        walls.append(
            Rectangle(
                name="wall",
                position=(float(middle[0]) + x, float(middle[1]) + y, z),
                axis="+x",
                tilt_deg=(0.0, float(np.degrees(np.arctan2(-along[0], along[1])))),
                half_width=float(np.linalg.norm(along) * (1.0 + beyond.sum()) / 2.0),
                half_height=scale / 2.0,
                surface=surface,
            )
        )
    for end in (-0.5, 0.5):
        walls.append(
            Rectangle(
                name="end", position=(x, y, z + end * scale), axis="+z" if end < 0 else "-z",
                half_width=4.0 * scale, half_height=4.0 * scale, surface=surface,
            )
        )  # fmt: skip
    normals = np.array([w.frame[2] for w in walls], Exact)
    places = np.array([w.position for w in walls], Exact)
    middle = np.array([*(feet.mean(axis=0) + at[:2]), z], Exact)
    normals *= np.sign(((middle - places) * normals).sum(axis=1))[:, None]
    corners = np.array(
        [[*(foot + at[:2]), z + end * scale] for end in (-0.5, 0.5) for foot in feet], Exact
    )
    edges = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
    return Chamber(named(walls), normals, (normals * places).sum(axis=1), corners, edges)


def from_inside(chamber: Chamber, starts: Any, along: Any) -> tuple[Any, Any]:
    """Return the rays that start in a chamber, and not within rounding of what is around it."""
    middle = chamber.corners.mean(axis=0)
    heights = (starts - middle) @ chamber.normals.T - (chamber.offsets - chamber.normals @ middle)
    keep = heights.min(axis=1) > 64.0 * U * chamber.far
    return starts[keep], along[keep]


def rays_from_outside(
    r: np.random.Generator, chamber: Chamber, n: int, walls: int
) -> tuple[Any, Any]:
    """Return rays at edges and corners of a chamber from beyond any of its first `walls` planes.

    They start between the other planes, where there are any.
    """
    middle = chamber.corners.mean(axis=0)
    on = on_edges(r, chamber, n)
    ends = (on + r.integers(-8, 9, (n, 3)) * np.spacing(np.abs(on).astype(float))).astype(float)
    away = r.normal(size=(n, 3)).astype(Exact)
    away /= np.linalg.norm(away.astype(float), axis=1)[:, None]
    share = r.choice([1.0, 0.3, 1e-2, 1e-4], (n, 1)).astype(Exact) * chamber.size
    starts = (on + share * away).astype(float)
    heights = (starts - middle) @ chamber.normals.T - (chamber.offsets - chamber.normals @ middle)
    margin = 4096.0 * U * chamber.far
    keep = (heights[:, :walls].min(axis=1) < -margin) & (heights[:, walls:] > margin).all(axis=1)
    apart = np.linalg.norm(ends - starts, axis=1)
    keep &= apart > 1e-5 * chamber.size
    return starts[keep], ((ends - starts) / apart[:, None])[keep]


def entered(chamber: Chamber, starts: Any, along: Any, steps: int = 20) -> int:
    """Return how many rays were inside a chamber anywhere on their way between two interactions."""
    points, _, _ = follow(chamber.elements, starts, along, steps)
    middle = chamber.corners.mean(axis=0)
    between = (points[:, 1:] + points[:, :-1]) / 2
    heights = (between - middle) @ chamber.normals.T - (chamber.offsets - chamber.normals @ middle)
    return int((heights.min(axis=2) > 4096.0 * U * chamber.far).any(axis=1).sum())
