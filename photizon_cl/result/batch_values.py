"""What single cells gave, batch by batch: for differences of runs, and to judge a σ."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.tally import SparseTally, values, whole_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["MOST_VALUES", "BatchValues"]

MOST_VALUES: Final = 1 << 22
"""Numbers that are kept at most, 32 MiB; a run that goes on beyond keeps none of them."""


class BatchValues:
    """Values of some cells in each batch, in launched weights.

    Parameters
    ----------
    ranges : sequence of (int, int)
        First cell and number of cells, ascending.
    """

    def __init__(self, ranges: tuple[tuple[int, int], ...]) -> None:
        self.ranges = ranges
        self.cells = (
            np.concatenate([np.arange(first, first + n) for first, n in ranges])
            if ranges
            else np.empty(0, np.int64)
        )
        self._rows: list[NDArray[np.float64]] | None = []
        self._whole = np.empty((0, len(self.cells)))

    @property
    def kept(self) -> bool:
        """Whether every batch so far is there."""
        return self._rows is not None

    def add(self, tally: NDArray[np.int64] | SparseTally) -> None:
        """Add a batch, in canonical form."""
        if self._rows is None or not self.ranges:
            return
        if (len(self._rows) + 1) * len(self.cells) > MOST_VALUES:
            self._rows = None
            return
        if isinstance(tally, SparseTally):
            found = np.concatenate([whole_of(tally, first, n) for first, n in self.ranges])
        else:
            found = tally[self.cells]
        self._rows.append(values(found))

    def copy(self) -> BatchValues:
        """Return an independent copy."""
        made = BatchValues(())
        made.ranges, made.cells, made._whole = self.ranges, self.cells, self._whole
        made._rows = None if self._rows is None else list(self._rows)
        return made

    def table(self) -> NDArray[np.float64] | None:
        """Return all, shape (batches, cells); None where they are not kept."""
        if self._rows is None:
            return None
        if len(self._whole) < len(self._rows):
            self._whole = np.array(self._rows).reshape(len(self._rows), len(self.cells))
            self._whole.flags.writeable = False
            self._rows = list(self._whole)  # parts of it, and no second copy
        return self._whole

    def restore(self, table: NDArray[np.float64] | None) -> None:
        """Go on from what `table` gave.

        Raises
        ------
        ValueError
            Where it is of other cells.
        """
        if table is None:
            self._rows = None
            return
        if table.ndim != 2 or table.shape[1] != len(self.cells):
            raise ValueError(f"batch values of the shape {table.shape}")
        self._rows = list(np.array(table, np.float64))

    def of(self, cell: int) -> NDArray[np.float64] | None:
        """Return what a cell gave in each batch, shape (batches,); None where it is not kept."""
        table = self.table()
        if table is None:
            return None
        column = int(np.searchsorted(self.cells, cell))
        if column == len(self.cells) or self.cells[column] != cell:
            return None
        return table[:, column].copy()
