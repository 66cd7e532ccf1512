"""What a run takes of memory, before it takes it; and that it is not begun where it cannot fit.

A process that runs out of memory ends in many ways, most of them without a word and with nothing
saved. So everything large is added up beforehand: what the device allocates, from the very sizes
that the engine uses, and on the host the sums, batches on the way, and the arrays at the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hostcode.device.device import explain_choice, preferred_lanes, survey
from hostcode.device.memory import room
from hostcode.errors import DeviceError
from hostcode.program.plan import default_plan
from hostcode.run.queue import Queue
from hostcode.run.sizes import Sizes
from hostcode.run.tally import CELL, SparseTally, is_sparse
from photizon_cl.errors import RunError, show
from photizon_cl.result.sums import SPARSE_CELL

if TYPE_CHECKING:
    from collections.abc import Callable

    from hostcode.device.device import DeviceRecord
    from hostcode.device.memory import Room
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.result.statistics import Accumulator

__all__ = [
    "Needs",
    "check_memory",
    "human",
    "no_room_for",
    "on_usual_device",
    "refusal",
    "statement",
    "too_large",
]

_PROGRAM: Final = 256 << 20
"""What building a program, and the libraries that write files, take beside all of this."""
_SUMS: Final = 8 * (4 + 1 + 1 + 1)
"""Bytes of a cell's sums: limbs, count, mean, squares."""
_BATCH: Final = 8 * CELL
"""Bytes of a cell of a batch on the host."""
_WRITTEN: Final = 2 * (_SUMS + 8)
"""Bytes that a cell's sums take more while they are written, of those that are held sparsely."""
_LIT: Final = 2 * 8 * (CELL + 1) + 16
"""Bytes of a cell of a sparse batch: number and row, twice while powers are filled in."""
_GROWING: Final = 64 << 20
"""What is to be left beside the sums when they grow."""
_MAP_BIN: Final = 4 * 8
"""Bytes of a map's bin in a result: irradiance, σ, count, area."""
_FAR_BIN: Final = 3 * 8
_DRAWN_BIN: Final = 2 * 8
"""Bytes of a bin while the largest map is written or drawn: values, masks, what is packed."""
_QUADS: Final = 1 << 20
_QUAD: Final = 140
"""Bytes of each of the first 2^20 bins while they are drawn; more are drawn as a picture."""
_WORDS: Final = {
    "tally": "the tally of a batch on the device",
    "copies": "copies of the tally on the device",
    "waiting": "rays that wait on the device",
    "records": "arrivals that are written down on the device",
    "scene": "the scene on the device",
    "sums": "the sums over batches",
    "batches": "batches on the way",
    "arrays": "the arrays of the result",
    "files": "writing and drawing them",
}
_SHORT: Final = {
    "tally": "tally",
    "copies": "its copies",
    "waiting": "waiting rays",
    "records": "records",
    "scene": "scene",
    "sums": "sums",
    "batches": "batches",
    "arrays": "arrays",
    "files": "files and figures",
}


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
        On the host when the result is there and is saved; the device's buffers have gone by then.
    more : int
        What sums may grow by where all cells come to be lit, and writing them take; 0 where they
        do not grow.
    waiting_more : int
        What rays that wait may take at most, where rays split.
    shared : bool
        Whether the device's memory is the host's.
    """

    device: dict[str, int]
    largest_buffer: tuple[str, int]
    while_running: dict[str, int]
    at_the_end: dict[str, int]
    more: int
    waiting_more: int
    shared: bool

    @classmethod
    def of(
        cls,
        compiled: CompiledScene,
        record: DeviceRecord | None,
        plan: ExecutionPlan | None,
        on_the_way: int = 0,
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
        batches = _LIT * lit if sparse else _BATCH * n * (slots + 2)
        running = {"sums": sums, "batches": batches + on_the_way}
        end = {
            "sums": sums,
            "arrays": _MAP_BIN * sum(bins) + _FAR_BIN * far,
            "files": _drawn(max(*bins, far, 0)) + (0 if sparse else (_SUMS + 8) * n),
        }
        device = {} if sizes is None else {name: sizes.total(name) for name in sizes.buffers}
        more = 0
        if sizes is not None and record is not None and tables.spec.splits:
            more = max(Queue.budget_of(record) - device["waiting"], 0)
        return cls(
            device=device,
            largest_buffer=("", 0) if sizes is None else sizes.largest,
            while_running=running,
            at_the_end=end,
            more=(SPARSE_CELL + _WRITTEN) * n if sparse else 0,
            waiting_more=more,
            shared=record is not None and record.type == "cpu",
        )

    @property
    def tracing(self) -> dict[str, int]:
        """What this process takes while it traces."""
        return {**(self.device if self.shared else {}), **self.while_running}

    @property
    def most_at_a_time(self) -> int:
        """What this process takes at most at a time, all sums being as small as they may be."""
        return max(sum(self.tracing.values()), sum(self.at_the_end.values()))


def _drawn(bins: int) -> int:
    return _DRAWN_BIN * bins + _QUAD * min(bins, _QUADS)


def human(size: float) -> str:
    """Return a number of bytes as people say it."""
    unit, factor = next(
        ((u, f) for u, f in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)) if size >= 0.9995 * f),
        ("bytes", 1.0),
    )
    shown = size / factor
    return f"{shown:.3g} {unit}" if shown < 999.5 else f"{shown:.0f} {unit}"


def too_large(
    record: DeviceRecord, parts: dict[str, int], largest: tuple[str, int], left: Room | None = None
) -> tuple[str, str]:
    """Say why a device cannot hold its buffers, and which part is to be less; else nothing.

    Parameters
    ----------
    record : DeviceRecord
        The device.
    parts : dict of str to int
        Bytes of the buffers by part.
    largest : tuple of (str, int)
        The part with the largest single one, and its bytes.
    left : Room or None, optional
        What this process may still take, where the buffers count among that and nothing else does.
    """
    part, size = largest
    if size > record.max_allocation:
        why = (
            f"{_WORDS[part]} takes {human(size)} in one piece, and {record.label} gives at most "
            f"{human(record.max_allocation)}"
        )
        return why, part
    whole = sum(parts.values())
    part = max(parts, key=parts.__getitem__, default="")
    if whole > record.global_memory:
        has = f"{record.label} has {human(record.global_memory)}"
    elif left is not None and whole > left.left:
        has = f"{human(left.left)} are left of {left.what} ({human(left.limit)})"
    else:
        return "", ""
    why = (
        f"the device's buffers take {human(whole)}, most of it {_WORDS[part]} "
        f"({human(parts[part])}), and {has}"
    )
    return why, part


def refusal(
    compiled: CompiledScene, needs: Needs, record: DeviceRecord | None, left: Room | None
) -> str:
    """Say why a run cannot fit, and what to change; nothing where it can.

    Parameters
    ----------
    compiled : CompiledScene
        The scene.
    needs : Needs
        What it takes.
    record : DeviceRecord or None
        The device, None where others run it.
    left : Room or None
        What this process may still take, None where that is not known.
    """
    if record is not None:
        why, part = too_large(record, needs.device, needs.largest_buffer)
        if why:
            return f"{why}: {_advice(compiled, part)}"
    if left is None or needs.most_at_a_time + _PROGRAM <= left.left:
        return ""
    phases = (needs.tracing, needs.at_the_end)
    worst = max(phases, key=lambda parts: sum(parts.values()))
    part = max(worst, key=worst.__getitem__)
    when = "at the end" if worst is needs.at_the_end else "while it traces"
    return (
        f"this scene takes {human(needs.most_at_a_time + _PROGRAM)} of memory {when}, and "
        f"{human(left.left)} are left of {left.what} ({human(left.limit)}); the largest part is "
        f"{_WORDS[part]}, {human(worst[part])}: {_advice(compiled, part)}"
    )


def no_room_for(
    cells: object, tally: Accumulator, look: Callable[[], Room | None] | None = None
) -> str:
    """Say that sums cannot grow by a batch's cells; nothing where they can, or do not grow.

    Parameters
    ----------
    cells : ndarray or SparseTally
        The batch.
    tally : Accumulator
        The sums so far.
    look : callable, optional
        Gives what this process may still take.
    """
    if not isinstance(cells, SparseTally):
        return ""
    left = (look or room)()
    # a block is held twice while it grows, and all that is on the way is small beside a batch
    needed = SPARSE_CELL * len(cells.numbers) + _GROWING
    if left is None or left.left >= needed:
        return ""
    return (
        f"the sums over batches take {human(tally.held_bytes)} and would grow by up to "
        f"{human(SPARSE_CELL * len(cells.numbers))} with the next batch, and "
        f"{human(left.left)} are left of {left.what} ({human(left.limit)}): run fewer batches, or "
        "take fewer bins in maps and far field"
    )


def _advice(compiled: CompiledScene, part: str) -> str:
    """Return what to change for a part to become smaller, with its path and value."""
    layout, scene = compiled.layout, compiled.scene
    if part in ("waiting", "records"):
        rays = compiled.settings.rays_per_batch
        return f"lower run.rays_per_batch (it is {rays})"
    if part == "scene":
        return f"take fewer elements (there are {len(scene.element)})"
    maps = sorted((d for d in layout.detectors if d.nx), key=lambda d: -d.nx * d.ny)
    far = layout.n_mu * layout.n_phi
    if far and (not maps or far >= maps[0].nx * maps[0].ny):
        found = f"they are {layout.n_mu} and {layout.n_phi}"
        text = f"lower far_field.n_mu and far_field.n_phi ({found}"
        more = len(maps)
    elif maps:
        d = maps[0]
        text = (
            f"take fewer bins in element[{d.element}].detector.map of "
            f"{show(scene.element[d.element].name)} (it is [{d.nx}, {d.ny}]"
        )
        more = len(maps) - 1
    else:
        return f"take fewer elements and detectors ({layout.n_cells} quantities are counted)"
    bins = sum(d.nx * d.ny for d in maps) + far
    return text + (f"; with {more} other maps {bins} bins)" if more else ")")


def check_memory(
    compiled: CompiledScene,
    record: DeviceRecord | None,
    plan: ExecutionPlan | None,
    on_the_way: int = 0,
    look: Callable[[], Room | None] | None = None,
) -> ExecutionPlan | None:
    """Return how a device is to run a scene, which is fewer batches at once where memory is short.

    Raises
    ------
    RunError
        Where it cannot fit, with the reason, see `refusal`.
    """
    needs = Needs.of(compiled, record, plan, on_the_way)
    small = needs.most_at_a_time + needs.more < _PROGRAM
    left = None if small else (look or room)()
    why = refusal(compiled, needs, record, left)
    if why and plan is not None and Sizes.of(compiled.tables, plan).slots > 1:
        plan = plan.with_(wave_rays=compiled.settings.rays_per_batch)
        why = refusal(compiled, Needs.of(compiled, record, plan, on_the_way), record, left)
    if why:
        raise RunError(why)
    return plan


def statement(
    compiled: CompiledScene, record: DeviceRecord, plan: ExecutionPlan, left: Room | None
) -> str:
    """Return, in a line, what a run takes of memory, and where that it does not fit.

    Parameters
    ----------
    compiled : CompiledScene
        The scene.
    record, plan : DeviceRecord, ExecutionPlan
        The device and how it runs.
    left : Room or None
        What this process may still take, None where that is not known.
    """
    needs = Needs.of(compiled, record, plan)
    text = (
        f"{human(needs.most_at_a_time)} at most at a time: device {_listed(needs.device)}; host "
        f"{_listed(needs.while_running)}, at the end {_listed(needs.at_the_end)}"
    )
    if needs.more:
        text += f"; up to {human(needs.more)} more for sums, and to write them, as bins are lit"
    if needs.waiting_more:
        text += f"; up to {human(needs.waiting_more)} more for rays that wait"
    why = refusal(compiled, needs, record, left)
    return f"{text}. It will not fit: {why}" if why else text


def on_usual_device(compiled: CompiledScene) -> str:
    """Return the `statement` for the device that a run would have, on which nothing is done."""
    try:
        record = explain_choice(records=survey().records).record
    except DeviceError as error:
        return f"not known without a device ({str(error).splitlines()[0]})"
    plan = default_plan(record, preferred_lanes(record, compiled.tables.spec.effects))
    return statement(compiled, record, plan, room())


def _listed(parts: dict[str, int]) -> str:
    shown = [f"{_SHORT[name]} {human(size)}" for name, size in parts.items() if size > 999]
    return f"{human(sum(parts.values()))} ({', '.join(shown)})" if shown else human(0)
