"""How much room for rounding the edges of flat elements need where they meet at a small angle.

Two faces that share an edge agree on where it is only to the rounding of their positions, δ. Where
they meet at an angle α, or π − α, a ray between them finds no gap if each goes on beyond its edge
by about δ/sin α, and a point put back onto one of them is on the right side of the other if it
stays as far within. The kernels' bounds hold for sin α ≥ 1/2 (gated); for less they are multiplied
by what is found here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element

__all__ = ["edge_factors"]

_SHARP: Final = 0.5
"""Sine of the angle from which on the bounds hold as they are."""
_AT_ONCE: Final = 1 << 16
"""Pairs looked at at once, which bounds the memory."""


def edge_factors(near: Neighbours) -> NDArray[np.float64]:
    """Return by how much each element's bounds at its edges are to be multiplied.

    Parameters
    ----------
    near : Neighbours
        The elements of a scene.

    Returns
    -------
    ndarray, shape (n, 4), float64
        For the edges at +u, −u, +v and −v: 1/sin of the smallest angle that a rectangle makes with
        a plane face on which this edge lies, or a disk with the sphere on which its rim lies, if
        that is more than 2; else 1.
    """
    elements = near.elements
    factors = np.ones((len(elements), 4))
    plane = [n for n, e in enumerate(elements) if e.flat or isinstance(e, BaffledTube)]
    disks = any(isinstance(elements[n], Disk) for n in plane)
    balls = [n for n, e in enumerate(elements) if disks and isinstance(e, Sphere)]
    # plane faces along the axes meet at right angles
    if balls or any(elements[n].tilt_deg != (0.0, 0.0) for n in plane):
        # coincident elements have the same edges: the first stands for all
        first: dict[Any, int] = {}
        stands_for = {}
        for n in plane + balls:
            e = elements[n]
            stands_for[n] = first.setdefault((e.kind, e.position, e.frame, e.local_box), n)
        asked = list(first.values())
        if len(asked) < len(stands_for):
            factors[asked] = _factors(Neighbours([elements[n] for n in asked]))
        else:
            factors = _factors(near)
        factors[list(stands_for)] = factors[list(stands_for.values())]
    return factors


def _factors(near: Neighbours) -> NDArray[np.float64]:
    elements, rooms = near.elements, near.rooms
    factors = np.ones((len(elements), 4))
    tilted = np.array([e.tilt_deg != (0.0, 0.0) for e in elements])
    sides = np.array([isinstance(e, Rectangle) for e in elements])
    rims = np.array([isinstance(e, Disk) for e in elements])
    balls = np.array([isinstance(e, Sphere) for e in elements])
    plane = np.array([e.flat or isinstance(e, BaffledTube) for e in elements])
    faces = _Faces(elements)
    for first, second in near.pairs():
        angle = sides[first] & plane[second] & (tilted[first] | tilted[second])
        _sharpen(factors, faces, first[angle], second[angle], rooms)
        on_ball = rims[first] & balls[second]
        for i, j in zip(first[on_ball].tolist(), second[on_ball].tolist(), strict=True):
            room = float(max(rooms[i], rooms[j]))
            sine = _rim_on_ball(elements[i], elements[j], room)
            factors[i] = np.maximum(factors[i], 1.0 / sine)
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


class _Faces:
    """The plane faces of elements, one after the other.

    begin : ndarray, shape (n + 1,), int64
        Where each element's begin.
    table : ndarray, shape (faces, 14), float64
        Centre, frame (u, v, normal), half sizes along u and v.
    """

    def __init__(self, elements: Sequence[Element]) -> None:
        faces = [_faces(e) for e in elements]
        self.begin = np.cumsum([0, *map(len, faces)])
        self.table = np.array([face for group in faces for face in group]).reshape(-1, 14)


def _sharpen(
    factors: NDArray[np.float64],
    faces: _Faces,
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    rooms: NDArray[np.float64],
) -> None:
    """Raise the factors of rectangles `first` by the angles they make with faces of `second`."""
    begin, table = faces.begin, faces.table
    many = begin[second + 1] - begin[second]
    one = np.repeat(first, many)
    within = np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    other = np.repeat(begin[second], many) + within
    room = np.repeat(np.maximum(rooms[first], rooms[second]), many)
    for start in range(0, len(one), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        sine = _sharpest(table[begin[one[part]]], table[other[part]], room[part])
        np.maximum.at(factors, one[part], 1.0 / sine)


def _faces(element: Element) -> list[list[float]]:
    """Return an element's plane faces, as the rows of `_Faces`."""
    found: list[tuple[Any, Any, tuple[float, float]]] = []
    if isinstance(element, BaffledTube):
        (u, v, w), position = np.array(element.frame), np.array(element.position)
        h, middle = element.half_width, 0.5 * element.length
        found += [
            (sign * h * n + middle * w + position, (t, w, n), (h, middle))
            for n, t in ((u, v), (v, u))
            for sign in (1.0, -1.0)
        ]
        found += [(z * w + position, (u, v, w), (h, h)) for z in element.baffle_positions]
    elif isinstance(element, Rectangle):
        found.append((element.position, element.frame, element.half_sizes))
    elif isinstance(element, Disk):
        found.append((element.position, element.frame, (element.radius, element.radius)))
    return [[*c, *(x for row in f for x in row), *half] for c, f, half in found]


def _sharpest(
    a: NDArray[np.float64], b: NDArray[np.float64], room: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the sines of the angles at which the edges of rectangles end on faces, else 1."""
    centre, half = a[:, :3], a[:, 12:14]
    normal = b[:, 9:12]
    sine = np.ones((len(a), 4))
    for along, across in ((0, 1), (1, 0)):
        e, f = a[:, 3 + 3 * along : 6 + 3 * along], a[:, 3 + 3 * across : 6 + 3 * across]
        for k, sign in enumerate((1.0, -1.0)):
            edge = centre + sign * half[:, along, None] * e - b[:, :3]
            height = _dot(edge, normal)
            slope = half[:, across] * np.abs(_dot(f, normal))
            rise = np.abs(_dot(e, normal))
            # the edge lies in the face's plane, and not the whole rectangle
            ends = (np.abs(height) + slope <= room) & (2.0 * half[:, along] * rise > room)
            sine[ends, 2 * along + k] = rise[ends]
    return sine


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((a * b).sum(axis=1))
