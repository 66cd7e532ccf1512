"""Exact areas of the bins of a map on an annulus.

A bin that only the inner circle crosses is summed up outside of it. In one that both circles cross
the ring is summed up by angle from the centre: between the circles a piece is half its angle times
(R − r)(R + r). So no area is the difference of nearly equal ones, however narrow the ring.
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["less_sine", "ring_areas"]

_ROUNDING: Final = 8.0 * 2.0**-53
"""Of the ratio of the radii and of a corner's distance, relative to them."""

Bin = tuple[float, float, float, float]


def ring_areas(
    x0: NDArray[np.float64],
    x1: NDArray[np.float64],
    y0: NDArray[np.float64],
    y1: NDArray[np.float64],
    radius: float,
    inner: float,
) -> NDArray[np.float64]:
    """Return the areas of bins of a quadrant within a ring.

    Parameters
    ----------
    x0, x1, y0, y1 : ndarray, shape (n,), float64
        Edges of bins that begin within the inner circle, in units of the outer radius, 0 to 1.
    radius, inner : float
        Radii in metres, 0 < inner < radius.

    Returns
    -------
    ndarray, shape (n,), float64
        In units of the outer radius squared; 0 for bins wholly within the inner circle.
    """
    ratio = Fraction(inner) / Fraction(radius)
    # each from the exact ratio: neither follows from the other where it is far less than 1
    r, width = float(ratio), float(1 - ratio)
    far = np.hypot(x1, y1)
    areas = _outside(x0, x1, y0, y1, r)
    areas[far <= r * (1.0 + _ROUNDING)] = 0.0
    for k in np.flatnonzero(far > 1.0).tolist():
        areas[k] = _between((float(x0[k]), float(x1[k]), float(y0[k]), float(y1[k])), r, width)
    return areas


def _outside(
    x0: NDArray[np.float64],
    x1: NDArray[np.float64],
    y0: NDArray[np.float64],
    y1: NDArray[np.float64],
    r: float,
) -> NDArray[np.float64]:
    """Return the areas of [x0, x1] × [y0, y1] outside a circle: over its chord, less the bulge."""

    def height(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sqrt(np.maximum((r - x) * (r + x), 0.0))

    a = np.clip(height(y1), x0, x1)  # up to here the arc lies above the bin
    b = np.maximum(np.clip(height(y0), x0, x1), a)  # and from here on below it
    ya, yb = np.clip(height(a), y0, y1), np.clip(height(b), y0, y1)
    over = (b - a) * 0.5 * ((y1 - ya) + (y1 - yb))
    # a circle that is lost beside the bins, or whose radius is no double, has no bulge
    chord = 0.5 * np.hypot(b - a, yb - ya)
    half = np.minimum(np.divide(chord, r, out=np.zeros_like(chord), where=chord > 0.0), 1.0)
    bulge = 0.5 * r * r * less_sine(2.0 * np.arcsin(half))
    return np.asarray((x1 - b) * (y1 - y0) + np.maximum(over - bulge, 0.0))


def _between(edges: Bin, r: float, width: float) -> float:
    """Return the area of a bin between the circles of radius r = 1 − width and 1."""
    x0, x1, y0, y1 = edges
    low, high = math.atan2(y0, x1), math.atan2(y1, x0)
    turns = {low, high, math.atan2(y0, x0), math.atan2(y1, x1)}
    for circle in (r, 1.0):
        turns |= {math.acos(x / circle) for x in (x0, x1) if x < circle}
        turns |= {math.asin(y / circle) for y in (y0, y1) if y < circle}
    total = 0.0
    for a, b in pairwise(sorted(t for t in turns if low <= t <= high)):
        total += _piece(edges, a, b, r, width)
    return total


def _piece(edges: Bin, a: float, b: float, r: float, width: float) -> float:
    """Return the area between two angles, between which no other circle or edge begins."""
    x0, x1, y0, y1 = edges
    angle = b - a
    middle = 0.5 * (a + b)
    sine, less = math.sin(angle), float(less_sine(np.asarray(angle)))

    def reach(x: float, y: float, along: float) -> tuple[float, float]:
        """Return the distances of two edges along an angle."""
        c, s = math.cos(along), math.sin(along)
        return (x / c if c > 0.0 else math.inf), (y / s if s > 0.0 else math.inf)

    outer, inner = reach(x1, y1, middle), reach(x0, y0, middle)
    o = outer.index(min(outer))
    i = inner.index(max(x for x in inner if x < math.inf))
    ends, begins = min(outer[o], 1.0), max(inner[i], r)
    if ends <= begins:
        return 0.0
    out_a, out_b = (min(max(reach(x1, y1, t)[o], r), 1.0) for t in (a, b))
    in_a, in_b = (min(max(reach(x0, y0, t)[i], r), 1.0) for t in (a, b))
    if outer[o] >= 1.0 and inner[i] <= r:
        return 0.5 * width * (1.0 + r) * angle
    if outer[o] >= 1.0:
        return 0.5 * (less + sine * ((1.0 - in_a) + in_a * (1.0 - in_b)))
    if inner[i] <= r:
        return 0.5 * (sine * ((out_a - r) * out_b + r * (out_b - r)) - r * r * less)
    return 0.5 * sine * (out_a * out_b - in_a * in_b)


def less_sine(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return angle − sin(angle) for 0 ≤ angle ≤ π/2 without cancellation."""
    square = angle * angle
    series = np.ones_like(angle)
    for k in (17, 15, 13, 11, 9, 7, 5):
        series = 1.0 - square / ((k - 1) * k) * series
    small = angle * square / 6.0 * series
    return np.where(angle < 1.0, small, angle - np.sin(angle))
