"""Intersections of given rays with a scene, by the kernels that the trace runs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.build import build
from hostcode.run.tables import launch_of
from hostcode.run.tally import CELL

if TYPE_CHECKING:
    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

__all__ = [
    "LEFT_PLUS",
    "NO_FACE",
    "Followed",
    "apart",
    "element_of",
    "face_of",
    "follow_rays",
    "probe_faces",
    "probe_rays",
]

NO_FACE: Final = -1
"""State of a ray that was launched and has left no face."""
LEFT_PLUS: Final = 2
"""Bit of the state that says that the ray is now on the side that the normal points to."""

_RAYS_AT_ONCE: Final = 1 << 20
_STATE: Final = 15


def apart(device: OpenDevice, items: int) -> tuple[tuple[int], tuple[int]]:
    """Return the global and local size for work-items that have much memory of their own.

    Left to itself a CPU's runtime makes groups of thousands, whose items' private memory (the
    search's stack, above all) then stands on one thread's stack together and overflows it. Items
    beyond the number asked for must find nothing to do.
    """
    local = 64 if device.record.type == "gpu" else 1
    return (math.ceil(items / local) * local,), (local,)


def element_of(left: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the elements that states name, −1 for none."""
    return left >> 34


def face_of(left: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the faces that states name."""
    return (left >> 18) & 0xFFFF


def probe_rays(
    device: OpenDevice, tables: DeviceTables, rays: NDArray[np.float64], lanes: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return what each launched ray hits first.

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
    hits, faces = probe_faces(device, tables, rays, lanes)
    return hits, element_of(faces)


def probe_faces(
    device: OpenDevice,
    tables: DeviceTables,
    rays: NDArray[np.float64],
    lanes: int,
    left: NDArray[np.int64] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return which face each ray hits first, for rays that may be under way.

    Parameters
    ----------
    device, tables, rays, lanes
        As for `probe_rays`.
    left : ndarray, shape (n,), int64, optional
        What each ray has left: a state that this function returned, for a ray that goes on from
        there as if reflected, or that state with `LEFT_PLUS` flipped for one that went through;
        `NO_FACE` for a launched ray. Default all launched.

    Returns
    -------
    hits : ndarray, shape (n, 7), float64
        As for `probe_rays`.
    faces : ndarray, shape (n,), int64
        The state of a ray reflected there, see `element_of` and `face_of`; −1 on a miss.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    import pyopencl as cl

    n = len(rays)
    hits, faces = np.empty((n, 7)), np.empty(n, np.int64)
    if not n:
        return hits, faces
    if left is None:
        left = np.full(n, NO_FACE, np.int64)
    program = build(device, tables.spec.for_device(lanes, ("probe",)))
    kernel = program.kernel("probe_stage")
    flags = cl.mem_flags
    # A kernel keeps none of its arguments alive: each needs a name here.
    common = _scene_arguments(device, tables)
    for start in range(0, n, _RAYS_AT_ONCE):
        part = np.ascontiguousarray(rays[start : start + _RAYS_AT_ONCE], np.float64)
        m = len(part)
        out, which = np.empty((m, 7)), np.empty(m, np.int64)
        rays_buffer = _upload(device, part)
        left_buffer = _upload(device, left[start : start + m].astype(np.int64))
        hits_buffer = cl.Buffer(device.context, flags.WRITE_ONLY, out.nbytes)
        faces_buffer = cl.Buffer(device.context, flags.WRITE_ONLY, which.nbytes)
        kernel.set_args(*common, rays_buffer, left_buffer, hits_buffer, faces_buffer, np.uint64(m))
        cl.enqueue_nd_range_kernel(device.queue, kernel, *apart(device, math.ceil(m / lanes)))
        cl.enqueue_copy(device.queue, out, hits_buffer)
        cl.enqueue_copy(device.queue, which, faces_buffer)
        hits[start : start + m], faces[start : start + m] = out, which
    program.keep()
    return hits, faces


@dataclass(frozen=True, eq=False)
class Followed:
    """Rays through some interactions, entry (ray, step) each.

    Parameters
    ----------
    distance : ndarray, shape (n, steps), float64
        Metres to the interaction; infinite where the ray escaped.
    point, normal, direction : ndarray, shape (n, steps, 3), float64
        Where (recentred), the outward normal there, and the direction after it.
    weight : ndarray, shape (n, steps), float64
        Weight after it; the ray starts with 1.
    other_direction, other_weight : ndarray
        The same of the child that was not followed; weight 0 where there was none.
    left : ndarray, shape (n, steps), int64
        State after it, −1 where the ray has ended.
    """

    distance: NDArray[np.float64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    direction: NDArray[np.float64]
    weight: NDArray[np.float64]
    other_direction: NDArray[np.float64]
    other_weight: NDArray[np.float64]
    left: NDArray[np.int64]


def follow_rays(
    device: OpenDevice,
    tables: DeviceTables,
    rays: NDArray[np.float64],
    steps: int,
    left: NDArray[np.int64] | None = None,
    *,
    reflected: bool = False,
) -> Followed:
    """Follow rays through interactions by the functions of the trace, writing each one out.

    Parameters
    ----------
    device, tables, rays, left
        As for `probe_faces`.
    steps : int
        Interactions at most. The generation cap and roulette are not applied.
    reflected : bool
        Where a surface splits, follow the reflected child rather than the transmitted one.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """
    import pyopencl as cl

    n = len(rays)
    if left is None:
        left = np.full(n, NO_FACE, np.int64)
    states, faces = np.full((n, steps, _STATE), np.nan), np.full((n, steps), -1, np.int64)
    program = build(device, tables.spec.for_device(1, ("follow",)))
    kernel = program.kernel("follow_stage")
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    common = _scene_arguments(device, tables)
    rays_buffer = _upload(device, np.ascontiguousarray(rays, np.float64))
    left_buffer = _upload(device, left.astype(np.int64))
    states_buffer = cl.Buffer(device.context, flags, hostbuf=states)
    faces_buffer = cl.Buffer(device.context, flags, hostbuf=faces)
    kernel.set_args(
        *common,
        rays_buffer,
        left_buffer,
        states_buffer,
        faces_buffer,
        np.uint64(n),
        np.uint64(steps),
        np.uint64(reflected),
    )
    cl.enqueue_nd_range_kernel(device.queue, kernel, *apart(device, n))
    cl.enqueue_copy(device.queue, states, states_buffer)
    cl.enqueue_copy(device.queue, faces, faces_buffer)
    program.keep()
    return Followed(
        states[..., 0],
        states[..., 1:4],
        states[..., 4:7],
        states[..., 7:10],
        states[..., 10],
        states[..., 11:14],
        states[..., 14],
        faces,
    )


def _upload(device: OpenDevice, array: NDArray[Any]) -> cl.Buffer:
    """Copy an array to the device; buffers cannot be empty, and an empty scene has empty tables."""
    import pyopencl as cl

    filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
    flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
    return cl.Buffer(device.context, flags, hostbuf=filled)


def _scene_arguments(device: OpenDevice, tables: DeviceTables) -> tuple[cl.Buffer, ...]:
    """Return the buffers that every stage begins with."""
    import pyopencl as cl

    launch = launch_of(tables, slots=1, items=1)
    # `follow` plays no roulette and knows no generation cap
    launch["generation_cap"] = np.iinfo(np.uint64).max >> 1
    if "roulette_floor" in (launch.dtype.names or ()):
        launch["roulette_floor"] = 0.0
    scene = (tables.geometry, tables.materials, tables.sources, tables.codes)
    # the tally is not read: large scenes book into it, and `follow` throws it away
    nothing = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, 8 * CELL * tables.n_cells + 64)
    uploaded = (_upload(device, array) for array in scene)
    return (_upload(device, launch.reshape(1)), *uploaded, nothing)
