"""The sheet of a conic of revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.elements.revolved import RevolvedWall
from photizon_cl.scene.elements.sheets import Sheet, equator, sheet_area, sheet_sag
from photizon_cl.scene.parameters import LARGEST, about
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face

_INNER: Final = "a radius from 0 up to but not including aperture_radius, in metres"


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
            high = sheet_sag(radius, k, aperture)
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
        return float(sheet_sag(self.curvature_radius, self.conic_constant, r))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its sheet, with the normal into the concave side."""
        sheet = Sheet(
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
        """Area of one side in m²."""
        return sheet_area(self.curvature_radius, self.conic_constant, self.heights)

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
