"""How what escapes is binned by direction."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import declare, integer, tilt
from photizon_cl.scene.described import ABSENT, Accepts, Described
from photizon_cl.scene.edges import even_edges
from photizon_cl.scene.frames import AXES, frame, sincos_deg
from photizon_cl.scene.number_lists import Ascending
from photizon_cl.scene.parameters import Choice

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.frames import Frame

__all__ = ["MAX_FAR_FIELD_BINS", "FarField"]

MAX_FAR_FIELD_BINS: Final = 8192
_USUAL_ROWS: Final = 40
_CLOSEST: Final = 1e-9
"""Degrees between edges at least: a direction of doubles is known to some 1e-14."""
_NO_TILT: Final[Any] = (0.0, 0.0)
_ROWS: Final = ("n_mu", "n_theta", "theta_edges_deg")
"""Parameters that say what the rows are; one of them is given at most."""


class _Axis(Choice):
    """One of the six axes; written where it is not the usual one."""

    silent = True


@dataclass(frozen=True, kw_only=True)
class FarField(Described):
    """The ``[far_field]`` table: bins for what escapes.

    Rows are by the angle θ from `axis`: of equal solid angle, ascending in cos θ from −1 (`n_mu`),
    or ascending in θ, of equal width from 0 to 180° (`n_theta`) or between edges that are given
    (`theta_edges_deg`). Columns are `n_phi` equal parts of the turn about the axis, from its u
    towards its v. What leaves outside the edges escapes unbinned.

    Parameters
    ----------
    axis : str
        Where θ is 0: one of the six axes; for ``+z`` φ runs from world +x towards +y.
    tilt_deg : pair of float, optional
        Turns that axis, as it does a source's or an element's.
    n_mu : int, optional
        Bins in cos θ, 1 … 8192; 40 where nothing else says what the rows are.
    n_theta : int, optional
        Bins in θ instead, 1 … 8192.
    theta_edges_deg : sequence of float, optional
        Edges of bins in θ instead, in degrees: 2 … 8193, ascending within 0 … 180. A direction on
        an edge belongs to the bin above it, on the last edge to the last bin.
    n_phi : int
        Bins in φ, 1 … 8192.
    """

    label: ClassVar[str] = "far_field"
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {item: tuple(other for other in _ROWS if other != item) for item in _ROWS}
    )

    axis: str = field(
        default="+z", metadata=declare(_Axis(AXES, meaning="where θ is 0; φ from its u towards v"))
    )
    tilt_deg: Accepts[Sequence[float], tuple[float, float]] = field(
        default=_NO_TILT, metadata=tilt()
    )
    n_mu: int | None = field(
        default=None,
        metadata=integer(1, MAX_FAR_FIELD_BINS, f"bins in cos θ, {_USUAL_ROWS} by default"),
    )
    n_theta: int | None = field(
        default=None,
        metadata=integer(1, MAX_FAR_FIELD_BINS, "bins of equal width in θ, instead of n_mu"),
    )
    theta_edges_deg: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT,
        metadata=declare(
            Ascending(
                "angles in degrees",
                0.0,
                180.0,
                least=2,
                most=MAX_FAR_FIELD_BINS + 1,
                closest=_CLOSEST,
                meaning="edges of bins in θ, instead of n_mu",
                unit="deg",
                hint="θ is 0 along the axis and 180 against it",
            )
        ),
    )
    n_phi: int = field(default=32, metadata=integer(1, MAX_FAR_FIELD_BINS, "bins in φ"))

    def __post_init__(self) -> None:
        """Check every value; where nothing says what the rows are, they are the usual ones."""
        super().__post_init__()
        if all(getattr(self, item) is None for item in _ROWS):
            object.__setattr__(self, "n_mu", _USUAL_ROWS)

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Refuse two descriptions of the rows."""
        given = [item for item in _ROWS if known.get(item) is not None]
        return [
            Problem(
                item,
                show(known.get(item)),
                f"nothing beside {given[0]}",
                hint=f"{given[0]} says what the rows are; give one of {', '.join(_ROWS)}",
            )
            for item in given[1:]
        ]

    @property
    def frame(self) -> Frame:
        """u, v and axis as unit vectors in the world."""
        return frame(self.axis, self.tilt_deg)

    @property
    def turned(self) -> bool:
        """Whether its frame is another than the world's."""
        return self.frame != frame("+z")

    @property
    def by_theta(self) -> bool:
        """Whether rows ascend in θ; else in cos θ, from −1."""
        return self.n_mu is None

    @cached_property
    def edges_deg(self) -> tuple[float, ...]:
        """Edges of the bins in θ in degrees, ascending; where the rows are bins in θ."""
        if self.theta_edges_deg is not None:
            return self.theta_edges_deg
        assert self.n_theta is not None
        return tuple(even_edges(0.0, 180.0, self.n_theta))

    @property
    def rows(self) -> int:
        """Bins in θ or cos θ."""
        return len(self.edges_deg) - 1 if self.n_mu is None else self.n_mu

    @property
    def rows_by(self) -> str:
        """What makes the rows as many as they are, as advice names it."""
        if self.theta_edges_deg is not None:
            return "the number of far_field.theta_edges_deg"
        return "far_field.n_theta" if self.by_theta else "far_field.n_mu"

    @property
    def whole(self) -> bool:
        """Whether every direction is in a bin."""
        return self.n_mu is not None or self.edges_deg[:: self.rows] == (0.0, 180.0)

    @cached_property
    def solid_angles(self) -> tuple[float, ...]:
        """Solid angle of a bin of each row in steradians.

        (2/n_mu)(2π/n_phi), or (4π/n_phi) sin((a + b)/2) sin((b − a)/2) for a row from a to b, which
        is (2π/n_phi)(cos a − cos b) without its cancellation.
        """
        if self.n_mu is not None:
            return (2.0 / self.n_mu * (2.0 * math.pi / self.n_phi),) * self.n_mu
        unit, edges = 4.0 * math.pi / self.n_phi, self.edges_deg
        return tuple(
            unit * sincos_deg(0.5 * (a + b))[0] * sincos_deg(0.5 * (b - a))[0]
            for a, b in pairwise(edges)
        )

    def single(self) -> FarField:
        """Return one bin for everything, which the same program counts."""
        if self.by_theta:
            return replace(self, n_theta=1, theta_edges_deg=None, n_phi=1)
        return replace(self, n_mu=1, n_phi=1)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the solid angle of a bin: of the smallest and the largest where they differ."""
        if not self.by_theta:
            return {"bin solid angle": (self.solid_angles[0], "sr")}
        smallest, largest = min(self.solid_angles), max(self.solid_angles)
        return {"smallest bin": (smallest, "sr"), "largest bin": (largest, "sr")}
