"""The diffusely shining disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.outlines import Circular
from photizon_cl.scene.rows import Row
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
    does: ClassVar[str] = "rays from a disk of uniform radiance"
    costs: ClassVar[str] = "two sines and cosines a ray"
    draws_position: ClassVar[bool] = True
    row: ClassVar[Row] = Row("LAMBERTIAN_DISK", ("radius", "m", "radius"))

    radius: float = field(metadata=positive_length("radius"))

    @property
    def face(self) -> Plane:
        """The disk."""
        return Plane(name="face", outline=Circular(self.radius))

    def packed(self) -> dict[str, float]:
        """Return the radius."""
        return {"radius": self.radius}

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
