"""What a scattered ray is aimed at: an element as a flat outline or a ball around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from photizon_cl.scene.faces import Ball, Plane
from photizon_cl.scene.frames import frame
from photizon_cl.scene.outlines import Circular, Rectangular

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.frames import Frame, Vec3

__all__ = ["BALL", "RING", "SQUARE", "Target", "target_of"]

SQUARE: Final = 0
"""A rectangle: |u| ≤ `a`, |v| ≤ `b`."""
RING: Final = 1
"""A disk or annulus: `b` ≤ √(u² + v²) ≤ `a`."""
BALL: Final = 2
"""A ball of radius `a`."""


@dataclass(frozen=True)
class Target:
    """Where points of a target are drawn.

    Parameters
    ----------
    shape : int
        `SQUARE`, `RING` or `BALL`.
    centre : tuple of float
        In world coordinates, in metres.
    frame : tuple of tuple of float
        Rows (u, v, normal) in world coordinates; of no meaning for a ball.
    a, b : float
        Its sizes in metres.
    area : float
        Of the flat ones in m², else 0.
    reach : float
        Radius in metres of a ball around the centre that holds it.
    side : int
        1 where only what arrives against the normal is meant, −1 along it, 0 where both are.
    """

    shape: int
    centre: Vec3
    frame: Frame
    a: float
    b: float
    area: float
    reach: float
    side: int = 0


def target_of(element: Element) -> Target:
    """Return what is aimed at to meet an element.

    A flat element is its own outline, seen from the side that its detector counts where it has one.
    Every other is a ball: a whole sphere its own, else the smaller of the balls around its box and
    around its position.
    """
    face = element.sole_face
    if isinstance(face, Plane) and element.flat:
        side = 0 if element.detector is None else (1 if element.detector_plus else -1)
        outline, hole = face.outline, face.hole
        if isinstance(outline, Rectangular) and hole is None:
            a, b = outline.half_u, outline.half_v
            return Target(
                SQUARE, _point(element, face.centre), element.frame, a, b, 4.0 * a * b,
                math.hypot(a, b), side,
            )  # fmt: skip
        if isinstance(outline, Circular) and (hole is None or isinstance(hole, Circular)):
            a, b = outline.radius, 0.0 if hole is None else hole.radius
            area = math.pi * (a - b) * (a + b)
            return Target(RING, _point(element, face.centre), element.frame, a, b, area, a, side)
    low, high = element.local_box
    middle = tuple(0.5 * (x + y) for x, y in zip(low, high, strict=True))
    box = 0.5 * math.dist(low, high)
    if isinstance(face, Ball) or element.reach <= box:
        middle, box = (0.0, 0.0, 0.0), element.reach
    x, y, z = middle
    return Target(BALL, _point(element, (x, y, z)), frame("+z"), box, 0.0, 0.0, box)


def _point(element: Element, local: Vec3) -> Vec3:
    """Return a local point in world coordinates; the element's own position loses nothing."""
    x, y, z = element.position
    if local == (0.0, 0.0, 0.0):
        return (x, y, z)
    dx, dy, dz = (
        math.fsum(a * row[n] for a, row in zip(local, element.frame, strict=True)) for n in range(3)
    )
    return (x + dx, y + dy, z + dz)
