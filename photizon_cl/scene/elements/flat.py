"""What flat elements share."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.frames import axis_index
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.outlines import Outline

EDGES: Final = (4.0, 2.0)
"""How many roundings a face goes on beyond its edge, and how many within it points are put back."""
EDGES_TILTED: Final = (8.0, 16.0)
"""The same where its coordinates are sums of products with a rounded frame."""


@dataclass(frozen=True, kw_only=True)
class Flat(Element):
    """A part of a plane around `position`, with `axis` as its normal."""

    row: ClassVar[Row] = Row(
        "FLAT",
        (
            "outer_u",
            "m",
            "half size along u, or the axis behind the normal's, with its bound",
        ),
        (
            "outer_v",
            "m",
            "the same along v, or the axis behind that; of a hole: its radius less that",
        ),
        ("inner_u", "m", "half size less its bound: a hit beyond it is moved onto it"),
        ("inner_v", "m", "the same along v; of a hole: its radius and its bound"),
        ("ends", "m", "rounding bound of where other faces end at the plane"),
        ("sign", "", "of the normal along its axis"),
        ("aside", "", "how far beside its edge a face that meets it there may be, in `ends`"),
        (
            "plane",
            "m",
            "rounding bound of the plane, at most `ends`; a tilted one grows",
        ),
        ("outer_minus_u", "m", "as outer_u, on the other side of the centre"),
        ("outer_minus_v", "m", "as outer_v, on the other side of the centre"),
        ("inner_minus_u", "m", "as inner_u, on the other side of the centre"),
        ("inner_minus_v", "m", "as inner_v, on the other side of the centre"),
    )
    faced: ClassVar[bool] = False
    flat: ClassVar[bool] = True
    has_map: ClassVar[bool] = True

    @property
    @abstractmethod
    def outline(self) -> Outline:
        """What bounds it in its plane."""

    @property
    def hole(self) -> Outline | None:
        """What is cut out of it around the centre."""
        return None

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Its face, of which both sides are meant."""
        return (Plane(name="face", outline=self.outline, hole=self.hole),)

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Half extents along u and v in metres."""
        return self.outline.half_sizes

    @property
    def class_axis(self) -> int | None:
        """World axis of the normal; None where it is tilted."""
        return None if self.tilt_deg != (0.0, 0.0) else axis_index(self.axis) // 2

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        u, v = self.half_sizes
        return (-u, -v, 0.0), (u, v, 0.0)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the half sizes with their rounding bounds, see ``kernels/lib/flat.mako``.

        The bounds are what the rounding of a hit point's coordinates can amount to: a few units
        in the last place of the element's size and distance from the origin, and at the edges +u,
        −u, +v and −v `at_edges` times that.
        """
        far = max(map(abs, centre))
        hu, hv = self.half_sizes
        plus_u, minus_u, plus_v, minus_v = at_edges
        if axis is not None:
            # its kernel has one bound for both sides; for +a the frame's u is world axis a + 1, for
            # -a it is a + 2
            plus_u, plus_v = max(plus_u, minus_u), max(plus_v, minus_v)
            if axis_index(self.axis) % 2 == 1:
                hu, hv, plus_u, plus_v = hv, hu, plus_v, plus_u
            minus_u, minus_v = plus_u, plus_v
        # A point put back within the inner bound lies on the right side of a face that shares the
        # edge, whatever rounding.
        grows, shrinks = EDGES if axis is not None else EDGES_TILTED

        def bounds(half: float, factor: float) -> tuple[float, float]:
            room = factor * roundoff * (half + far)
            return half + grows * room, max(half - shrinks * room, 0.5 * half)

        outer_u, inner_u = bounds(hu, plus_u)
        outer_v, inner_v = bounds(hv, plus_v)
        outer_minus_u, inner_minus_u = bounds(hu, minus_u)
        outer_minus_v, inner_minus_v = bounds(hv, minus_v)
        # what comes to this plane on another face has crossed about as much as this one's size
        plane = far if axis is None else abs(centre[axis]) + max(hu, hv)
        # other faces end at this one to within the rounding of all coordinates
        ends = far + (hu + hv if axis is None else max(hu, hv))
        # how far aside a point of a face that meets this one at its edge may be where it is 64 of
        # that over it
        aside = 64.0 * max(2.0, *at_edges)
        return {
            "outer_u": outer_u,
            "outer_v": outer_v,
            "inner_u": inner_u,
            "inner_v": inner_v,
            "ends": 4.0 * roundoff * ends,
            "sign": -1.0 if axis_index(self.axis) % 2 else 1.0,
            "aside": aside,
            "plane": 4.0 * roundoff * plane,
            "outer_minus_u": outer_minus_u,
            "outer_minus_v": outer_minus_v,
            "inner_minus_u": inner_minus_u,
            "inner_minus_v": inner_minus_v,
        }
