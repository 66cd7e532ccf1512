"""A BSDF that was measured."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from photizon_cl.errors import Problem, counted, show
from photizon_cl.scene.declarations import declare
from photizon_cl.scene.number_lists import Ascending
from photizon_cl.scene.parameters import Number, Numbers
from photizon_cl.scene.rows import NO_ROW, Row
from photizon_cl.scene.scatters.base import NARROWEST, Scatter
from photizon_cl.scene.scatters.total import pieces_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters.total import Array

_MOST: Final = 128
"""Nodes of a table."""
_CLOSEST: Final = 1e-7
"""How far apart nodes are at least."""
_LEAST_TAKEN: Final = 1.0 / 50.0
"""Part of the directions tried that must be above the horizon and under the table's lines."""


@dataclass(frozen=True)
class TableScatter(Scatter):
    """A table of the BSDF over Δ: linear between its nodes, constant below the first.

    Beyond the last node nothing is scattered.

    Parameters
    ----------
    delta : sequence of float
        Δ of the nodes, 1 to 128 of them, ascending from 0 to 2 and at least 1e-7 apart.
    bsdf_per_sr : sequence of float
        BSDF in 1/sr at each, not negative.
    """

    kind: ClassVar[str] = "table"
    kernel: ClassVar[str] = "table"
    does: ClassVar[str] = "scatter by a table of the BSDF"
    costs: ClassVar[str] = (
        "two random blocks and three searches of the table for each that is tried"
    )
    row: ClassVar[Row] = NO_ROW
    sample: ClassVar[Mapping[str, object]] = MappingProxyType(
        {"delta": (0.0, 0.01, 0.1, 1.0), "bsdf_per_sr": (10.0, 5.0, 0.1, 0.005)}
    )

    delta: Sequence[float] = field(
        metadata=declare(
            Ascending(
                "values of Δ", 0.0, 2.0, least=1, most=_MOST, closest=_CLOSEST,
                meaning="Δ of the nodes",
            )
        )
    )  # fmt: skip
    bsdf_per_sr: Sequence[float] = field(
        metadata=declare(
            Numbers(
                "a list of numbers from 0 to 1e18, one for each Δ",
                Number("a number from 0 to 1e18", 0.0, 1e18),
                meaning="BSDF in 1/sr at each",
            )
        )
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is a value for each node, and that they can be sampled."""
        delta, values = known.get("delta"), known.get("bsdf_per_sr")
        if delta is None or values is None:
            return []
        if len(delta) != len(values):
            expected = f"{counted(len(delta), 'number')}, one for each delta"
            return [Problem("bsdf_per_sr", f"{len(values)} of them", expected)]
        if delta[-1] == 0.0:
            hint = "beyond the last node nothing is scattered"
            return [Problem("delta", show(delta), "a last one above 0", hint=hint)]
        return []

    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0."""
        at, rest = self._place(delta)
        r, f = np.array(self._nodes), np.array(self._values)
        slope = np.append(np.diff(f) / np.diff(r), 0.0)
        return np.where(delta <= r[-1], f[at] + slope[at] * rest, 0.0)

    def within(self, radius: Array) -> Array:
        """Return ∫ BSDF(s) s ds from 0 to a radius."""
        at, rest = self._place(np.minimum(radius, self._nodes[-1]))
        r: Array = np.array(self._nodes)
        f: Array = np.array(self._values)
        slope = np.append(np.diff(f) / np.diff(r), 0.0)
        whole = [0.0]
        for k, step in enumerate(np.diff(r).tolist()):
            whole.append(whole[-1] + float(_part(r[k], f[k], slope[k], step)))
        before: Array = np.array(whole)
        return before[at] + _part(r[at], f[at], slope[at], rest)

    @property
    def width(self) -> float:
        """The first Δ that is told from 0: kinks are known besides."""
        return next(iter(self.kinks), 1.0)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Values of Δ where it is not smooth.

        Not those that no direction tells from 0: it is constant below the first node, and the next
        one is far.
        """
        return tuple(d for d in self.delta if d > NARROWEST)

    @property
    def falls(self) -> bool:
        """Whether no value is above the one before."""
        return all(b <= a for a, b in zip(self._values, self._values[1:], strict=False))

    def packed(self) -> dict[str, float]:
        """Return nothing: there are nodes."""
        return {}

    @property
    def nodes(self) -> list[list[float]]:
        """Of each node Δ, BSDF, slope behind it, height and sum of what is tried."""
        r, f = self._nodes, self._values
        rows: list[list[float]] = []
        so_far = 0.0
        for k in range(len(r)):
            last = k + 1 == len(r)
            slope = 0.0 if last else (f[k + 1] - f[k]) / (r[k + 1] - r[k])
            most = 0.0 if last else max(f[k], f[k + 1])
            rows.append([r[k], f[k], slope, most, so_far])
            if not last:
                so_far += 0.5 * most * (r[k + 1] - r[k]) * (r[k + 1] + r[k])
        return rows

    @property
    def _nodes(self) -> tuple[float, ...]:
        return (*((0.0,) if self.delta[0] > 0.0 else ()), *self.delta)

    @property
    def _values(self) -> tuple[float, ...]:
        return (*((self.bsdf_per_sr[0],) if self.delta[0] > 0.0 else ()), *self.bsdf_per_sr)

    def _place(self, delta: Array) -> tuple[NDArray[np.intp], Array]:
        r = np.array(self._nodes)
        at = np.clip(np.searchsorted(r, delta, side="right") - 1, 0, len(r) - 1)
        return at, delta - r[at]

    def refusal(self) -> str:
        """Say why it cannot be sampled, empty where it can.

        Kernels try directions under the steps that lie over its lines, until one is under the lines
        and above the horizon: the part of those is bounded from below for what nowhere grows.
        """
        if self.falls:
            return ""
        pieces = pieces_of(self)
        d = 0.5 * (pieces.edges[:-1] + pieces.edges[1:])
        tis = pieces(d)
        tried = 2.0 * math.pi * self._tried_within(2.0 - d)
        seen = tis > 1e-7 * float(tis.max(initial=0.0))
        least = float((tis[seen] / tried[seen]).min(initial=1.0))
        if least >= _LEAST_TAKEN:
            return ""
        return (
            f"it grows with Δ so that at some angle only {least:.2g} of the directions that are "
            "tried would be above the horizon; let it grow less, or give it more nodes"
        )

    def _tried_within(self, radius: Array) -> Array:
        rows: Array = np.array(self.nodes)
        at, _ = self._place(radius)
        r, most = rows[at, 0], rows[at, 3]
        part: Array = 0.5 * most * (radius - r) * (radius + r)
        before: Array = rows[at, 4]
        return before + part


def _part(r: Array, f: Array, slope: Array, h: Array | float) -> Array:
    """Return ∫ (f + slope x)(r + x) dx from 0 to h."""
    return h * (f * r + h * (0.5 * (f + slope * r) + h * slope / 3.0))
