"""An open device, and how many rays suit one of its work-items."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pyopencl as cl

    from hostcode.device.capability import DeviceRecord

__all__ = ["OpenDevice", "preferred_lanes"]


@dataclass(frozen=True, slots=True)
class OpenDevice:
    """A device with a context and an in-order queue of its own.

    Parameters
    ----------
    record : DeviceRecord
        Its capabilities.
    device : pyopencl.Device
        The runtime's device; a sub-device where `open_device` was asked for fewer compute units.
    context : pyopencl.Context
        Holds this device alone.
    queue : pyopencl.CommandQueue
        In order.
    profiling : bool
        Whether events of the queue carry times.
    """

    record: DeviceRecord
    device: cl.Device
    context: cl.Context
    queue: cl.CommandQueue
    profiling: bool = False


def preferred_lanes(record: DeviceRecord, effects: frozenset[str] = frozenset()) -> int:
    """Return how many rays a work-item holds at once, as suits a device and a program.

    Parameters
    ----------
    record : DeviceRecord
        The device's capabilities.
    effects : frozenset of str, optional
        Effects that are compiled in.

    Returns
    -------
    int
        1 on a GPU; on a CPU 8 that go through a tree of boxes in turn, else the lanes of a packet:
        16 where PoCL vectorises and has vectors of 8 doubles, or 8.
    """
    if record.type == "gpu":
        return 1
    if "acceleration" in effects:
        return 8
    # measured: 16 gain nothing with PoCL 3.0, and lose 3 to 10 % with Intel's runtime
    vectorises = record.is_pocl and record.pocl_version >= (3, 1)
    return 16 if vectorises and record.native_vector_width_double >= 8 else 8
