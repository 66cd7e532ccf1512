"""The diffusely shining sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.faces import Ball
from photizon_cl.scene.rows import Row
from photizon_cl.scene.sources.base import Source


@dataclass(frozen=True, kw_only=True)
class LambertianSphere(Source):
    """A spherical shell of uniform radiance L that shines outward.

    Points uniform by area, directions with density cos θ/π about the outward normal.
    Φ = πL·4πr². The shell does not block light, its own included.

    Parameters
    ----------
    radius : float
        r in metres.
    """

    kind: ClassVar[str] = "lambertian-sphere"
    kernel: ClassVar[str] = "lambertian_sphere"
    does: ClassVar[str] = "rays from a shell of uniform radiance"
    costs: ClassVar[str] = "two sines and cosines a ray"
    draws_position: ClassVar[bool] = True
    row: ClassVar[Row] = Row("LAMBERTIAN_SPHERE", ("radius", "m", "radius"))

    radius: float = field(metadata=positive_length("radius"))

    @property
    def face(self) -> Ball:
        """The shell."""
        return Ball(name="shell", radius=self.radius)

    def packed(self) -> dict[str, float]:
        """Return the radius."""
        return {"radius": self.radius}

    @property
    def area(self) -> float:
        """Emitting area 4πr² in m²."""
        return 4.0 * math.pi * self.radius * self.radius

    @property
    def radiant_exitance(self) -> float:
        """M = Φ/4πr² in W/m²."""
        return self.flux / self.area

    @property
    def radiance(self) -> float:
        """L = M/π in W/(m² sr)."""
        return self.radiant_exitance / math.pi

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return area, radiant exitance and radiance."""
        return {
            "area": (self.area, "m²"),
            "radiant exitance": (self.radiant_exitance, "W/m²"),
            "radiance": (self.radiance, "W/(m² sr)"),
        }
