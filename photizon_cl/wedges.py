"""How much room for rounding the edges of flat elements need where they meet at a small angle.

Two faces that share an edge agree on where it is only to the rounding of their positions, δ. Where
they meet at an angle α, or π − α, a ray between them finds no gap if each goes on beyond its edge by
about δ/sin α, and a point put back onto one of them is on the right side of the other if it stays as
far within. The kernels' bounds hold for sin α ≥ 1/2 (gated); for less they are multiplied by what is
found here.
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


def edge_factors(elements: Sequence[Element]) -> NDArray[np.float64]:
    """Return by how much each element's bounds at its edges are to be multiplied.

    Parameters
    ----------
    elements : sequence of Element
        Of a scene, in order.

    Returns
    -------
    ndarray, shape (n,), float64
        1/sin of the smallest angle that a rectangle makes with a plane face on which one of its edges
        lies, or a disk with the sphere on which its rim lies, where that is more than 2; else 1.
    """
    factors = np.ones(len(elements))
    tilted = np.array([e.tilt_deg != (0.0, 0.0) for e in elements], bool)
    rims = np.array([isinstance(e, Disk) for e in elements], bool)
    balls = np.array([isinstance(e, Sphere) for e in elements], bool)
    # faces along the axes meet at right angles
    if not (tilted.any() or (rims.any() and balls.any())):
        return factors
    boxes = world_boxes(elements, (0.0, 0.0, 0.0))
    room = room_for_rounding(boxes)
    first, second = neighbours(boxes, room)
    sides = np.array([isinstance(e, Rectangle) for e in elements], bool)
    plane = np.array([e.flat or isinstance(e, BaffledTube) for e in elements], bool)
    angle = sides[first] & plane[second] & (tilted[first] | tilted[second])
    _sharpen_edges(factors, elements, first[angle], second[angle], room)
    on_ball = rims[first] & balls[second]
    for i, j in zip(first[on_ball].tolist(), second[on_ball].tolist(), strict=True):
        factors[i] = max(factors[i], 1.0 / _rim_on_ball(elements[i], elements[j], room))
    factors[factors < 1.0 / _SHARP] = 1.0
    return factors


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


# -- plane faces ---------------------------------------------------------------------------------


def _sharpen_edges(
    factors: NDArray[np.float64],
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
        sine = _sharpest(table[begin[one[part]]], table[other[part]], room)
        np.maximum.at(factors, one[part], 1.0 / sine)


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
) -> NDArray[np.float64]:
    """Return the least sine of the angles at which edges of rectangles end on faces, else 1."""
    centre, half = a[:, :3], a[:, 12:14]
    normal = b[:, 9:12]
    sine = np.ones(len(a))
    for along, across in ((0, 1), (1, 0)):
        e, f = a[:, 3 + 3 * along : 6 + 3 * along], a[:, 3 + 3 * across : 6 + 3 * across]
        for sign in (1.0, -1.0):
            edge = centre + sign * half[:, along, None] * e - b[:, :3]
            height = _dot(edge, normal)
            slope = half[:, across] * np.abs(_dot(f, normal))
            rise = np.abs(_dot(e, normal))
            # the edge lies in the face's plane, and not the whole rectangle
            ends = (np.abs(height) + slope <= room) & (2.0 * half[:, along] * rise > room)
            sine = np.minimum(sine, np.where(ends, rise, 1.0))
    return sine


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return (a * b).sum(axis=1)
