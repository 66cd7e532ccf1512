"""The queue of waiting rays: a stack for each work-item, fields as a structure of arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hostcode.errors import HostError
from hostcode.program.fields import of_type
from hostcode.program.structs import ITEM, numpy_dtype

if TYPE_CHECKING:
    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.program.spec import ProgramSpec

__all__ = ["Queue"]


class Queue:
    """Queue buffers on a device.

    Parameters
    ----------
    device : OpenDevice
        Where.
    spec : ProgramSpec
        Which fields, and how segments lie.
    n_items : int
        Segments.
    capacity : int
        Rays a segment holds.
    """

    def __init__(self, device: OpenDevice, spec: ProgramSpec, n_items: int, capacity: int) -> None:
        import pyopencl as cl

        self._cl, self._device, self._spec = cl, device, spec
        self.n_items, self.capacity = n_items, capacity
        self._layout: tuple[tuple[int, Any], ...] = (
            (len(of_type(spec.ray_fields, "real")), np.float64),
            (len(of_type(spec.ray_fields, "word")), np.uint32),
            (len(of_type(spec.ray_fields, "long", "ulong")), np.int64),
        )
        size = n_items * numpy_dtype(ITEM).itemsize
        self.items = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, size)
        self.fields = [self._allocate(n, dtype) for n, dtype in self._layout]

    @property
    def places(self) -> int:
        """Rays that all segments together hold."""
        return self.n_items * self.capacity

    def _allocate(self, n: int, dtype: Any) -> cl.Buffer:
        size = n * self.places * np.dtype(dtype).itemsize
        limit = self._device.record.max_allocation
        if size > limit:
            raise HostError(
                f"queue: {self.capacity} waiting rays for each of {self.n_items} work-items need a "
                f"buffer of {size} bytes, and {self._device.record.name} allows {limit}: lower "
                "generation_cap, set roulette_floor, or run fewer rays at once"
            )
        return self._cl.Buffer(self._device.context, self._cl.mem_flags.READ_WRITE, size)

    def _shape(self, n: int, capacity: int) -> tuple[int, ...]:
        if self._spec.interleaved:
            return (n, capacity, self.n_items)
        return (n, self.n_items, capacity)

    def grow(self) -> None:
        """Double the room of every segment and keep what waits in it."""
        old = self.capacity
        kept: list[NDArray[Any]] = []
        for buffer, (n, dtype) in zip(self.fields, self._layout, strict=True):
            array = np.empty(self._shape(n, old), dtype)
            self._cl.enqueue_copy(self._device.queue, array, buffer)
            kept.append(array)
        self.capacity = 2 * old
        self.fields = [self._allocate(n, dtype) for n, dtype in self._layout]
        for buffer, array, (n, dtype) in zip(self.fields, kept, self._layout, strict=True):
            wide = np.zeros(self._shape(n, self.capacity), dtype)
            if self._spec.interleaved:
                wide[:, :old, :] = array
            else:
                wide[:, :, :old] = array
            self._cl.enqueue_copy(self._device.queue, buffer, wide)
