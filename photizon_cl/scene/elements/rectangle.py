"""The flat rectangle."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import ClassVar

from photizon_cl.scene.areas import even_areas
from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.elements.flat import Flat
from photizon_cl.scene.filters.along import across
from photizon_cl.scene.outlines import Rectangular


@dataclass(frozen=True, kw_only=True)
class Rectangle(Flat):
    """A flat rectangle: local |u| ≤ half_width, |v| ≤ half_height, w = 0, edges included.

    `position` is its centre and `axis` its normal. A ray that runs in its plane does not hit it.

    Parameters
    ----------
    half_width : float
        Half the side along u, in metres.
    half_height : float
        Half the side along v, in metres.
    """

    kind: ClassVar[str] = "rectangle"
    kernel: ClassVar[str] = "rectangle"
    does: ClassVar[str] = "plane hit inside a rectangle"
    costs: ClassVar[str] = "one division an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("elements/rectangle", "lib/flat")

    half_width: float = field(metadata=positive_length("half the side along u"))
    half_height: float = field(metadata=positive_length("half the side along v"))

    @cached_property
    def outline(self) -> Rectangular:
        """What bounds it in its plane."""
        return Rectangular(self.half_width, self.half_height)

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around the centre that holds it."""
        return math.hypot(self.half_width, self.half_height)

    @property
    def area(self) -> float:
        """Area of one side in m²."""
        return (2.0 * self.half_width) * (2.0 * self.half_height)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the area, and the area of a map's bin."""
        out = {"area": (self.area, "m²")}
        if self.detector is not None and self.detector.map is not None:
            nx, ny = self.detector.map
            out["bin area"] = (2.0 * self.half_width / nx * (2.0 * self.half_height / ny), "m²")
        return out

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map, along u and v."""
        return MapBins(
            x=across("u", self.half_width, nx),
            y=across("v", self.half_height, ny),
            area_of=partial(even_areas, self.half_width, self.half_height, nx, ny),
        )
