"""The smooth interface of two transparent media."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.parameters import refractive_index
from photizon_cl.scene.rows import Row
from photizon_cl.scene.surfaces.base import Surface


@dataclass(frozen=True)
class Fresnel(Surface):
    """A smooth dielectric interface, unpolarised, that splits every ray into both children.

    R is the mean of the two polarised Fresnel reflectances and T = 1 − R; the reflected child
    carries R of the weight, the transmitted one T, bent by Snell's law. Beyond the critical angle
    the reflected child keeps everything. Nothing is absorbed and no draw is made. Media are not
    tracked: the side that a ray comes from says which index it is in.

    Parameters
    ----------
    index : float
        Refractive index behind a flat element's normal, and inside a solid.
    index_outside : float, optional
        Refractive index on the side that the normal points to.

    Notes
    -----
    Formulas: M. Born and E. Wolf, Principles of Optics, 7th edition, § 1.5.2. Both indices are
    real and from 0.001 to 1000.
    """

    kind: ClassVar[str] = "fresnel"
    kernel: ClassVar[str] = "fresnel"
    does: ClassVar[str] = "refraction and partial reflection"
    costs: ClassVar[str] = "two square roots and a division an interaction"
    row: ClassVar[Row] = Row(
        "FRESNEL",
        ("ratio_plus", "", "m = n₁/n₂ for a ray from the + side"),
        ("one_less_square_plus", "", "1 − m², without cancellation"),
        ("ratio_minus", "", "m for a ray from the − side"),
        ("one_less_square_minus", "", "1 − m², without cancellation"),
    )
    absorbs: ClassVar[bool] = False
    reflects: ClassVar[bool] = True
    transmits: ClassVar[bool] = True
    refracts: ClassVar[bool] = True
    splits: ClassVar[bool] = True
    colour: ClassVar[str] = "#56b4e9"
    label_text: ClassVar[str] = "glass"

    index: float = field(metadata=refractive_index("index behind the normal, or inside the solid"))
    index_outside: float = field(
        default=1.0, metadata=refractive_index("index on the normal's side")
    )

    def packed(self) -> dict[str, float]:
        """Return m = n₁/n₂ and 1 − m² from the + side, and from the − side.

        1 − m² = (n₂ − n₁)(n₂ + n₁)/n₂², with the difference of the indices taken before anything
        is rounded.
        """
        inside, outside = self.index, self.index_outside
        return {
            "ratio_plus": outside / inside,
            "one_less_square_plus": (inside - outside) * (inside + outside) / (inside * inside),
            "ratio_minus": inside / outside,
            "one_less_square_minus": (outside - inside) * (outside + inside) / (outside * outside),
        }

    @property
    def indices(self) -> tuple[float, float]:
        """Refractive indices behind its normal and on the other side."""
        return self.index, self.index_outside

    @property
    def normal_reflectance(self) -> float:
        """Reflectance at normal incidence, ((n − n')/(n + n'))²."""
        ratio = (self.index - self.index_outside) / (self.index + self.index_outside)
        return ratio * ratio

    @property
    def critical_angle_deg(self) -> float | None:
        """Critical angle in degrees in the denser medium; None where the indices are equal."""
        if self.index == self.index_outside:
            return None
        low, high = sorted((self.index, self.index_outside))
        return math.degrees(math.asin(low / high))

    def advice(self) -> list[str]:
        """Say where it is no border."""
        if self.index != self.index_outside:
            return []
        return ["has the same index on both sides: it reflects nothing and bends nothing"]

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the reflectance at normal incidence and the critical angle."""
        out = {"reflectance at normal incidence": (self.normal_reflectance, "")}
        if self.critical_angle_deg is not None:
            out["critical angle in the denser medium"] = (self.critical_angle_deg, "deg")
        return out
