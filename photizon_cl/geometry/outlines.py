"""The outlines of elements: where planes cut them, their edges, and their surfaces in facets.

A section is computed from the element's own shape, not from a mesh: flat faces are cut exactly, and
surfaces of revolution are cut circle by circle, with the ends of each piece found by bisection.
Ports, holes and the open ends of tubes and concentrators stay open.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.faces import Plane, Revolved

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.outlines import Outline

    Line = NDArray[np.float64]
    """Points of a polyline, shape (k, 3), in metres."""
    Values = NDArray[np.float64]
    """A number for each of k places, shape (k,)."""
    Normal = NDArray[np.float64]
    """A unit vector, shape (3,)."""

__all__ = ["cut", "edges", "facets", "to_world"]

_STEPS: Final = 400
_TURN: Final = np.linspace(0.0, 2.0 * np.pi, 181)


def to_world(element: Element, local: Line) -> Line:
    """Return local points, shape (k, 3), in world coordinates."""
    return np.asarray(local @ np.array(element.frame) + np.array(element.position))


def cut(element: Element, axis: int, at: float, number: int | None = None) -> list[Line]:
    """Return the curves in which a plane cuts an element.

    Parameters
    ----------
    element : Element
        What is cut.
    axis : int
        World axis (0, 1, 2) across which the plane lies.
    at : float
        Its coordinate in metres.
    number : int, optional
        Only of this face.

    Returns
    -------
    list of ndarray, each shape (k, 3)
        Polylines in world coordinates, in metres. A flat face that lies in the plane gives its rim.
    """
    frame = np.array(element.frame)
    normal, offset = frame[:, axis], at - element.position[axis]
    lines: list[Line] = []
    for face in _faces(element) if number is None else [element.faces[number]]:
        if isinstance(face, Plane):
            lines += [] if face.empty else _cut_plane(face, normal, offset)
        elif isinstance(face, Revolved):
            lines += _cut_revolved(face, normal, offset)
    return [to_world(element, line) for line in lines]


def edges(element: Element) -> list[Line]:
    """Return the curves that show an element's shape from anywhere: rims, edges, meridians."""
    lines: list[Line] = []
    for face in _faces(element):
        if isinstance(face, Plane):
            lines += _rims(face)
            continue
        r, z = face.profile(np.linspace(0.0, 1.0, 91))
        ends = [k for k in (0, -1) if r[k] > 1e-9 * r.max()]
        middle = [int(np.argmax(r))] if r.max() > max(r[0], r[-1]) else []  # where it bulges
        lines += [_circle(float(r[k]), float(z[k])) for k in (*ends, *middle)]
        for turn in np.arange(0.0, np.pi, np.pi / 4.0):
            for side in (turn, turn + np.pi):
                lines.append(np.stack([r * np.cos(side), r * np.sin(side), z], axis=1))
    return [to_world(element, line) for line in lines]


def facets(element: Element) -> list[Line]:
    """Return polygons that make up the surface, for filling it with a faint colour."""
    out: list[Line] = []
    for face in _faces(element):
        if isinstance(face, Plane):
            out += _rims(face) if face.hole is None else _around_hole(face)
            continue
        r, z = face.profile(np.linspace(0.0, 1.0, 17))
        turn = np.linspace(0.0, 2.0 * np.pi, 37)
        for k in range(len(r) - 1):
            for a, b in pairwise(turn):
                corners = [(r[k], a, z[k]), (r[k], b, z[k]), (r[k + 1], b, z[k + 1])]
                corners.append((r[k + 1], a, z[k + 1]))
                out.append(np.array([(q * math.cos(t), q * math.sin(t), h) for q, t, h in corners]))
    return [to_world(element, polygon) for polygon in out]


# -- shapes --------------------------------------------------------------------------------------


def _faces(element: Element) -> list[Plane | Revolved]:
    """Return the faces that can be seen, in local coordinates."""
    return [
        face
        for face in element.faces
        if isinstance(face, Revolved) or (isinstance(face, Plane) and not face.empty)
    ]


def _rims(face: Plane) -> list[Line]:
    """Return the outline of a plane face and that of its hole, if any, as polylines."""
    parts = [face.outline] if face.hole is None else [face.outline, face.hole]
    return [face.points(part.rim()) for part in parts]


def _circle(radius: float, w: float) -> Line:
    return np.stack(
        [radius * np.cos(_TURN), radius * np.sin(_TURN), np.full_like(_TURN, w)], axis=1
    )


def _around_hole(face: Plane) -> list[Line]:
    """Return quadrilaterals between the outline of a plane face and its hole."""
    assert face.hole is not None
    rim, hole = face.outline.rim(), face.hole.rim()
    if len(rim) != len(hole):  # a corner of either is a corner of a quadrilateral
        corners = np.vstack([part.corners for part in (face.outline, face.hole)])
        angles = np.arctan2(corners[:, 1], corners[:, 0]) % (2.0 * np.pi)
        angles = np.unique(np.concatenate([_TURN, angles]))
        rim, hole = face.outline.towards(angles), face.hole.towards(angles)
    return [
        face.points(np.array([rim[k], rim[k + 1], hole[k + 1], hole[k]]))
        for k in range(len(rim) - 1)
    ]


# -- cutting -------------------------------------------------------------------------------------


def _cut_plane(face: Plane, normal: Normal, offset: float) -> list[Line]:
    rim, *holes = _rims(face)
    heights = rim @ normal - offset
    size = float(np.abs(rim).max())
    if np.all(np.abs(heights) <= 1e-12 * size):  # drawing only: it lies in the plane
        return [rim, *holes]
    chord = _chord(rim, heights)
    if chord is None:
        return []
    gap = _chord(holes[0], holes[0] @ normal - offset) if holes else None
    if gap is None:
        return [chord]
    assert face.hole is not None
    gap = _to_rim(face, face.hole, gap)
    along = chord[1] - chord[0]
    if (gap[1] - gap[0]) @ along < 0.0:
        gap = gap[::-1]
    return [np.stack([chord[0], gap[0]]), np.stack([gap[1], chord[1]])]


def _chord(polygon: Line, heights: Values) -> Line | None:
    """Return the two points where a plane meets the rim of a convex polygon."""
    found: list[Line] = []
    for a, b, ha, hb in zip(polygon, polygon[1:], heights, heights[1:], strict=False):
        if (ha < 0.0) != (hb < 0.0):
            found.append(a + (b - a) * (ha / (ha - hb)))
    return np.stack([found[0], found[-1]]) if len(found) >= 2 else None


def _to_rim(face: Plane, outline: Outline, chord: Line) -> Line:
    """Return a chord whose ends are moved along it from the outline's polygon onto the outline."""
    ends = []
    for a, b in (chord, chord[::-1]):
        along = (a - b) / (float(np.linalg.norm(a - b)) or 1.0)
        inside, outside = 0.0, 2.0 * outline.reach
        for _ in range(60):
            middle = 0.5 * (inside + outside)
            x, y, _ = face.within(tuple((a + middle * along).tolist()))
            inside, outside = (middle, outside) if outline.holds(x, y) else (inside, middle)
        ends.append(a + outside * along)
    return np.stack(ends)


def _cut_revolved(face: Revolved, normal: Normal, offset: float) -> list[Line]:
    """Cut circle by circle: on the one of radius r at height w the plane stands at φ0 ± β."""
    across = math.hypot(normal[0], normal[1])
    if across < 1e-12:  # the plane stands across the axis
        return _cut_across(face, offset / float(normal[2]))
    turn = math.atan2(normal[1], normal[0])

    def cosine(s: Values) -> Values:
        r, w = face.profile(s)
        with np.errstate(divide="ignore", invalid="ignore"):
            c = (offset - normal[2] * w) / (r * across)
        # in the pole of a closed surface the plane that holds the axis has no angle of its own
        return np.where(r > 0.0, c, np.where(offset == normal[2] * w, 0.0, np.inf))

    s = np.linspace(0.0, 1.0, _STEPS + 1)
    c = cosine(s)
    inside = np.abs(c) <= 1.0
    lines: list[Line] = []
    steps = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    for a, b in zip(steps[::2], steps[1::2], strict=True):
        places = list(s[a:b])
        if a > 0:
            places.insert(0, _limit(cosine, s[a], s[a - 1]))
        if b <= _STEPS:
            places.append(_limit(cosine, s[b - 1], s[b]))
        at = np.array(places)
        r, w = face.profile(at)
        beta = np.arccos(np.clip(cosine(at), -1.0, 1.0))
        halves = [
            np.stack([r * np.cos(turn + k * beta), r * np.sin(turn + k * beta), w], axis=1)
            for k in (1.0, -1.0)
        ]
        point = 1e-12 * float(face.profile(s)[0].max())  # a pole, sin π included
        closed_first, closed_last = a > 0 or r[0] <= point, b <= _STEPS or r[-1] <= point
        if closed_first or not closed_last:
            if closed_first:  # from one open end over the closed one to the other
                line = np.vstack([halves[1][::-1], halves[0]])
                lines.append(np.vstack([line, line[:1]]) if closed_last else line)
            else:
                lines += halves
        else:
            lines.append(np.vstack([halves[0], halves[1][::-1]]))
    return lines


def _cut_across(face: Revolved, height: float) -> list[Line]:
    s = np.linspace(0.0, 1.0, _STEPS + 1)
    _, w = face.profile(s)
    for a, b, wa, wb in zip(s, s[1:], w, w[1:], strict=False):
        if min(wa, wb) <= height <= max(wa, wb):
            low, high = (a, b) if wa <= wb else (b, a)
            for _ in range(60):
                middle = 0.5 * (low + high)
                below = face.profile(np.array([middle]))[1][0] < height
                low, high = (middle, high) if below else (low, middle)
            radius = float(face.profile(np.array([high]))[0][0])
            return [_circle(radius, height)] if radius > 0.0 else []
    return []


def _limit(cosine: Callable[[Values], Values], inside: float, outside: float) -> float:
    """Return where |cosine| reaches 1 between a place inside and one outside."""
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        if abs(float(cosine(np.array([middle]))[0])) <= 1.0:
            inside = middle
        else:
            outside = middle
    return inside
