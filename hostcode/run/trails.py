"""Which steps a path has: the launched ray that shows it is followed until it arrives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.program.build import build
from hostcode.program.fields import of_type
from hostcode.run.probe import apart
from hostcode.run.queue import Queue
from hostcode.run.tables import launch_of
from hostcode.run.tally import CELL

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

__all__ = ["MOST_INTERACTIONS", "follow_trails"]

MOST_INTERACTIONS: Final = 1 << 22
"""Steps for which the children of one launched ray are followed."""
_WANTED: Final = 5
_BYTES_AT_ONCE: Final = 64 << 20
_AT_ONCE: Final = 4096


def follow_trails(
    device: OpenDevice,
    tables: DeviceTables,
    wanted: NDArray[np.int64],
    longest: int,
    give_up: Callable[[], bool] | None = None,
) -> Sequence[NDArray[np.int64] | None]:
    """Return the steps of paths.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        The compiled scene, whose rays carry the keys of their paths.
    wanted : ndarray, shape (n, 5), int64
        Key of each path, batch of the launched ray that shows it and its number in that, element
        and number of the detector that it ends in.
    longest : int
        Interactions of the longest.
    give_up : callable, optional
        Asked on the way: whether to leave the rest.

    Returns
    -------
    sequence of (ndarray, shape (interactions,), int64) or None
        Element << 20 | name of the face << 4 | event of each step; None where the path was not
        found within `MOST_INTERACTIONS`, or was left.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    import pyopencl as cl

    spec = tables.spec.for_device(1, ("trails",))
    program = build(device, spec)
    kernel = program.kernel("trails_stage")
    capacity = max(longest, 1)
    cap = int(tables.launch["generation_cap"])
    stack = cap + 2 if spec.splits else 1
    # what is followed may be longer than what is wanted
    room = max(capacity, cap + 1)
    words = len(of_type(spec.ray_fields, "word"))
    a_path = 8 * room + (8 * (len(spec.ray_fields) - words) + 4 * words + 8) * stack
    at_once = min(max(_BYTES_AT_ONCE // a_path, 1), len(wanted), _AT_ONCE)
    flags = cl.mem_flags

    def allocate(n: int) -> cl.Buffer:
        return cl.Buffer(device.context, flags.READ_WRITE, 8 * max(n, 1))

    def upload(array: NDArray[np.int64] | NDArray[np.float64]) -> cl.Buffer:
        # buffers cannot be empty
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return cl.Buffer(device.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=filled)

    launch = launch_of(tables, slots=1, stack_capacity=stack)
    launch_buffer = allocate(launch.nbytes // 8)
    scene = [upload(a) for a in (tables.geometry, tables.materials, tables.sources, tables.codes)]
    tally = allocate(CELL * tables.n_cells)
    queue = Queue(device, spec, at_once, stack)
    last_steps, chains, lengths = (allocate(n) for n in (at_once * stack, at_once * room, at_once))
    found: list[NDArray[np.int64] | None] = []
    for begin in range(0, len(wanted), at_once):
        if give_up is not None and give_up():
            break
        some = wanted[begin : begin + at_once]
        launch["items"] = len(some)
        cl.enqueue_copy(device.queue, launch_buffer, launch)
        asked = upload(some)  # kept: a kernel does not hold its arguments
        kernel.set_args(
            launch_buffer, *scene, tally, *queue.fields, last_steps, asked, chains, lengths,
            np.uint64(room), np.uint64(MOST_INTERACTIONS),
        )  # fmt: skip
        cl.enqueue_nd_range_kernel(device.queue, kernel, *apart(device, len(some)))
        steps, n = np.empty((len(some), room), np.int64), np.empty(len(some), np.int64)
        cl.enqueue_copy(device.queue, steps, chains)
        cl.enqueue_copy(device.queue, n, lengths)
        found += [s[:k].copy() if k >= 0 else None for s, k in zip(steps, n.tolist(), strict=True)]
    program.keep()
    return found + [None] * (len(wanted) - len(found))
