"""How a device runs a wave: measured choices that never change a bit of the answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from hostcode.errors import HostError
from hostcode.program.spec import CACHED_BYTES

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord

__all__ = ["COMPOSITIONS", "LANE_WIDTHS", "ExecutionPlan", "default_plan"]

COMPOSITIONS: Final = ("packets", "classical", "whole-path")
LANE_WIDTHS: Final = (1, 2, 4, 8, 16)


@dataclass(frozen=True)
class ExecutionPlan:
    """How waves run.

    Parameters
    ----------
    composition : str
        ``packets``: persistent packets, every stage in one kernel; ``classical``: a kernel per
        stage and one interaction a step; ``whole-path``: a work-item follows one ray to its end.
    lanes : int
        Rays a work-item holds at once: 1, 2, 4, 8 or 16; in the lanes of a packet, or where they go
        through a tree of boxes in turn.
    items : int
        Work-items, each with its own segment of the queue (``whole-path``: one per ray).
    wave_rays : int
        Rays launched in one wave.
    max_bounces : int
        K, the most steps that a packet makes in one launch; as many as take a fifth of a second.
    refill : int
        Empty lanes that make a packet refill.
    local_size : int
        Work-group size.
    stack_rays : int
        Waiting rays a queue segment holds at first, where 64 MiB are enough for all segments; it
        grows when a scene needs more.
    tally_parts : int
        Work-items that share the records of one segment.
    tally_copies : int
        Copies of the tally that the tally stage adds to without atomics, 0 for atomics.
    interleaved : bool
        Queue layout: segments interleaved (GPUs) or contiguous.
    cached_bytes : int
        How much of the tables of a scene with many elements is taken to stay in a core's cache:
        what a ray needs beyond it is fetched while other rays go on.
    """

    composition: str = "packets"
    lanes: int = 16
    items: int = 16
    wave_rays: int = 262144
    max_bounces: int = 1 << 20
    refill: int = 4
    local_size: int = 1
    stack_rays: int = 256
    tally_parts: int = 4
    tally_copies: int = 0
    interleaved: bool = False
    cached_bytes: int = CACHED_BYTES

    def __post_init__(self) -> None:
        if self.composition not in COMPOSITIONS:
            raise HostError(
                f"composition {self.composition!r} is none of {', '.join(COMPOSITIONS)}"
            )
        if self.lanes not in LANE_WIDTHS:
            raise HostError(f"lanes {self.lanes} is none of {', '.join(map(str, LANE_WIDTHS))}")
        if self.composition == "whole-path" and self.lanes != 1:
            raise HostError(f"lanes {self.lanes}: the whole-path composition has one lane")
        for name in ("items", "wave_rays", "max_bounces", "refill", "local_size", "tally_parts"):
            if getattr(self, name) < 1:
                raise HostError(f"{name} {getattr(self, name)}: must be at least 1")

    def with_(self, **changes: Any) -> ExecutionPlan:
        """Return a plan with some choices changed."""
        return replace(self, **changes)


def default_plan(record: DeviceRecord, lanes: int) -> ExecutionPlan:
    """Return the plan measured best for a kind of device.

    Parameters
    ----------
    record : DeviceRecord
        The device's capabilities.
    lanes : int
        Its preferred lane width.
    """
    if record.type == "gpu":
        return ExecutionPlan(
            lanes=1,
            items=262144,
            wave_rays=1 << 22,
            refill=1,
            local_size=64,
            stack_rays=16,
            tally_parts=1,
            interleaved=True,
        )
    items = 8 * max(record.compute_units, 1)
    return ExecutionPlan(
        lanes=lanes, items=items, refill=max(lanes // 4, 1), tally_copies=record.compute_units
    )
