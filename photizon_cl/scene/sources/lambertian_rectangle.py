"""The diffusely shining rectangle."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.outlines import Rectangular
from photizon_cl.scene.rows import Row
from photizon_cl.scene.sources.base import DirectedSource


@dataclass(frozen=True, kw_only=True)
class LambertianRectangle(DirectedSource):
    """A rectangle of uniform radiance L that shines on the side of its axis only: an LED's chip.

    Points uniform by area, directions with density cos θ/π about +w. Φ = πL·A.

    Parameters
    ----------
    half_width : float
        Half the side along u, in metres.
    half_height : float
        Half the side along v, in metres.
    """

    kind: ClassVar[str] = "lambertian-rectangle"
    kernel: ClassVar[str] = "lambertian_rectangle"
    does: ClassVar[str] = "rays from a rectangle of uniform radiance"
    costs: ClassVar[str] = "one sine and cosine and a second random block a ray"
    draws_position: ClassVar[bool] = True
    row: ClassVar[Row] = Row(
        "LAMBERTIAN_RECTANGLE",
        ("half_width", "m", "half the side along u"),
        ("half_height", "m", "half the side along v"),
    )

    half_width: float = field(metadata=positive_length("half the side along u"))
    half_height: float = field(metadata=positive_length("half the side along v"))

    @property
    def face(self) -> Plane:
        """The rectangle."""
        return Plane(name="face", outline=Rectangular(self.half_width, self.half_height))

    def packed(self) -> dict[str, float]:
        """Return the half sizes."""
        return {"half_width": self.half_width, "half_height": self.half_height}

    @property
    def area(self) -> float:
        """Emitting area in m²."""
        return (2.0 * self.half_width) * (2.0 * self.half_height)

    @property
    def radiant_exitance(self) -> float:
        """M = Φ/A in W/m²."""
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
