"""The isotropic point source."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.sources.base import Source


@dataclass(frozen=True, kw_only=True)
class IsotropicPoint(Source):
    """A point that shines equally in every direction.

    Density 1/(4π) per steradian: cos θ uniform on [−1, 1] and φ uniform about the world axes.
    Radiant intensity I = Φ/4π.
    """

    kind: ClassVar[str] = "isotropic-point"
    kernel: ClassVar[str] = "isotropic_point"
    does: ClassVar[str] = "rays from a point, uniform over the sphere"
    costs: ClassVar[str] = "one sine and cosine a ray"

    @property
    def radiant_intensity(self) -> float:
        """I = Φ/4π in W/sr."""
        return self.flux / (4.0 * math.pi)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the radiant intensity."""
        return {"radiant intensity": (self.radiant_intensity, "W/sr")}
