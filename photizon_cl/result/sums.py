"""Sums over batches, cell by cell: exact totals, counts, and Welford's mean and squares.

Two forms give the same bits: arrays of all cells, and, where these are very many, blocks that hold
only the cells that something was ever counted in. A cell that is zero in all batches stays zero in
every one of its sums, so that nothing is lost by not holding it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from hostcode.run.tally import BLOCK, UNIT_EXPONENT, SparseTally, values

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

__all__ = ["SPARSE_CELL", "TOTAL_LIMBS", "DenseSums", "SparseSums", "Sums", "totals_of", "welford"]

_LOW: Final = np.int64(0xFFFFFFFF)
SPARSE_CELL: Final = 46
"""Bytes of the sums of a cell where only those that are lit are held."""
TOTAL_LIMBS: Final = 4
"""A total has one limb more than a batch: 2^48 rays of weight 1 pass 2^63 units of 2^-31."""

Rows = tuple["NDArray[np.int64]", "NDArray[np.int64]", "NDArray[Any]", "NDArray[Any]"]
"""Limbs, counts, means and squares of some cells."""
Counted = tuple["NDArray[np.int64]", "NDArray[np.float64]", "NDArray[np.float64]"]
"""Counts, totals and squares of some cells."""


class Sums(Protocol):
    """Sums of `n_cells` cells."""

    n_cells: int

    @classmethod
    def of(cls, n_cells: int, numbers: NDArray[np.int64] | None, rows: Rows) -> Sums:
        """Return sums that hold some rows; copies."""

    def add(self, cells: Any, batches: int) -> None:
        """Add a batch, the `batches`-th, in canonical form."""

    def copy(self) -> Sums:
        """Return an independent copy."""

    def limbs(self, first: int, n: int) -> NDArray[np.int64]:
        """Return exact totals, shape (n, 4)."""

    def count(self, first: int, n: int) -> NDArray[np.int64]:
        """Return counts, shape (n,)."""

    def mean(self, first: int, n: int) -> NDArray[np.float64]:
        """Return the exact totals as numbers, shape (n,)."""

    def m2(self, first: int, n: int) -> NDArray[np.float64]:
        """Return Welford's squares, shape (n,)."""

    def counted(self, first: int, n: int, least: int, every: int = 1) -> Counted:
        """Return counts, totals and squares of the cells with so many counts or more, in order.

        Of the first cell of each `every` alone.
        """

    def rows(self) -> tuple[NDArray[np.int64] | None, Rows]:
        """Return a copy of everything: numbers of the cells, None where it is all, and sums."""


def welford(
    mean: NDArray[np.float64], m2: NDArray[np.float64], x: NDArray[np.float64], batches: int
) -> None:
    """Add numbers of the `batches`-th batch to running means and sums of squared deviations."""
    # a number equal to the mean so far leaves the sum of squares exactly as it is
    delta = x - mean
    mean += delta / batches
    m2 += delta * (x - mean)


def _carry(limbs: NDArray[np.int64]) -> None:
    for k in (3, 2, 1):
        limbs[:, k - 1] += limbs[:, k] >> 32
        limbs[:, k] &= _LOW


def totals_of(limbs: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return exact totals, shape (n, 4), as numbers, in launched weights."""
    # Canonical limbs below the first are not negative: adding from the small end loses nothing.
    total = np.zeros(len(limbs))
    for k in (3, 2, 1, 0):
        total += np.ldexp(limbs[:, k].astype(np.float64), UNIT_EXPONENT + 32 * (3 - k))
    return total


class DenseSums:
    """Sums of all cells in arrays."""

    def __init__(self, n_cells: int) -> None:
        self.n_cells = n_cells
        self._limbs = np.zeros((n_cells, TOTAL_LIMBS), np.int64)
        self._count = np.zeros(n_cells, np.int64)
        self._mean, self._m2 = np.zeros(n_cells), np.zeros(n_cells)

    @classmethod
    def of(cls, n_cells: int, numbers: NDArray[np.int64] | None, rows: Rows) -> DenseSums:
        """Return sums that hold some rows; copies."""
        made = cls(n_cells)
        at = slice(None) if numbers is None else numbers
        for mine, given in zip(made._arrays, rows, strict=True):
            mine[at] = given
        return made

    @property
    def _arrays(self) -> Rows:
        return self._limbs, self._count, self._mean, self._m2

    def add(self, cells: Any, batches: int) -> None:
        """Add a batch, see `Sums`."""
        for first in range(0, self.n_cells, BLOCK):  # what is worked on at a time stays in a cache
            part = slice(first, first + BLOCK)
            some, limbs = cells[part], self._limbs[part]
            limbs[:, 1:] += some[:, :3]
            _carry(limbs)
            self._count[part] += some[:, 3]
            welford(self._mean[part], self._m2[part], values(some), batches)

    def copy(self) -> DenseSums:
        """Return an independent copy."""
        return self.of(self.n_cells, None, self._arrays)

    def limbs(self, first: int, n: int) -> NDArray[np.int64]:
        """Return exact totals, see `Sums`."""
        return self._limbs[first : first + n]

    def count(self, first: int, n: int) -> NDArray[np.int64]:
        """Return counts, see `Sums`."""
        return self._count[first : first + n]

    def mean(self, first: int, n: int) -> NDArray[np.float64]:
        """Return totals as numbers, see `Sums`."""
        return totals_of(self._limbs[first : first + n])

    def m2(self, first: int, n: int) -> NDArray[np.float64]:
        """Return squares, see `Sums`."""
        return self._m2[first : first + n]

    def counted(self, first: int, n: int, least: int, every: int = 1) -> Counted:
        """Return counts, totals and squares of well-counted cells, see `Sums`."""
        part = slice(first, first + n, every)
        count = self._count[part]
        enough = count >= least
        return count[enough], totals_of(self._limbs[part][enough]), self._m2[part][enough]

    def rows(self) -> tuple[NDArray[np.int64] | None, Rows]:
        """Return a copy of everything, see `Sums`."""
        limbs, count, mean, m2 = self._arrays
        return None, (limbs.copy(), count.copy(), mean.copy(), m2.copy())


class _Block:
    """Sums of those of up to 2^16 cells in which something was counted, `SPARSE_CELL` each."""

    __slots__ = ("at", "count", "high", "low", "m2", "mean")

    def __init__(self) -> None:
        self.at = np.empty(0, np.uint16)
        self.high, self.low = np.empty(0, np.int64), np.empty((0, 3), np.uint32)
        self.count = np.empty(0, np.int64)
        self.mean, self.m2 = np.empty(0), np.empty(0)

    @property
    def limbs(self) -> NDArray[np.int64]:
        """Exact totals, shape (m, 4); a copy."""
        out = np.empty((len(self.at), TOTAL_LIMBS), np.int64)
        out[:, 0], out[:, 1:] = self.high, self.low
        return out

    def set(self, where: NDArray[Any], limbs: NDArray[np.int64]) -> None:
        """Set exact totals in canonical form."""
        self.high[where], self.low[where] = limbs[:, 0], limbs[:, 1:].astype(np.uint32)

    def places(self, numbers: NDArray[np.int64]) -> NDArray[np.intp]:
        """Return where some cells are held, ascending; they are from now on."""
        wanted = numbers.astype(np.uint16)
        if not len(self.at):
            self._grow(wanted)
            return np.arange(len(wanted))
        where = np.searchsorted(self.at, wanted)
        missing = self.at[np.minimum(where, len(self.at) - 1)] != wanted
        if missing.any():
            self._grow(wanted[missing])
            where = np.searchsorted(self.at, wanted)
        return where

    def _grow(self, new: NDArray[np.uint16]) -> None:
        at = np.union1d(self.at, new)
        old = np.searchsorted(at, self.at)
        for name in ("high", "low", "count", "mean", "m2"):
            array = getattr(self, name)
            wide = np.zeros((len(at), *array.shape[1:]), array.dtype)
            wide[old] = array
            setattr(self, name, wide)
        self.at = at

    def add(self, cells: SparseTally, batches: int) -> None:
        """Add a batch's cells of the block."""
        x = None
        if len(cells.numbers):
            where = self.places(cells.numbers)
            limbs = np.empty((len(where), TOTAL_LIMBS), np.int64)
            limbs[:, 0], limbs[:, 1:] = self.high[where], self.low[where]
            limbs[:, 1:] += cells.rows[:, :3]
            _carry(limbs)
            self.set(where, limbs)
            self.count[where] += cells.rows[:, 3]
            x = np.zeros(len(self.at))
            x[where] = values(cells.rows)
        elif len(self.at):
            x = np.zeros(len(self.at))
        if x is not None:
            welford(self.mean, self.m2, x, batches)

    def copy(self) -> _Block:
        made = _Block()
        for name in self.__slots__:
            setattr(made, name, getattr(self, name).copy())
        return made


class SparseSums:
    """Sums of the cells in which something was counted, in blocks."""

    def __init__(self, n_cells: int) -> None:
        self.n_cells = n_cells
        self._blocks = [_Block() for _ in range(0, n_cells, BLOCK)]

    @classmethod
    def of(cls, n_cells: int, numbers: NDArray[np.int64] | None, rows: Rows) -> SparseSums:
        """Return sums that hold some rows; copies."""
        made = cls(n_cells)
        for k, block in enumerate(made._blocks):
            first = k * BLOCK
            if numbers is None:
                part = slice(first, first + BLOCK)
                lit = np.zeros(len(rows[1][part]), np.bool_)
                for given in rows:
                    some = given[part]
                    lit |= some.any(axis=1) if some.ndim == 2 else some != 0
                at = np.flatnonzero(lit)
                limbs, count, mean, m2 = (given[part][at] for given in rows)
            else:
                begin, end = np.searchsorted(numbers, (first, first + BLOCK))
                at = numbers[begin:end] - first
                limbs, count, mean, m2 = (given[begin:end] for given in rows)
            if len(at):
                where = block.places(at)
                block.set(where, limbs)
                block.count[where], block.mean[where], block.m2[where] = count, mean, m2
        return made

    @property
    def nbytes(self) -> int:
        """Bytes that are held."""
        return sum(SPARSE_CELL * len(block.at) for block in self._blocks)

    def add(self, cells: SparseTally, batches: int) -> None:
        """Add a batch, see `Sums`."""
        for first, part in cells.blocks():
            self._blocks[first // BLOCK].add(part, batches)

    def copy(self) -> SparseSums:
        """Return an independent copy."""
        made = SparseSums(0)
        made.n_cells, made._blocks = self.n_cells, [block.copy() for block in self._blocks]
        return made

    def _held(self, first: int, n: int) -> Iterator[tuple[_Block, slice, NDArray[np.int64]]]:
        """Give the blocks of a range: which of their rows are in it, and where in the range."""
        end = min(first + n, self.n_cells)
        for k in range(first // BLOCK, -(-end // BLOCK)):
            block = self._blocks[k]
            if len(block.at):
                low, high = max(first - k * BLOCK, 0), min(end - k * BLOCK, BLOCK)
                at = block.at.astype(np.int64)
                part = slice(*np.searchsorted(at, (low, high)))
                yield block, part, at[part] + (k * BLOCK - first)

    def limbs(self, first: int, n: int) -> NDArray[np.int64]:
        """Return exact totals, see `Sums`."""
        out = np.zeros((n, TOTAL_LIMBS), np.int64)
        for block, part, at in self._held(first, n):
            out[at] = block.limbs[part]
        return out

    def count(self, first: int, n: int) -> NDArray[np.int64]:
        """Return counts, see `Sums`."""
        out = np.zeros(n, np.int64)
        for block, part, at in self._held(first, n):
            out[at] = block.count[part]
        return out

    def mean(self, first: int, n: int) -> NDArray[np.float64]:
        """Return totals as numbers, see `Sums`."""
        out = np.zeros(n)
        for block, part, at in self._held(first, n):
            out[at] = totals_of(block.limbs[part])
        return out

    def m2(self, first: int, n: int) -> NDArray[np.float64]:
        """Return squares, see `Sums`."""
        out = np.zeros(n)
        for block, part, at in self._held(first, n):
            out[at] = block.m2[part]
        return out

    def counted(self, first: int, n: int, least: int, every: int = 1) -> Counted:
        """Return counts, totals and squares of well-counted cells, see `Sums`."""
        counts, totals, squares = [np.empty(0, np.int64)], [np.empty(0)], [np.empty(0)]
        for block, part, at in self._held(first, n):
            enough = (block.count[part] >= least) & (at % every == 0)
            if enough.any():
                counts.append(block.count[part][enough])
                totals.append(totals_of(block.limbs[part][enough]))
                squares.append(block.m2[part][enough])
        return np.concatenate(counts), np.concatenate(totals), np.concatenate(squares)

    def rows(self) -> tuple[NDArray[np.int64] | None, Rows]:
        """Return a copy of everything, see `Sums`."""
        blocks = self._blocks
        numbers = [b.at.astype(np.int64) + k * BLOCK for k, b in enumerate(blocks)]
        return np.concatenate([np.empty(0, np.int64), *numbers]), (
            np.concatenate([np.empty((0, TOTAL_LIMBS), np.int64), *(b.limbs for b in blocks)]),
            np.concatenate([np.empty(0, np.int64), *(b.count for b in blocks)]),
            np.concatenate([np.empty(0), *(b.mean for b in blocks)]),
            np.concatenate([np.empty(0), *(b.m2 for b in blocks)]),
        )
