"""A face of a lens: its curvature, its sag and where it stands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.elements.placed import Placed
from photizon_cl.scene.elements.sheets import Sheet, sheet_area, sheet_sag
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.outlines import Circular

if TYPE_CHECKING:
    from photizon_cl.scene.faces import Face

__all__ = ["LensFace", "thinnest"]


@dataclass(frozen=True)
class LensFace:
    """One of the two faces of a lens, seen along its own outward direction.

    Parameters
    ----------
    radius : float
        Radius of curvature at the vertex in metres: positive where the face is convex, negative
        where it is concave, infinite where it is flat.
    constant : float
        Conic constant.
    aperture : float
        Radius of the rim in metres.
    """

    radius: float
    constant: float
    aperture: float

    @property
    def flat(self) -> bool:
        """Whether it is a plane."""
        return math.isinf(self.radius)

    @property
    def curvature(self) -> float:
        """1/R in 1/m, 0 of a plane."""
        return 1.0 / self.radius

    @property
    def kappa(self) -> float:
        """1 + conic constant."""
        return 1.0 + self.constant

    @cached_property
    def sag(self) -> Fraction:
        """Height of the vertex over the rim's plane in metres, negative where it is concave.

        But for the rounding of one square root it is exact.
        """
        return self.sag_at(self.aperture)

    def sag_at(self, r: float) -> Fraction:
        """Return how far it falls from the vertex to a distance r from the axis, in metres."""
        if self.flat:
            return Fraction(0)
        fall = sheet_sag(abs(self.radius), self.constant, r)
        return fall if self.radius > 0.0 else -fall

    @property
    def polishes(self) -> bool:
        """Whether it is long or flat: then its function at one end says little of the other."""
        return abs(self.kappa) > 2.0 or float(abs(self.sag)) > 4.0 * abs(self.radius)

    def reach(self, vertex: float) -> float:
        """Return the distance of its farthest point, but for its rim, from the lens's centre.

        With κ = 1 + k > 1 the meridian r² = w(2R − κw) bulges: r² + (v ∓ w)² is greatest at
        w = (R ∓ v)/(κ − 1), where that is before the rim; v is the height of the vertex.

        Parameters
        ----------
        vertex : float
            Height of the vertex over the centre in metres, in the direction that the face faces.
        """
        if self.flat or self.kappa <= 1.0:
            return abs(vertex)
        big, facing = abs(self.radius), math.copysign(1.0, self.radius)
        at = (big - facing * vertex) / (self.kappa - 1.0)
        at = min(max(at, 0.0), float(abs(self.sag)))
        square = max(at * (2.0 * big - self.kappa * at), 0.0)
        return math.hypot(math.sqrt(square), vertex - facing * at) * (1.0 + 8.0 * ROUNDOFF)

    @property
    def area(self) -> float:
        """Area in m²."""
        if self.flat:
            return math.pi * self.aperture**2
        return sheet_area(abs(self.radius), self.constant, (0.0, float(abs(self.sag))))

    def face(self, name: str, rim: float, side: float) -> Face:
        """Return the face.

        Parameters
        ----------
        name : str
            Its name.
        rim : float
            Height of the rim's plane on the element's axis in metres.
        side : float
            1 where it faces along the axis, −1 where against it.
        """
        if self.flat:
            return Plane(
                name=name, outline=Circular(self.aperture), centre=(0.0, 0.0, rim), sense=side
            )
        convex = math.copysign(1.0, self.radius)
        shape = Sheet(
            name=name,
            radius=abs(self.radius),
            kappa=self.kappa,
            rims=(0.0, self.aperture),
            heights=(0.0, float(abs(self.sag))),
        )
        height = float(Fraction(rim) + Fraction(side) * self.sag)
        return Placed(name=name, sense=convex, shape=shape, height=height, up=-side * convex)


def thinnest(front: LensFace, back: LensFace) -> float | None:
    """Return the distance from the axis, between it and the rim, where a lens is thinnest, or None.

    The sag has the slope c/(2 sqrt(1 − κc²x)) over x = r². Those of a convex and a concave face add
    up to nothing in one place, where R² − κx is the same of both.
    """
    if front.flat or back.flat or (front.radius > 0.0) == (back.radius > 0.0):
        return None
    bend = Fraction(back.kappa) - Fraction(front.kappa)
    if bend == 0:
        return None
    square = (Fraction(back.radius) ** 2 - Fraction(front.radius) ** 2) / bend
    if not 0 < square < Fraction(front.aperture) ** 2:
        return None
    return min(math.sqrt(square), front.aperture)
