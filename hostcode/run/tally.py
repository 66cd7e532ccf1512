"""Exact tallies: integer limbs of 2^-31, 2^-63 and 2^-95, and a count.

A cell is four 64-bit integers (a, b, c, count) that stand for (a·2^64 + b·2^32 + c)·2^-95 launched
weights. Sums of cells are exact and do not depend on order. The canonical form has 0 ≤ b, c < 2^32;
two tallies stand for the same numbers exactly when their canonical forms are the same bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["CELL", "UNIT_EXPONENT", "canonical", "exact", "image", "values"]

CELL: Final = 4
"""Integers of one cell."""
UNIT_EXPONENT: Final = -95
"""Exponent of the last limb's unit."""

_LOW: Final = np.int64(0xFFFFFFFF)


def canonical(tally: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a tally with its carries propagated.

    Parameters
    ----------
    tally : ndarray, shape (n, 4), int64
        Limbs and counts; the limbs may have any sign.
    """
    out = tally.copy()
    out[:, 1] += out[:, 2] >> 32
    out[:, 2] &= _LOW
    out[:, 0] += out[:, 1] >> 32
    out[:, 1] &= _LOW
    return out


def values(tally: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the cells' values in launched weights, rounded to at most one unit in the last place.

    Parameters
    ----------
    tally : ndarray, shape (n, 4), int64
        In canonical form.
    """
    low = tally[:, 2] * 2.0**UNIT_EXPONENT + tally[:, 1] * 2.0 ** (UNIT_EXPONENT + 32)
    return np.asarray(tally[:, 0] * 2.0 ** (UNIT_EXPONENT + 64) + low, dtype=np.float64)


def exact(tally: NDArray[np.int64]) -> list[int]:
    """Return the cells as whole numbers of 2^-95 launched weights."""
    return [(int(a) << 64) + (int(b) << 32) + int(c) for a, b, c, _ in tally]


def image(weight: float) -> int:
    """Return a weight as a whole number of 2^-95, rounded as the kernels round it.

    Parameters
    ----------
    weight : float
        Between 0 and 4.
    """
    scaled = weight * 2.0**31
    total = 0
    for _ in range(3):
        whole = int(np.rint(scaled))
        total = (total << 32) + whole
        scaled = (scaled - whole) * 2.0**32
    return total
