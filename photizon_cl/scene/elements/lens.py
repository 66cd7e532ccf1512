"""What lenses share: caps of balls that meet a plane in a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.elements.base import Element
from photizon_cl.scene.faces import Ball
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class CappedLens(Element):
    """A solid bounded by caps; its surface is one property, its normals point out of the glass."""

    row: ClassVar[Row] = Row(
        "SOLID",
        ("rim", "m", "radius a of the rim"),
        ("depth", "m", "of the (front) ball's centre behind the rim's plane, h = sqrt(R² − a²)"),
        ("inverse", "1/m", "1/R of the (front) ball"),
        ("rim_square", "m²", "a²"),
        ("near", "m", "rounding bound of a coordinate, absolute"),
        ("radius", "m", "R of the (front) ball"),
        ("relative", "", "rounding bound of a coordinate, relative to its size"),
    )
    libraries: ClassVar[tuple[str, ...]] = ("lib/cap",)
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "outside"
    faces_at_a_point: ClassVar[int] = 2
    radii: ClassVar[tuple[str, ...]] = ()
    """Names of its parameters that are radii of curvature."""

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that the aperture fits the balls."""
        problems = super().cross_check(known)
        aperture = known.get("aperture_radius")
        for name in cls.radii:
            radius: Any = known.get(name)
            if aperture is not None and radius is not None and aperture > radius:
                problems.append(
                    Problem(
                        "aperture_radius",
                        show(aperture),
                        f"at most {name}, {show(radius)}",
                        hint="a cap cannot be wider than its ball; equal makes a hemisphere",
                    )
                )
        return problems


@lru_cache(maxsize=1 << 16)
def centre_depth(radius: float, aperture: float) -> float:
    """Return sqrt(R² − a²) in metres, the distance of the ball's centre from the rim's plane.

    Correctly rounded up to the square root's own rounding: the difference is taken exactly.
    """
    square = Fraction(radius) ** 2 - Fraction(aperture) ** 2
    return math.sqrt(square)


def sag(radius: float, aperture: float) -> float:
    """Return the height of the cap in metres, R − sqrt(R² − a²), without cancellation."""
    return aperture * (aperture / (radius + centre_depth(radius, aperture)))


def cap_area(radius: float, aperture: float) -> float:
    """Return the area of the cap in m², π(a² + sag²): 2πR·sag, where that may vanish."""
    high = sag(radius, aperture)
    return math.pi * (aperture * aperture + high * high)


def cap(name: str, radius: float, aperture: float, sign: float) -> Ball:
    """Return the cap on one side of the rim's plane as a face, convex outwards."""
    depth = centre_depth(radius, aperture)
    return Ball(
        name=name,
        radius=radius,
        height=-sign * depth,
        polar=(0.0, math.atan2(aperture, depth)),
        pole=sign,
    )


def on_cap(local: Vec3, radius: float, aperture: float, sign: float, slack: float) -> bool:
    """Say whether a local point lies on the cap on one side of the rim's plane.

    From the rim, so that a ball of whatever size around a small lens loses nothing.
    """
    x, y, z = local[0], local[1], sign * local[2]
    if z < -slack:
        return False
    depth = centre_depth(radius, aperture)
    off = x * x + y * y + z * z + 2.0 * depth * z - aperture * aperture
    return abs(off) <= 2.0 * radius * slack


def cap_columns(radius: float, aperture: float, centre: Vec3, roundoff: float) -> dict[str, float]:
    """Return the columns of a lens's row for a cap, or for the front one."""
    return {
        "rim": aperture,
        "depth": centre_depth(radius, aperture),
        "inverse": 1.0 / radius,
        "rim_square": aperture * aperture,
        "near": 4.0 * roundoff * max(map(abs, centre)),
        "radius": radius,
        "relative": 4.0 * roundoff,
    }
