"""Sums over batches of cells by key: which paths bring light to a detector.

Exact totals and Welford's squares of every key, in the order in which keys were admitted: batch by
batch, of one batch the strongest first. A detector admits as many as its share; then no new one, so
that every key that is here has all of its arrivals, and what the others brought is what is left of
the detector's power. The first keys, which are mostly the strongest, keep what each batch gave, so
that a group of them has a standard error of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.tally import canonical, values, whole_of
from photizon_cl.errors import RunError
from photizon_cl.result.sums import TOTAL_LIMBS, totals_of, welford

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from hostcode.run.keyed import KeyedRows
    from hostcode.run.tally import SparseTally
    from photizon_cl.compile.layout import TallyLayout

__all__ = [
    "LEAST_ADMITTED",
    "MOST_FOLLOWED_VALUES",
    "KeyedState",
    "KeyedSums",
    "admitted",
    "check_paths",
]

LEAST_ADMITTED: Final = 1 << 16
"""Keys that all detectors together admit at least, in equal shares."""
FOLLOWED: Final = 1 << 13
"""Keys of which each batch's value is kept at most."""
MOST_FOLLOWED_VALUES: Final = 1 << 22
"""Numbers that are kept of them, 32 MiB; as batches become many, of fewer keys."""
_LOW: Final = np.int64(0xFFFFFFFF)
_AGREES: Final = 1e-6
"""Part of a mean, or of its scatter, by which what is kept of it may differ."""


def admitted(layout: TallyLayout) -> dict[int, int]:
    """Return how many paths each detector admits, by its number: four times its rows at least."""
    having = {number: d.paths for number, d in enumerate(layout.detectors) if d.paths}
    least = LEAST_ADMITTED // max(len(having), 1)
    return {number: max(4 * rows, least) for number, rows in having.items()}


def check_paths(
    layout: TallyLayout, cells: NDArray[np.int64] | SparseTally, keyed: KeyedRows | None
) -> None:
    """See that a batch's paths bring each detector its power, to the last bit, and its arrivals.

    Raises
    ------
    RunError
        Where they do not, which is a defect of the engine.
    """
    if keyed is None:
        return
    for number, d in enumerate(layout.detectors):
        if d.paths:
            mine = keyed.rows[keyed.about >> 32 == number]
            total = canonical(mine.sum(axis=0, dtype=np.int64)[np.newaxis])
            if (total != whole_of(cells, d.power, 1)).any():
                raise RunError(
                    f"the paths to the detector on element {d.element} bring another power than it "
                    "has in a batch: this is a defect of the engine; please report it with the "
                    "scene file"
                )


@dataclass(frozen=True, eq=False)
class KeyedState:
    """Everything that sums by key remember, in order of admission.

    Parameters
    ----------
    keys, about, first : ndarray, shape (m,), int64
        See `hostcode.run.keyed.KeyedRows`.
    limbs : ndarray, shape (m, 4), int64
        Exact totals, as those of `AccumulatorState`.
    count : ndarray, shape (m,), int64
        Arrivals.
    mean, m2 : ndarray, shape (m,), float64
        Welford's mean and sum of squared deviations, in launched weights.
    values : ndarray, shape (batches, f), float64
        What each batch gave of the first f keys, in launched weights.
    """

    keys: NDArray[np.int64]
    about: NDArray[np.int64]
    first: NDArray[np.int64]
    limbs: NDArray[np.int64]
    count: NDArray[np.int64]
    mean: NDArray[np.float64]
    m2: NDArray[np.float64]
    values: NDArray[np.float64]


class KeyedSums:
    """Sums of batches' cells by key, strictly in order.

    Parameters
    ----------
    most : mapping of int to int
        Keys that each detector admits at most, by its number.
    """

    def __init__(self, most: Mapping[int, int]) -> None:
        self.most = dict(most)
        self.keys = self.about = self.first = self.count = np.empty(0, np.int64)
        self.limbs = np.empty((0, TOTAL_LIMBS), np.int64)
        self.mean = self.m2 = np.empty(0)
        self._order = np.empty(0, np.intp)
        self._rows: list[NDArray[np.float64]] = []
        self._widest = 0  # numbers of the longest of them
        self._table: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self.keys)

    def rows_of(self, detector: int) -> NDArray[np.intp]:
        """Return which rows are a detector's, in order of admission."""
        return np.flatnonzero(self.about >> 32 == detector)

    def full(self, detector: int) -> bool:
        """Say whether a detector admits no new key."""
        return len(self.rows_of(detector)) >= self.most.get(detector, 0)

    def add(self, batch: KeyedRows, batches: int) -> None:
        """Add the `batches`-th batch.

        Raises
        ------
        RunError
            Where a key stands for something else than it did: two paths share it.
        """
        at = self._places(batch.keys)
        new = self._admitted(batch, np.flatnonzero(at < 0))
        if len(new):
            at[new] = np.arange(len(self.keys), len(self.keys) + len(new))
            self._admit(batch, new)
        known = at >= 0
        at, rows = at[known], batch.rows[known]
        if (self.about[at] != batch.about[known]).any():
            raise RunError("two paths have the same key, once in 10^7 runs: take another seed")
        limbs = self.limbs[at]
        limbs[:, 1:] += rows[:, :3]
        for k in (3, 2, 1):
            limbs[:, k - 1] += limbs[:, k] >> 32
            limbs[:, k] &= _LOW
        self.limbs[at] = limbs
        self.count[at] += rows[:, 3]
        x = np.zeros(len(self.keys))
        x[at] = values(rows)
        welford(self.mean, self.m2, x, batches)
        self._rows.append(x[: self._width(len(self._rows) + 1)].copy())
        self._table = None
        self._widest = max(self._widest, len(self._rows[-1]))
        most = self._width(len(self._rows))
        if self._widest > 2 * most:  # they are cut when batches are twice as many, not at each
            self._rows = [row if len(row) <= most else row[:most].copy() for row in self._rows]
            self._widest = most

    @staticmethod
    def _width(batches: int) -> int:
        """Return of how many keys each batch's value is kept of so many batches."""
        return min(FOLLOWED, MOST_FOLLOWED_VALUES // max(batches, 1))

    def _admitted(self, batch: KeyedRows, new: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return which of a batch's new keys there is room for, the strongest first."""
        rows = batch.rows[new]
        rank = np.lexsort((batch.keys[new], -rows[:, 2], -rows[:, 1], -rows[:, 0]))
        new = new[rank]
        which, own = batch.about[new] >> 32, self.about >> 32
        fits = np.zeros(len(new), np.bool_)
        for detector, most in self.most.items():
            left = most - int(np.count_nonzero(own == detector))
            fits[np.flatnonzero(which == detector)[: max(left, 0)]] = True
        return new[fits]

    def _places(self, keys: NDArray[np.int64]) -> NDArray[np.intp]:
        """Return where keys stand, −1 for those that are not here."""
        if not len(self.keys):
            return np.full(len(keys), -1)
        ordered = self.keys[self._order]
        at = np.minimum(np.searchsorted(ordered, keys), len(ordered) - 1)
        return np.where(ordered[at] == keys, self._order[at], -1)

    def _admit(self, batch: KeyedRows, new: NDArray[np.intp]) -> None:
        n = len(new)
        self.keys = np.append(self.keys, batch.keys[new])
        self.about = np.append(self.about, batch.about[new])
        self.first = np.append(self.first, batch.first[new])
        self.limbs = np.append(self.limbs, np.zeros((n, TOTAL_LIMBS), np.int64), axis=0)
        self.count = np.append(self.count, np.zeros(n, np.int64))
        self.mean, self.m2 = np.append(self.mean, np.zeros(n)), np.append(self.m2, np.zeros(n))
        self._order = np.argsort(self.keys)

    # -- what came of it -----------------------------------------------------------------------

    def exact(self, row: int) -> int:
        """Return the total of a key over all batches as a whole number of 2^-95."""
        total = 0
        for limb in self.limbs[row]:
            total = (total << 32) + int(limb)
        return total

    def table(self) -> NDArray[np.float64]:
        """Return what batches gave of the first keys, shape (batches, f), in launched weights."""
        if self._table is None:
            width = min(len(self.keys), self._width(len(self._rows)))
            self._table = np.zeros((len(self._rows), width))
            for k, row in enumerate(self._rows):
                self._table[k, : len(row[:width])] = row[:width]
            self._table.flags.writeable = False
        return self._table

    # -- keeping -------------------------------------------------------------------------------

    def copy(self) -> KeyedSums:
        """Return an independent copy."""
        made = KeyedSums(self.most)
        for name in ("keys", "about", "first", "limbs", "count", "mean", "m2", "_order"):
            setattr(made, name, getattr(self, name).copy())
        made._rows, made._widest = list(self._rows), self._widest
        return made

    def state(self) -> KeyedState:
        """Return a copy of everything."""
        return KeyedState(
            self.keys.copy(),
            self.about.copy(),
            self.first.copy(),
            self.limbs.copy(),
            self.count.copy(),
            self.mean.copy(),
            self.m2.copy(),
            self.table(),
        )

    @classmethod
    def restore(cls, most: Mapping[int, int], state: KeyedState, batches: int) -> KeyedSums:
        """Return sums that go on where `state` was taken.

        Raises
        ------
        ValueError
            Where its arrays do not belong together, or are no totals.
        """
        m = len(state.keys)
        if len(np.unique(state.keys)) != m or (state.keys == 0).any():
            raise ValueError("its keys of paths are not different")
        arrays = (state.about, state.first, state.count, state.mean, state.m2)
        if any(a.shape != (m,) for a in arrays) or state.limbs.shape != (m, TOTAL_LIMBS):
            raise ValueError("its sums of paths do not belong together")
        width = min(m, cls._width(batches))
        if state.values.shape != (batches, width):
            raise ValueError(f"its paths' batch values have the shape {state.values.shape}")
        numbers = np.concatenate([state.mean, state.m2, state.values.ravel()])
        if not np.isfinite(numbers).all() or (state.m2 < 0.0).any():
            raise ValueError("it has paths with means or squares that are no numbers")
        low = state.limbs[:, 1:]
        if (low < 0).any() or (low > _LOW).any() or (state.count < 1).any():
            raise ValueError("its paths' totals are not canonical, or have no count")
        if (state.first < 0).any() or (state.limbs[:, 0] < 0).any():
            raise ValueError("its paths have negative totals or rays")
        made = cls(most)
        made.keys, made.about, made.first = (
            np.array(a, np.int64) for a in (state.keys, state.about, state.first)
        )
        made.limbs, made.count = np.array(state.limbs, np.int64), np.array(state.count, np.int64)
        made.mean, made.m2 = np.array(state.mean, np.float64), np.array(state.m2, np.float64)
        made._order = np.argsort(made.keys)
        made._rows, made._widest = list(np.array(state.values, np.float64)), width
        which = made.about >> 32
        if any(np.count_nonzero(which == d) > most.get(int(d), 0) for d in np.unique(which)):
            raise ValueError("it has more paths to a detector than a result keeps")
        made._check_scatter(batches)
        return made

    def _check_scatter(self, batches: int) -> None:
        """See that means and squares are those of totals and of what batches gave.

        Raises
        ------
        ValueError
            Where they are not.
        """
        if not batches:
            if len(self.keys):
                raise ValueError("it has paths and no batches")
            return
        exact = totals_of(self.limbs) / batches
        scatter = np.sqrt(self.m2 / batches)
        if not (np.abs(self.mean - exact) <= _AGREES * (exact + scatter)).all():
            raise ValueError("its paths' means are not those of their totals")
        table = self.table()
        n = table.shape[1]
        spread = table.std(axis=0)
        room = _AGREES * (exact[:n] + scatter[:n] + spread)
        if not (
            (np.abs(table.mean(axis=0) - exact[:n]) <= room).all()
            and (np.abs(spread - scatter[:n]) <= room).all()
        ):
            raise ValueError("its paths' batch values are not those of their totals")
