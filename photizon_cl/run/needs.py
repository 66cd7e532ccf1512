"""What a run takes of memory, part by part, before it takes it.

Everything large is added up: what the device allocates, from the very sizes that the engine uses,
and on the host the sums, batches on the way, and the arrays at the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hostcode.run.queue import Queue
from hostcode.run.sizes import Sizes
from hostcode.run.tally import CELL, is_sparse
from photizon_cl.result.batch_values import MOST_VALUES
from photizon_cl.result.keyed_sums import MOST_FOLLOWED_VALUES, admitted
from photizon_cl.result.sums import SPARSE_CELL

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import TallyLayout

__all__ = ["WRITTEN", "Needs", "array_sizes", "drawn", "human"]

_PATH: Final = 8 * (3 + 4 + 1 + 1 + 1)
"""Bytes of a path: key, what is known of it, first ray, limbs, count, mean, squares."""
_SUMS: Final = 8 * (4 + 1 + 1 + 1)
"""Bytes of a cell's sums: limbs, count, mean, squares."""
_BATCH: Final = 8 * CELL
"""Bytes of a cell of a batch on the host."""
WRITTEN: Final = 2 * (_SUMS + 8)
"""Bytes that a cell's sums take more while they are written, of those that are held sparsely."""
_LIT: Final = 2 * 8 * (CELL + 1) + 16
"""Bytes of a cell of a sparse batch: number and row, twice while powers are filled in."""
_VALUE: Final = 8
"""Bytes of what a cell gave in a batch, where that is kept."""
_MAP_BIN: Final = 4 * 8
"""Bytes of a map's bin in a result: irradiance, σ, count, area."""
_FAR_BIN: Final = 3 * 8
_DRAWN_BIN: Final = 2 * 8
"""Bytes of a bin while the largest map is written or drawn: values, masks, what is packed."""
_QUADS: Final = 1 << 20
_QUAD: Final = 140
"""Bytes of each of the first 2^20 bins while they are drawn; more are drawn as a picture."""


@dataclass(frozen=True)
class Needs:
    """What a run takes of memory, in bytes.

    Parameters
    ----------
    device : dict of str to int
        Buffers by part, see `hostcode.run.sizes.Sizes`.
    largest_buffer : tuple of (str, int)
        The part with the largest single one.
    while_running : dict of str to int
        On the host while it traces.
    at_the_end : dict of str to int
        On the host when the result is there; the device's buffers have gone by then.
    state, files, figures : int
        What a checkpoint takes beside what is there while it is written, what all files take
        beside the arrays at the end, and what drawing them takes.
    more : int
        What sums may grow by where all cells come to be lit, and writing them take; 0 where they
        do not grow.
    waiting_more : int
        What rays that wait may take at most, where rays split.
    shared : bool
        Whether the device's memory is the host's.
    values, more_values : int
        What is kept of single batches, of quantities that are one number, where it is known how
        many there will be; and what that may become at most.
    """

    device: dict[str, int]
    largest_buffer: tuple[str, int]
    while_running: dict[str, int]
    at_the_end: dict[str, int]
    state: int
    files: int
    figures: int
    more: int
    waiting_more: int
    shared: bool
    values: int
    more_values: int

    @classmethod
    def of(
        cls,
        compiled: CompiledScene,
        record: DeviceRecord | None,
        plan: ExecutionPlan | None,
        on_the_way: int = 0,
        batches: int | None = None,
    ) -> Needs:
        """Return the needs of a scene.

        Parameters
        ----------
        compiled : CompiledScene
            The scene.
        record, plan : DeviceRecord, ExecutionPlan or None
            The device and how it runs; None where other processes run it.
        on_the_way : int, optional
            Bytes of what comes from these.
        batches : int or None, optional
            In all, where that is known.
        """
        layout, tables = compiled.layout, compiled.tables
        n = layout.n_cells
        sizes = None if plan is None else Sizes.of(tables, plan)
        slots = 1 if sizes is None else sizes.slots
        bins = [d.nx * d.ny for d in layout.detectors]
        far = layout.n_mu * layout.n_phi
        sparse = is_sparse(n)
        sums = 0 if sparse else _SUMS * n
        # mostly a ray arrives once; where it arrives more often the run may end early for it
        lit = min(n, int(tables.launch["rays_per_batch"]))
        held = _LIT * lit if sparse else _BATCH * n * (slots + 2)
        running = {"sums": sums, "batches": held + on_the_way}
        end = {"sums": sums, "arrays": sum(array_sizes(layout).values())}
        state = 0 if sparse else (_SUMS + 8) * n
        largest = max(*bins, far, 0)
        device = {} if sizes is None else {name: sizes.total(name) for name in sizes.buffers}
        more = 0
        if sizes is not None and record is not None and tables.spec.splits:
            more = max(Queue.budget_of(record) - device["waiting"], 0)
        return cls(
            device=device,
            largest_buffer=("", 0) if sizes is None else sizes.largest,
            while_running=running,
            at_the_end=end,
            state=state,
            files=state + _DRAWN_BIN * largest,
            figures=drawn(largest),
            more=((SPARSE_CELL + WRITTEN) * n if sparse else 0) + _paths(layout),
            waiting_more=more,
            shared=record is not None and record.type == "cpu",
            values=_values(layout, batches or 0),
            more_values=_values(layout, MOST_VALUES),
        )

    def phases(self, *, saved: bool, drawn: bool) -> dict[str, dict[str, int]]:
        """Return what this process takes by part, by when, all sums being as small as may be.

        Parameters
        ----------
        saved, drawn : bool
            Whether it writes checkpoints and files, and draws.
        """
        end = {**self.at_the_end, "values": self.values}
        tracing = {**(self.device if self.shared else {}), **self.while_running}
        tracing["values"] = self.values
        found = {"while it traces": tracing, "at the end": end}
        if saved:  # the values stand twice while they are put into one table
            twice = {"values": 2 * self.values}
            found["while it traces"] = {**tracing, **twice, "state": self.state}
            found["while it is saved"] = {**end, **twice, "files": self.files}
        if drawn:
            found["while it is drawn"] = {**end, "figures": self.figures}
        return found

    def most_at_a_time(self, *, saved: bool = False, drawn: bool = False) -> int:
        """Return what this process takes at most at a time, see `phases`."""
        return max(sum(p.values()) for p in self.phases(saved=saved, drawn=drawn).values())


def _paths(layout: TallyLayout) -> int:
    """Return what sums by path may come to, and writing them."""
    if not layout.most_paths:
        return 0
    return 3 * (_PATH * sum(admitted(layout).values()) + _VALUE * MOST_FOLLOWED_VALUES)


def _values(layout: TallyLayout, batches: int) -> int:
    """Return what is kept of so many single batches; none of them where they are too many."""
    cells = sum(n for _, n in layout.scalars)
    most = MOST_VALUES // cells if cells else 0
    return _VALUE * cells * min(batches, most)


def array_sizes(layout: TallyLayout) -> dict[str, int]:
    """Return what the arrays of a result take, by what they are of."""
    maps = sum(d.nx * d.ny * (1 + d.wavelengths) for d in layout.detectors)
    return {"detectors": _MAP_BIN * maps, "far_field": _FAR_BIN * layout.n_mu * layout.n_phi}


def drawn(bins: int) -> int:
    """Return what drawing a map of so many bins takes."""
    return _DRAWN_BIN * bins + _QUAD * min(bins, _QUADS)


def human(size: float) -> str:
    """Return a number of bytes as people say it."""
    unit, factor = next(
        ((u, f) for u, f in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)) if size >= 0.9995 * f),
        ("bytes", 1.0),
    )
    shown = size / factor
    return f"{shown:.3g} {unit}" if shown < 999.5 else f"{shown:.0f} {unit}"
