"""Reading batches' tallies from a device, and adding up what is read of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.errors import HostError
from hostcode.run.tally import BLOCK, CELL, SparseTally, canonical, carry, lit_rows, merged

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice

__all__ = ["read_dense", "read_sparse"]

_FULLEST: Final = 2.0**62
"""Units of 2^-31 launched weights that a batch's cells may hold together."""


def read_dense(
    device: OpenDevice,
    buffer: cl.Buffer,
    slots: int,
    n_cells: int,
    before: NDArray[np.int64] | None,
) -> NDArray[np.int64]:
    """Return what the slots' tallies hold, in canonical form.

    Parameters
    ----------
    device : OpenDevice
        Where they are.
    buffer : Buffer
        That holds them.
    slots, n_cells : int
        How many, and cells of each.
    before : ndarray, shape (slots, n_cells, 4), int64, or None
        What was read of them before, which is added.

    Returns
    -------
    ndarray, shape (slots, n_cells, 4), int64

    Raises
    ------
    HostError
        Where one holds so much that its integers may run over.
    """
    import pyopencl as cl

    total = np.empty((slots, n_cells, CELL), np.int64)
    cl.enqueue_copy(device.queue, total, buffer)
    if before is not None:
        total += before
    carry(total.reshape(-1, CELL))
    for slot in range(slots):
        _check(np.abs(total[slot, :, 0], dtype=np.float64).sum())
    return total


def read_sparse(
    device: OpenDevice, buffer: cl.Buffer, n_cells: int, before: SparseTally | None
) -> SparseTally:
    """Return what a tally of very many cells holds; as `read_dense`, of one slot."""
    import pyopencl as cl

    numbers: list[NDArray[np.int64]] = []
    rows: list[NDArray[np.int64]] = []
    space = np.empty((min(BLOCK, n_cells), CELL), np.int64)
    for first in range(0, n_cells, BLOCK):
        block = space[: min(BLOCK, n_cells - first)]
        cl.enqueue_copy(device.queue, block, buffer, src_offset=8 * CELL * first)
        lit = lit_rows(block)
        if len(lit):
            numbers.append(lit + first)
            rows.append(canonical(block[lit]))
    found = SparseTally(n_cells, _joined(numbers, ()), _joined(rows, (CELL,)))
    total = found if before is None else merged(before, found)
    _check(np.abs(total.rows[:, 0], dtype=np.float64).sum())
    return total


def _joined(parts: Sequence[NDArray[np.int64]], ends: tuple[int, ...]) -> NDArray[np.int64]:
    return np.concatenate(parts) if parts else np.empty((0, *ends), np.int64)


def _check(held: float) -> None:
    """Raise far below the overflow, which what rays pass many times could reach without a word."""
    if held > _FULLEST:
        raise HostError(
            "a batch's tally holds more than 2^31 launched weights: what rays pass or meet "
            "very often filled it, or an effect counts numbers beyond 4 at once; take fewer "
            "rays_per_batch or a lower generation_cap, or give the effect a scale"
        )
