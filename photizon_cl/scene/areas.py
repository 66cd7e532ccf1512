"""Exact areas of the bins of irradiance maps.

No formula here subtracts nearly equal areas, so each bin keeps its accuracy however fine the map.
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.ring_areas import less_sine, ring_areas

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["circle_areas", "even_areas", "zone_areas"]

_AT_ONCE: Final = 1 << 20
"""Bins whose areas are computed together: it takes ten arrays on the way."""
_RIM: Final = 4.0 * 2.0**-53
"""Rounding of the cosine of a port's rim, 1 − 2f, of numbers about 1."""


def even_areas(half_width: float, half_height: float, nx: int, ny: int) -> NDArray[np.float64]:
    """Return the areas of nx × ny equal bins of a rectangle, shape (ny, nx), in m²."""
    return _spread(np.array([[(2.0 * half_width / nx) * (2.0 * half_height / ny)]]), nx, ny)


def _spread(areas: NDArray[np.float64], nx: int, ny: int) -> NDArray[np.float64]:
    """Return areas that are equal along rows, or everywhere, as a view of all bins."""
    return np.broadcast_to(areas, (ny, nx))


def zone_areas(radius: float, port_fraction: float, nx: int, ny: int) -> NDArray[np.float64]:
    """Return the areas of bins uniform in φ and cos θ outside the port, shape (ny, nx), in m².

    A zone's area is proportional to its height (Archimedes); the port is cos θ > 1 − 2f.
    """
    rim = 1 - 2 * Fraction(port_fraction)
    edges = [Fraction(2 * j - ny, ny) for j in range(ny + 1)]
    heights = [float(min(b, rim) - a) for a, b in pairwise(edges)]
    # 0.3 is not quite three tenths in binary: what the rounding of the rim leaves of a zone is none
    # except of the first, in which all of a wall may be
    heights[1:] = [h if h > _RIM else 0.0 for h in heights[1:]]
    rows = np.array(heights) * (2.0 * math.pi / nx * radius * radius)
    return _spread(rows[:, np.newaxis], nx, ny)


def circle_areas(radius: float, nx: int, ny: int, inner: float = 0.0) -> NDArray[np.float64]:
    """Return the area that each bin of the bounding square shares with a disk or annulus.

    Returns
    -------
    ndarray, shape (ny, nx), float64
        Square metres; the sum is π(R² − r²).
    """
    # By symmetry every bin is one or two (an odd middle one: two mirrored halves) bins of a
    # quadrant of the unit disk.
    columns, rows = _folded(nx), _folded(ny)
    areas = np.empty((ny, nx))
    slab = max(_AT_ONCE // nx, 1)
    for first in range(0, ny, slab):
        some = slice(first, first + slab)
        y0, y1, my = (ends[some] for ends in rows)
        areas[some] = _slab_areas(radius, inner, columns, (y0, y1, my), nx, ny)
    return areas


_Folded = tuple["NDArray[np.float64]", "NDArray[np.float64]", "NDArray[np.float64]"]


def _slab_areas(
    radius: float, inner: float, columns: _Folded, rows: _Folded, nx: int, ny: int
) -> NDArray[np.float64]:
    """Return the areas of some rows of bins, see `circle_areas`."""
    x0, x1, mx = columns
    y0, y1, my = rows
    quadrant = _quadrant_areas(x0[np.newaxis], x1[np.newaxis], y0[:, np.newaxis], y1[:, np.newaxis])
    times, unit = mx[np.newaxis] * my[:, np.newaxis], radius * radius
    # Which bins lie wholly outside or inside is decided in integers, since a corner may stand
    # exactly on the circle; whole bins are equal.
    quadrant[_corners(x0, y0, nx, ny) >= (nx * ny) ** 2] = 0.0
    areas: NDArray[np.float64] = quadrant * (times * unit)
    full = _corners(x1, y1, nx, ny) <= (nx * ny) ** 2
    areas[full] = (2.0 * radius / nx) * (2.0 * radius / ny)
    if inner:
        j, i = np.nonzero(np.hypot(x0, y0[:, np.newaxis]) * radius < inner)
        ring = ring_areas(x0[i], x1[i], y0[j], y1[j], radius, inner)
        areas[j, i] = ring * (times * unit)[j, i]
    return areas


def _corners(x: NDArray[np.float64], y: NDArray[np.float64], nx: int, ny: int) -> NDArray[np.int64]:
    """Return (nx·ny)² times the squared distances of corners from the centre, exactly."""
    i, j = np.rint(x * nx).astype(np.int64) * ny, np.rint(y * ny).astype(np.int64) * nx
    return np.asarray(i[np.newaxis] ** 2 + j[:, np.newaxis] ** 2, dtype=np.int64)


def _folded(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return inner edge, outer edge and multiplicity of n bins over [−1, 1], folded onto [0, 1]."""
    k = np.arange(n + 1)
    edges = np.abs(2 * k - n) / n
    inner, outer = np.minimum(edges[:-1], edges[1:]), np.maximum(edges[:-1], edges[1:])
    times = np.ones(n)
    if n % 2:
        inner[n // 2], times[n // 2] = 0.0, 2.0
    return inner, outer, times


def _quadrant_areas(
    x0: NDArray[np.float64],
    x1: NDArray[np.float64],
    y0: NDArray[np.float64],
    y1: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the areas of [x0, x1] × [y0, y1] within the unit disk, 0 ≤ x0 < x1 ≤ 1, same for y.

    A full strip where the arc lies above the bin, then a trapezoid under the arc's chord, then the
    segment between chord and arc.
    """
    left = np.clip(_height(y1), x0, x1)  # up to here the arc lies above the bin
    right = np.clip(_height(y0), x0, x1)  # and from here on below it
    a, b = np.minimum(left, right), right
    ya, yb = np.clip(_height(a), y0, y1), np.clip(_height(b), y0, y1)
    strip = (a - x0) * (y1 - y0)
    trapezoid = (b - a) * 0.5 * ((ya - y0) + (yb - y0))
    angle = 2.0 * np.arcsin(np.minimum(0.5 * np.hypot(b - a, yb - ya), 1.0))
    return strip + trapezoid + 0.5 * less_sine(angle)


def _height(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return sqrt(1 − x²)."""
    return np.asarray(np.sqrt((1.0 - x) * (1.0 + x)), dtype=np.float64)
