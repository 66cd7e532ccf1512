"""The wall of a cone."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.elements.revolved import RevolvedWall
from photizon_cl.scene.faces import Straight
from photizon_cl.scene.parameters import LARGEST, about
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face

_RADIUS = "a radius from 0 to 1e150 in metres"
_LONG = 0.5
"""Ratio of the radii below which a ray's meeting at one end says little of the other."""


@dataclass(frozen=True, kw_only=True)
class Cone(RevolvedWall):
    """The wall of a frustum, open at both ends: sqrt(u² + v²) = r₀ + (r₁ − r₀) w/L, 0 ≤ w ≤ L.

    `position` is the centre of the entrance and `axis` points from the entrance to the exit. The
    rims belong to the wall, whose normals point away from the axis. One of the radii may be 0; the
    apex has no normal, and a ray through it may hit or miss. A ray along a straight line of the
    wall does not hit it.

    Parameters
    ----------
    entrance_radius : float
        r₀ in metres.
    exit_radius : float
        r₁ in metres.
    length : float
        L along the axis in metres.
    """

    kind: ClassVar[str] = "cone"
    kernel: ClassVar[str] = "cone"
    does: ClassVar[str] = "wall of a cone hit"
    costs: ClassVar[str] = "one square root and up to two roots an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "lib/revolved", "elements/cone")
    traits: ClassVar[frozenset[str]] = frozenset({"polished", "pointed"})
    row: ClassVar[Row] = Row(
        "CONE",
        ("foot", "m", "radius r0 at the entrance"),
        ("slope", "", "growth k of the radius along the axis"),
        ("cosine", "", "1/sqrt(1 + k²)"),
        ("narrow", "m", "the smaller radius"),
        ("wide", "m", "the larger radius"),
        ("polishes", "", "whether roots are polished, 0 or 1"),
        base=RevolvedWall.row,
    )

    entrance_radius: float = field(metadata=number(_RADIUS, 0.0, LARGEST, "entrance radius", "m"))
    exit_radius: float = field(metadata=number(_RADIUS, 0.0, LARGEST, "exit radius", "m"))
    length: float = field(metadata=positive_length("length"))

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Refuse a cone without any width."""
        problems = super().cross_check(known)
        if known.get("entrance_radius") == 0.0 and known.get("exit_radius") == 0.0:
            hint = "with both radii 0 nothing is left of the cone; one of them may be"
            problems.append(Problem("exit_radius", show(0.0), "a positive radius", hint=hint))
        radii = known.get("entrance_radius"), known.get("exit_radius")
        length = known.get("length")
        if None not in radii and length is not None:
            # what a ray's meeting is found from is as large as the slope times the radius
            least = abs(Fraction(radii[1]) - Fraction(radii[0])) * max(map(Fraction, radii))
            least /= Fraction(LARGEST)
            if Fraction(length) < least:
                hint = "so flat a cone leaves the range of doubles; take a disk, with a hole"
                wanted = f"at least |r1 - r0| max(r0, r1)/{LARGEST:g} m, {about(least)}"
                problems.append(Problem("length", show(length), wanted, hint=hint))
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why its surface cannot refract."""
        return "a cone is a wall, not a solid with an inside of glass; take a wall's surface"

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its wall."""
        radii = (self.entrance_radius, self.exit_radius)
        return (Straight(name="wall", radii=radii, length=self.length),)

    @property
    def heights(self) -> tuple[float, float]:
        """Heights of the entrance and of the exit in metres."""
        return (0.0, self.length)

    @property
    def widest(self) -> float:
        """The larger radius in metres."""
        return max(self.entrance_radius, self.exit_radius)

    @property
    def slope(self) -> float:
        """Growth of the radius along the axis, (r₁ − r₀)/L."""
        return float(
            (Fraction(self.exit_radius) - Fraction(self.entrance_radius)) / Fraction(self.length)
        )

    @property
    def shape(self) -> dict[str, float]:
        """Radii and slope."""
        narrow, wide = sorted((self.entrance_radius, self.exit_radius))
        return {
            "foot": self.entrance_radius,
            "slope": self.slope,
            "cosine": 1.0 / math.hypot(1.0, self.slope),
            "narrow": narrow,
            "wide": wide,
            "polishes": float(narrow < _LONG * wide),
        }

    @property
    def slant(self) -> float:
        """Length of the wall from rim to rim in metres."""
        return math.hypot(self.length, self.exit_radius - self.entrance_radius)

    @property
    def area(self) -> float:
        """Area of one side in m², π(r₀ + r₁) times the slant."""
        return math.pi * (self.entrance_radius + self.exit_radius) * self.slant

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the half-angle and the wall's area."""
        return {
            "half-angle": (math.degrees(math.atan(abs(self.slope))), "deg"),
            "wall area": (self.area, "m²"),
        }
