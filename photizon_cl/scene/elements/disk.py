"""The flat disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import ClassVar

from photizon_cl.scene.areas import circle_areas
from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.elements.flat import Flat
from photizon_cl.scene.faces import Circular
from photizon_cl.scene.filters.along import across
from photizon_cl.scene.parameters import positive_length


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

    @cached_property
    def outline(self) -> Circular:
        """What bounds it in its plane."""
        return Circular(self.radius)

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

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map, along u and v over the bounding square."""
        return MapBins(
            x=across("u", self.radius, nx),
            y=across("v", self.radius, ny),
            area_of=partial(circle_areas, self.radius, nx, ny),
            rims=(self.radius,),
        )
