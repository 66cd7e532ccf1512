"""When a run stops: the accuracy that it reached, and the goal that it had."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.compile.layout import ABSORBED_IN

if TYPE_CHECKING:
    from photizon_cl.compile.layout import Quantity, TallyLayout
    from photizon_cl.result.statistics import Accumulator

__all__ = ["LEAST_BATCHES", "Goal", "History", "achieved_sigma", "judged", "relative_sigma"]

LEAST_BATCHES: Final = 8
"""Batches before a target can be met: a standard error from fewer is itself too uncertain."""


@dataclass(frozen=True)
class Goal:
    """What a run is to reach; it ends at whichever comes first.

    Parameters
    ----------
    batches : int or None
        Batches in all.
    target : float or None
        Median relative standard error, as `achieved_sigma` gives it.
    max_seconds : float or None
        Time on the host's clock; checked between waves, and at least one batch is made.
    """

    batches: int | None = None
    target: float | None = None
    max_seconds: float | None = None

    def reached(self, layout: TallyLayout, tally: Accumulator) -> bool:
        """Say whether the run ends behind the batch that was added last, time aside."""
        if self.batches is not None and tally.batches >= self.batches:
            return True
        if self.target is None or tally.batches < LEAST_BATCHES:
            return False
        achieved = achieved_sigma(layout, tally)
        return achieved is not None and achieved <= self.target


def achieved_sigma(layout: TallyLayout, tally: Accumulator) -> float | None:
    """Return the median relative standard error of what a scene is about.

    Over the bins with at least 10 arrivals of all maps together; without a map, over the
    detectors' totals; without a detector, over the absorbed rows, those of what media absorb among
    them, and the escaped row. Totals and rows that are zero have no relative error and are left
    out. Where a run names quantities that must each meet its target, the largest of their relative
    standard errors.

    Returns
    -------
    float or None
        None with a single batch, or where nothing has a relative error.
    """
    if tally.batches < 2:
        return None
    errors = [_median(ranges, tally, bins=bins) for ranges, bins in judged(layout)]
    return None if None in errors else max(e for e in errors if e is not None)


def judged(layout: TallyLayout) -> list[tuple[list[tuple[int, int]], bool]]:
    """Return what must each meet a target: ranges of cells, and whether they are bins.

    The median over all cells of a row's ranges counts, of bins over those that are lit.
    """
    if layout.watched:
        return [([(q.first, q.bins or 1)], bool(q.bins)) for q in layout.watched]
    maps = [(d.map, d.nx * d.ny) for d in layout.detectors if d.nx]
    if maps:
        return [(maps, True)]
    powers = [(d.power, 1) for d in layout.detectors]
    inside = [(layout.row(r.name), 1) for r in layout.rows if r.name.startswith(f"{ABSORBED_IN}.")]
    return [(powers or [(0, layout.n_elements + 1), *inside], False)]


def _median(ranges: list[tuple[int, int]], tally: Accumulator, *, bins: bool) -> float | None:
    """Return the median relative standard error of some cells; None where nothing arrived."""
    if bins:
        found = [tally.well_counted(*r) for r in ranges]
    else:
        found = [(tally.mean(*r), tally.standard_error(*r)) for r in ranges]
    mean = np.concatenate([mean for mean, _ in found])
    error = np.concatenate([error for _, error in found])
    known = mean > 0.0
    return float(np.median(error[known] / mean[known])) if known.any() else None


def relative_sigma(quantity: Quantity, tally: Accumulator) -> float | None:
    """Return a quantity's relative standard error; of bins the median over those that are lit.

    Returns
    -------
    float or None
        None with a single batch, or where nothing arrived.
    """
    if tally.batches < 2:
        return None
    return _median([(quantity.first, quantity.bins or 1)], tally, bins=bool(quantity.bins))


class History:
    """How σ fell while a run went on.

    Parameters
    ----------
    rows : tuple of (int, float, float or None)
        What is known from earlier calls: batches, seconds, σ.
    seconds : float
        Time of those calls.
    """

    _MOST: Final = 512
    """Rows, beyond which every other one is dropped."""
    _SHARE: Final = 0.02
    """Part of a run's time that looking at σ may take."""

    def __init__(self, rows: tuple[tuple[int, float, float | None], ...], seconds: float) -> None:
        self.rows = rows
        self._before = seconds
        self._next = 0.0

    def note(
        self, layout: TallyLayout, tally: Accumulator, elapsed: float, *, last: bool = False
    ) -> None:
        """Add a row, where it is time for one or this is the last one of the call."""
        if elapsed < self._next and not last:
            return
        if self.rows and self.rows[-1][0] == tally.batches:
            return
        started = time.perf_counter()
        achieved = achieved_sigma(layout, tally)
        self._next = elapsed + (time.perf_counter() - started) / self._SHARE
        rows = self.rows if len(self.rows) < self._MOST else self.rows[1::2]
        self.rows = (*rows, (tally.batches, self._before + elapsed, achieved))
