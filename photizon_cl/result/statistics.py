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

from hostcode.run.tally import CELL, UNIT_EXPONENT, canonical, values
from photizon_cl.errors import RunError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.compile.layout import TallyLayout

__all__ = ["LIT_COUNT", "Accumulator", "AccumulatorState", "complete", "exact_sum"]

LIT_COUNT: Final = 10
"""Arrivals from which on a bin counts as lit, and below which it is hatched."""

_LOW: Final = np.int64(0xFFFFFFFF)
_TOTAL_LIMBS: Final = 4
"""A total has one limb more than a batch: 2^48 rays of weight 1 pass 2^63 units of 2^-31."""


def exact_sum(cells: NDArray[np.int64]) -> tuple[int, int]:
    """Return the sum of cells as a whole number of 2^-95 launched weights, and the sum of counts.

    Parameters
    ----------
    cells : ndarray, shape (n, 4), int64
        In canonical form.
    """
    a, b, c, count = (int(x) for x in cells.sum(axis=0, dtype=np.int64))
    return (a << 64) + (b << 32) + c, count


def complete(layout: TallyLayout, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Fill the power cells that a device leaves to the host.

    Where a detector has tallies, each arrival is in exactly one cell of each, and the device counts
    it only there.

    Parameters
    ----------
    layout : TallyLayout
        Meaning of the cells.
    cells : ndarray, shape (n_cells, 4), int64
        A batch's tally in canonical form.

    Returns
    -------
    ndarray, shape (n_cells, 4), int64
        In canonical form; the argument itself where there is nothing to fill.

    Raises
    ------
    RunError
        Where two tallies of a detector disagree, which is a defect of the engine.
    """
    partial = [d for d in layout.detectors if d.tallies]
    if not partial:
        return cells
    out = cells.copy()
    for d in partial:
        first, *others = (out[t.first : t.first + t.size] for t in d.tallies)
        for tally, parts in zip(d.tallies[1:], others, strict=True):
            if exact_sum(parts) != exact_sum(first):
                raise RunError(
                    f"the {d.tallies[0].name} and the {tally.name} of the detector on element "
                    f"{d.element} disagree in a batch: this is a defect of the engine; please "
                    "report it with the scene file"
                )
        out[d.power] = first.sum(axis=0)
        out[d.power : d.power + 1] = canonical(out[d.power : d.power + 1])
    return out


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
    """

    batches: int
    limbs: NDArray[np.int64]
    count: NDArray[np.int64]
    mean: NDArray[np.float64]
    m2: NDArray[np.float64]
    digest: bytes


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
    """

    def __init__(
        self,
        n_cells: int,
        differences: Sequence[tuple[int, int]] = (),
        counted_in: tuple[int, int] | None = None,
    ) -> None:
        self.n_cells = n_cells
        self.differences = tuple(differences)
        self.counted_in = counted_in
        self.batches = 0
        self._limbs = np.zeros((n_cells, _TOTAL_LIMBS), np.int64)
        self._count = np.zeros(n_cells, np.int64)
        self._mean = np.zeros(n_cells + len(self.differences))
        self._m2 = np.zeros(n_cells + len(self.differences))
        self._digest = bytes(32)

    def add(self, cells: NDArray[np.int64]) -> None:
        """Add the next batch.

        Parameters
        ----------
        cells : ndarray, shape (n_cells, 4), int64
            Its completed tally in canonical form.

        Raises
        ------
        ValueError
            If the shape is another one.
        """
        if cells.shape != (self.n_cells, CELL):
            raise ValueError(f"cells of shape {cells.shape}, expected {(self.n_cells, CELL)}")
        chain = hashlib.sha256(self._digest)
        chain.update(self._image(cells).data)
        self._digest = chain.digest()
        self.batches += 1
        limbs = self._limbs
        limbs[:, 1:] += cells[:, :3]
        for k in (3, 2, 1):
            limbs[:, k - 1] += limbs[:, k] >> 32
            limbs[:, k] &= _LOW
        self._count += cells[:, 3]
        # Welford: a batch equal to the mean so far leaves the sum of squares exactly as it is.
        x = self._batch_values(cells)
        delta = x - self._mean
        self._mean += delta / self.batches
        self._m2 += delta * (x - self._mean)

    def _image(self, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return what the digest is taken over."""
        if self.counted_in is None:
            return np.ascontiguousarray(cells, dtype="<i8")
        last, into = self.counted_in
        image = np.array(cells[:last], dtype="<i8")
        image[into, 3] += cells[last, 3]
        return image

    def _batch_values(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        x = values(cells)
        if not self.differences:
            return x
        pairs = np.array(self.differences)
        difference = canonical(cells[pairs[:, 0]] - cells[pairs[:, 1]])
        # The canonical form of a small negative number would round away: take its magnitude.
        sign = np.where(difference[:, 0] < 0, np.int64(-1), np.int64(1))
        return np.concatenate([x, sign * values(canonical(difference * sign[:, np.newaxis]))])

    def copy(self) -> Accumulator:
        """Return an independent copy."""
        return Accumulator.restore(self.state(), self.differences, self.counted_in)

    def state(self) -> AccumulatorState:
        """Return a copy of everything that it remembers."""
        return AccumulatorState(
            self.batches,
            self._limbs.copy(),
            self._count.copy(),
            self._mean.copy(),
            self._m2.copy(),
            self._digest,
        )

    @classmethod
    def of(cls, layout: TallyLayout, state: AccumulatorState | None = None) -> Accumulator:
        """Return an accumulator of a scene's batches, empty or one that goes on from a state.

        States of versions in which interactions had no row of their own are brought to this form.

        Raises
        ------
        ValueError
            If the state is of another scene.
        """
        balance = [(layout.killed, layout.boosted)]
        counted_in = (layout.interactions, layout.depth_capped)
        if state is None:
            return cls(layout.n_cells, balance, counted_in)
        if len(state.count) == layout.n_cells - 1:
            state = _with_interactions(state, *counted_in)
        if len(state.count) != layout.n_cells:
            raise ValueError(f"{len(state.count)} cells, and its scene has {layout.n_cells}")
        return cls.restore(state, balance, counted_in)

    @classmethod
    def restore(
        cls,
        state: AccumulatorState,
        differences: Sequence[tuple[int, int]] = (),
        counted_in: tuple[int, int] | None = None,
    ) -> Accumulator:
        """Return an accumulator that goes on where `state` was taken.

        Raises
        ------
        ValueError
            If the arrays' shapes do not belong together.
        """
        n = len(state.count)
        made = cls(n, differences, counted_in)
        wanted = [(n, _TOTAL_LIMBS), (n,), made._mean.shape, made._mean.shape]
        found = [a.shape for a in (state.limbs, state.count, state.mean, state.m2)]
        if found != wanted or len(state.digest) != 32 or state.batches < 0:
            raise ValueError(f"arrays of shapes {found}, expected {wanted}")
        made.batches = int(state.batches)
        made._limbs[...] = state.limbs
        made._count[...] = state.count
        made._mean[...] = state.mean
        made._m2[...] = state.m2
        made._digest = bytes(state.digest)
        return made

    @property
    def digest(self) -> str:
        """``sha256:…`` over the exact tallies of all batches in order, each chained to the last."""
        return f"sha256:{self._digest.hex()}"

    @property
    def count(self) -> NDArray[np.int64]:
        """Arrivals of each cell, shape (n_cells,)."""
        return self._count

    def exact(self, cell: int) -> int:
        """Return the total of a cell over all batches as a whole number of 2^-95."""
        total = 0
        for limb in self._limbs[cell]:
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
        limbs = self._limbs[first : self.n_cells if n is None else first + n]
        # Canonical limbs below the first are not negative: adding from the small end loses nothing.
        total = np.zeros(len(limbs))
        for k in (3, 2, 1, 0):
            total += np.ldexp(limbs[:, k].astype(np.float64), UNIT_EXPONENT + 32 * (3 - k))
        return total / max(self.batches, 1)

    def standard_error(self, first: int = 0, n: int | None = None) -> NDArray[np.float64]:
        """Return the standard error of the mean of cells (then differences), in launched weights.

        NaN with fewer than two batches; exactly 0 where all batches agree.

        Parameters
        ----------
        first, n : int, optional
            Which cells; default all, and the differences behind them.
        """
        m2 = self._m2[first : None if n is None else first + n]
        if self.batches < 2:
            return np.full(len(m2), np.nan)
        return np.asarray(np.sqrt(m2 / (self.batches - 1) / self.batches), dtype=np.float64)


def _with_interactions(state: AccumulatorState, last: int, counted_in: int) -> AccumulatorState:
    """Return a state whose interactions stand in a last cell of their own."""
    count = np.append(state.count, state.count[counted_in])
    count[counted_in] = 0
    return AccumulatorState(
        state.batches,
        np.append(state.limbs, np.zeros((1, _TOTAL_LIMBS), np.int64), axis=0),
        count,
        np.insert(state.mean, last, 0.0),
        np.insert(state.m2, last, 0.0),
        state.digest,
    )
