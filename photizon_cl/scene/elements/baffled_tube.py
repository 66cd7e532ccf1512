"""The square tube with baffles."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import integer, number, positive_length
from photizon_cl.scene.elements.base import ROUNDOFF, Element
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.outlines import Rectangular
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.frames import Vec3

MAX_BAFFLES: Final = 4096
CLEAR_RANGE: Final = "a length from 0 to half_width in metres"


@dataclass(frozen=True, kw_only=True)
class BaffledTube(Element):
    """A tube of square section, open at both ends, with thin plates across it.

    `position` is the centre of the square entrance and `axis` points from the entrance to the exit.
    Baffle i of N stands at length·i/(N + 1): a square plate over the whole section with a centred
    square hole of half-width `clear_half_width`, whose rim belongs to the plate. Normals of the
    walls point away from the axis, those of the baffles along it. Without baffles and with mirror
    walls it is a light pipe.

    Parameters
    ----------
    half_width : float
        Half the side of the section, in metres.
    length : float
        Length in metres.
    baffles : int, optional
        N, 0 … 4096.
    clear_half_width : float, optional
        Half the side of the holes in metres, at most `half_width`. Required where there are
        baffles, ignored where there are none.
    """

    kind: ClassVar[str] = "baffled-tube"
    kernel: ClassVar[str] = "baffled_tube"
    does: ClassVar[str] = "walls and baffles of a square tube hit"
    costs: ClassVar[str] = "one division a wall and a baffle a segment"
    templates: ClassVar[tuple[str, ...]] = ("lib/local", "elements/baffled_tube")
    traits: ClassVar[frozenset[str]] = frozenset({"moves-hits", "own-sides"})
    row: ClassVar[Row] = Row(
        "BAFFLED_TUBE",
        ("half", "m", "half the side of the section"),
        ("outer", "m", "the same with its rounding bound"),
        ("inner", "m", "the same less that bound"),
        ("length", "m", "length"),
        ("plates", "", "number of baffles"),
        ("hole", "m", "half the side of their holes less its rounding bound"),
        ("near", "m", "rounding bound of a coordinate"),
    )
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "inside"
    faces_at_a_point: ClassVar[int] = 3

    half_width: float = field(metadata=positive_length("half the side of the section"))
    length: float = field(metadata=positive_length("length"))
    baffles: int = field(default=0, metadata=integer(0, MAX_BAFFLES, "number of baffles"))
    clear_half_width: float | None = field(
        default=None,
        metadata=number(CLEAR_RANGE, 0.0, 1e150, "half the side of the baffles' holes", "m"),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check the holes against the tube."""
        problems = super().cross_check(known)
        clear, half = known.get("clear_half_width"), known.get("half_width")
        if known.get("baffles"):
            if clear is None:
                problems.append(
                    Problem("clear_half_width", "nothing", CLEAR_RANGE, hint="baffles need a hole")
                )
            elif clear is not None and half is not None and clear > half:
                problems.append(
                    Problem(
                        "clear_half_width",
                        show(clear),
                        f"at most half_width, {show(half)}",
                        hint="the hole cannot be wider than the tube",
                    )
                )
        return problems

    @classmethod
    def wall_reason(cls, known: Known) -> str:
        """Say why a tube's surface cannot refract."""
        return "a tube is a wall, not a solid with an inside of glass; take a wall's surface"

    @property
    def reach(self) -> float:
        """Distance in metres from the centre of the entrance to the exit's corners."""
        return math.hypot(self.half_width, self.half_width, self.length)

    @property
    def baffle_positions(self) -> tuple[float, ...]:
        """Distances of the baffles from the entrance in metres."""
        return tuple(self.length * (i + 1) / (self.baffles + 1) for i in range(self.baffles))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The walls at +u, −u, +v and −v, then the baffles."""
        h, middle = self.half_width, 0.5 * self.length
        wall, back = Rectangular(h, middle), (0.0, 0.0, -1.0)
        walls = [
            Plane(
                name="wall",
                outline=wall,
                centre=(h * x, h * y, middle),
                frame=((y, -x, 0.0), back, (x, y, 0.0)),
            )
            for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
        ]
        clear = self.clear_half_width
        hole = Rectangular(clear, clear) if clear else None
        plate = Rectangular(h, h)
        baffles = [
            Plane(name=f"baffle {i + 1}", outline=plate, hole=hole, centre=(0.0, 0.0, z))
            for i, z in enumerate(self.baffle_positions)
        ]
        return (*walls, *baffles)

    @property
    def local_box(self) -> tuple[Vec3, Vec3]:
        """Low and high corner in local coordinates, in metres."""
        h = self.half_width
        return (-h, -h, 0.0), (h, h, self.length)

    def packed(
        self,
        centre: Vec3,
        axis: int | None,
        at_edges: Sequence[float] = (),
        roundoff: float = ROUNDOFF,
    ) -> dict[str, float]:
        """Return the sizes with their bounds."""
        rounding = 4.0 * roundoff * max(map(abs, centre))
        near = rounding + 4.0 * roundoff * self.half_width
        # a tilted tube's coordinates are sums of products as large as its length
        inside = 0.5 * near
        if axis is None:
            inside = 2.0 * near + 4.0 * roundoff * self.length
        clear = self.clear_half_width if self.baffles and self.clear_half_width is not None else 0.0
        return {
            "half": self.half_width,
            "outer": self.half_width + near,
            "inner": self.half_width - inside,
            "length": self.length,
            "plates": float(self.baffles),
            "hole": clear - near,
            "near": rounding,
        }

    @property
    def area(self) -> float:
        """Area of one side of the walls and of the baffles in m²."""
        clear = self.clear_half_width or 0.0
        plate = 4.0 * (self.half_width - clear) * (self.half_width + clear)
        return 8.0 * self.half_width * self.length + self.baffles * plate

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the area and where the baffles stand."""
        out = {"area of walls and baffles": (self.area, "m²")}
        for i, at in enumerate(self.baffle_positions[:8]):
            out[f"baffle {i + 1} at"] = (at, "m")
        return out
