"""Where a scene stands in the device's coordinates: near their origin, where numbers are finest."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.model import Scene

__all__ = ["bounded", "moved", "recentre", "recentred"]


def recentre(scene: Scene) -> tuple[float, float, float]:
    """Return the shift that brings a far scene near the origin, zero for one that is near.

    A whole multiple of four times the scene's size, rounded to a power of two: positions lose
    nothing by the subtraction, and a scene around the origin is not touched.
    """
    boxes = [(e.position, e.reach) for e in scene.element]
    boxes += [(s.position, s.reach) for s in scene.source]
    low = np.min([np.subtract(p, r) for p, r in boxes], axis=0)
    high = np.max([np.add(p, r) for p, r in boxes], axis=0)
    size = float(np.max(high - low))
    if not size > 0.0:
        return (0.0, 0.0, 0.0)
    step = math.ldexp(4.0, math.frexp(size)[1])
    x, y, z = (float(np.rint(c / step)) * step for c in (low + high) / 2)
    return (x, y, z)


def moved(position: Sequence[float], shift: Vec3) -> Vec3:
    """Return a position in the device's coordinates."""
    return (position[0] - shift[0], position[1] - shift[1], position[2] - shift[2])


def bounded(position: Sequence[float], shift: Vec3, roundoff: float) -> Vec3:
    """Return the size of each coordinate of a position that its rounding follows, in metres.

    Two elements that share an edge agree on it only to the rounding of the positions that they were
    given, in doubles, however near the recentred scene is; and to that of the kernels' coordinates.
    """
    coarser = ROUNDOFF / roundoff
    x, y, z = (
        max(abs(c), abs(q) * coarser) for c, q in zip(moved(position, shift), position, strict=True)
    )
    return (x, y, z)


def recentred(scene: Scene, shift: Vec3, roundoff: float) -> Scene:
    """Return the scene in which elements touch or not, to the rounding of the kernels' coordinates.

    In double precision that is the scene as it was given, whose positions are as coarse.
    """
    if roundoff == ROUNDOFF or shift == (0.0, 0.0, 0.0):
        return scene
    return dataclasses.replace(
        scene,
        source=tuple(
            dataclasses.replace(s, position=moved(s.position, shift)) for s in scene.source
        ),
        element=tuple(
            dataclasses.replace(e, position=moved(e.position, shift)) for e in scene.element
        ),
    )
