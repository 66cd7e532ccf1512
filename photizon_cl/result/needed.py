"""How many batches a target takes, told from those that are there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.result.stopping import LEAST_BATCHES, judged

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator

__all__ = ["batches_needed", "sampling_step"]

_MANY: Final = 16
"""Bins from which on their scatter tells how well their median is known."""
_LOOKED_AT: Final = 1 << 16
"""Bins of a map of very many that are looked at: of so many the median is known to 1 %."""
_ROUNDS: Final = 60
_WIDEST: Final = 3.0
"""Relative error beyond which nothing is known: an interval of a factor e^6 to either side."""


def batches_needed(layout: TallyLayout, tally: Accumulator, target: float) -> tuple[float, float]:
    """Return at which batch a run should meet its target, and the relative error of that.

    σ falls with the square root of the batches, and the median over lit bins stands still
    meanwhile only where all of them are lit: as dimmer ones reach their tenth arrival they count
    too, and the median rises. So it is taken over those that will be lit by then.

    Parameters
    ----------
    layout, tally : TallyLayout, Accumulator
        What the run has, at least two batches, and what that means.
    target : float
        Relative standard error to reach, as `achieved_sigma` gives it.

    Returns
    -------
    batches, spread : float
        Of several quantities that must each meet it those of the one that takes longest; infinite
        where nothing arrived.
    """
    found = [_of(ranges, bins, tally, target) for ranges, bins in judged(layout)]
    return max(found)


def _of(
    ranges: list[tuple[int, int]], bins: bool, tally: Accumulator, target: float
) -> tuple[float, float]:
    """Return the same of the median over some ranges of cells, which are bins or are not."""
    n = tally.batches
    parts = [_cells(tally, *r, bins=bins) for r in ranges]
    count = np.concatenate([c for c, _ in parts])
    # of one batch, relative to the mean
    variance = np.concatenate([v for _, v in parts])
    # few bins are as good as one: they may be the two sides of a balance
    many = bins and len(variance) >= _MANY
    least = LIT_COUNT if bins else 0
    batches = float(n)
    median = math.nan
    for _ in range(_ROUNDS):
        lit = variance[count * (batches / n) >= least]
        if not len(lit):
            if not len(variance):
                return math.inf, 0.0
            # until the first of them is lit, whatever rounding says of that
            batches = max(n * least / float(count.max()), batches) * (1.0 + 1e-9)
            continue
        median = float(np.median(lit))
        # the median of an estimated variance lies below the variance, the less the more batches
        wanted = median / target**2 * _low(batches) / _low(n)
        if wanted <= batches * (1.0 + 1e-6):
            break
        batches = wanted
    batches = max(median / target**2 * _low(batches) / _low(n), LEAST_BATCHES)
    if many and len(lit) >= _MANY:
        half = 0.5 / math.sqrt(len(lit))
        low, high = np.quantile(lit, (0.5 - half, 0.5 + half))
        # bins of two kinds, in the light and in a shadow, have a median that is hardly known
        spread = min(float(high - low) / (2.0 * median), _WIDEST) if median else 0.0
    else:
        spread = math.sqrt(2.0 / (n - 1))
    # what is there already is part of the outcome
    return batches, spread * math.sqrt(max(1.0 - n / batches, 0.0))


def _cells(
    tally: Accumulator, first: int, n: int, *, bins: bool
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return arrivals and relative variance of a batch, of the cells of a range with a mean."""
    if bins:
        count, mean, error = tally.reached(first, n, sampling_step(n, _LOOKED_AT))
    else:
        mean, error = tally.mean(first, n), tally.standard_error(first, n)
        count = tally.counts(first, n)
    known = mean > 0.0
    return count[known], tally.batches * (error[known] / mean[known]) ** 2


def sampling_step(bins: int, most: int) -> int:
    """Return which bins are looked at of very many: each so-manyth, a prime, so across columns.

    Parameters
    ----------
    bins : int
        How many there are.
    most : int
        How many are looked at.
    """
    step = -(-bins // most)
    while any(step % d == 0 for d in range(2, math.isqrt(step) + 1)):
        step += 1
    return step


def _low(batches: float) -> float:
    """Return the median of the variance that normal batches show, of what it is."""
    return float((1.0 - 2.0 / (9.0 * (batches - 1.0))) ** 3)
