"""Outlines of plane faces, each in its plane around its centre, in metres."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Line = NDArray[np.float64]
    """Points of a polyline in metres, shape (k, 2) in a plane or (k, 3)."""
    Values = NDArray[np.float64]
    """A number for each of k places, shape (k,)."""
    Rows = NDArray[np.float64]
    """Axes of a drawing, shape (3, 3), or one of them, shape (3,)."""

__all__ = ["Circular", "Outline", "Rectangular", "ring"]

_TURN: Final = np.linspace(0.0, 2.0 * np.pi, 181)
_SKETCH: Final = np.linspace(0.0, 2.0 * np.pi, 91)


class Outline:
    """The outline of a plane face: what is within `rounding` of a rectangle around its centre."""

    @property
    @abstractmethod
    def core(self) -> tuple[float, float]:
        """Half sizes of that rectangle along u and v in metres."""

    @property
    @abstractmethod
    def rounding(self) -> float:
        """Metres around it."""

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Half extents along u and v in metres."""
        (u, v), around = self.core, self.rounding
        return (u + around, v + around)

    @property
    def reach(self) -> float:
        """Distance of the farthest point from the centre in metres."""
        return math.hypot(*self.core) + self.rounding

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Corners of that rectangle."""
        u, v = self.core
        return ((-u, -v), (-u, v), (u, -v), (u, v)) if u or v else ((0.0, 0.0),)

    def from_core(self, x: float, y: float) -> float:
        """Return the distance in metres of a point of the plane from that rectangle."""
        u, v = self.core
        return math.hypot(max(abs(x) - u, 0.0), max(abs(y) - v, 0.0))

    @abstractmethod
    def holds(self, x: float, y: float, around: float = 0.0, grown: float = 1.0) -> bool:
        """Say whether all within `around` metres of a point is within the outline times `grown`."""

    @abstractmethod
    def rim(self) -> Line:
        """Return the outline as a closed polyline, shape (k, 2), a corner twice."""

    @abstractmethod
    def towards(self, angles: Values) -> Line:
        """Return its points in some directions from the centre, in radians, shape (k, 2)."""

    @abstractmethod
    def sketch(self, rows: Rows) -> Line:
        """Return a polyline for small drawings around the centre, shape (k, 3), of axes (3, 3)."""


@dataclass(frozen=True)
class Rectangular(Outline):
    """A rectangle: |u| ≤ half_u, |v| ≤ half_v, in metres."""

    half_u: float
    half_v: float

    @property
    def core(self) -> tuple[float, float]:  # noqa: D102
        return (self.half_u, self.half_v)

    @property
    def rounding(self) -> float:  # noqa: D102
        return 0.0

    def holds(self, x: float, y: float, around: float = 0.0, grown: float = 1.0) -> bool:  # noqa: D102
        return abs(x) + around <= self.half_u * grown and abs(y) + around <= self.half_v * grown

    def rim(self) -> Line:  # noqa: D102
        corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)]
        return np.array([(self.half_u * a, self.half_v * b) for a, b in corners])

    def towards(self, angles: Values) -> Line:  # noqa: D102
        along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        with np.errstate(divide="ignore"):
            steps = np.array(self.core) / np.abs(along)
        return np.asarray(along * steps.min(axis=1, keepdims=True))

    def sketch(self, rows: Rows) -> Line:  # noqa: D102
        return np.asarray(self.rim() @ rows[:2])


@dataclass(frozen=True)
class Circular(Outline):
    """A circle of a radius in metres."""

    radius: float

    @property
    def core(self) -> tuple[float, float]:  # noqa: D102
        return (0.0, 0.0)

    @property
    def rounding(self) -> float:  # noqa: D102
        return self.radius

    def holds(self, x: float, y: float, around: float = 0.0, grown: float = 1.0) -> bool:  # noqa: D102
        return math.hypot(x, y) + around <= self.radius * grown

    def rim(self) -> Line:  # noqa: D102
        points = self.towards(_TURN)
        points[-1] = points[0]  # sin 2π is not 0: a plane through both would cross the rim once
        return points

    def towards(self, angles: Values) -> Line:  # noqa: D102
        return np.stack([self.radius * np.cos(angles), self.radius * np.sin(angles)], axis=1)

    def sketch(self, rows: Rows) -> Line:  # noqa: D102
        return ring(self.radius, rows[0], rows[1])


def ring(radius: float, a: Rows, b: Rows) -> Line:
    """Return a circle around the origin along two axes, a polyline for small drawings."""
    return np.asarray(radius * (np.outer(np.cos(_SKETCH), a) + np.outer(np.sin(_SKETCH), b)))
