"""Which steps a path has: the launched ray that shows it is followed until it arrives."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.build import build
from hostcode.program.fields import of_type
from hostcode.run.probe import apart
from hostcode.run.queue import Queue
from hostcode.run.tables import launch_of
from hostcode.run.tally import CELL

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

__all__ = ["MOST_INTERACTIONS", "follow_trails"]

MOST_INTERACTIONS: Final = 1 << 22
"""Steps for which the children of one launched ray are followed."""
_BYTES_AT_ONCE: Final = 64 << 20
_AT_ONCE: Final = 4096
_FIRST: Final = 4
"""Rays that are followed together at first; twice as many where that took less than `_SHORT`."""
_SHORT: Final = 0.1


def follow_trails(
    device: OpenDevice,
    tables: DeviceTables,
    keys: NDArray[np.int64],
    rays: NDArray[np.int64],
    interactions: NDArray[np.int64],
    give_up: Callable[[], bool] | None = None,
) -> list[NDArray[np.int64] | None]:
    """Return the steps of paths.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        The compiled scene, whose rays carry the keys of their paths.
    keys : ndarray, shape (n,), int64
        Of the paths.
    rays : ndarray, shape (n,), int64
        Number of a launched ray that shows each.
    interactions : ndarray, shape (n,), int64
        Of each path.
    give_up : callable, optional
        Asked on the way: whether to leave the rest.

    Returns
    -------
    list of (ndarray, shape (interactions,), int64) or None
        Element << 20 | name of the face << 4 | event of each step; None where the path was not
        found within `MOST_INTERACTIONS` of its ray, or was left.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    import pyopencl as cl

    found: list[NDArray[np.int64] | None] = [None] * len(keys)
    if not len(keys):
        return found
    spec = tables.spec.for_device(1, ("trails",))
    program = build(device, spec)
    kernel = program.kernel("trails_stage")
    cap = int(tables.launch["generation_cap"])
    stack = cap * spec.children + 2 if spec.splits else 1
    room = cap + 1
    words = len(of_type(spec.ray_fields, "word"))
    a_ray = 8 * room + (8 * (len(spec.ray_fields) - words) + 4 * words + 8) * stack
    at_once = min(max(_BYTES_AT_ONCE // a_ray, 1), _AT_ONCE)
    flags = cl.mem_flags

    def allocate(n: int) -> cl.Buffer:
        return cl.Buffer(device.context, flags.READ_WRITE, 8 * max(n, 1))

    def upload(array: NDArray[Any]) -> cl.Buffer:
        # buffers cannot be empty
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return cl.Buffer(device.context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=filled)

    launch = launch_of(tables, slots=1, stack_capacity=stack)
    launch_buffer = allocate(launch.nbytes // 8)
    scene = [upload(a) for a in (tables.geometry, tables.materials, tables.sources, tables.codes)]
    tally = allocate(CELL * tables.n_cells)
    queue = Queue(device, spec, at_once, stack)
    last_steps, chains = allocate(at_once * stack), allocate(at_once * room)
    per_batch = int(tables.launch["rays_per_batch"])
    order = np.lexsort((keys.view(np.uint64), rays))  # as the kernel has the keys of a ray
    done, together = 0, min(_FIRST, at_once)
    while done < len(order) and not (give_up is not None and give_up()):
        began = time.perf_counter()
        some = _group(order[done:], rays, interactions, together)
        done += len(some)
        numbers, begins, counts = np.unique(rays[some], return_index=True, return_counts=True)
        longest = np.maximum.reduceat(interactions[some], begins)
        asked = np.stack([*divmod(numbers, per_batch), begins, counts, longest], axis=1)
        launch["items"] = len(asked)
        cl.enqueue_copy(device.queue, launch_buffer, launch)
        width = max(int(longest.max()), 1)
        steps = np.zeros((len(some), width), np.int64)
        lengths = np.full(len(some), -1)
        # kept here: a kernel does not hold its arguments
        buffers = [upload(a) for a in (asked, keys[some], steps, lengths)]
        kernel.set_args(
            launch_buffer, *scene, tally, *queue.fields, last_steps, chains, *buffers,
            np.uint64(room), np.uint64(width), np.uint64(MOST_INTERACTIONS),
        )  # fmt: skip
        cl.enqueue_nd_range_kernel(device.queue, kernel, *apart(device, len(asked)))
        cl.enqueue_copy(device.queue, steps, buffers[2])
        cl.enqueue_copy(device.queue, lengths, buffers[3])
        for n, row, length in zip(some.tolist(), steps, lengths.tolist(), strict=True):
            found[n] = row[:length].copy() if length >= 0 else None
        if time.perf_counter() - began < _SHORT:
            together = min(2 * together, at_once)
    program.keep()
    return found


def _group(
    order: NDArray[np.intp], rays: NDArray[np.int64], interactions: NDArray[np.int64], most: int
) -> NDArray[np.intp]:
    """Return the first paths of an order, of so many rays at most, whose steps take little room."""
    new = np.diff(rays[order], prepend=-1) != 0
    last = int(np.searchsorted(np.cumsum(new), most, side="right"))
    widest = np.maximum.accumulate(interactions[order[:last]])
    size = 8 * np.arange(1, last + 1) * np.maximum(widest, 1)
    return order[: max(int(np.searchsorted(size, _BYTES_AT_ONCE, side="right")), 1)]
