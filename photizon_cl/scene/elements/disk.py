"""The flat disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.scene.elements.flat import Flat
from photizon_cl.scene.parameters import positive_length

if TYPE_CHECKING:
    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class Disk(Flat):
    """A flat disk: local u² + v² ≤ radius², w = 0, rim included.

    `position` is its centre and `axis` its normal. A ray that runs in its plane does not hit it.

    Parameters
    ----------
    radius : float
        Radius in metres.
    """

    kind: ClassVar[str] = "disk"
    kernel: ClassVar[str] = "disk"
    does: ClassVar[str] = "plane hit inside a circle"
    costs: ClassVar[str] = "one division an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("elements/disk", "lib/flat")

    radius: float = field(metadata=positive_length("radius"))

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Half extents along u and v in metres."""
        return (self.radius, self.radius)

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around the centre that holds it."""
        return self.radius

    @property
    def area(self) -> float:
        """Area of one side in m², πr²."""
        return math.pi * self.radius * self.radius

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the area."""
        return {"area": (self.area, "m²")}

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:
        """Say whether a local point lies on the disk, see `Element.touches`."""
        u, v, w = local
        return abs(w) <= slack and math.hypot(u, v) <= self.radius + reach + slack
