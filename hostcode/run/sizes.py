"""How large everything is that a device holds while it traces a scene, before any is allocated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.program.fields import REALS, of_type
from hostcode.program.structs import ITEM, LAUNCH, STATUS, numpy_dtype
from hostcode.run.keyed import KeyedTable
from hostcode.run.queue import Queue
from hostcode.run.tally import CELL, is_sparse

if TYPE_CHECKING:
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables

__all__ = ["LEAST", "Sizes", "hit_sizes"]

LEAST: Final = 64
"""Bytes of a buffer: it cannot be empty."""
_TALLY_BYTES: Final = 256 << 20
"""Device memory that the slots' tallies may take."""
_WAITING_BYTES: Final = 64 << 20
"""Device memory for waiting rays at first, where it is enough; it grows when more wait."""
_KEYED_BYTES: Final = 256 << 20
"""Device memory that the slots' cells by key may take at first."""
_COPIES_BYTES: Final = 64 << 20
"""Device memory that the tally stage's own copies may take."""


@dataclass(frozen=True)
class Sizes:
    """What an engine allocates for a scene.

    Parameters
    ----------
    slots : int
        Batches in flight at once.
    copies : int
        Tallies that the tally stage keeps without atomics, 0 where they would take too much.
    items : int
        Work-items.
    wave_rays : int
        Rays of one wave: whole batches, or a part of one.
    capacity : int
        Waiting rays that a work-item's segment holds at first.
    records : int
        Endings that a work-item writes down in a launch.
    buffers : dict of str to tuple of int
        Bytes of the device's buffers: of the ``tally``, its ``copies``, cells ``keyed`` by what
        was met, ``waiting`` rays, the
        ``records`` of endings, and the ``scene``.
    """

    slots: int
    copies: int
    items: int
    wave_rays: int
    capacity: int
    records: int
    buffers: dict[str, tuple[int, ...]]

    @classmethod
    def of(cls, tables: DeviceTables, plan: ExecutionPlan) -> Sizes:
        """Return the sizes for a scene and a plan."""
        spec, rays = tables.spec, int(tables.launch["rays_per_batch"])
        one = 8 * CELL * tables.n_cells
        slots = 1
        if not is_sparse(tables.n_cells):
            slots = max(min(plan.wave_rays // rays, max(_TALLY_BYTES // one, 1)), 1)
        if spec.keyed:
            slots = max(min(slots, _KEYED_BYTES // KeyedTable.size(1)), 1)
        copies = plan.tally_copies if spec.records else 0
        copies = copies if copies * one * slots <= _COPIES_BYTES else 0
        wave = slots * rays if slots > 1 else min(plan.wave_rays, rays)
        if plan.composition == "whole-path":
            items = wave
        else:
            items = max(min(plan.items, wave) // slots, 1) * slots
        an_item = math.ceil(wave / items)
        capacity = _capacity(tables, plan, items, an_item)
        records = 0
        if spec.records:
            more = 2 * an_item if spec.splits else an_item + plan.lanes
            records = max(more, (4 if spec.splits else 2) * plan.lanes)
        scene = (tables.geometry, tables.materials, tables.sources, tables.codes)
        arrays: tuple[Any, ...] = (*scene, tables.detector_numbers, tables.edges)
        buffers = {
            "tally": (one * slots,),
            "copies": (copies * one * slots,),
            **({"keyed": (KeyedTable.size(slots),)} if spec.keyed else {}),
            "waiting": (
                items * numpy_dtype(ITEM).itemsize,
                *Queue.sizes(spec, items * capacity),
                *hit_sizes(tables, plan, items * capacity),
            ),
            "records": (
                8 * len(of_type(spec.ending_fields, *REALS)) * items * records,
                4 * len(of_type(spec.ending_fields, "word")) * items * records,
            ),
            "scene": (
                *(np.asarray(a).nbytes for a in arrays),
                numpy_dtype(LAUNCH + spec.launch_members).itemsize,
                8 * len(STATUS),
            ),
        }
        for part, found in buffers.items():
            buffers[part] = tuple(max(size, LEAST) for size in found)
        return cls(slots, copies, items, wave, capacity, records, buffers)

    def total(self, *parts: str) -> int:
        """Return the bytes of some parts of the buffers, of all where none is named."""
        return sum(sum(self.buffers[part]) for part in parts or self.buffers)

    @property
    def largest(self) -> tuple[str, int]:
        """The part with the largest single buffer, and that buffer's bytes."""
        part = max(self.buffers, key=lambda name: max(self.buffers[name]))
        return part, max(self.buffers[part])


def hit_sizes(tables: DeviceTables, plan: ExecutionPlan, places: int) -> tuple[int, int]:
    """Return the bytes of the buffers for what the search finds, where it is a stage of its own."""
    places = places if plan.composition == "classical" else 0
    fields = tables.spec.hit_fields
    reals = sum(field.type == "real" for field in fields)
    return 8 * reals * places, 8 * (len(fields) - reals) * places


def _capacity(tables: DeviceTables, plan: ExecutionPlan, items: int, an_item: int) -> int:
    """Return how many waiting rays a work-item's segment holds at first."""
    children = tables.spec.children
    if plan.composition == "classical":
        rays = math.ceil(an_item / plan.lanes) * plan.lanes
        return (1 + children) * rays + plan.lanes if children else rays
    most = _WAITING_BYTES // (items * Queue.bytes_of_a_ray(tables.spec))
    if plan.composition == "whole-path":
        return max(min(plan.stack_rays, most), 3 + children) if children else 1
    if not children:
        return plan.lanes
    return max(min(plan.stack_rays, most), (3 + children) * plan.lanes)
