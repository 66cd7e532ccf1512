"""Waves of rays on a device, until every ray they started has ended.

A batch's tally is a pure function of the scene, the seed and the batch's number. Nothing of how it
is computed reaches it: composition, lanes, wave size, work-items, work-groups or threads.

Several batches may be in flight, each in a *slot* of its own. A wave launches a range of their
rays, shares it among the work-items and drains them all; then the slots' tallies are read.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.errors import Abandoned
from hostcode.program.build import Program, build
from hostcode.program.structs import ITEM, LAUNCH, STATUS, numpy_dtype
from hostcode.run.keyed import KeyedRows, KeyedTable
from hostcode.run.queue import Queue
from hostcode.run.readout import read_dense, read_sparse
from hostcode.run.sizes import LEAST, Sizes, hit_sizes
from hostcode.run.tables import launch_of
from hostcode.run.tally import CELL, is_sparse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.device import OpenDevice
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables
    from hostcode.run.tally import SparseTally

__all__ = ["BatchTally", "Engine", "EngineStatistics"]

_STAGES: Final = {
    "packets": ("wave",),
    "classical": ("classical",),
    "whole-path": ("whole_path",),
}
_EVENTS_BEFORE_FLUSH: Final = 1 << 30
"""Interactions after which the limbs are read: 2^31 pieces of 2^32 fill a 64-bit sum. Escapes
are not counted: there is at most one for each interaction or launched ray, and a batch has at most
2^24 of those."""
_FIRST_STEPS: Final = 1 << 14
"""Steps of a packet in the first launch; then they follow how long launches take."""
_LAUNCH_SECONDS: Final = (0.05, 0.2)
"""A launch shorter than the first has twice the steps next time, one longer than the second half.
Between launches a run may be given up."""
_MERGED: Final = 256
"""Integers of the tally that a work-group adds the copies of."""


@dataclass(frozen=True, eq=False)
class BatchTally:
    """The exact tally of one batch.

    Parameters
    ----------
    batch : int
        Its number in the stream.
    cells : ndarray, shape (n_cells, 4), int64, or SparseTally
        Canonical limbs and counts, see `hostcode.run.tally`; sparse where there are very many.
    keyed : KeyedRows or None
        Cells by key; None where the scene keeps none.
    """

    batch: int
    cells: NDArray[np.int64] | SparseTally
    keyed: KeyedRows | None = None


@dataclass
class EngineStatistics:
    """What an engine did: interactions, launches, seconds on the host's clock."""

    interactions: int = 0
    launches: int = 0
    waves: int = 0
    seconds: float = 0.0
    enqueue_seconds: float = 0.0


_Read = tuple["Sequence[NDArray[np.int64] | SparseTally]", "list[KeyedRows] | None"]
"""Tallies of the batches in flight, and their cells by key."""


class Engine:
    """Traces batches of one scene on one device.

    Parameters
    ----------
    device : OpenDevice
        Where.
    tables : DeviceTables
        What: the scene, and the settings of its stream (``tables.launch``).
    plan : ExecutionPlan
        How; changes no bit of the result.
    anew : bool
        Whether its programs are compiled whatever is kept of them, see `build`.

    Raises
    ------
    KernelBuildError
        Where the program cannot be built.
    """

    def __init__(
        self, device: OpenDevice, tables: DeviceTables, plan: ExecutionPlan, *, anew: bool = False
    ) -> None:
        import pyopencl as cl

        self._cl = cl
        self.device, self.tables, self.plan = device, tables, plan
        self.statistics = EngineStatistics()
        self.give_up: Callable[[], bool] | None = None
        """Asked between launches: whether the batches in flight are to be abandoned."""
        self._rays_per_batch = int(tables.launch["rays_per_batch"])
        self.sizes = sizes = Sizes.of(tables, plan)
        self._slots, self._copies, self._items = sizes.slots, sizes.copies, sizes.items
        spec = tables.spec.for_device(
            plan.lanes,
            _STAGES[plan.composition],
            interleaved=plan.interleaved,
            private_tallies=self._copies > 0,
            cached_bytes=plan.cached_bytes,
        )
        self.program: Program = build(device, spec, anew=anew)
        self._programs = [self.program]
        if spec.records:
            self._programs.append(build(device, spec.for_tally(), anew=anew))
        self._queue = Queue(device, spec, self._items, sizes.capacity)
        allocate, upload = self._allocate, self._upload
        self._scene = [
            upload(a) for a in (tables.geometry, tables.materials, tables.sources, tables.codes)
        ]
        self._detector_numbers = upload(tables.detector_numbers)
        self._edges = upload(tables.edges)
        self._launch_buffer = allocate(numpy_dtype(LAUNCH + spec.launch_members).itemsize)
        self._status = allocate(8 * len(STATUS))
        (tally,) = sizes.buffers["tally"]
        self._tally = allocate(tally)
        self._tally_copies = allocate(self._copies * self._tally.size)
        self._keyed = KeyedTable(device, sizes.slots) if spec.keyed else None
        self._steps = min(_FIRST_STEPS, plan.max_bounces)
        self._clean = 0  # slots of whose tallies nothing is left in the copies
        self._record_capacity = sizes.records
        reals, words = sizes.buffers["records"]
        self._records = (allocate(reals), allocate(words))
        self._hits = self._allocate_hits()
        self._bind()
        self.build_seconds = sum(p.build_seconds for p in self._programs) + self._warm_up()

    def _allocate(self, size: int) -> cl.Buffer:
        flags = self._cl.mem_flags.READ_WRITE
        return self._cl.Buffer(self.device.context, flags, max(int(size), LEAST))

    def _upload(self, array: NDArray[Any]) -> cl.Buffer:
        flags = self._cl.mem_flags.READ_ONLY | self._cl.mem_flags.COPY_HOST_PTR
        # a buffer cannot be empty
        filled = np.ascontiguousarray(array) if array.size else np.zeros(1, array.dtype)
        return self._cl.Buffer(self.device.context, flags, hostbuf=filled)

    def _allocate_hits(self) -> tuple[cl.Buffer, cl.Buffer]:
        """Return buffers for what the search finds, where that is a stage of its own."""
        reals, wholes = hit_sizes(self.tables, self.plan, self._queue.places)
        return self._allocate(reals), self._allocate(wholes)

    # -- kernels -------------------------------------------------------------------------------

    def _bind(self) -> None:
        """Make the kernels and set the arguments that stay."""
        common = (self._launch_buffer, *self._scene, self._tally)
        queue = (self._queue.items, self._status, *self._queue.fields)
        kernels: list[tuple[cl.Kernel, int]] = []

        def add(name: str, *arguments: Any, size: int = self._items, of: int = 0) -> None:
            kernel = self._programs[of].kernel(name)
            kernel.set_args(*arguments)
            local = self.plan.local_size
            kernels.append((kernel, math.ceil(size / local) * local))

        if self.plan.composition == "classical":
            add("generate_stage", *common, *queue)
            add("intersect_stage", *common, *queue, *self._hits)
            add("interact_stage", *common, *queue, *self._records, *self._hits)
        else:
            name = "wave" if self.plan.composition == "packets" else "whole_path"
            add(name, *common, *queue, *self._records)
        if self._record_capacity:
            whole = self.plan.composition == "whole-path"
            parts = self._copies or (1 if whole else self.plan.tally_parts)
            add(
                "tally_stage",
                self._launch_buffer,
                self._scene[3],
                self._detector_numbers,
                self._edges,
                self._queue.items,
                *self._records,
                self._tally_copies if self._copies else self._tally,
                np.uint64(parts),
                *self._keyed_arguments(),
                size=parts if self._copies else self._items * parts,
                of=1,
            )
        self._merge = None
        if self._copies:
            self._merge = self._programs[1].kernel("merge_stage")
            self._merge.set_args(
                self._launch_buffer, self._tally_copies, self._tally, np.uint64(self._copies)
            )
        self._kernels = kernels

    def _keyed_arguments(self) -> tuple[Any, ...]:
        """Return what the tally stage is told of the cells by key."""
        table = self._keyed
        return () if table is None else (table.buffer, np.uint64(table.capacity))

    @property
    def _most_steps(self) -> int:
        """Steps of a launch that cannot fill a sum."""
        flushed = max(_EVENTS_BEFORE_FLUSH // (2 * self._items * self.plan.lanes), 1)
        return min(self.plan.max_bounces, flushed)

    def _write_launch(self, first_batch: int, items: int | None = None) -> None:
        plan = self.plan
        capacity = self._queue.capacity
        children = self.tables.spec.children
        launch = launch_of(
            self.tables,
            ray_base=first_batch * self._rays_per_batch,
            slots=self._slots,
            items=self._items if items is None else items,
            max_bounces=min(self._steps, self._most_steps),
            refill=min(plan.refill, plan.lanes),
            fill=capacity // (1 + children),
            stack_capacity=capacity,
            record_capacity=self._record_capacity,
        )
        self._cl.enqueue_copy(self.device.queue, self._launch_buffer, launch)

    def _warm_up(self) -> float:
        """Launch every kernel on no work: some runtimes generate code at the first launch."""
        started = time.perf_counter()
        self._write_launch(0, items=0)
        for kernel, size in self._kernels:
            self._cl.enqueue_nd_range_kernel(
                self.device.queue, kernel, (size,), (self.plan.local_size,)
            )
        self._launch_merge(self._slots)
        self.device.queue.finish()
        for program in self._programs:
            program.keep()
        return time.perf_counter() - started

    @property
    def program_sizes(self) -> tuple[int, int | None]:
        """Bytes of the programs' text, and of what was made of it where the device says."""
        made = [program.binary_bytes() for program in self._programs]
        known = [size for size in made if size is not None]
        text = sum(len(program.source.encode()) for program in self._programs)
        return text, sum(known) if len(known) == len(made) else None

    # -- running -------------------------------------------------------------------------------

    def run(self, first_batch: int, n_batches: int) -> Iterator[BatchTally]:
        """Trace batches and give their tallies in order.

        Parameters
        ----------
        first_batch : int
            Number of the first one, from 0.
        n_batches : int
            How many.

        Raises
        ------
        Abandoned
            Where `give_up` said so; none of the batches in flight counts.
        """
        done = 0
        while done < n_batches:
            slots = min(self._slots, n_batches - done)
            started = time.perf_counter()
            tallies, keyed = self._run_slots(first_batch + done, slots)
            self.statistics.seconds += time.perf_counter() - started
            slots = len(tallies)
            for slot in range(slots):
                by_key = None if keyed is None else keyed[slot]
                yield BatchTally(first_batch + done + slot, tallies[slot], by_key)
            done += slots

    @property
    def batches_at_once(self) -> int:
        """How many batches are in flight together."""
        return self._slots

    def _run_slots(self, first_batch: int, slots: int) -> _Read:
        """Trace the batches of the first slots, until the cells by key have room for them."""
        made = self.statistics.interactions
        while True:
            if self._keyed is not None:
                slots = min(slots, self._keyed.slots)
            found = self._drain(first_batch, slots)
            if found is not None:
                return found
            assert self._keyed is not None
            self._keyed.grow()
            self._bind()
            self.statistics.interactions = made

    def _drain(self, first_batch: int, slots: int) -> _Read | None:
        """Trace the batches; None as soon as there is no room for the cells by key."""
        self._write_launch(first_batch)
        if self._keyed is not None:
            self._keyed.clear(slots)
        self._clear(self._tally, slots)
        clean, self._clean = self._clean, 0
        if slots > clean:
            self._clear(self._tally_copies, slots, self._copies)
        total: Any = None
        keyed: list[KeyedRows] | None = None
        events = 0
        for items in self._waves(slots):
            self.statistics.waves += 1
            self._cl.enqueue_copy(self.device.queue, self._queue.items, items)
            while True:
                began = time.perf_counter()
                unfinished, blocked, interactions, passed = self._launch()
                took = time.perf_counter() - began
                self.statistics.interactions += interactions
                if self._keyed is not None and self._keyed.too_small():
                    return None
                events += interactions + passed
                if events > _EVENTS_BEFORE_FLUSH:
                    total = self._read(slots, total)
                    self._clear(self._tally, slots)
                    if self._keyed is not None:
                        keyed = self._keyed.read(slots, keyed)
                        self._keyed.clear(slots)
                    events = 0
                if not unfinished:
                    break
                if self.give_up is not None and self.give_up():
                    raise Abandoned
                if blocked:
                    self._grow(first_batch)
                elif self._adapt(took):
                    self._write_launch(first_batch)
        tallies: Sequence[NDArray[np.int64] | SparseTally] = self._read(slots, total)
        self._clean = max(slots, clean)
        if self._keyed is not None:
            keyed = self._keyed.read(slots, keyed)
        return tallies, keyed

    def _adapt(self, took: float) -> bool:
        """Choose how many steps the next launch has; say whether that is another number."""
        short, long = _LAUNCH_SECONDS
        steps = self._steps
        if took > long:
            steps = max(steps // 2, 1)
        elif took < short:
            steps = min(2 * steps, self._most_steps)
        changed = steps != self._steps
        self._steps = steps
        return changed

    def _waves(self, slots: int) -> Iterator[NDArray[np.void]]:
        """Give the work-items' states at the start of each wave."""
        rays = self._rays_per_batch
        dtype = numpy_dtype(ITEM)
        if self._slots > 1:
            per_slot = self._items // self._slots
            items = np.zeros(self._items, dtype)
            for slot in range(slots):
                bounds = np.arange(per_slot + 1, dtype=np.int64) * rays // per_slot
                part = items[slot * per_slot : (slot + 1) * per_slot]
                part["slot"], part["next"], part["end"] = slot, bounds[:-1], bounds[1:]
            yield items
            return
        wave = self.sizes.wave_rays
        for start in range(0, rays, wave):
            count = min(wave, rays - start)
            bounds = start + np.arange(self._items + 1, dtype=np.int64) * count // self._items
            items = np.zeros(self._items, dtype)
            items["next"], items["end"] = bounds[:-1], bounds[1:]
            yield items

    def _launch(self) -> tuple[int, ...]:
        cl, queue = self._cl, self.device.queue
        started = time.perf_counter()
        status = np.zeros(len(STATUS), np.int64)
        cl.enqueue_copy(queue, self._status, status, is_blocking=False)
        local = (self.plan.local_size,)
        for kernel, size in self._kernels:
            cl.enqueue_nd_range_kernel(queue, kernel, (size,), local)
        self.statistics.launches += len(self._kernels)
        self.statistics.enqueue_seconds += time.perf_counter() - started
        counters = np.empty_like(status)
        cl.enqueue_copy(queue, counters, self._status)
        return tuple(map(int, counters))

    def _grow(self, first_batch: int) -> None:
        """Give every segment twice the room; nothing in it is lost."""
        self._queue.grow()
        self._hits = self._allocate_hits()
        self._bind()
        self._write_launch(first_batch)

    def _launch_merge(self, slots: int) -> None:
        if self._merge is None:
            return
        # one group size whatever the number of cells: PoCL compiles a kernel for each
        size = (self._integers(slots),)
        self._cl.enqueue_nd_range_kernel(self.device.queue, self._merge, size, (_MERGED,))

    def _integers(self, slots: int) -> int:
        """Return how many integers the first slots' tallies have, in whole work-groups."""
        return math.ceil(slots * self.tables.n_cells * CELL / _MERGED) * _MERGED

    def _clear(self, buffer: cl.Buffer, slots: int, copies: int = 1) -> None:
        """Clear what the first slots' tallies hold: the others are neither added to nor read."""
        zero, whole = np.zeros(1, np.int64), 8 * CELL * self.tables.n_cells * self._slots
        size = min(8 * self._integers(slots), whole)
        for copy in range(copies):
            self._cl.enqueue_fill_buffer(self.device.queue, buffer, zero, copy * whole, size)

    def _read(self, slots: int, before: Any) -> Any:
        """Return what the slots' tallies hold, with what was read of them before."""
        self._launch_merge(slots)
        n_cells = self.tables.n_cells
        if is_sparse(n_cells):
            return [read_sparse(self.device, self._tally, n_cells, before[0] if before else None)]
        return read_dense(self.device, self._tally, slots, n_cells, before)
