"""What walls of revolution share: a meridian about the axis, between two rims."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.frames import Vec3


@dataclass(frozen=True, kw_only=True)
class RevolvedWall(Element):
    """The wall of a convex body of revolution about the axis, between two heights, rims included.

    In local coordinates its points are x² + y² = P(z) with a quadratic P; one face.
    """

    row: ClassVar[Row] = Row(
        "REVOLVED",
        ("low", "m", "height of the lower rim"),
        ("high", "m", "height of the upper rim"),
        ("near", "m", "rounding bound of a coordinate, to which one grows with its size"),
        ("most", "m", "the same all over the wall"),
    )
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "inside"

    @property
    @abstractmethod
    def heights(self) -> tuple[float, float]:
        """Heights of the lower and of the upper rim over `position` in metres."""

    @property
    @abstractmethod
    def widest(self) -> float:
        """Largest radius in metres."""

    @property
    @abstractmethod
    def shape(self) -> Mapping[str, float]:
        """Values of the columns that the kind adds to the row."""

    @property
    def reach(self) -> float:
        """Distance in metres from `position` to the farthest rim, at least."""
        return math.hypot(self.widest, max(map(abs, self.heights)))

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        r, (low, high) = self.widest, self.heights
        return (-r, -r, low), (r, r, high)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return rims, rounding bounds and shape."""
        low, high = self.heights
        near = 4.0 * roundoff * max(map(abs, centre))
        most = near + 4.0 * roundoff * (2.0 * self.widest + max(abs(low), abs(high)))
        return {"low": low, "high": high, "near": near, "most": most, **self.shape}
