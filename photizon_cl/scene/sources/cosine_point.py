"""The point source with a cosine lobe."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from photizon_cl.scene.sources.base import DirectedSource


@dataclass(frozen=True, kw_only=True)
class CosinePoint(DirectedSource):
    """A point that shines into the half space of its axis with I(θ) = I0 cos θ.

    Density cos θ/π per steradian about +w: sin²θ uniform on [0, 1]. Φ = πI0. The model of a small
    flat emitter seen from far.
    """

    kind: ClassVar[str] = "cosine-point"
    kernel: ClassVar[str] = "cosine_point"
    does: ClassVar[str] = "rays from a point with a cosine lobe"
    costs: ClassVar[str] = "one sine and cosine a ray"

    @property
    def radiant_intensity(self) -> float:
        """Radiant intensity on the axis, I0 = Φ/π, in W/sr."""
        return self.flux / math.pi

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the radiant intensity on the axis."""
        return {"radiant intensity on the axis": (self.radiant_intensity, "W/sr")}
