"""Every segment of a few rays, by the functions that the trace runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.build import build
from hostcode.program.fields import of_type
from hostcode.run.probe import apart
from hostcode.run.queue import Queue
from hostcode.run.readout import read_dense, read_sparse
from hostcode.run.tables import launch_of
from hostcode.run.tally import CELL, SparseTally, is_sparse

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

__all__ = ["REALS", "WHOLES", "Follower", "RawPaths", "joined", "trace_paths"]

REALS: Final = 7
"""Numbers of a segment: start, end (the direction where it escapes), weight."""
WHOLES: Final = 7
"""Integers of a segment: path, generation, element, segment it continues, begins, ending, face."""
_BYTES_AT_ONCE: Final = 64 << 20


@dataclass(frozen=True, eq=False)
class RawPaths:
    """Segments of rays in the order in which they were followed, ray by ray.

    Parameters
    ----------
    ray : ndarray, shape (n,), int64
        Number of the launched ray.
    reals : ndarray, shape (n, REALS), float64
        In the scene's recentred coordinates, in metres; weights relative to the heaviest launched.
    wholes : ndarray, shape (n, WHOLES), int64
        The segment that one continues counts within all of `ray`.
    cut : ndarray, int64
        Numbers of the rays that were not followed to their ends.
    cells : ndarray, shape (n_cells, 4), int64, or SparseTally
        The ledger's part of the batch's tally, as the device gives it, see `hostcode.run.tally`.
    """

    ray: NDArray[np.int64]
    reals: NDArray[np.float64]
    wholes: NDArray[np.int64]
    cut: NDArray[np.int64]
    cells: NDArray[np.int64] | SparseTally


def trace_paths(device: OpenDevice, tables: DeviceTables, max_segments: int) -> RawPaths:
    """Follow the rays of batch 0 and return every segment.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        The compiled scene; its ``rays_per_batch`` rays are followed.
    max_segments : int
        Segments written down of one launched ray and its children.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    follower = Follower(device, tables, max_segments)
    parts = list(follower.follow(0, 0, int(tables.launch["rays_per_batch"])))
    return joined(parts, follower.cells())


def joined(parts: Sequence[RawPaths], cells: NDArray[np.int64] | SparseTally) -> RawPaths:
    """Return parts of what was followed as one, with what the ledger says of all."""
    behind, wholes = 0, []
    for part in parts:
        moved = part.wholes.copy()
        moved[:, 3] += np.where(moved[:, 3] >= 0, behind, 0)
        wholes.append(moved)
        behind += len(part.ray)
    return RawPaths(
        np.concatenate([np.empty(0, np.int64), *(part.ray for part in parts)]),
        np.concatenate([np.empty((0, REALS)), *(part.reals for part in parts)]),
        np.concatenate([np.empty((0, WHOLES), np.int64), *wholes]),
        np.concatenate([np.empty(0, np.int64), *(part.cut for part in parts)]),
        cells,
    )


class Follower:
    """Follows launched rays and writes every segment down.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        The compiled scene.
    max_segments : int
        Segments written down of one launched ray and its children.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """

    def __init__(self, device: OpenDevice, tables: DeviceTables, max_segments: int) -> None:
        import pyopencl as cl

        self._cl, self._device, self._tables, self._most = cl, device, tables, max_segments
        spec = tables.spec.for_device(1, ("paths",))
        self._program = build(device, spec)
        self._kernel = self._program.kernel("paths_stage")
        # A split leaves its children waiting: so many for each segment that was written.
        stack = max_segments * spec.children + 2 if spec.splits else 1
        words = len(of_type(spec.ray_fields, "word"))
        waiting = 8 * (len(spec.ray_fields) - words) + 4 * words + 8
        a_ray = 8 * (REALS + WHOLES) * max_segments + waiting * stack + 16
        rays = int(tables.launch["rays_per_batch"])
        self.at_once = min(max(_BYTES_AT_ONCE // a_ray, 1), rays)
        """Rays that are followed together."""
        self._launch = launch_of(
            tables, slots=1, stack_capacity=stack, record_capacity=max_segments
        )
        self._launch_buffer = self._allocate(self._launch.nbytes // 8)
        self._scene = [
            self._upload(a)
            for a in (tables.geometry, tables.materials, tables.sources, tables.codes)
        ]
        self._tally = self._allocate(CELL * tables.n_cells)
        zero = np.zeros(1, np.int64)
        cl.enqueue_fill_buffer(device.queue, self._tally, zero, 0, self._tally.size)
        n = self.at_once
        self._queue = Queue(device, spec, n, stack)
        self._parents, self._counts = self._allocate(n * stack), self._allocate(2 * n)
        self._reals = self._allocate(REALS * n * max_segments)
        self._wholes = self._allocate(WHOLES * n * max_segments)

    def _upload(self, array: NDArray[Any]) -> cl.Buffer:
        # Buffers cannot be empty, and a scene without elements has empty tables.
        flags = self._cl.mem_flags.READ_ONLY | self._cl.mem_flags.COPY_HOST_PTR
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return self._cl.Buffer(self._device.context, flags, hostbuf=filled)

    def _allocate(self, n: int) -> cl.Buffer:
        return self._cl.Buffer(self._device.context, self._cl.mem_flags.READ_WRITE, 8 * n)

    def follow(self, batch: int, first: int, n: int) -> Iterator[RawPaths]:
        """Follow rays of a batch, and give their segments some rays at a time.

        Parameters
        ----------
        batch : int
            Number of the batch.
        first, n : int
            Number in that of the first ray, and how many.
        """
        cl, queue = self._cl, self._device.queue
        base = batch * int(self._tables.launch["rays_per_batch"])
        for begin in range(first, first + n, self.at_once):
            m = min(self.at_once, first + n - begin)
            self._launch["items"], self._launch["ray_base"] = m, base
            cl.enqueue_copy(queue, self._launch_buffer, self._launch)
            self._kernel.set_args(
                self._launch_buffer, *self._scene, self._tally, *self._queue.fields,
                self._parents, self._reals, self._wholes, self._counts, np.uint64(begin),
            )  # fmt: skip
            cl.enqueue_nd_range_kernel(queue, self._kernel, *apart(self._device, m))
            counts = np.empty((m, 2), np.int64)
            cl.enqueue_copy(queue, counts, self._counts)
            # of the room for each ray's segments what the longest one has taken
            longest = max(int(counts[:, 0].max()), 1)
            reals = self._begun(self._reals, np.empty((m, longest, REALS)))
            wholes = self._begun(self._wholes, np.empty((m, longest, WHOLES), np.int64))
            used = np.arange(longest) < counts[:, :1]
            before = np.cumsum(counts[:, 0]) - counts[:, 0]
            wholes[..., 3] += np.where(wholes[..., 3] >= 0, before[:, np.newaxis], 0)
            numbers = np.arange(base + begin, base + begin + m)
            ray = np.repeat(numbers, counts[:, 0])
            cut = numbers[counts[:, 1] > 0]
            none = np.empty((0, CELL), np.int64)
            yield RawPaths(ray, reals[used], wholes[used], cut, none)
        self._program.keep()

    def _begun(self, buffer: cl.Buffer, into: NDArray[Any]) -> NDArray[Any]:
        """Read the first segments of each ray, as many as an array holds."""
        rays, segments, numbers = into.shape
        row = 8 * segments * numbers
        part: dict[str, Any] = {
            "buffer_origin": (0, 0), "host_origin": (0, 0), "region": (row, rays),
            "buffer_pitches": (8 * self._most * numbers,), "host_pitches": (row,),
        }  # fmt: skip
        self._cl.enqueue_copy(self._device.queue, into, buffer, **part)
        return into

    def cells(self) -> NDArray[np.int64] | SparseTally:
        """Return the ledger's part of the tally of all that was followed."""
        n_cells = self._tables.n_cells
        if is_sparse(n_cells):
            return read_sparse(self._device, self._tally, n_cells, None)
        dense = read_dense(self._device, self._tally, 1, n_cells, None)
        return np.asarray(dense[0], np.int64)
