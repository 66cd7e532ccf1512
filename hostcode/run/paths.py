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
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

__all__ = ["REALS", "WHOLES", "RawPaths", "trace_paths"]

REALS: Final = 7
"""Numbers of a segment: start, end (the direction where it escapes), weight."""
WHOLES: Final = 6
"""Integers of a segment: path, generation, element, segment it continues, begins, ending."""
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
    cut : ndarray, shape (rays,), bool
        Which rays were not followed to their ends.
    cells : ndarray, shape (n_cells, 4), int64, or SparseTally
        The ledger's part of the batch's tally, as the device gives it, see `hostcode.run.tally`.
    """

    ray: NDArray[np.int64]
    reals: NDArray[np.float64]
    wholes: NDArray[np.int64]
    cut: NDArray[np.bool_]
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
    import pyopencl as cl

    rays = int(tables.launch["rays_per_batch"])
    spec = tables.spec.for_device(1, ("paths",))
    program = build(device, spec)
    kernel = program.kernel("paths_stage")
    # A split leaves one child waiting, so that no more wait than segments were written.
    stack = max_segments + 2 if spec.splits else 1
    words = len(of_type(spec.ray_fields, "word"))
    waiting = 8 * (len(spec.ray_fields) - words) + 4 * words + 8
    a_ray = 8 * (REALS + WHOLES) * max_segments + waiting * stack + 16
    at_once = min(max(_BYTES_AT_ONCE // a_ray, 1), rays)
    flags = cl.mem_flags

    def upload(array: NDArray[Any]) -> cl.Buffer:
        # Buffers cannot be empty, and a scene without elements has empty tables.
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return cl.Buffer(device.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=filled)

    def allocate(n: int) -> cl.Buffer:
        return cl.Buffer(device.context, flags.READ_WRITE, 8 * n)

    launch = launch_of(tables, slots=1, stack_capacity=stack, record_capacity=max_segments)
    launch_buffer = allocate(launch.nbytes // 8)
    scene = [upload(a) for a in (tables.geometry, tables.materials, tables.sources, tables.codes)]
    tally = allocate(CELL * tables.n_cells)
    cl.enqueue_fill_buffer(device.queue, tally, np.zeros(1, np.int64), 0, tally.size)
    queue = Queue(device, spec, at_once, stack)
    parents, counts_buffer = allocate(at_once * stack), allocate(2 * at_once)
    reals_buffer = allocate(REALS * at_once * max_segments)
    wholes_buffer = allocate(WHOLES * at_once * max_segments)
    segments = (reals_buffer, wholes_buffer, counts_buffer)
    found: list[tuple[NDArray[Any], ...]] = []
    behind = 0
    for first in range(0, rays, at_once):
        m = min(at_once, rays - first)
        launch["items"] = m
        cl.enqueue_copy(device.queue, launch_buffer, launch)
        kernel.set_args(
            launch_buffer, *scene, tally, *queue.fields, parents, *segments, np.uint64(first)
        )
        cl.enqueue_nd_range_kernel(device.queue, kernel, *apart(device, m))
        counts = np.empty((m, 2), np.int64)
        cl.enqueue_copy(device.queue, counts, counts_buffer)
        reals = np.empty((m, max_segments, REALS))
        wholes = np.empty((m, max_segments, WHOLES), np.int64)
        cl.enqueue_copy(device.queue, reals, reals_buffer)
        cl.enqueue_copy(device.queue, wholes, wholes_buffer)
        used = np.arange(max_segments) < counts[:, :1]
        before = behind + np.cumsum(counts[:, 0]) - counts[:, 0]
        wholes[..., 3] += np.where(wholes[..., 3] >= 0, before[:, np.newaxis], 0)
        ray = np.repeat(np.arange(first, first + m), counts[:, 0])
        found.append((ray, reals[used], wholes[used], counts[:, 1] > 0))
        behind += len(ray)
    cells: NDArray[np.int64] | SparseTally
    if is_sparse(tables.n_cells):
        cells = read_sparse(device, tally, tables.n_cells, None)
    else:
        cells = read_dense(device, tally, 1, tables.n_cells, None)[0]
    program.keep()
    ray, reals, wholes, cut = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return RawPaths(ray, reals, wholes, cut, cells)
