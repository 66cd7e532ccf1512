"""Whether elements of a scene touch face to face.

Where they do, a ray between two faces has no room to show which side of each it is on, and the
kernels must remember it (effect ``contact``). Saying yes too often costs a word a ray; saying no
where faces touch would lose light, so every test here has room for rounding.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING, Final

from photizon_cl.elements import Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.elements import Element

__all__ = ["in_contact"]

_ROOM: Final = 2.0**-40
"""Distance at which faces count as touching, relative to the elements' size and position."""
_PAIRS: Final = 300
"""More elements than this are taken to touch, rather than look at every pair."""


def in_contact(elements: Sequence[Element]) -> bool:
    """Say whether any two elements may touch face to face."""
    if len(elements) > _PAIRS:
        return True
    return any(_touch(a, b) for a, b in combinations(elements, 2))


def _touch(a: Element, b: Element) -> bool:
    offset = [q - p for p, q in zip(a.position, b.position, strict=True)]
    scale = max(a.reach, b.reach, *map(abs, a.position), *map(abs, b.position))
    room = _ROOM * scale
    distance = math.hypot(*offset)
    if distance > a.reach + b.reach + room:
        return False
    if a.flat and b.flat:
        normal, other = a.frame[2], b.frame[2]
        parallel = abs(sum(p * q for p, q in zip(normal, other, strict=True)))
        apart = abs(sum(p * q for p, q in zip(normal, offset, strict=True)))
        # a small angle between them moves a face by no more than its reach times that angle
        return parallel >= 1.0 - 2.0**-18 and apart <= room + 0.01 * b.reach
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        return (
            abs(distance - (a.radius + b.radius)) <= room
            or abs(distance - abs(a.radius - b.radius)) <= room
        )
    if isinstance(b, Sphere) and a.flat:
        apart = abs(sum(p * q for p, q in zip(a.frame[2], offset, strict=True)))
        return abs(apart - b.radius) <= room
    if isinstance(a, Sphere) and b.flat:
        return _touch(b, a)
    return True
