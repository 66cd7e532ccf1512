"""Exact tallies: integer limbs of 2^-31, 2^-63 and 2^-95, and a count.

A cell is four 64-bit integers (a, b, c, count) that stand for (a·2^64 + b·2^32 + c)·2^-95 launched
weights. Sums of cells are exact and do not depend on order. The canonical form has 0 ≤ b, c < 2^32;
two tallies stand for the same numbers exactly when their canonical forms are the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

__all__ = [
    "BLOCK",
    "CELL",
    "UNIT_EXPONENT",
    "SparseTally",
    "canonical",
    "carry",
    "exact",
    "image",
    "is_sparse",
    "lit_rows",
    "merged",
    "some_of",
    "values",
    "whole_of",
]

CELL: Final = 4
"""Integers of one cell."""
UNIT_EXPONENT: Final = -95
"""Exponent of the last limb's unit."""

BLOCK: Final = 1 << 16
"""Cells that are worked on together where all of them would take much memory."""

_LOW: Final = np.int64(0xFFFFFFFF)
_SPARSE_FROM: Final = 1 << 22
"""Cells from which on a tally is kept without those that are zero."""


def is_sparse(n_cells: int) -> bool:
    """Say whether a tally of so many cells is kept without those that are zero.

    A map of very many bins has few arrivals in a batch, and whole it takes gigabytes, several times
    over.
    """
    return n_cells >= _SPARSE_FROM


@dataclass(frozen=True, eq=False)
class SparseTally:
    """A tally of which the cells that are zero are left out.

    Parameters
    ----------
    n_cells : int
        Cells that it stands for.
    numbers : ndarray, shape (m,), int64
        Which cells there are, ascending.
    rows : ndarray, shape (m, 4), int64
        These, in canonical form.
    """

    n_cells: int
    numbers: NDArray[np.int64]
    rows: NDArray[np.int64]

    def __post_init__(self) -> None:
        """See that the arrays are what they should be.

        Raises
        ------
        ValueError
            Where they are not: it may come from another process.
        """
        m = len(self.numbers)
        fits = self.numbers.shape == (m,) and self.rows.shape == (m, CELL)
        if not fits or self.numbers.dtype != np.int64 or self.rows.dtype != np.int64:
            raise ValueError("numbers and rows do not belong together")
        if m and not (
            self.numbers[0] >= 0
            and self.numbers[-1] < self.n_cells
            and (self.numbers[1:] > self.numbers[:-1]).all()
        ):
            raise ValueError("numbers do not ascend")

    @classmethod
    def of(cls, cells: NDArray[np.int64]) -> SparseTally:
        """Return all cells of an array, shape (n_cells, 4), without those that are zero."""
        lit = lit_rows(cells)
        return cls(len(cells), lit, cells[lit])

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays."""
        return self.numbers.nbytes + self.rows.nbytes

    def copy(self) -> SparseTally:
        """Return a tally that shares nothing with this one, looked at again."""
        return SparseTally(self.n_cells, self.numbers.copy(), self.rows.copy())

    def within(self, first: int, n: int) -> SparseTally:
        """Return some of the cells, numbered from 0."""
        begin, end = np.searchsorted(self.numbers, (first, first + n))
        return SparseTally(n, self.numbers[begin:end] - first, self.rows[begin:end])

    def whole(self) -> NDArray[np.int64]:
        """Return all cells, shape (n_cells, 4)."""
        out = np.zeros((self.n_cells, CELL), np.int64)
        out[self.numbers] = self.rows
        return out

    def blocks(self) -> Iterator[tuple[int, SparseTally]]:
        """Give all cells in order, some at a time: the number of the first, and they."""
        firsts = np.arange(0, self.n_cells, BLOCK)
        bounds = np.searchsorted(self.numbers, np.append(firsts, self.n_cells))
        for k, first in enumerate(firsts.tolist()):
            part = slice(bounds[k], bounds[k + 1])
            n = min(BLOCK, self.n_cells - first)
            yield first, SparseTally(n, self.numbers[part] - first, self.rows[part])

    def with_cells(self, cells: dict[int, NDArray[np.int64]]) -> SparseTally:
        """Return the tally with some cells replaced; they may be zero."""
        new = np.setdiff1d(np.array(list(cells), np.int64), self.numbers)
        at = np.searchsorted(self.numbers, new)
        numbers = np.insert(self.numbers, at, new)
        rows = np.insert(self.rows, at, 0, axis=0)
        for cell, row in cells.items():
            rows[np.searchsorted(numbers, cell)] = row
        return SparseTally(self.n_cells, numbers, rows)


def lit_rows(tally: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return which cells of an array are not all zero, ascending, shape (m,), int64."""
    # by number of the integer: far faster than asking row by row where few are lit
    found = np.asarray(np.flatnonzero(tally.reshape(-1)) // CELL, dtype=np.int64)
    if not len(found):
        return found
    return np.asarray(found[np.append(True, found[1:] != found[:-1])])


def some_of(cells: NDArray[np.int64] | SparseTally, first: int, n: int) -> NDArray[np.int64]:
    """Return a range of a tally's cells, shape (m, 4), perhaps without those that are zero."""
    if isinstance(cells, SparseTally):
        return cells.within(first, n).rows
    return cells[first : first + n]


def whole_of(cells: NDArray[np.int64] | SparseTally, first: int, n: int) -> NDArray[np.int64]:
    """Return a range of a tally's cells, shape (n, 4)."""
    if isinstance(cells, SparseTally):
        return cells.within(first, n).whole()
    return cells[first : first + n]


def merged(a: SparseTally, b: SparseTally) -> SparseTally:
    """Return the sum of two tallies in canonical form."""
    numbers = np.union1d(a.numbers, b.numbers)
    rows = np.zeros((len(numbers), CELL), np.int64)
    for part in (a, b):
        rows[np.searchsorted(numbers, part.numbers)] += part.rows
    return SparseTally(a.n_cells, numbers, canonical(rows))


def canonical(tally: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a tally with its carries propagated.

    Parameters
    ----------
    tally : ndarray, shape (n, 4), int64
        Limbs and counts; the limbs may have any sign.
    """
    out = tally.copy()
    carry(out)
    return out


def carry(tally: NDArray[np.int64]) -> None:
    """Bring a tally, shape (n, 4), into canonical form where it stands."""
    tally[:, 1] += tally[:, 2] >> 32
    tally[:, 2] &= _LOW
    tally[:, 0] += tally[:, 1] >> 32
    tally[:, 1] &= _LOW


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
