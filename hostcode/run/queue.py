"""The queue of waiting rays: a stack for each work-item, fields as a structure of arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.errors import QueueFull
from hostcode.program.fields import REALS, of_type
from hostcode.program.structs import ITEM, numpy_dtype

if TYPE_CHECKING:
    import pyopencl as cl

    from hostcode.device.device import DeviceRecord, OpenDevice
    from hostcode.program.spec import ProgramSpec

__all__ = ["BUDGET", "Queue"]

BUDGET: Final = 1 << 30
"""Bytes of device memory that waiting rays may take, on a device of little memory."""
_PART: Final = 8
"""On one of much memory, the part of it that they may take."""


_FEWER: Final = (
    "more rays split off than may wait; set roulette_floor (1e-6, say), or lower generation_cap or "
    "rays_per_batch"
)


def _layout(spec: ProgramSpec) -> tuple[tuple[int, Any], ...]:
    """Return how many fields each buffer holds of a ray, and of which type."""
    return (
        (len(of_type(spec.ray_fields, *REALS)), np.float64),
        (len(of_type(spec.ray_fields, "word")), np.uint32),
        (len(of_type(spec.ray_fields, "long", "ulong")), np.int64),
    )


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
        self.budget = self.budget_of(device.record)
        self._layout = _layout(spec)
        size = n_items * numpy_dtype(ITEM).itemsize
        self.items = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, size)
        self._check(capacity)
        self.fields = [self._allocate(n, dtype) for n, dtype in self._layout]

    @staticmethod
    def bytes_of_a_ray(spec: ProgramSpec) -> int:
        """Return how much memory a waiting ray takes."""
        fields = spec.ray_fields
        return 8 * len(of_type(fields, *REALS, "long", "ulong")) + 4 * len(of_type(fields, "word"))

    @staticmethod
    def budget_of(record: DeviceRecord) -> int:
        """Return the bytes that waiting rays may take on a device."""
        if record.type == "gpu":  # its memory is no one else's
            return max(BUDGET, record.global_memory // _PART)
        return BUDGET

    @staticmethod
    def sizes(spec: ProgramSpec, places: int) -> tuple[int, ...]:
        """Return the bytes of the buffers that so many waiting rays take."""
        return tuple(n * places * np.dtype(dtype).itemsize for n, dtype in _layout(spec))

    @property
    def places(self) -> int:
        """Rays that all segments together hold."""
        return self.n_items * self.capacity

    def _allocate(self, n: int, dtype: Any) -> cl.Buffer:
        size = n * self.places * np.dtype(dtype).itemsize
        return self._cl.Buffer(self._device.context, self._cl.mem_flags.READ_WRITE, size)

    def _check(self, capacity: int) -> None:
        """See that segments of so many rays may be had.

        Raises
        ------
        QueueFull
            Where they are larger than a buffer or the budget may be.
        """
        sizes = self.sizes(self._spec, self.n_items * capacity)
        record = self._device.record
        if max(sizes) <= record.max_allocation and sum(sizes) <= self.budget:
            return
        raise QueueFull(
            f"room for {self.n_items * capacity} waiting rays takes {sum(sizes) / 1e9:.1f} GB, and "
            f"the queue may have {min(record.max_allocation, self.budget) / 1e9:.1f} GB: {_FEWER}"
        )

    def _rows(self, n: int, capacity: int) -> tuple[int, int]:
        """Return how many rows a field's buffer has that stay together, and how long each is."""
        if self._spec.interleaved:
            return n, capacity * self.n_items
        return n * self.n_items, capacity

    def grow(self) -> None:
        """Double the room of every segment and keep what waits in it.

        Raises
        ------
        QueueFull
            Where there is no room for it; the queue is of no more use then.
        """
        old, kept = self.capacity, self.fields
        self._check(2 * old)
        try:
            self._double(old, kept)
        except self._cl.MemoryError as error:
            raise QueueFull(
                f"the device has no memory for {2 * self.places} waiting rays: {_FEWER}"
            ) from error

    def _double(self, old: int, kept: list[cl.Buffer]) -> None:
        self.capacity = 2 * old
        self.fields = []
        for n, dtype in self._layout:
            buffer = kept.pop(0)  # field by field, so that no more than one is held twice
            wide = self._allocate(n, dtype)
            rows, length = self._rows(n, old)
            size = np.dtype(dtype).itemsize
            if rows:
                self._cl.enqueue_copy(
                    self._device.queue,
                    wide,
                    buffer,
                    src_origin=(0, 0, 0),
                    dst_origin=(0, 0, 0),
                    region=(length * size, rows, 1),
                    src_pitches=(length * size,),
                    dst_pitches=(2 * length * size,),
                )
                self._device.queue.finish()
            buffer.release()
            self.fields.append(wide)
