"""The plano-convex lens."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.elements.lens import (
    CappedLens,
    cap,
    cap_area,
    cap_columns,
    on_cap,
    sag,
)
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.outlines import Circular

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class PlanoConvex(CappedLens):
    """The cap of a ball, cut off by a plane.

    `position` is the centre of the flat face and `axis` points to the convex vertex; the ball has
    its centre sqrt(R² − a²) behind the flat face and the glass is as thick as the sag,
    R − sqrt(R² − a²). Faces are closed and share the rim.

    Parameters
    ----------
    curvature_radius : float
        R in metres.
    aperture_radius : float
        Radius a of the flat face in metres, at most R (a hemisphere).
    """

    kind: ClassVar[str] = "plano-convex"
    kernel: ClassVar[str] = "plano_convex"
    does: ClassVar[str] = "plane and cap of a lens hit"
    costs: ClassVar[str] = "two roots an element a segment"
    templates: ClassVar[tuple[str, ...]] = (
        "lib/local", "lib/solid", "lib/cap_bound", "elements/plano_convex",
    )  # fmt: skip
    radii: ClassVar[tuple[str, ...]] = ("curvature_radius",)

    curvature_radius: float = field(metadata=positive_length("radius of the ball"))
    aperture_radius: float = field(metadata=positive_length("radius of the flat face"))

    @property
    def thickness(self) -> float:
        """Thickness on the axis in metres: the sag."""
        return sag(self.curvature_radius, self.aperture_radius)

    @property
    def reach(self) -> float:
        """Distance in metres from the centre of the flat face to the farthest point."""
        return self.aperture_radius

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The flat face, whose normal points against the axis, and the cap."""
        a = self.aperture_radius
        return (
            Plane(name="flat", outline=Circular(a), sense=-1.0),
            cap("curved", self.curvature_radius, a, 1.0),
        )

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        a = self.aperture_radius
        return (-a, -a, 0.0), (a, a, self.thickness)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the cap's numbers."""
        return cap_columns(self.curvature_radius, self.aperture_radius, centre, roundoff)

    @property
    def area(self) -> float:
        """Area of both faces in m²."""
        return math.pi * self.aperture_radius**2 + cap_area(
            self.curvature_radius, self.aperture_radius
        )

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the thickness and the areas."""
        return {
            "sag and thickness": (self.thickness, "m"),
            "area": (self.area, "m²"),
        }

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:
        """Say whether a local point lies on a face to within `slack` metres."""
        flat = abs(local[2]) <= slack
        if flat and math.hypot(local[0], local[1]) <= self.aperture_radius + slack:
            return True
        return on_cap(local, self.curvature_radius, self.aperture_radius, 1.0, slack)
