"""The faces that elements are made of, each in its element's local frame, in metres.

What follows from an element's shape (which elements touch, at what angles they meet, where planes
cut them, how they are drawn) is computed from its faces, whatever the element is. A face of a new
shape is a subclass of `Revolved` in the file of the element that has it.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.frames import Frame, Vec3, frame, to_local
from photizon_cl.scene.outlines import ring

if TYPE_CHECKING:
    from photizon_cl.scene.outlines import Line, Outline, Rows, Values

__all__ = ["Ball", "Face", "Plane", "Revolved", "Straight"]

_AS_IT_IS: Final = frame("+z")
_STEP: Final = 2.0**-14
"""Part of a profile over which its slope is taken."""


@dataclass(frozen=True, kw_only=True)
class Face:
    """A face of an element.

    Parameters
    ----------
    name : str
        As path tables and `photizon_cl.probe` give it; several faces may share one.
    sense : float
        1 where the element's normal points along a plane's own, away from the centre of a ball or
        away from the axis of a surface of revolution; else −1.
    """

    name: str
    sense: float = 1.0

    @abstractmethod
    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:
        """Say whether a local point lies on the face, see `Element.touches`."""

    def hidden(self, local: Vec3, radius: float, *, plus: bool, passed: bool) -> bool:
        """Say whether no straight line from within `radius` of a point meets one side of the face.

        False where that is not known.

        Parameters
        ----------
        local : tuple of float
            The point in local coordinates, in metres.
        radius : float
            Around it, in metres.
        plus : bool
            Whether the side is the one that the element's normal points to.
        passed : bool
            Whether lines go on behind the face; else they end where they meet it.
        """
        return False


@dataclass(frozen=True, kw_only=True)
class Plane(Face):
    """A part of a plane.

    Parameters
    ----------
    outline : Outline
        What bounds it.
    hole : Outline, optional
        What is cut out around the centre, along the same axes; its rim belongs to the face.
    centre : tuple of float
        In metres.
    frame : tuple of tuple of float
        Rows (u, v, normal), right-handed.
    """

    outline: Outline
    hole: Outline | None = None
    centre: Vec3 = (0.0, 0.0, 0.0)
    frame: Frame = _AS_IT_IS

    @property
    def empty(self) -> bool:
        """Whether the hole leaves nothing but its rim."""
        return self.hole is not None and self.hole == self.outline

    def within(self, local: Vec3) -> Vec3:
        """Return a local point in the face's own frame, from its centre."""
        x, y, z = (a - b for a, b in zip(local, self.centre, strict=True))
        return to_local(self.frame, (x, y, z))

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:  # noqa: D102
        x, y, z = self.within(local)
        outline, hole = self.outline, self.hole
        if abs(z) > slack or outline.from_core(x, y) > outline.rounding + reach + slack:
            return False
        return hole is None or not hole.holds(x, y, reach + slack)

    def hidden(self, local: Vec3, radius: float, *, plus: bool, passed: bool) -> bool:  # noqa: D102
        height = self.sense * self.within(local)[2]
        return height + radius <= 0.0 if plus else height - radius >= 0.0

    def points(self, plane: Line) -> Line:
        """Return points given by u and v, shape (k, 2), in local coordinates, shape (k, 3)."""
        (u, v, _), x, y = np.array(self.frame), plane[:, :1], plane[:, 1:]
        return np.asarray(np.array(self.centre) + (x * u + y * v))

    def sketch(self, rows: Rows) -> list[Line]:
        """Return lines that show it around its centre, for axes (3, 3) in the world."""
        return [part.sketch(rows) for part in (self.outline, self.hole) if part is not None]

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around its centre that holds it."""
        return self.outline.reach


@dataclass(frozen=True, kw_only=True)
class Revolved(Face):
    """A surface of revolution about the local axis; subclasses give its profile."""

    @abstractmethod
    def profile(self, s: Values) -> tuple[Values, Values]:
        """Return radius and height in metres, each shape (k,), at k places along the profile.

        Places are numbers from 0 to 1, which are the rims. The height goes up or down all the way.
        """

    @property
    def ball(self) -> Ball | None:
        """The ball that it is a part of, whose sense is its own; None where it is of none."""
        return None

    @property
    def osculating(self) -> Ball | None:
        """The ball by which it touches things: its own, or the one that fits it at its vertex."""
        return self.ball

    def place_at(self, height: float) -> float:
        """Return the place of the profile at a height; the nearer end beyond either."""
        ends = self.profile(np.array([0.0, 1.0]))[1]
        rising = bool(ends[0] <= ends[1])
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            below = bool(self.profile(np.array([middle]))[1][0] < height)
            low, high = (middle, high) if below == rising else (low, middle)
        return low if low == 0.0 else high

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:  # noqa: D102
        x, y, z = local
        heights = self.profile(np.array([0.0, 1.0]))[1]
        if not heights.min() - slack <= z <= heights.max() + slack:
            return False
        return self.apart(math.hypot(x, y), z) <= slack

    def apart(self, radius: float, height: float) -> float:
        """Return the distance in metres of a circle about the axis from the face.

        To first order, and that of its nearer end for a height beyond either.
        """
        place = self.place_at(height)
        return abs(float(self.profile(np.array([place]))[0][0]) - radius) * self._sine(place)

    def sine_at(self, radius: float, height: float, room: float) -> float:
        """Return the sine of the angle between the face and the plane of a circle that lies on it.

        `room` is the distance in metres that counts as none.
        """
        return self._sine(self.place_at(height))

    def _sine(self, place: float) -> float:
        """Return the sine of the angle between the profile and the plane across the axis."""
        ends = np.array([max(place - _STEP, 0.0), min(place + _STEP, 1.0)])
        radius, height = (float(np.diff(x)[0]) for x in self.profile(ends))
        return abs(height) / (math.hypot(radius, height) or 1.0)

    def rim_sine(self, centre: Vec3, normal: Vec3, radius: float, room: float) -> float | None:
        """Return at what angle a plane meets the face in a circle.

        Parameters
        ----------
        centre, normal : tuple of float
            Of the circle, in local coordinates; the normal has unit length.
        radius : float
            Of the circle, in metres.
        room : float
            Distance in metres that counts as none.

        Returns
        -------
        float or None
            The sine of the angle between the plane and the face, where the circle lies on it.
        """
        across = math.hypot(normal[0], normal[1])
        if math.hypot(centre[0], centre[1]) > room or across * radius > room:
            return None
        heights = self.profile(np.array([0.0, 1.0]))[1]
        if not heights.min() - room <= centre[2] <= heights.max() + room:
            return None
        if self.apart(radius, centre[2]) > room:
            return None
        return self.sine_at(radius, centre[2], room)


@dataclass(frozen=True, kw_only=True)
class Straight(Revolved):
    """A surface of revolution with a straight profile from height 0 up.

    Parameters
    ----------
    radii : tuple of float
        At its lower and at its upper end, in metres.
    length : float
        Along the axis, in metres.
    """

    radii: tuple[float, float]
    length: float

    def profile(self, s: Values) -> tuple[Values, Values]:  # noqa: D102
        low, high = self.radii
        # not low + s (high − low), which loses a narrow end beside a wide one
        return low * (1.0 - s) + high * s, s * self.length


@dataclass(frozen=True, kw_only=True)
class Ball(Revolved):
    """A ball, or its zone between two polar angles.

    By angles, not by heights: of a shallow cap those would be lost to cancellation.

    Parameters
    ----------
    radius : float
        In metres.
    height : float
        Of its centre along the local axis, in metres.
    polar : tuple of float
        First and last angle in radians from the pole.
    pole : float
        1 where that points along the local axis, else −1.
    """

    radius: float
    height: float = 0.0
    polar: tuple[float, float] = (0.0, math.pi)
    pole: float = 1.0

    @property
    def ball(self) -> Ball:  # noqa: D102
        return self

    @property
    def whole(self) -> bool:
        """Whether it is all of the ball."""
        return self.polar == (0.0, math.pi)

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around the local origin that holds it."""
        return abs(self.height) + self.radius

    @cached_property
    def _cosines(self) -> tuple[float, float]:
        return math.cos(self.polar[1]), math.cos(self.polar[0])

    def profile(self, s: Values) -> tuple[Values, Values]:  # noqa: D102
        first, last = self.polar
        theta = first + s * (last - first)
        # sin π is not 0 in floating point; a radius is never negative
        radius = np.abs(self.radius * np.sin(theta))
        return radius, self.height + self.pole * (self.radius * np.cos(theta))

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:  # noqa: D102
        x, y, z = local[0], local[1], local[2] - self.height
        low, high = (self.radius * c for c in self._cosines)
        near = abs(math.hypot(x, y, z) - self.radius) <= slack
        return near and low - slack <= self.pole * z <= high + slack

    def holds(self, local: Vec3, radius: float = 0.0) -> bool:
        """Say whether all within `radius` of a local point is inside the ball."""
        centre = math.hypot(local[0], local[1], local[2] - self.height)
        return centre + radius < self.radius

    def hidden(self, local: Vec3, radius: float, *, plus: bool, passed: bool) -> bool:  # noqa: D102
        if not self.whole:
            return False
        if plus == (self.sense > 0.0):
            return self.holds(local, radius)  # a line that leaves a ball does not come back
        if passed:
            return False  # one that goes in meets the inside where it leaves
        return math.hypot(local[0], local[1], local[2] - self.height) - radius > self.radius

    def sine_at(self, radius: float, height: float, room: float) -> float:  # noqa: D102
        # at the pole the face leaves a plane across by `room` only after a distance
        return min(max(radius, math.sqrt(room) * math.sqrt(self.radius)) / self.radius, 1.0)

    def rim_sine(self, centre: Vec3, normal: Vec3, radius: float, room: float) -> float | None:  # noqa: D102
        offset = (centre[0], centre[1], centre[2] - self.height)
        height = sum(a * b for a, b in zip(offset, normal, strict=True))
        aside = math.hypot(*(a - height * b for a, b in zip(offset, normal, strict=True)))
        if aside > room or abs(math.hypot(height, radius) - self.radius) > room:
            return None
        return self.sine_at(radius, height, room)

    def sketch(self, rows: Rows) -> list[Line]:
        """Return lines that show it around its centre, for axes (3, 3) in the world."""
        u, v, w = rows
        return [ring(self.radius, a, b) for a, b in ((u, v), (v, w), (w, u))]
