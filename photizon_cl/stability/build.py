"""Small helpers that the case families share."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.scene.frames import frame
from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.stability.case import Case, Left, Triple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.elements import Element

__all__ = [
    "SCALES",
    "TILT",
    "above",
    "aimed",
    "below",
    "black",
    "in_world",
    "nudge",
    "turned",
    "unit",
]

SCALES: Final = (1e-9, 1e-3, 1.0, 1e4, 1e9)
"""Sizes in metres."""
TILT: Final = (33.3, -71.7)
"""A tilt of no special angle, in degrees."""


def black(
    kind: type[Any],
    scale: float = 1.0,
    *,
    tilt: tuple[float, float] = (0.0, 0.0),
    at: Sequence[float] = (0.0, 0.0, 0.0),
    axis: str = "+z",
    name: str = "one",
    **sizes: float,
) -> Element:
    """Return a black element whose lengths are multiplied by a scale."""
    lengths = {
        key: value
        if key.endswith(("_deg", "fraction", "baffles", "constant", "conic"))
        else value * scale
        for key, value in sizes.items()
    }
    x, y, z = (float(c) * scale for c in at)
    made: Element = kind(
        name=name, position=(x, y, z), axis=axis, tilt_deg=tilt, surface=Absorber(), **lengths
    )
    return made


def unit(v: Sequence[float]) -> Triple:
    """Return a vector of unit length up to rounding."""
    length = math.sqrt(math.fsum(x * x for x in v))
    x, y, z = (float(c) / length for c in v)
    return (x, y, z)


def in_world(element: Element, v: Sequence[float], *, point: bool = False) -> Triple:
    """Return a local vector, or a local point, in world coordinates, rounded."""
    rows = frame(element.axis, element.tilt_deg)
    moved = [math.fsum(v[i] * rows[i][k] for i in range(3)) for k in range(3)]
    if point:
        moved = [m + c for m, c in zip(moved, element.position, strict=True)]
    x, y, z = moved
    return (x, y, z)


def aimed(
    label: str,
    elements: tuple[Element, ...],
    start: Sequence[float],
    end: Sequence[float],
    *,
    left: Left | None = None,
    must_hit: bool = False,
) -> Case:
    """Return the case of a ray from one local point towards another, of the first element."""
    a = in_world(elements[0], start, point=True)
    d = np.subtract(in_world(elements[0], end, point=True), a)
    return Case(label, elements, a, unit(d.tolist()), left, must_hit)


def turned(
    label: str,
    elements: tuple[Element, ...],
    start: Sequence[float],
    along: Sequence[float],
    *,
    left: Left | None = None,
    must_hit: bool = False,
) -> Case:
    """Return the case of a ray from a local point in a local direction, of the first element."""
    a = in_world(elements[0], start, point=True)
    return Case(label, elements, a, unit(in_world(elements[0], along)), left, must_hit)


def nudge(x: float, n: int) -> float:
    """Return the double n places after x (before it where n < 0)."""
    for _ in range(abs(n)):
        x = math.nextafter(x, math.copysign(math.inf, n))
    return x


def above(x: float) -> float:
    """Return the next double."""
    return nudge(x, 1)


def below(x: float) -> float:
    """Return the double before."""
    return nudge(x, -1)
