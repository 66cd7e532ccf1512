"""Batch means: exact totals, standard errors from the scatter between batches, a chained digest.

Every batch is an unbiased estimate of the whole scene; what is reported is the mean over batches,
and its standard error is the standard deviation of the batches over the square root of their
number. The mean is taken from the exact integer total, the scatter from Welford's recurrence in
batch order, so that the same batches give the same bits however they were computed.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.tally import (
    BLOCK,
    CELL,
    SparseTally,
    canonical,
    is_sparse,
    some_of,
    values,
    whole_of,
)
from photizon_cl.errors import RunError
from photizon_cl.result.batch_values import BatchValues
from photizon_cl.result.keyed_sums import KeyedState, KeyedSums, admitted
from photizon_cl.result.sums import TOTAL_LIMBS, DenseSums, SparseSums, Sums, welford

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from hostcode.run.keyed import KeyedRows
    from photizon_cl.compile.layout import TallyLayout

__all__ = ["LIT_COUNT", "Accumulator", "AccumulatorState", "complete", "exact_sum", "known_part"]

LIT_COUNT: Final = 10
"""Arrivals from which on a bin counts as lit, and below which it is hatched."""


def known_part(counts: NDArray[np.int64]) -> float:
    """Return which part of the bins that rays reach is lit; 1 where none is reached."""
    reached = int(np.count_nonzero(counts))
    return float(np.count_nonzero(counts >= LIT_COUNT) / reached) if reached else 1.0


def exact_sum(cells: NDArray[np.int64]) -> tuple[int, int]:
    """Return the sum of cells as a whole number of 2^-95 launched weights, and the sum of counts.

    Parameters
    ----------
    cells : ndarray, shape (n, 4), int64
        In canonical form.
    """
    a, b, c, count = (int(x) for x in cells.sum(axis=0, dtype=np.int64))
    return (a << 64) + (b << 32) + c, count


def complete(
    layout: TallyLayout, cells: NDArray[np.int64] | SparseTally
) -> NDArray[np.int64] | SparseTally:
    """Fill the cells that a device leaves to the host.

    Where a detector has tallies, each arrival is in exactly one cell of each, and the device counts
    it only there. Where the ledger's rows are divided, the device books their parts alone.

    Parameters
    ----------
    layout : TallyLayout
        Meaning of the cells.
    cells : ndarray, shape (n_cells, 4), int64, or SparseTally
        A batch's tally in canonical form.

    Returns
    -------
    ndarray, shape (n_cells, 4), int64, or SparseTally
        In canonical form; the argument itself where there is nothing to fill.

    Raises
    ------
    RunError
        Where two tallies of a detector disagree, which is a defect of the engine.
    """
    partial = [d for d in layout.detectors if d.tallies]
    if not partial and not layout.parts:
        return cells
    powers = _undivided(layout, cells)
    for d in partial:
        first, *others = (some_of(cells, t.first, t.size) for t in d.tallies)
        for tally, parts in zip(d.tallies[1:], others, strict=True):
            if exact_sum(parts) != exact_sum(first):
                raise RunError(
                    f"the {d.tallies[0].name} and the {tally.name} of the detector on element "
                    f"{d.element} disagree in a batch: this is a defect of the engine; please "
                    "report it with the scene file"
                )
        powers[d.power] = canonical(first.sum(axis=0)[np.newaxis])[0]
    if isinstance(cells, SparseTally):
        return cells.with_cells(powers)
    out = cells.copy()
    for cell, power in powers.items():
        out[cell] = power
    return out


def _undivided(
    layout: TallyLayout, cells: NDArray[np.int64] | SparseTally
) -> dict[int, NDArray[np.int64]]:
    """Return the rows of the ledger that are the sums of parts, by cell."""
    if not layout.parts:
        return {}
    shape = (layout.n_rows, layout.parts, CELL)
    parts = whole_of(cells, layout.divided, layout.n_rows * layout.parts).reshape(shape)
    return dict(enumerate(canonical(parts.sum(axis=1))))


@dataclass(frozen=True, eq=False)
class AccumulatorState:
    """Everything an accumulator remembers, as plain arrays; what a checkpoint holds.

    Parameters
    ----------
    batches : int
        Number of batches added.
    limbs : ndarray, shape (n_cells, 4), int64
        Exact totals, units 2^1, 2^-31, 2^-63 and 2^-95 launched weights; all but the first in
        0 … 2^32 − 1.
    count : ndarray, shape (n_cells,), int64
        Arrivals.
    mean, m2 : ndarray, shape (n_cells + n_differences,), float64
        Welford's running mean and sum of squared deviations, in launched weights.
    digest : bytes
        The chained SHA-256, 32 bytes.
    cells : ndarray, shape (m,), int64, or None
        The only cells that have rows above where they are not all, ascending; all others are zero.
    batch_values : ndarray, shape (batches, k), float64, or None
        What single cells gave in each batch, in launched weights; None where that is not known.
    keyed : KeyedState or None
        Sums of cells by key; None where the scene keeps none.
    """

    batches: int
    limbs: NDArray[np.int64]
    count: NDArray[np.int64]
    mean: NDArray[np.float64]
    m2: NDArray[np.float64]
    digest: bytes
    cells: NDArray[np.int64] | None = None
    batch_values: NDArray[np.float64] | None = None
    keyed: KeyedState | None = None


class Accumulator:
    """Sums batches, strictly in order.

    Parameters
    ----------
    n_cells : int
        Cells of a batch's tally.
    differences : sequence of (int, int), optional
        Pairs of cells whose difference needs a standard error of its own (the two are correlated,
        so that it does not follow from theirs). Their means and errors stand behind the cells'.
    counted_in : tuple of (int, int), optional
        The last cell, which only counts, and the cell in whose unused count the digest has it: the
        digest is the same as of versions in which it had no row of its own.
    scalars : tuple of (int, int), optional
        First and number of cells whose values are kept batch by batch.
    """

    def __init__(
        self,
        n_cells: int,
        differences: Sequence[tuple[int, int]] = (),
        counted_in: tuple[int, int] | None = None,
        scalars: tuple[tuple[int, int], ...] = (),
    ) -> None:
        self.n_cells = n_cells
        self.batch_values = BatchValues(scalars)
        self.differences = tuple(differences)
        self.counted_in = counted_in
        self.batches = 0
        self._sums: Sums = SparseSums(n_cells) if is_sparse(n_cells) else DenseSums(n_cells)
        self._difference_mean = np.zeros(len(self.differences))
        self._difference_m2 = np.zeros(len(self.differences))
        self.keyed: KeyedSums | None = None
        """Sums of cells by key, where the scene keeps any."""
        self._digest = bytes(32)

    def add(self, cells: NDArray[np.int64] | SparseTally, keyed: KeyedRows | None = None) -> None:
        """Add the next batch.

        Parameters
        ----------
        cells : ndarray, shape (n_cells, 4), int64, or SparseTally
            Its completed tally in canonical form.
        keyed : KeyedRows, optional
            Its cells by key, where the scene keeps any.

        Raises
        ------
        ValueError
            If the shape is another one.
        """
        if isinstance(cells, SparseTally):
            if cells.n_cells != self.n_cells:
                raise ValueError(f"{cells.n_cells} cells, expected {self.n_cells}")
            if isinstance(self._sums, DenseSums):
                cells = cells.whole()
        elif cells.shape != (self.n_cells, CELL):
            raise ValueError(f"cells of shape {cells.shape}, expected {(self.n_cells, CELL)}")
        elif isinstance(self._sums, SparseSums):
            cells = SparseTally.of(cells)
        if self.keyed is not None and keyed is not None:
            self.keyed.add(keyed, self.batches + 1)
        chain = hashlib.sha256(self._digest)
        for part in self._image(cells):
            chain.update(np.ascontiguousarray(part, dtype="<i8").data)
        if keyed is not None:
            for part in keyed.arrays:
                chain.update(np.ascontiguousarray(part, dtype="<i8").data)
        self._digest = chain.digest()
        self.batches += 1
        self._sums.add(cells, self.batches)
        self.batch_values.add(cells)
        if self.differences:
            x = self._batch_differences(cells)
            welford(self._difference_mean, self._difference_m2, x, self.batches)

    def _image(self, cells: NDArray[np.int64] | SparseTally) -> Iterator[NDArray[np.int64]]:
        """Give what the digest is taken over, in order."""
        last, into = self.counted_in or (self.n_cells, 0)
        row = whole_of(cells, into, 1)
        if self.counted_in is not None:
            row = row.copy()
            row[0, 3] += whole_of(cells, last, 1)[0, 3]
        if not isinstance(cells, SparseTally):
            yield from (cells[:into], row, cells[into + 1 : last])
            return
        space = np.zeros((BLOCK, CELL), np.int64)
        for first, part in cells.blocks():
            space[part.numbers] = part.rows
            if first <= into < first + BLOCK:
                space[into - first] = row[0]
            yield space[: min(BLOCK, last - first)]
            space[part.numbers] = 0
            if first <= into < first + BLOCK:
                space[into - first] = 0

    def _batch_differences(self, cells: NDArray[np.int64] | SparseTally) -> NDArray[np.float64]:
        found = [whole_of(cells, a, 1)[0] - whole_of(cells, b, 1)[0] for a, b in self.differences]
        difference = canonical(np.stack(found))
        # The canonical form of a small negative number would round away: take its magnitude.
        sign = np.where(difference[:, 0] < 0, np.int64(-1), np.int64(1))
        return np.asarray(sign * values(canonical(difference * sign[:, np.newaxis])))

    def copy(self) -> Accumulator:
        """Return an independent copy."""
        made = Accumulator(0, self.differences, self.counted_in)
        made.n_cells, made.batches, made._digest = self.n_cells, self.batches, self._digest
        made._sums = self._sums.copy()
        made.batch_values = self.batch_values.copy()
        made.keyed = None if self.keyed is None else self.keyed.copy()
        made._difference_mean = self._difference_mean.copy()
        made._difference_m2 = self._difference_m2.copy()
        return made

    def state(self) -> AccumulatorState:
        """Return a copy of everything that it remembers."""
        cells, (limbs, count, mean, m2) = self._sums.rows()
        if self.differences:
            mean = np.concatenate([mean, self._difference_mean])
            m2 = np.concatenate([m2, self._difference_m2])
        kept = self.batch_values.table()
        keyed = None if self.keyed is None else self.keyed.state()
        return AccumulatorState(
            self.batches, limbs, count, mean, m2, self._digest, cells, kept, keyed
        )

    @property
    def held_bytes(self) -> int:
        """Bytes of sums that grow as more cells are lit, 0 where they do not grow."""
        return self._sums.nbytes if isinstance(self._sums, SparseSums) else 0

    @classmethod
    def of(cls, layout: TallyLayout, state: AccumulatorState | None = None) -> Accumulator:
        """Return an accumulator of a scene's batches, empty or one that goes on from a state.

        States of versions in which interactions had no row of their own are brought to this form.

        Raises
        ------
        ValueError
            If the state is of another scene.
        """
        made = cls._of(layout, state)
        if layout.most_paths:
            most = admitted(layout)
            if state is None:
                made.keyed = KeyedSums(most)
            elif state.keyed is None:
                raise ValueError("its scene has path tables, and it has none")
            else:
                made.keyed = KeyedSums.restore(most, state.keyed, made.batches)
        return made

    @classmethod
    def _of(cls, layout: TallyLayout, state: AccumulatorState | None) -> Accumulator:
        balance = [(layout.killed, layout.boosted)]
        balance += [
            (layout.part(layout.killed, k), layout.part(layout.boosted, k))
            for k in range(layout.parts)
        ]
        counted_in = (layout.interactions, layout.depth_capped)
        if state is None:
            return cls(layout.n_cells, balance, counted_in, layout.scalars)
        if state.cells is not None:
            return cls.restore(state, balance, counted_in, layout.n_cells, layout.scalars)
        if len(state.count) == layout.n_cells - 1:
            state = _with_interactions(state, *counted_in)
        if len(state.count) != layout.n_cells:
            raise ValueError(f"{len(state.count)} cells, and its scene has {layout.n_cells}")
        return cls.restore(state, balance, counted_in, scalars=layout.scalars)

    @classmethod
    def restore(
        cls,
        state: AccumulatorState,
        differences: Sequence[tuple[int, int]] = (),
        counted_in: tuple[int, int] | None = None,
        n_cells: int | None = None,
        scalars: tuple[tuple[int, int], ...] = (),
    ) -> Accumulator:
        """Return an accumulator that goes on where `state` was taken.

        Raises
        ------
        ValueError
            If the arrays' shapes do not belong together.
        """
        m, nd = len(state.count), len(differences)
        n = m if n_cells is None else n_cells
        made = cls(n, differences, counted_in, scalars)
        wanted = [(m, TOTAL_LIMBS), (m,), (m + nd,), (m + nd,)]
        found = [a.shape for a in (state.limbs, state.count, state.mean, state.m2)]
        if found != wanted or len(state.digest) != 32 or state.batches < 0:
            raise ValueError(f"arrays of shapes {found}, expected {wanted}")
        cells = state.cells
        if cells is not None:
            ascend = cells.shape == (m,) and (cells[1:] > cells[:-1]).all()
            if not ascend or (m and not (cells[0] >= 0 and cells[-1] < n)):
                raise ValueError(f"its cells are none of a tally of {n}, or not in order")
        rows = (state.limbs, state.count, state.mean[:m], state.m2[:m])
        made._sums = type(made._sums).of(n, cells, rows)
        made.batches = int(state.batches)
        made.batch_values.restore(state.batch_values)
        made._difference_mean[...] = state.mean[m:]
        made._difference_m2[...] = state.m2[m:]
        made._digest = bytes(state.digest)
        return made

    @property
    def digest(self) -> str:
        """``sha256:…`` over the exact tallies of all batches in order, each chained to the last."""
        return f"sha256:{self._digest.hex()}"

    @property
    def count(self) -> NDArray[np.int64]:
        """Arrivals of each cell, shape (n_cells,)."""
        return self.counts()

    def counts(self, first: int = 0, n: int | None = None) -> NDArray[np.int64]:
        """Return the arrivals of cells, shape (n,)."""
        return self._sums.count(first, self.n_cells - first if n is None else n)

    def exact(self, cell: int) -> int:
        """Return the total of a cell over all batches as a whole number of 2^-95."""
        total = 0
        for limb in self._sums.limbs(cell, 1)[0]:
            total = (total << 32) + int(limb)
        return total

    def mean(self, first: int = 0, n: int | None = None) -> NDArray[np.float64]:
        """Return the mean over batches of cells, in launched weights.

        From the exact totals, rounded to two units in the last place at most.

        Parameters
        ----------
        first, n : int, optional
            Which cells; default all.
        """
        total = self._sums.mean(first, self.n_cells - first if n is None else n)
        total /= max(self.batches, 1)
        return total

    def standard_error(self, first: int = 0, n: int | None = None) -> NDArray[np.float64]:
        """Return the standard error of the mean of cells (then differences), in launched weights.

        NaN with fewer than two batches; exactly 0 where all batches agree.

        Parameters
        ----------
        first, n : int, optional
            Which cells; default all, and the differences behind them.
        """
        end = self.n_cells + len(self.differences) if n is None else first + n
        if self.batches < 2:
            return np.full(end - first, np.nan)
        last = min(end, self.n_cells)
        m2 = self._sums.m2(first, last - first) if first < last else np.empty(0)
        if end > self.n_cells:
            more = slice(max(first - self.n_cells, 0), end - self.n_cells)
            m2 = np.concatenate([m2, self._difference_m2[more]])
        return self._error(m2)

    def _error(self, m2: NDArray[np.float64]) -> NDArray[np.float64]:
        out = m2 / (self.batches - 1)
        out /= self.batches
        return np.sqrt(out, out=out)

    def well_counted(self, first: int, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return mean and standard error of those cells of a range that count as lit, in order.

        At least two batches.
        """
        _, totals, squares = self._sums.counted(first, n, LIT_COUNT)
        return totals / self.batches, self._error(squares)

    def reached(
        self, first: int, n: int, every: int = 1
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Return count, mean and standard error of the cells of a range that count anything.

        At least two batches; of the first cell of each `every` alone.
        """
        counts, totals, squares = self._sums.counted(first, n, 1, every)
        return counts, totals / self.batches, self._error(squares)


def _with_interactions(state: AccumulatorState, last: int, counted_in: int) -> AccumulatorState:
    """Return a state whose interactions stand in a last cell of their own."""
    count = np.append(state.count, state.count[counted_in])
    count[counted_in] = 0
    return AccumulatorState(
        state.batches,
        np.append(state.limbs, np.zeros((1, TOTAL_LIMBS), np.int64), axis=0),
        count,
        np.insert(state.mean, last, 0.0),
        np.insert(state.m2, last, 0.0),
        state.digest,
        batch_values=state.batch_values,
    )
