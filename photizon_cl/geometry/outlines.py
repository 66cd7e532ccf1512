"""The outlines of elements: where planes cut them, their edges, and their surfaces in facets.

A section is computed from the element's own shape, not from a mesh: flat faces are cut exactly, and
surfaces of revolution are cut circle by circle, with the ends of each piece found by bisection.
Ports, holes and the open ends of tubes and concentrators stay open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.lens import centre_depth
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import sincos_deg

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element

    Line = NDArray[np.float64]
    """Points of a polyline, shape (k, 3), in metres."""

__all__ = ["cut", "edges", "facets", "to_world"]

_STEPS: Final = 400
_TURN: Final = np.linspace(0.0, 2.0 * np.pi, 181)


@dataclass(frozen=True)
class _Face:
    """A flat face: a convex polygon in local coordinates, perhaps with a hole in it."""

    rim: Line
    hole: Line | None = None


@dataclass(frozen=True)
class _Revolved:
    """A surface of revolution about the local axis: its profile over s from 0 to 1."""

    profile: Callable[[Line], tuple[Line, Line]]
    """Radius and height, in metres."""


def to_world(element: Element, local: Line) -> Line:
    """Return local points, shape (k, 3), in world coordinates."""
    return np.asarray(local @ np.array(element.frame) + np.array(element.position))


def cut(element: Element, axis: int, at: float) -> list[Line]:
    """Return the curves in which a plane cuts an element.

    Parameters
    ----------
    element : Element
        What is cut.
    axis : int
        World axis (0, 1, 2) across which the plane lies.
    at : float
        Its coordinate in metres.

    Returns
    -------
    list of ndarray, each shape (k, 3)
        Polylines in world coordinates, in metres. A flat face that lies in the plane gives its rim.
    """
    frame = np.array(element.frame)
    normal, offset = frame[:, axis], at - element.position[axis]
    lines: list[Line] = []
    for part in _parts(element):
        if isinstance(part, _Face):
            lines += _cut_face(part, normal, offset)
        else:
            lines += _cut_revolved(part, normal, offset)
    return [to_world(element, line) for line in lines]


def edges(element: Element) -> list[Line]:
    """Return the curves that show an element's shape from anywhere: rims, edges, meridians."""
    lines: list[Line] = []
    for part in _parts(element):
        if isinstance(part, _Face):
            lines.append(part.rim)
            if part.hole is not None:
                lines.append(part.hole)
            continue
        r, z = part.profile(np.linspace(0.0, 1.0, 91))
        ends = [k for k in (0, -1) if r[k] > 1e-9 * r.max()]
        middle = [] if ends and not isinstance(element, Sphere) else [int(np.argmax(r))]
        lines += [_circle(float(r[k]), float(z[k])) for k in (*ends, *middle)]
        for turn in np.arange(0.0, np.pi, np.pi / 4.0):
            for side in (turn, turn + np.pi):
                lines.append(np.stack([r * np.cos(side), r * np.sin(side), z], axis=1))
    return [to_world(element, line) for line in lines]


def facets(element: Element) -> list[Line]:
    """Return polygons that make up the surface, for filling it with a faint colour."""
    out: list[Line] = []
    for part in _parts(element):
        if isinstance(part, _Face):
            out += [part.rim] if part.hole is None else _frame_of(part.rim, part.hole)
            continue
        r, z = part.profile(np.linspace(0.0, 1.0, 17))
        turn = np.linspace(0.0, 2.0 * np.pi, 37)
        for k in range(len(r) - 1):
            for a, b in pairwise(turn):
                corners = [(r[k], a, z[k]), (r[k], b, z[k]), (r[k + 1], b, z[k + 1])]
                corners.append((r[k + 1], a, z[k + 1]))
                out.append(np.array([(q * math.cos(t), q * math.sin(t), h) for q, t, h in corners]))
    return [to_world(element, polygon) for polygon in out]


# -- shapes --------------------------------------------------------------------------------------


def _parts(element: Element) -> list[_Face | _Revolved]:
    """Return an element's faces in local coordinates, in metres."""
    if isinstance(element, Rectangle):
        return [_Face(_rectangle(element.half_width, element.half_height, 0.0))]
    if isinstance(element, Disk):
        return [_Face(_circle(element.radius, 0.0))]
    if isinstance(element, Sphere):
        opening = math.acos(element.cos_port)
        return [_Revolved(_arc(element.radius, 0.0, opening, math.pi))]
    if isinstance(element, Cpc):
        return [_Revolved(_concentrator(element))]
    if isinstance(element, BaffledTube):
        return _tube(element)
    if isinstance(element, PlanoConvex):
        a = element.aperture_radius
        return [_Revolved(_cap(element.curvature_radius, a, 1.0)), _Face(_circle(a, 0.0))]
    if isinstance(element, Biconvex):
        a = element.aperture_radius
        return [
            _Revolved(_cap(element.front_radius, a, 1.0)),
            _Revolved(_cap(element.back_radius, a, -1.0)),
        ]
    raise NotImplementedError(f"no outline for a {element.kind}")


def _rectangle(half_u: float, half_v: float, w: float) -> Line:
    corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)]
    return np.array([(half_u * a, half_v * b, w) for a, b in corners])


def _circle(radius: float, w: float) -> Line:
    return np.stack(
        [radius * np.cos(_TURN), radius * np.sin(_TURN), np.full_like(_TURN, w)], axis=1
    )


def _arc(
    radius: float, centre: float, first: float, last: float, sign: float = 1.0
) -> Callable[[Line], tuple[Line, Line]]:
    def profile(s: Line) -> tuple[Line, Line]:
        theta = first + s * (last - first)
        # sin π is not 0 in floating point; a radius is never negative
        return np.abs(radius * np.sin(theta)), sign * (centre + radius * np.cos(theta))

    return profile


def _cap(radius: float, aperture: float, sign: float) -> Callable[[Line], tuple[Line, Line]]:
    opening = math.atan2(aperture, centre_depth(radius, aperture))
    return _arc(radius, -centre_depth(radius, aperture), 0.0, opening, sign)


def _concentrator(element: Cpc) -> Callable[[Line], tuple[Line, Line]]:
    """Return the meridian of a CPC, solved for the radius as in its class's description."""
    a, (sine, cosine) = element.exit_radius, sincos_deg(element.acceptance_deg)
    linear = 2.0 * (1.0 + sine) ** 2

    def profile(s: Line) -> tuple[Line, Line]:
        z = s * (element.length / a)
        q = (1.0 + sine) * (3.0 + sine) + z * (2.0 * cosine * (2.0 + sine) - sine * sine * z)
        p = 2.0 * cosine * sine * z + linear
        return a * 2.0 * q / (p + np.sqrt(p * p + 4.0 * cosine * cosine * q)), s * element.length

    return profile


def _tube(element: BaffledTube) -> list[_Face | _Revolved]:
    h, length = element.half_width, element.length
    corners = _rectangle(h, h, 0.0)
    out: list[_Face | _Revolved] = []
    for a, b in pairwise(corners):
        end = np.array([0.0, 0.0, length])
        out.append(_Face(np.array([a, b, b + end, a + end, a])))
    clear = element.clear_half_width or 0.0
    for w in element.baffle_positions:
        if clear < h:
            hole = _rectangle(clear, clear, w) if clear > 0.0 else None
            out.append(_Face(_rectangle(h, h, w), hole))
    return out


def _frame_of(rim: Line, hole: Line) -> list[Line]:
    """Return the four quadrilaterals between a square and its square hole."""
    return [np.array([rim[k], rim[k + 1], hole[k + 1], hole[k]]) for k in range(4)]


# -- cutting -------------------------------------------------------------------------------------


def _cut_face(face: _Face, normal: Line, offset: float) -> list[Line]:
    heights = face.rim @ normal - offset
    size = float(np.abs(face.rim).max())
    if np.all(np.abs(heights) <= 1e-12 * size):  # drawing only: it lies in the plane
        return [face.rim] if face.hole is None else [face.rim, face.hole]
    chord = _chord(face.rim, heights)
    if chord is None:
        return []
    gap = None if face.hole is None else _chord(face.hole, face.hole @ normal - offset)
    if gap is None:
        return [chord]
    along = chord[1] - chord[0]
    if (gap[1] - gap[0]) @ along < 0.0:
        gap = gap[::-1]
    return [np.stack([chord[0], gap[0]]), np.stack([gap[1], chord[1]])]


def _chord(polygon: Line, heights: Line) -> Line | None:
    """Return the two points where a plane meets the rim of a convex polygon."""
    found: list[Line] = []
    for a, b, ha, hb in zip(polygon, polygon[1:], heights, heights[1:], strict=False):
        if (ha < 0.0) != (hb < 0.0):
            found.append(a + (b - a) * (ha / (ha - hb)))
    return np.stack([found[0], found[-1]]) if len(found) >= 2 else None


def _cut_revolved(part: _Revolved, normal: Line, offset: float) -> list[Line]:
    """Cut circle by circle: on the one of radius r at height w the plane stands at φ0 ± β."""
    across = math.hypot(normal[0], normal[1])
    if across < 1e-12:  # the plane stands across the axis
        return _cut_across(part, offset / float(normal[2]))
    turn = math.atan2(normal[1], normal[0])

    def cosine(s: Line) -> Line:
        r, w = part.profile(s)
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
        r, w = part.profile(at)
        beta = np.arccos(np.clip(cosine(at), -1.0, 1.0))
        halves = [
            np.stack([r * np.cos(turn + k * beta), r * np.sin(turn + k * beta), w], axis=1)
            for k in (1.0, -1.0)
        ]
        point = 1e-12 * float(part.profile(s)[0].max())  # a pole, sin π included
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


def _cut_across(part: _Revolved, height: float) -> list[Line]:
    s = np.linspace(0.0, 1.0, _STEPS + 1)
    _, w = part.profile(s)
    for a, b, wa, wb in zip(s, s[1:], w, w[1:], strict=False):
        if min(wa, wb) <= height <= max(wa, wb):
            low, high = (a, b) if wa <= wb else (b, a)
            for _ in range(60):
                middle = 0.5 * (low + high)
                below = part.profile(np.array([middle]))[1][0] < height
                low, high = (middle, high) if below else (low, middle)
            radius = float(part.profile(np.array([high]))[0][0])
            return [_circle(radius, height)] if radius > 0.0 else []
    return []


def _limit(cosine: Callable[[Line], Line], inside: float, outside: float) -> float:
    """Return where |cosine| reaches 1 between a place inside and one outside."""
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        if abs(float(cosine(np.array([middle]))[0])) <= 1.0:
            inside = middle
        else:
            outside = middle
    return inside
