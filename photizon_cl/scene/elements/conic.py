"""The sheet of a conic of revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from photizon_cl.errors import Problem, show
from photizon_cl.scene.elements.revolved import RevolvedWall
from photizon_cl.scene.faces import Revolved
from photizon_cl.scene.parameters import LARGEST, about, number, positive_length
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face

_INNER: Final = "a radius from 0 up to but not including aperture_radius, in metres"


@dataclass(frozen=True, kw_only=True)
class _Sheet(Revolved):
    """The meridian as `Conic` states it; lengths in metres.

    With κ = 1 + k, from r² = w(2R − κw) and dw/dr = r/(R − κw). Of an ellipsoid the profile runs by
    the angle of its slope, in which an equator has as many places as a vertex; of the others, whose
    slope comes to an end, by asinh(r sqrt(1 − κ)/R). Neither subtracts nearly equal numbers.
    """

    radius: float
    kappa: float
    rims: tuple[float, float]
    heights: tuple[float, float]

    def profile(self, s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        big, kappa = self.radius, self.kappa
        rims = np.array(self.rims)
        if kappa > 0.0:
            first, last = np.arctan2(rims, self._levels(np.array(self.heights)))
            at = first * (1.0 - s) + last * s
            sine, cosine = np.sin(at), np.cos(at)
            r = big * sine / np.hypot(cosine, math.sqrt(kappa) * sine)
            root = big * cosine / np.hypot(cosine, math.sqrt(kappa) * sine)
        else:
            width = big / math.sqrt(1.0 - kappa)
            first, last = np.arcsinh(rims / width)
            r = width * np.sinh(first * (1.0 - s) + last * s)
            root = np.hypot(big, math.sqrt(-kappa) * r)
        w = r * (r / (big + root))
        for place, rim, height in zip((0.0, 1.0), self.rims, self.heights, strict=True):
            r, w = np.where(s == place, rim, r), np.where(s == place, height, w)
        return np.clip(r, *self.rims), np.clip(w, *self.heights)

    def _levels(self, w: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return R − κw, what the slope's denominator is at a height."""
        return np.asarray(np.maximum(self.radius - self.kappa * w, 0.0))

    def place_at(self, height: float) -> float:
        """Return the place of the profile at a height; the nearer end beyond either."""
        w = min(max(height, self.heights[0]), self.heights[1])
        r, ends = self.radius_at(w), np.array(self.rims)
        if self.kappa > 0.0:
            first, last = np.arctan2(ends, self._levels(np.array(self.heights)))
            at = float(np.arctan2(r, self._levels(np.array(w))))
        else:
            width = self.radius / math.sqrt(1.0 - self.kappa)
            first, last = np.arcsinh(ends / width)
            at = math.asinh(r / width)
        return min(max((at - float(first)) / float(last - first), 0.0), 1.0)

    def radius_at(self, height: float) -> float:
        """Return the radius in metres at a height, that of the nearer rim beyond either."""
        w = min(max(height, self.heights[0]), self.heights[1])
        r = math.sqrt(w) * math.sqrt(2.0 * self.radius - self.kappa * w)
        return min(max(r, self.rims[0]), self.rims[1])

    def apart(self, radius: float, height: float) -> float:
        """Return the distance in metres of a circle about the axis from the sheet.

        |F|/|∇F| of F = r² − w(2R − κw), with F as a product.
        """
        w = min(max(height, self.heights[0]), self.heights[1])
        on = self.radius_at(w)
        gradient = math.hypot(radius, self.radius - self.kappa * w)
        return abs(radius - on) * (0.5 * ((radius + on) / gradient))

    def sine_at(self, radius: float, height: float, room: float) -> float:
        """Return the sine of the angle between the sheet and the plane of a circle that lies on it.

        Of one about the vertex that of the least circle at which the sheet leaves its plane.
        """
        w = min(max(height, self.heights[0]), self.heights[1])
        r = max(radius, min(math.sqrt(2.0 * room) * math.sqrt(self.radius), self.rims[1]))
        return r / math.hypot(r, self.radius - self.kappa * w)


@dataclass(frozen=True, kw_only=True)
class Conic(RevolvedWall):
    """A sheet of a conic of revolution: a paraboloid, an ellipsoid, a hyperboloid, a sphere.

    `position` is the vertex and the sheet opens towards +w. With r the distance from the axis, R
    the radius of curvature at the vertex and k the conic constant::

        w = r²/R / (1 + sqrt(1 − (1 + k) r²/R²)),   inner_radius ≤ r ≤ aperture_radius

    k = −1 is a paraboloid with its focus at R/2, k < −1 a hyperboloid, −1 < k an ellipsoid (prolate
    below 0, where both foci lie on the axis at R/(1 ± sqrt(−k))), 0 a sphere. The rims belong to
    the sheet. Its normals point into the concave side, which is the `inside`, so that the `index`
    of a `fresnel` sheet is on its convex side.

    Parameters
    ----------
    curvature_radius : float
        R in metres.
    conic_constant : float, optional
        k.
    aperture_radius : float
        Radius of the rim in metres; for k > −1 at most R/sqrt(1 + k), the ellipsoid's equator.
    inner_radius : float, optional
        Radius in metres of a hole around the vertex, 0 for none.
    """

    kind: ClassVar[str] = "conic"
    kernel: ClassVar[str] = "conic"
    does: ClassVar[str] = "sheet of a conic hit"
    costs: ClassVar[str] = "two square roots and up to two roots an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "lib/revolved", "elements/conic")
    traits: ClassVar[frozenset[str]] = frozenset({"polished", "inward", "own-sides"})
    row: ClassVar[Row] = Row(
        "CONIC",
        ("radius", "m", "radius of curvature R at the vertex"),
        ("kappa", "", "1 + conic constant"),
        ("inner", "m", "radius of the inner rim"),
        ("aperture", "m", "radius of the outer rim"),
        ("polishes", "", "whether roots are polished, 0 or 1"),
        base=RevolvedWall.row,
    )

    curvature_radius: float = field(metadata=positive_length("radius of curvature at the vertex"))
    conic_constant: float = field(
        default=0.0,
        metadata=number("a number from -1e6 to 1e6", -1e6, 1e6, "conic constant"),
    )
    aperture_radius: float = field(metadata=positive_length("radius of the rim"))
    inner_radius: float = field(
        default=0.0, metadata=number(_INNER, 0.0, LARGEST, "radius of the hole", "m")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that the rims lie on the sheet, one inside the other."""
        problems = super().cross_check(known)
        radius, aperture = known.get("curvature_radius"), known.get("aperture_radius")
        k, inner = known.get("conic_constant") or 0.0, known.get("inner_radius")
        if radius is not None and aperture is not None and k > -1.0:
            widest = equator(radius, k)
            if aperture > widest:
                problems.append(
                    Problem(
                        "aperture_radius",
                        show(aperture),
                        f"at most R/sqrt(1 + k), {show(widest)}",
                        hint="an ellipsoid is widest at its equator; equal makes a half",
                    )
                )
        if radius is not None and aperture is not None and known.get("conic_constant") is not None:
            high = _sag(radius, k, aperture)
            if high > Fraction(LARGEST):
                problems.append(
                    Problem(
                        "aperture_radius",
                        show(aperture),
                        f"an aperture of a sheet at most {LARGEST:g} m high",
                        hint=f"its sag would be {about(high)} m; take a smaller aperture",
                    )
                )
        if inner is not None and aperture is not None and inner >= aperture:
            problems.append(
                Problem(
                    "inner_radius",
                    show(inner),
                    f"less than aperture_radius, {show(aperture)}",
                    hint="the hole would leave nothing of the sheet",
                )
            )
        return problems

    @property
    def kappa(self) -> float:
        """1 + k, the square of the ratio of its semi-axes across and along."""
        return 1.0 + self.conic_constant

    def sag(self, r: float) -> float:
        """Return the height over the vertex in metres at a distance r from the axis."""
        return float(_sag(self.curvature_radius, self.conic_constant, r))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its sheet, with the normal into the concave side."""
        sheet = _Sheet(
            name="sheet",
            sense=-1.0,
            radius=self.curvature_radius,
            kappa=self.kappa,
            rims=(self.inner_radius, self.aperture_radius),
            heights=self.heights,
        )
        return (sheet,)

    @property
    def heights(self) -> tuple[float, float]:
        """Heights of the inner and of the outer rim over the vertex in metres."""
        return (self.sag(self.inner_radius), self.sag(self.aperture_radius))

    @property
    def widest(self) -> float:
        """Radius of the rim in metres."""
        return self.aperture_radius

    @property
    def shape(self) -> dict[str, float]:
        """The conic's constants and its rims."""
        # long or flat: what F is at one end says little of the other
        polishes = abs(self.kappa) > 2.0 or self.heights[1] > 4.0 * self.curvature_radius
        return {
            "radius": self.curvature_radius,
            "kappa": self.kappa,
            "inner": self.inner_radius,
            "aperture": self.aperture_radius,
            "polishes": float(polishes),
        }

    @property
    def area(self) -> float:
        """Area of one side in m².

        2πr·ds = 2π sqrt(R² − k r²) dw with r² = w(2R − κw), by Gauss-Legendre quadrature
        in pieces that halve towards both rims, near which the root may turn sharply.
        """
        (low, high), radius = self.heights, self.curvature_radius
        halves = 0.5 ** np.arange(1.0, 31.0)
        ends = np.concatenate([[0.0], halves[:0:-1], [0.5], 1.0 - halves[1:], [1.0]])
        nodes, weights = np.polynomial.legendre.leggauss(16)
        width = 0.5 * np.diff(ends)[:, None]
        s = ends[:-1, None] + width * (1.0 + nodes)
        w = low + s * (high - low)
        r, k = np.sqrt(w) * np.sqrt(2.0 * radius - self.kappa * w), self.conic_constant
        if k <= 0.0:
            root = np.hypot(radius, math.sqrt(-k) * r)
        else:
            part = math.sqrt(k) * r / radius
            root = radius * np.sqrt(np.maximum((1.0 - part) * (1.0 + part), 0.0))
        return 2.0 * math.pi * (high - low) * float((width * weights * root).sum())

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the sags, the foci on the axis and the area."""
        low, high = self.heights
        out = {"sag": (high, "m")}
        if self.inner_radius > 0.0:
            out["sag of the inner rim"] = (low, "m")
        k, radius = self.conic_constant, self.curvature_radius
        if k == -1.0:
            out["focus at"] = (0.5 * radius, "m")
        elif k < 0.0:
            out["near focus at"] = (radius / (1.0 + math.sqrt(-k)), "m")
            # R/(1 − sqrt(−k)), in which a k near −1 would be lost
            out["far focus at"] = (radius * (1.0 + math.sqrt(-k)) / self.kappa, "m")
        out["area"] = (self.area, "m²")
        return out


def _sag(radius: float, k: float, r: float) -> Fraction:
    """Return the height of a conic over its vertex in metres, beyond the range of a double too."""
    big, square = Fraction(radius), Fraction(r) ** 2
    # the equator's radius is rounded
    rest = max(big**2 - (1 + Fraction(k)) * square, Fraction(0))
    return square / (big + Fraction(math.sqrt(rest)))


def equator(radius: float, k: float) -> float:
    """Return the largest radius of an ellipsoid in metres, R/sqrt(1 + k), for k > −1."""
    return radius / math.sqrt(1 + Fraction(k))
