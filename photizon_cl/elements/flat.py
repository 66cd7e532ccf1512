"""What flat elements share."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.edges import even_edges
from photizon_cl.elements.base import Element
from photizon_cl.frames import axis_index

if TYPE_CHECKING:
    from photizon_cl.frames import Vec3

_ROUNDOFF: Final = 2.0**-53


@dataclass(frozen=True, kw_only=True)
class Flat(Element):
    """A part of a plane around `position`, with `axis` as its normal."""

    family: ClassVar[str] = "flat"
    flat: ClassVar[bool] = True
    has_map: ClassVar[bool] = True

    @property
    @abstractmethod
    def half_sizes(self) -> tuple[float, float]:
        """Half extents along u and v in metres."""

    @property
    def class_axis(self) -> int | None:
        """World axis of the normal; None where it is tilted."""
        return None if self.tilt_deg != (0.0, 0.0) else axis_index(self.axis) // 2

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        u, v = self.half_sizes
        return (-u, -v, 0.0), (u, v, 0.0)

    def packed(self, centre: Vec3, axis: int | None, at_edges: float = 1.0) -> tuple[float, ...]:
        """Return the half sizes with their rounding bounds, see ``kernels/lib/flat.mako``.

        The bounds are what the rounding of a hit point's coordinates can amount to: a few units
        in the last place of the element's size and distance from the origin, and `at_edges` times
        that at its edges.
        """
        far = max(map(abs, centre))
        half = self.half_sizes
        # for +a the frame's u is world axis a + 1; for -a it is a + 2
        if axis is not None and axis_index(self.axis) % 2 == 1:
            half = (half[1], half[0])
        # A tilted face's coordinates are sums of products with a rounded frame. A point put back
        # within `inner` lies on the right side of a face that shares the edge, whatever rounding.
        grows, shrinks = (4.0, 2.0) if axis is not None else (8.0, 16.0)
        room = [at_edges * _ROUNDOFF * (h + far) for h in half]
        outer = [h + grows * r for h, r in zip(half, room, strict=True)]
        inner = [max(h - shrinks * r, 0.5 * h) for h, r in zip(half, room, strict=True)]
        # what comes to this plane on another face has crossed about as much as this one's size
        plane = far if axis is None else abs(centre[axis]) + max(half)
        # other faces end at this one to within the rounding of all coordinates
        ends = far + (sum(half) if axis is None else max(half))
        sign = -1.0 if axis_index(self.axis) % 2 else 1.0
        # how far aside a point of a face that meets this one at its edge may be where it is 64 of
        # the plane's bounds over it
        aside = 64.0 * max(at_edges, 2.0)
        # a tilted plane's rounding grows with the distance from its centre
        slope = 4.0 * _ROUNDOFF
        return (*outer, *inner, 4.0 * _ROUNDOFF * plane, sign, slope, aside, 4.0 * _ROUNDOFF * ends)

    def map_edges(self, nx: int, ny: int) -> tuple[list[float], list[float]]:
        """Return edges in metres along u and along v over the bounding rectangle."""
        u, v = self.half_sizes
        return even_edges(-u, u, nx), even_edges(-v, v, ny)
