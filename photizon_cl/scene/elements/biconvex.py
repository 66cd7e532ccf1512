"""The biconvex lens."""

from __future__ import annotations

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
    centre_depth,
    on_cap,
    sag,
)
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class Biconvex(CappedLens):
    """The intersection of two balls that meet in a circle.

    `position` is the centre of the rim circle and `axis` points to the front vertex. The glass is
    as thick on the axis as both sags together. Faces are closed and share the rim.

    Parameters
    ----------
    front_radius : float
        Radius in metres of the ball whose cap is on the side of the axis.
    back_radius : float
        Radius in metres of the other ball.
    aperture_radius : float
        Radius a of the rim in metres, at most the smaller ball's.
    """

    kind: ClassVar[str] = "biconvex"
    kernel: ClassVar[str] = "biconvex"
    does: ClassVar[str] = "both caps of a lens hit"
    costs: ClassVar[str] = "two roots a cap a segment"
    templates: ClassVar[tuple[str, ...]] = (
        "lib/local", "lib/solid", "lib/cap_bound", "elements/biconvex",
    )  # fmt: skip
    row: ClassVar[Row] = Row(
        "BICONVEX",
        ("back_depth", "m", "of the back ball's centre behind the rim's plane"),
        ("back_inverse", "1/m", "1/R of the back ball"),
        ("back_radius", "m", "R of the back ball"),
        base=CappedLens.row,
    )
    radii: ClassVar[tuple[str, ...]] = ("front_radius", "back_radius")

    front_radius: float = field(metadata=positive_length("radius of the front ball"))
    back_radius: float = field(metadata=positive_length("radius of the back ball"))
    aperture_radius: float = field(metadata=positive_length("radius of the rim"))

    @property
    def thickness(self) -> float:
        """Thickness on the axis in metres."""
        return sag(self.front_radius, self.aperture_radius) + sag(
            self.back_radius, self.aperture_radius
        )

    @property
    def reach(self) -> float:
        """Radius in metres of a ball around the rim's centre that holds it."""
        return self.aperture_radius

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The cap on the side of the axis and the other one."""
        a = self.aperture_radius
        return (
            cap("front", self.front_radius, a, 1.0),
            cap("back", self.back_radius, a, -1.0),
        )

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        a = self.aperture_radius
        return (-a, -a, -sag(self.back_radius, a)), (a, a, sag(self.front_radius, a))

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the caps' numbers."""
        a, back = self.aperture_radius, self.back_radius
        return {
            **cap_columns(self.front_radius, a, centre, roundoff),
            "back_depth": centre_depth(back, a),
            "back_inverse": 1.0 / back,
            "back_radius": back,
        }

    @property
    def area(self) -> float:
        """Area of both faces in m²."""
        a = self.aperture_radius
        return cap_area(self.front_radius, a) + cap_area(self.back_radius, a)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the sags, the thickness and the area."""
        a = self.aperture_radius
        return {
            "front sag": (sag(self.front_radius, a), "m"),
            "back sag": (sag(self.back_radius, a), "m"),
            "thickness": (self.thickness, "m"),
            "area": (self.area, "m²"),
        }

    def touches(self, local: Vec3, slack: float, reach: float = 0.0) -> bool:
        """Say whether a local point lies on a face to within `slack` metres."""
        a = self.aperture_radius
        return on_cap(local, self.front_radius, a, 1.0, slack) or on_cap(
            local, self.back_radius, a, -1.0, slack
        )
