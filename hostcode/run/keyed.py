"""Cells by key: exact sums of what has no place of its own in a tally, because too many could be.

A device keeps them in a hash table, open addressing with linear probing, one for each batch in
flight: key, limbs and count as in any cell, what is known of the key, and the first launched ray
that came there. Integers are added with atomics, so that neither order nor place reaches the sums;
read out they stand in order of their keys. A table that is too small is found out by its batch,
which is then traced again with a larger one: nothing of it was handed over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.errors import HostError
from hostcode.run.tally import CELL, canonical

if TYPE_CHECKING:
    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice

__all__ = ["ENTRY", "FIRST_CAPACITY", "KeyedRows", "KeyedTable", "merged_rows"]

ENTRY: Final = 8
"""Integers of an entry: key, cell (4), 2^62 less the first ray's number, what is known, unused."""
FIRST_CAPACITY: Final = 1 << 13
"""Entries of a batch's table at first; a power of two."""
_GROWS: Final = 8
_MOST_BYTES: Final = 2 << 30
_FROM: Final = 1 << 62


@dataclass(frozen=True, eq=False)
class KeyedRows:
    """Cells by key, ascending.

    Parameters
    ----------
    keys : ndarray, shape (m,), int64
        Different, none of them 0.
    about : ndarray, shape (m,), int64
        What is known of each key: of one key always the same.
    first : ndarray, shape (m,), int64
        Lowest number of a launched ray that was counted there.
    rows : ndarray, shape (m, 4), int64
        Limbs and counts in canonical form, see `hostcode.run.tally`.
    """

    keys: NDArray[np.int64]
    about: NDArray[np.int64]
    first: NDArray[np.int64]
    rows: NDArray[np.int64]

    def __post_init__(self) -> None:
        """See that the arrays are what they should be.

        Raises
        ------
        ValueError
            Where they are not: they may come from another process.
        """
        m = len(self.keys)
        arrays = (self.keys, self.about, self.first, self.rows)
        shapes = [(m,), (m,), (m,), (m, CELL)]
        if [a.shape for a in arrays] != shapes or any(a.dtype != np.int64 for a in arrays):
            raise ValueError("keys and rows do not belong together")
        if (self.keys[1:] <= self.keys[:-1]).any() or (self.keys == 0).any():
            raise ValueError("keys do not ascend")

    def __len__(self) -> int:
        return len(self.keys)

    @property
    def arrays(self) -> tuple[NDArray[np.int64], ...]:
        """All arrays, in the order in which a digest takes them."""
        return self.keys, self.about, self.first, self.rows

    def copy(self) -> KeyedRows:
        """Return cells that share nothing with these, looked at again."""
        return KeyedRows(*(a.copy() for a in self.arrays))


def merged_rows(a: KeyedRows, b: KeyedRows) -> KeyedRows:
    """Return the sum of two tables."""
    keys = np.union1d(a.keys, b.keys)
    about = np.zeros(len(keys), np.int64)
    first = np.full(len(keys), _FROM)
    rows = np.zeros((len(keys), CELL), np.int64)
    for part in (a, b):
        at = np.searchsorted(keys, part.keys)
        about[at] = part.about
        first[at] = np.minimum(first[at], part.first)
        rows[at] += part.rows
    return KeyedRows(keys, about, first, canonical(rows))


class KeyedTable:
    """The tables of the batches in flight, on a device.

    Parameters
    ----------
    device : OpenDevice
        Where.
    slots : int
        Batches in flight.
    """

    def __init__(self, device: OpenDevice, slots: int) -> None:
        self._device, self.slots = device, slots
        self.capacity = FIRST_CAPACITY
        self.buffer = self._allocate()

    @staticmethod
    def size(slots: int, capacity: int = FIRST_CAPACITY) -> int:
        """Return the bytes of the tables: a head, then each batch's."""
        return 8 * ENTRY * (1 + slots * capacity)

    def _allocate(self) -> cl.Buffer:
        import pyopencl as cl

        size = self.size(self.slots, self.capacity)
        return cl.Buffer(self._device.context, cl.mem_flags.READ_WRITE, size)

    def clear(self, slots: int) -> None:
        """Empty the tables of the first slots."""
        import pyopencl as cl

        size = self.size(slots, self.capacity)
        cl.enqueue_fill_buffer(self._device.queue, self.buffer, np.zeros(1, np.int64), 0, size)

    def too_small(self) -> bool:
        """Say whether something found no place since the tables were emptied."""
        import pyopencl as cl

        head = np.empty(ENTRY, np.int64)
        cl.enqueue_copy(self._device.queue, head, self.buffer)
        return bool(head[0])

    def grow(self) -> None:
        """Make the tables larger, and fewer where they would be too large; what is in them is lost.

        Raises
        ------
        HostError
            Where one alone is more than there may be.
        """
        wanted = _GROWS * self.capacity
        most = min(_MOST_BYTES, self._device.record.max_allocation)
        while self.slots > 1 and self.size(self.slots, wanted) > most:
            self.slots //= 2
        while wanted > 2 * self.capacity and self.size(self.slots, wanted) > most:
            wanted //= 2
        size = self.size(self.slots, wanted)
        if size > most:
            raise HostError(
                f"more than {self.capacity} different paths end in one batch, and a larger table "
                f"takes {size / 1e9:.1f} GB: take fewer rays_per_batch or a lower generation_cap"
            )
        self.buffer.release()
        self.capacity = wanted
        self.buffer = self._allocate()

    def read(self, slots: int, before: list[KeyedRows] | None) -> list[KeyedRows]:
        """Return what the first slots' tables hold, with what was read of them before."""
        import pyopencl as cl

        found = []
        space = np.empty((self.capacity, ENTRY), np.int64)
        for slot in range(slots):
            offset = self.size(slot, self.capacity)
            cl.enqueue_copy(self._device.queue, space, self.buffer, src_offset=offset)
            lit = space[space[:, 0] != 0]
            lit = lit[np.argsort(lit[:, 0])]
            rows = canonical(lit[:, 1:5])
            found.append(KeyedRows(lit[:, 0].copy(), lit[:, 6].copy(), _FROM - lit[:, 5], rows))
        if before is None:
            return found
        return [merged_rows(a, b) for a, b in zip(before, found, strict=True)]
