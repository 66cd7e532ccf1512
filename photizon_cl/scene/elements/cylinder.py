"""The round tube."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.elements.revolved import RevolvedWall
from photizon_cl.scene.faces import Straight
from photizon_cl.scene.filters.along import along_axis
from photizon_cl.scene.filters.azimuth import Azimuth
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face


@dataclass(frozen=True, kw_only=True)
class Cylinder(RevolvedWall):
    """The wall of a round tube, open at both ends: u² + v² = radius², 0 ≤ w ≤ length.

    `position` is the centre of the entrance and `axis` points from the entrance to the exit. The
    rims belong to the wall, whose normals point away from the axis. A ray along the axis does not
    hit it.

    Parameters
    ----------
    radius : float
        Radius in metres.
    length : float
        Length in metres.
    """

    kind: ClassVar[str] = "cylinder"
    kernel: ClassVar[str] = "cylinder"
    does: ClassVar[str] = "wall of a round tube hit"
    costs: ClassVar[str] = "one square root and up to two roots an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "lib/revolved", "elements/cylinder")
    row: ClassVar[Row] = Row(
        "CYLINDER", ("radius", "m", "radius R"), ("inverse", "1/m", "1/R"), base=RevolvedWall.row
    )
    has_map: ClassVar[bool] = True

    radius: float = field(metadata=positive_length("radius"))
    length: float = field(metadata=positive_length("length"))

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why its surface cannot refract."""
        return "a cylinder is a wall, not a solid with an inside of glass; take a wall's surface"

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its wall."""
        return (Straight(name="wall", radii=(self.radius, self.radius), length=self.length),)

    @property
    def heights(self) -> tuple[float, float]:
        """Heights of the entrance and of the exit in metres."""
        return (0.0, self.length)

    @property
    def widest(self) -> float:
        """Its radius in metres."""
        return self.radius

    @property
    def shape(self) -> dict[str, float]:
        """Its radius."""
        return {"radius": self.radius, "inverse": 1.0 / self.radius}

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map, in φ and along the axis from the entrance."""
        each = 2.0 * math.pi * self.radius / nx * (self.length / ny)
        return MapBins(
            x=Azimuth(nx), y=along_axis(self.length, ny), area_of=partial(np.full, (ny, nx), each)
        )

    @property
    def area(self) -> float:
        """Area of one side in m², 2πR·L."""
        return 2.0 * math.pi * self.radius * self.length

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the areas of the wall, of an opening and of a map's bin."""
        out = {
            "wall area": (self.area, "m²"),
            "area of an opening": (math.pi * self.radius * self.radius, "m²"),
        }
        if self.detector is not None and self.detector.map is not None:
            nx, ny = self.detector.map
            out["bin area"] = (2.0 * math.pi * self.radius / nx * (self.length / ny), "m²")
        return out
