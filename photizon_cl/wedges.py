"""How much room for rounding the edges of flat elements need where they close a sharp wedge.

Two faces that share an edge agree on where it is only to the rounding of their positions, δ. Where
they meet at an angle α a ray between them finds no gap if each goes on beyond its edge by about
δ/sin α, and a point put back onto one of them is on the right side of the other if it stays as far
within. The kernels' bounds hold for angles from 30° on (gated); for sharper ones they are multiplied
by what is found here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.elements import BaffledTube, Disk, Rectangle, Sphere
from photizon_cl.neighbours import neighbours, room_for_rounding
from photizon_cl.tree import world_boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.elements import Element

__all__ = ["edge_factors"]

_SHARP: Final = 0.5
"""Sine of the angle from which on the bounds hold as they are."""
_AT_ONCE: Final = 1 << 16
"""Pairs looked at at once, which bounds the memory."""


def edge_factors(elements: Sequence[Element]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return by how much each element's bounds at its edges are to be multiplied.

    Parameters
    ----------
    elements : sequence of Element
        Of a scene, in order.

    Returns
    -------
    at_edges : ndarray, shape (n,), float64
        1/sin α of the sharpest wedge below 30° that a rectangle closes with a plane face on which
        one of its edges lies, or a disk with the sphere on which its rim lies; else 1.
    beside : ndarray, shape (n,), float64
        Half of 1/sin of the angle between them, wedge or not, where that is more than 1; else 1.
    """
    at_edges, beside = np.ones((2, len(elements)))
    tilted = np.array([e.tilt_deg != (0.0, 0.0) for e in elements], bool)
    rims = np.array([isinstance(e, Disk) for e in elements], bool)
    balls = np.array([isinstance(e, Sphere) for e in elements], bool)
    # faces along the axes meet at right angles
    if not (tilted.any() or (rims.any() and balls.any())):
        return at_edges, beside
    boxes = world_boxes(elements, (0.0, 0.0, 0.0))
    room = room_for_rounding(boxes)
    first, second = neighbours(boxes, room)
    sides = np.array([isinstance(e, Rectangle) for e in elements], bool)
    plane = np.array([e.flat or isinstance(e, BaffledTube) for e in elements], bool)
    wedge = sides[first] & plane[second] & (tilted[first] | tilted[second])
    _sharpen_edges(at_edges, beside, elements, first[wedge], second[wedge], room)
    on_ball = rims[first] & balls[second]
    for i, j in zip(first[on_ball].tolist(), second[on_ball].tolist(), strict=True):
        sine = _rim_on_ball(elements[i], elements[j], room)
        at_edges[i], beside[i] = max(at_edges[i], _factor(sine)), max(beside[i], 0.5 / sine)
    return at_edges, beside


def _rim_on_ball(disk: Element, ball: Element, room: float) -> float:
    """Return the sine of the angle of a disk with the sphere on which its rim lies, else 1."""
    assert isinstance(disk, Disk)
    assert isinstance(ball, Sphere)
    offset, normal = np.subtract(disk.position, ball.position), np.array(disk.frame[2])
    height = float(offset @ normal)
    aside = float(np.linalg.norm(offset - height * normal))
    sine = disk.radius / ball.radius
    on = aside <= room and abs(float(np.hypot(height, disk.radius)) - ball.radius) <= room
    return min(sine, 1.0) if on else 1.0


def _factor(sine: float) -> float:
    return 1.0 / sine if sine < _SHARP else 1.0


# -- plane faces ---------------------------------------------------------------------------------


def _sharpen_edges(
    at_edges: NDArray[np.float64],
    beside: NDArray[np.float64],
    elements: Sequence[Element],
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    room: float,
) -> None:
    """Raise the factors of rectangles `first` by the angles they make with faces of `second`."""
    if not len(first):
        return
    faces = [_faces(e) for e in elements]
    begin = np.cumsum([0, *map(len, faces)])
    table = np.array([face for group in faces for face in group]).reshape(-1, 14)
    many = begin[second + 1] - begin[second]
    one = np.repeat(first, many)
    within = np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    other = np.repeat(begin[second], many) + within
    for start in range(0, len(one), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        wedge, angle = _sharpest(table[begin[one[part]]], table[other[part]], room)
        np.maximum.at(at_edges, one[part], np.where(wedge < _SHARP, 1.0 / wedge, 1.0))
        np.maximum.at(beside, one[part], 0.5 / angle)


def _faces(element: Element) -> list[list[float]]:
    """Return an element's plane faces: centre, frame (u, v, normal), half sizes along u and v."""
    frame, position = np.array(element.frame), np.array(element.position)
    if isinstance(element, BaffledTube):
        u, v, w = frame
        h, middle = element.half_width, 0.5 * element.length
        found = [
            (sign * h * n + middle * w + position, (t, w, n), (h, middle))
            for n, t in ((u, v), (v, u))
            for sign in (1.0, -1.0)
        ]
        found += [(z * w + position, (u, v, w), (h, h)) for z in element.baffle_positions]
    elif isinstance(element, Rectangle):
        found = [(position, tuple(frame), element.half_sizes)]
    elif isinstance(element, Disk):
        found = [(position, tuple(frame), (element.radius, element.radius))]
    else:
        found = []
    return [[*c.tolist(), *np.ravel(f).tolist(), *half] for c, f, half in found]


def _sharpest(
    a: NDArray[np.float64], b: NDArray[np.float64], room: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least sines of wedges, and of all angles, that rectangles' edges make, else 1."""
    centre, half = a[:, :3], a[:, 12:14]
    normal = b[:, 9:12]
    wedge, angle = np.ones((2, len(a)))
    for along, across in ((0, 1), (1, 0)):
        e, f = a[:, 3 + 3 * along : 6 + 3 * along], a[:, 3 + 3 * across : 6 + 3 * across]
        for sign in (1.0, -1.0):
            edge = centre + sign * half[:, along, None] * e - b[:, :3]
            height = _dot(edge, normal)
            slope = half[:, across] * np.abs(_dot(f, normal))
            into = -sign * e
            rise = _dot(into, normal)
            flush = 2.0 * half[:, along] * np.abs(rise) <= room
            # the face goes on from the edge to the side on which the rectangle stands over it
            toward = into - rise[:, None] * normal
            reach = np.abs(_dot(b[:, 3:6], toward)) * b[:, 12]
            reach += np.abs(_dot(b[:, 6:9], toward)) * b[:, 13]
            ends = (np.abs(height) + slope <= room) & ~flush
            angle = np.minimum(angle, np.where(ends, np.abs(rise), 1.0))
            ends &= reach - _dot(edge, toward) > room
            wedge = np.minimum(wedge, np.where(ends, np.abs(rise), 1.0))
    return wedge, angle


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return (a * b).sum(axis=1)
