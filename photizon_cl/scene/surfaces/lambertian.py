"""The ideal diffuse reflector."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.curves import Curve, fraction_or_curve, number_of
from photizon_cl.scene.rows import Row
from photizon_cl.scene.surfaces.base import Surface


@dataclass(frozen=True)
class Lambertian(Surface):
    """An ideal diffuse surface: equal radiance in every direction of the side that was hit.

    The direction leaves with density cos θ/π per steradian about the normal of that side
    (Lambert's law; BRDF ρ/π), and the weight is multiplied by the reflectance; 1 − ρ of it is
    absorbed by the element.

    Parameters
    ----------
    reflectance : float or Curve
        Hemispherical reflectance ρ in [0, 1]; a table over wavelength in a scene that has a
        spectrum.
    """

    kind: ClassVar[str] = "lambertian"
    kernel: ClassVar[str] = "lambertian"
    does: ClassVar[str] = "diffuse reflection"
    costs: ClassVar[str] = "one random block, sine and cosine an interaction"
    row: ClassVar[Row] = Row("LAMBERTIAN", ("reflectance", "", "part of the weight that goes on"))
    absorbs: ClassVar[bool] = True
    reflects: ClassVar[bool] = True
    draws: ClassVar[bool] = True
    scatters: ClassVar[bool] = True
    colour: ClassVar[str] = "#cc79a7"
    label_text: ClassVar[str] = "diffuse reflector"

    reflectance: float | Curve = field(
        metadata=fraction_or_curve(
            "part of the power that is reflected", "the rest, 1 − ρ, is absorbed"
        )
    )

    def packed(self) -> dict[str, float]:
        """Return the reflectance."""
        return {"reflectance": number_of(self.reflectance)}

    @property
    def diffuse_reflectance(self) -> float | None:
        """ρ: all that is reflected is diffuse; None where that is a table."""
        return None if isinstance(self.reflectance, Curve) else self.reflectance

    @property
    def absorptance(self) -> float | None:
        """Part of each arrival that the element absorbs, 1 − ρ; None where that is a table."""
        return None if isinstance(self.reflectance, Curve) else 1.0 - self.reflectance

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the absorptance, where it is a number."""
        return {} if self.absorptance is None else {"absorptance": (self.absorptance, "")}
