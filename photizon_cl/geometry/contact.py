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

from photizon_cl.geometry.planes import PlaneFaces, dot
from photizon_cl.scene.faces import Ball

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
_PARALLEL: Final = 2.0**-40
"""Less than 1 by no more than this is the cosine between parallel planes."""
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
    bodies = [_Body(e) for e in elements]
    points = np.concatenate(
        [*(body.corners for body in bodies), *(_around(s.position, s.reach) for s in sources)]
    )
    if any(
        _beside_own_edges(body, points, float(room))
        for body, room in zip(bodies, rooms, strict=True)
    ):
        return True
    for first, second in near.pairs():
        for i, j in zip(first.tolist(), second.tolist(), strict=True):
            a, b, room = bodies[i], bodies[j], float(max(rooms[i], rooms[j]))
            if i < j and (_touch(a, b, room) or _seen_from_outside(a, b, points, room)):
                return True
    return False


class _Body:
    """An element and what its faces are in the world.

    element : Element
    corners : ndarray, shape (8, 3), float64
        Of the box around it in its own frame, in metres.
    normals, origins : ndarray, shape (faces, 3), float64
        Of its faces, where all of them are planes; else empty.
    ball : Ball or None
        Its face, where that is one (or a zone of one), and its centre in metres.
    """

    def __init__(self, element: Element) -> None:
        self.element = element
        local = np.array(list(product(*zip(*element.local_box, strict=True))))
        self.corners = np.array([element.position + c @ np.array(element.frame) for c in local])
        planes = PlaneFaces([element])
        self.normals, self.origins = planes.frames[:, 2], planes.centres
        face = element.sole_face
        self.ball = face if isinstance(face, Ball) else None
        rise = self.ball.height if self.ball else 0.0
        self.centre = np.array(element.position) + rise * np.array(element.frame[2])

    @property
    def flat(self) -> bool:
        """Whether it is a part of one plane."""
        return len(self.normals) == 1

    def heights(self, other: _Body) -> tuple[float, float]:
        """Lowest and highest corner of another body over the plane of a flat one, in metres."""
        normal, origin = self.normals[0], self.origins[0]
        heights = [float(np.dot(normal, c - origin)) for c in other.corners]
        return min(heights), max(heights)


def _around(position: Sequence[float], radius: float) -> NDArray[np.float64]:
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    return np.array(position) + radius * signs


def _beside_own_edges(body: _Body, points: NDArray[np.float64], room: float) -> bool:
    """Say whether any point sees edges between plane faces of one element from their outside.

    Those are edges of faces of which it is all on one side, as the walls of a tube are.
    """
    normals = body.normals
    if len(normals) < 2 or (np.abs(normals @ normals[0]) > 1.0 - _PARALLEL).all():
        return False
    own = body.corners @ normals.T - dot(body.origins, normals)
    low, high = own.min(axis=0), own.max(axis=0)
    outer = (low >= -room) | (high <= room)
    sides = np.where(high > -low, 1.0, -1.0)
    return any(
        (sides[n] * ((points - body.origins[n]) @ normals[n]) < -room).any()
        for n in np.flatnonzero(outer)
    )


def _seen_from_outside(a: _Body, b: _Body, points: NDArray[np.float64], room: float) -> bool:
    """Say whether any point is outside the angle between two flat elements that share an edge."""
    if not (a.flat and b.flat):
        return False
    for flat, other in ((a, b), (b, a)):
        low, high = flat.heights(other)
        side = 1.0 if high > -low else -1.0
        if (side * ((points - flat.origins[0]) @ flat.normals[0]) < -room).any():
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


def _touch(a: _Body, b: _Body, room: float) -> bool:
    if a.flat and b.flat:
        low_a, high_a = a.heights(b)
        low_b, high_b = b.heights(a)
        flush = max(high_a, -low_a, high_b, -low_b) <= room
        across = (low_a < -room and high_a > room) or (low_b < -room and high_b > room)
        # each on one side of the other: they meet along an edge of both, unless they are flush
        return flush or across
    if a.ball and b.ball:
        distance = math.dist(a.centre, b.centre)
        r, s = a.ball.radius, b.ball.radius
        return abs(r - s) - room <= distance <= r + s + room
    for body, other in ((a, b), (b, a)):
        if other.ball:
            farthest = max(math.dist(corner, other.centre) for corner in body.corners)
            if farthest < other.ball.radius - room:
                return False  # it is within the ball
            if body.flat:
                apart = abs(float(np.dot(body.normals[0], other.centre - body.origins[0])))
                return apart <= other.ball.radius + room
    return True
