"""The point source that fills a cone."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from photizon_cl.scene.declarations import number
from photizon_cl.scene.frames import sincos_deg
from photizon_cl.scene.parameters import SMALLEST
from photizon_cl.scene.rows import Row
from photizon_cl.scene.sources.base import DirectedSource


@dataclass(frozen=True, kw_only=True)
class ConePoint(DirectedSource):
    """A point that shines equally in every direction within a cone about +w.

    Density 1/(2π(1 − cos θ)) per steradian up to the half-angle θ: cos uniform on [cos θ, 1] and φ
    uniform. Φ = I·2π(1 − cos θ).

    Parameters
    ----------
    half_angle_deg : float
        θ in degrees, from 1e-150, below which 1 − cos θ vanishes, to 180 (the whole sphere).
    """

    kind: ClassVar[str] = "cone-point"
    kernel: ClassVar[str] = "cone_point"
    does: ClassVar[str] = "rays from a point, uniform over a cone"
    costs: ClassVar[str] = "one sine and cosine a ray"
    row: ClassVar[Row] = Row("CONE_POINT", ("height", "", "1 − cos θ of the half-angle"))

    half_angle_deg: float = field(
        metadata=number(
            "an angle from 1e-150 to 180 degrees", SMALLEST, 180.0, "half-angle of the cone", "deg"
        )
    )

    @property
    def height(self) -> float:
        """1 − cos θ = 2 sin² θ/2, without cancellation."""
        half = sincos_deg(0.5 * self.half_angle_deg)[0]
        return 2.0 * half * half

    def packed(self) -> dict[str, float]:
        """Return the height of the cone's cap on the unit sphere."""
        return {"height": self.height}

    @property
    def solid_angle(self) -> float:
        """2π(1 − cos θ) in sr."""
        return 2.0 * math.pi * self.height

    @property
    def radiant_intensity(self) -> float:
        """I = Φ/(2π(1 − cos θ)) in W/sr."""
        return self.flux / self.solid_angle

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the solid angle and the radiant intensity."""
        return {
            "solid angle": (self.solid_angle, "sr"),
            "radiant intensity": (self.radiant_intensity, "W/sr"),
        }
