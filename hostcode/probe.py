"""Intersections of given rays with a scene, by the kernels that the trace runs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program import build
from hostcode.structs import LAUNCH, numpy_dtype

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from hostcode.device import OpenDevice
    from hostcode.tables import DeviceTables

__all__ = ["probe_rays"]

_RAYS_AT_ONCE: Final = 1 << 20


def probe_rays(
    device: OpenDevice, tables: DeviceTables, rays: NDArray[np.float64], lanes: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return what each ray hits first.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        The compiled scene.
    rays : ndarray, shape (n, 6), float64
        Origins in the scene's recentred coordinates, in metres, and unit directions.
    lanes : int
        Lane width; changes no bit.

    Returns
    -------
    hits : ndarray, shape (n, 7), float64
        Distance, point (recentred), outward unit normal. On a miss the distance is infinite and the
        rest has no meaning.
    elements : ndarray, shape (n,), int64
        Number of the element, −1 on a miss.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    import pyopencl as cl

    n = len(rays)
    hits, elements = np.empty((n, 7)), np.empty(n, np.int64)
    if not n:
        return hits, elements
    program = build(device, tables.spec.for_device(lanes, ("probe",)))
    kernel = program.kernel("probe_stage")
    flags = cl.mem_flags
    read = flags.READ_ONLY | flags.COPY_HOST_PTR

    def upload(array: NDArray[Any]) -> cl.Buffer:
        # Buffers cannot be empty, and a scene without elements has empty tables.
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return cl.Buffer(device.context, read, hostbuf=filled)

    launch = np.zeros((), numpy_dtype(LAUNCH))
    for name, value in tables.launch.items():
        launch[name] = value
    launch["n_cells"], launch["slots"], launch["items"] = tables.n_cells, 1, 1
    nothing = cl.Buffer(device.context, flags.READ_WRITE, 64)  # the tally, which is not touched
    scene = [upload(a) for a in (tables.geometry, tables.materials, tables.sources, tables.codes)]
    common = (upload(launch.reshape(1)), *scene, nothing)
    for start in range(0, n, _RAYS_AT_ONCE):
        part = np.ascontiguousarray(rays[start : start + _RAYS_AT_ONCE], np.float64)
        m = len(part)
        out = np.empty((m, 7))
        which = np.empty(m, np.int64)
        # A kernel keeps none of its arguments alive: each needs a name here.
        rays_buffer = upload(part)
        hits_buffer = cl.Buffer(device.context, flags.WRITE_ONLY, out.nbytes)
        elements_buffer = cl.Buffer(device.context, flags.WRITE_ONLY, which.nbytes)
        kernel.set_args(*common, rays_buffer, hits_buffer, elements_buffer, np.uint64(m))
        cl.enqueue_nd_range_kernel(device.queue, kernel, (math.ceil(m / lanes),), None)
        cl.enqueue_copy(device.queue, out, hits_buffer)
        cl.enqueue_copy(device.queue, which, elements_buffer)
        hits[start : start + m], elements[start : start + m] = out, which
    return hits, elements
