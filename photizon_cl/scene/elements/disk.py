"""The flat disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.areas import circle_areas
from photizon_cl.scene.bins import MapBins
from photizon_cl.scene.declarations import number, positive_length
from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.elements.flat import EDGES, EDGES_TILTED, Flat
from photizon_cl.scene.filters.along import across
from photizon_cl.scene.outlines import Circular
from photizon_cl.scene.parameters import LARGEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.frames import Vec3

_INNER: Final = "a radius from 0 up to but not including radius, in metres"


@dataclass(frozen=True, kw_only=True)
class Disk(Flat):
    """A flat disk or annulus: local inner_radius² ≤ u² + v² ≤ radius², w = 0, rims included.

    `position` is its centre and `axis` its normal. A ray that runs in its plane does not hit it.

    Parameters
    ----------
    radius : float
        Radius in metres.
    inner_radius : float, optional
        Radius in metres of a hole around the centre, whose rim belongs to the disk; 0 for none.
    """

    kind: ClassVar[str] = "disk"
    kernel: ClassVar[str] = "disk"
    does: ClassVar[str] = "plane hit inside a circle"
    costs: ClassVar[str] = "one division an element a segment"
    templates: ClassVar[tuple[str, ...]] = ("elements/disk", "lib/flat")

    radius: float = field(metadata=positive_length("radius"))
    inner_radius: float = field(
        default=0.0, metadata=number(_INNER, 0.0, LARGEST, "radius of the hole", "m")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check the hole against the disk."""
        problems = super().cross_check(known)
        radius, inner = known.get("radius"), known.get("inner_radius")
        if radius is not None and inner is not None and inner >= radius:
            hint = "the hole would leave nothing of the disk"
            wanted = f"less than radius, {show(radius)}"
            problems.append(Problem("inner_radius", show(inner), wanted, hint=hint))
        return problems

    @property
    def opening(self) -> bool:
        """Whether it has a hole."""
        return self.inner_radius > 0.0

    @cached_property
    def outline(self) -> Circular:
        """What bounds it in its plane."""
        return Circular(self.radius)

    @property
    def hole(self) -> Circular | None:
        """What is cut out of it around the centre."""
        return Circular(self.inner_radius) if self.opening else None

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the radii with their rounding bounds."""
        values = super().packed(centre, axis, at_edges, roundoff)
        if self.opening:
            hole = self.inner_radius
            grows, shrinks = EDGES if axis is not None else EDGES_TILTED
            room = max(at_edges) * roundoff * (hole + max(map(abs, centre)))
            values["outer_v"] = hole - grows * room
            values["inner_v"] = min(hole + shrinks * room, 0.5 * (hole + values["inner_u"]))
        return values

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around the centre that holds it."""
        return self.radius

    @property
    def area(self) -> float:
        """Area of one side in m², π(R − r)(R + r)."""
        return math.pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the area."""
        return {"area": (self.area, "m²")}

    def map_bins(self, nx: int, ny: int) -> MapBins:
        """Return the bins of a map, along u and v over the bounding square."""
        return MapBins(
            x=across("u", self.radius, nx),
            y=across("v", self.radius, ny),
            area_of=partial(circle_areas, self.radius, nx, ny, self.inner_radius),
            rims=(self.radius, self.inner_radius) if self.opening else (self.radius,),
        )
