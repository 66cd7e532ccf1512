"""Tests of hypotheses with a stated rate of false alarms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from hostcode.run.tally import values
from photizon_cl.result.statistics import complete

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from oracles.engine import Traced


def sidak(alpha: float, n: int) -> float:
    """Return the level of each of n independent tests whose family has level alpha."""
    return float(-np.expm1(np.log1p(-alpha) / n))


def z_limit(alpha: float, degrees: float = np.inf) -> float:
    """Return the two-sided limit of Student's t (the normal law's without degrees)."""
    if np.isinf(degrees):
        return float(stats.norm.isf(alpha / 2))
    return float(stats.t.isf(alpha / 2, degrees))


def chi_square(counts: NDArray[np.int64], shares: NDArray[np.float64], alpha: float) -> None:
    """Assert that counts follow given shares; bins of no share must be empty.

    The last degree of freedom is that of the total, which is given; expected counts are at least 5.
    """
    counts, shares = np.ravel(counts), np.ravel(shares)
    assert abs(shares.sum() - 1.0) < 1e-6, f"shares add up to {shares.sum()}"
    total = counts.sum()
    assert counts[shares < 1e-12].sum() == 0
    expected = shares * total
    rare = expected < 5.0
    if rare.any():  # together they make one bin
        counts = np.append(counts[~rare], counts[rare].sum())
        expected = np.append(expected[~rare], max(expected[rare].sum(), 1e-9))
    if expected[-1] < 5.0:
        counts, expected = counts[:-1], expected[:-1]
    statistic = ((counts - expected) ** 2 / expected).sum()
    assert statistic < stats.chi2.isf(alpha, len(counts) - 1), f"chi2 {statistic} of {len(counts)}"


def batch_values(traced: Traced) -> NDArray[np.float64]:
    """Return each batch's cells in launched weights, shape (n_batches, n_cells)."""
    layout = traced.compiled.layout
    return np.array([values(complete(layout, cells)) for cells in traced.batches])


def batch_mean(
    traced: Traced, quantity: Callable[[NDArray[np.float64]], float]
) -> tuple[float, float]:
    """Return mean and standard error over batches of a function of a batch's cells."""
    sample = np.array([quantity(row) for row in batch_values(traced)])
    return float(sample.mean()), float(sample.std(ddof=1) / np.sqrt(len(sample)))


def batch_z(
    traced: Traced, quantity: Callable[[NDArray[np.float64]], float], truth: float
) -> float:
    """Return (mean − truth)/σ̂ from the scatter between batches."""
    mean, error = batch_mean(traced, quantity)
    return (mean - truth) / error
