"""The diffusely shining disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.parameters import positive_length
from photizon_cl.scene.sources.base import DirectedSource, circle_area


@dataclass(frozen=True, kw_only=True)
class LambertianDisk(DirectedSource):
    """A disk of uniform radiance L that shines on the side of its axis only.

    Points uniform by area, directions with density cos θ/π about +w. Φ = πL·πr².

    Parameters
    ----------
    radius : float
        r in metres.
    """

    kind: ClassVar[str] = "lambertian-disk"
    kernel: ClassVar[str] = "lambertian_disk"

    radius: float = field(metadata=positive_length("radius"))

    def packed(self) -> tuple[float, ...]:
        """Return ``(radius,)``."""
        return (self.radius,)

    @property
    def area(self) -> float:
        """Emitting area πr² in m²."""
        return circle_area(self.radius)

    @property
    def radiant_exitance(self) -> float:
        """M = Φ/πr² in W/m²."""
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
