"""Whether elements of a scene touch or cross otherwise than along the edges they share.

Where they do, the rounding of a hit point can put it on either side of the other face, and the
kernels must remember which side a ray is on (effect ``contact``). Saying yes too often costs some
words a ray; saying no where faces touch could lose light, so every test here has room for rounding.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.sphere import Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.geometry.neighbours import Neighbours
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.sources import Source

__all__ = ["in_contact", "note_size"]

_PAIRS: Final = 300
"""More elements than this are taken to touch, rather than look at every pair."""
_SLOTS: Final = (8, 16, 24)
"""Numbers of faces that a ray may remember: few, so that scenes share programs.

More than a scene can need changes nothing and costs it time: 4 and 10 % for 16 and 24 faces where
it needs 8, in packets of 16 lanes.
"""
_SHORT: Final = 2047
"""Up to this many elements a face has 16 bits in what a ray remembers, else 32."""


def in_contact(near: Neighbours, sources: Sequence[Source] = ()) -> bool:
    """Say whether rays must remember on which side of elements that touch they are.

    They must where any two elements may touch or cross otherwise than along an edge of both; and
    where they may share an edge, unless everything that a ray could come from, elements and
    `sources`, stands inside the angle between them, as in a room. At the outside of an edge a ray
    that was put back onto one wall may be behind the other.
    """
    elements, rooms = near.elements, near.rooms
    if len(elements) > _PAIRS:
        return True
    if not elements:
        return False
    things = np.array([corner for e in elements for corner in _corners(e)])
    around = [_around(s.position, s.packed()[0] if s.packed() else 0.0) for s in sources]
    points = np.concatenate([things, *around])
    if any(
        _beside_tube(e, points, float(room))
        for e, room in zip(elements, rooms, strict=True)
        if isinstance(e, BaffledTube)
    ):
        return True
    for first, second in near.pairs():
        for i, j in zip(first.tolist(), second.tolist(), strict=True):
            a, b, room = elements[i], elements[j], float(max(rooms[i], rooms[j]))
            if i < j and (_touch(a, b, room) or _seen_from_outside(a, b, points, room)):
                return True
    return False


def _around(position: Sequence[float], radius: float) -> NDArray[np.float64]:
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    return np.array(position) + radius * signs


def _beside_tube(tube: BaffledTube, points: NDArray[np.float64], room: float) -> bool:
    """Say whether any point is beside a tube, where its long edges are outer ones."""
    u, v, _ = np.array(tube.frame)
    offsets = points - np.array(tube.position)
    reach = np.maximum(np.abs(offsets @ u), np.abs(offsets @ v))
    return bool((reach > tube.half_width + room).any())


def _seen_from_outside(a: Element, b: Element, points: NDArray[np.float64], room: float) -> bool:
    """Say whether any point is outside the angle between two flat elements that share an edge."""
    if not (a.flat and b.flat):
        return False
    for flat, other in ((a, b), (b, a)):
        normal, origin = np.array(flat.frame[2]), np.array(flat.position)
        low, high = _heights(flat, other)
        side = 1.0 if high > -low else -1.0
        if (side * ((points - origin) @ normal) < -room).any():
            return True
    return False


def note_size(near: Neighbours) -> tuple[int, int]:
    """Return in how many words, and bits a face, a ray can remember all faces that meet at a point.

    No more than 24 faces: where more meet, those of the first elements are remembered.
    """
    bits = 16 if len(near.elements) <= _SHORT else 32
    return _slots(near) * bits // 64, bits


def _slots(near: Neighbours) -> int:
    own = np.array([e.faces_at_a_point for e in near.elements])
    faces = own.astype(np.float64)
    for first, second in near.pairs():
        faces += np.bincount(first, own[second], len(own))
    # more than n faces at a point are faces of elements that all have more than n around them
    return next((n for n in _SLOTS if own[faces > n].sum() <= n), _SLOTS[-1])


def _touch(a: Element, b: Element, room: float) -> bool:
    if a.flat and b.flat:
        low_a, high_a = _heights(a, b)
        low_b, high_b = _heights(b, a)
        flush = max(high_a, -low_a, high_b, -low_b) <= room
        across = (low_a < -room and high_a > room) or (low_b < -room and high_b > room)
        # each on one side of the other: they meet along an edge of both, unless they are flush
        return flush or across
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        distance = math.dist(a.position, b.position)
        return abs(a.radius - b.radius) - room <= distance <= a.radius + b.radius + room
    if isinstance(a, Sphere) and b.flat:
        a, b = b, a
    if isinstance(b, Sphere) and a.flat:
        offset = np.subtract(b.position, a.position)
        apart = abs(float(np.dot(a.frame[2], offset)))
        farthest = max(math.dist(corner, b.position) for corner in _corners(a))
        return apart <= b.radius + room and farthest >= b.radius - room
    return True


def _corners(element: Element) -> list[tuple[float, float, float]]:
    """Corners of the box around an element in its own frame, in world coordinates."""
    frame = np.array(element.frame)
    local = [np.array(c) for c in product(*zip(*element.local_box, strict=True))]
    x = [element.position + c @ frame for c in local]
    return [(float(p[0]), float(p[1]), float(p[2])) for p in x]


def _heights(flat: Element, other: Element) -> tuple[float, float]:
    """Lowest and highest corner of another element over the plane of a flat one, in metres."""
    normal, origin = np.array(flat.frame[2]), np.array(flat.position)
    heights = [float(np.dot(normal, np.array(c) - origin)) for c in _corners(other)]
    return min(heights), max(heights)
