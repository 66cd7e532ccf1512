"""That nothing is begun which cannot fit into memory: runs, and what is made of their results.

A process that runs out of memory ends in many ways, most of them without a word and with nothing
saved. So what it takes is known beforehand, see `photizon_cl.run.needs`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hostcode.device.device import explain_choice, survey
from hostcode.device.memory import room
from hostcode.errors import DeviceError
from hostcode.run.sizes import Sizes
from hostcode.run.tally import SparseTally
from hostcode.run.usual import usual_plan
from photizon_cl.errors import ResultError, RunError, show
from photizon_cl.result.sums import SPARSE_CELL
from photizon_cl.run.needs import WRITTEN, Needs, array_sizes, human

if TYPE_CHECKING:
    from collections.abc import Callable

    from hostcode.device.device import DeviceRecord
    from hostcode.device.memory import Room
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.statistics import Accumulator

__all__ = [
    "check_memory",
    "check_room",
    "no_room_for",
    "on_usual_device",
    "refusal",
    "statement",
    "too_large",
]

_PROGRAM: Final = 256 << 20
"""What building a program, and the libraries that write files, take beside all of this."""
_GROWING: Final = 64 << 20
"""What is to be left beside the sums when they grow."""
_WORDS: Final = {
    "tally": "the tally of a batch on the device",
    "copies": "copies of the tally on the device",
    "keyed": "path tables on the device",
    "waiting": "rays that wait on the device",
    "records": "arrivals that are written down on the device",
    "scene": "the scene on the device",
    "sums": "the sums over batches",
    "values": "what each batch gave of single quantities",
    "batches": "batches on the way",
    "arrays": "the arrays of the result",
    "state": "writing a checkpoint",
    "files": "writing its files",
    "figures": "drawing its figures",
}
_SHORT: Final = {
    "tally": "tally",
    "copies": "its copies",
    "keyed": "paths",
    "waiting": "waiting rays",
    "records": "records",
    "scene": "scene",
    "sums": "sums",
    "batches": "batches",
    "arrays": "arrays",
}


def _told_apart(size: int, limit: int) -> tuple[str, str]:
    """Return two numbers of bytes as people say them, whole where they would read the same."""
    texts = human(size), human(limit)
    return texts if texts[0] != texts[1] else (f"{size} bytes", f"{limit} bytes")


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
        asked, given = _told_apart(size, record.max_allocation)
        return (
            f"{_WORDS[part]} takes {asked} in one piece, and {record.label} gives at most {given}",
            part,
        )
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
    compiled: CompiledScene,
    needs: Needs,
    record: DeviceRecord | None,
    left: Room | None,
    *,
    saved: bool = False,
    drawn: bool = False,
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
    saved, drawn : bool, optional
        Whether room for its files, and for drawing it, is asked for too.
    """
    if record is not None:
        why, part = too_large(record, needs.device, needs.largest_buffer)
        if why:
            return f"{why}: {_advice(compiled, part)}"
    phases = needs.phases(saved=saved, drawn=drawn)
    when = max(phases, key=lambda name: sum(phases[name].values()))
    parts = phases[when]
    whole = sum(parts.values()) + _PROGRAM
    if left is None or whole <= left.left:
        return ""
    part = max(parts, key=parts.__getitem__)
    return (
        f"this scene takes {human(whole)} of memory {when}, and {human(left.left)} are left of "
        f"{left.what} ({human(left.limit)}); the largest part is {_WORDS[part]}, "
        f"{human(parts[part])}: {_advice(compiled, part)}"
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


def check_room(
    result: Estimates,
    name: str,
    advice: str = "open it where more is free, or run the scene with fewer bins",
    *,
    saved: bool = False,
    drawn: bool = False,
) -> None:
    """See that a result's arrays can be made, where they are not yet, written and drawn.

    A file of some kilobytes may stand for maps of gigabytes.

    Parameters
    ----------
    result : Estimates
        What was read, or traced.
    name : str
        What takes it, fit to begin the message.
    advice : str, optional
        What to do, fit to end it.
    saved, drawn : bool, optional
        Whether it is to be written, and drawn.

    Raises
    ------
    ResultError
        Where there is no room for it.
    """
    needs = Needs.of(result.compiled, None, None)
    layout = result.compiled.layout
    there = vars(result).keys()  # what was asked for once
    arrays = sum(size for what, size in array_sizes(layout).items() if what not in there)
    parts = {"arrays": arrays}
    if saved:
        lit = result.tally.held_bytes // SPARSE_CELL
        parts["files"] = needs.files + WRITTEN * lit
    if drawn:
        parts["figures"] = needs.figures
    # files are written, and closed, before anything is drawn
    whole = arrays + max(parts.get("files", 0), parts.get("figures", 0))
    left = room() if whole > _GROWING else None
    if left is None or whole + _GROWING <= left.left:
        return
    part = max(parts, key=parts.__getitem__)
    bins = sum(d.nx * d.ny for d in layout.detectors) + layout.n_mu * layout.n_phi
    raise ResultError(
        f"{name} takes {human(whole)} of memory for {bins} bins, most of it {_WORDS[part]} "
        f"({human(parts[part])}), and {human(left.left)} are left of {left.what} "
        f"({human(left.limit)}): {advice}"
    )


def _advice(compiled: CompiledScene, part: str) -> str:
    """Return what to change for a part to become smaller, with its path and value."""
    layout, scene = compiled.layout, compiled.scene
    if part in ("waiting", "records"):
        rays = compiled.settings.rays_per_batch
        return f"lower run.rays_per_batch (it is {rays})"
    if part == "values":
        rays = compiled.settings.rays_per_batch
        return f"take fewer batches of more rays (run.rays_per_batch is {rays})"
    if part == "scene":
        return f"take fewer elements (there are {len(scene.element)})"
    maps = sorted((d for d in layout.detectors if d.nx), key=lambda d: -_map_cells(d))
    far = layout.n_mu * layout.n_phi
    if far and (not maps or far >= _map_cells(maps[0])):
        assert scene.far_field is not None
        found = f"they are {layout.n_mu} and {layout.n_phi}"
        text = f"lower {scene.far_field.rows_by} and far_field.n_phi ({found}"
        more = len(maps)
    elif maps:
        d = maps[0]
        text = (
            f"take fewer bins in element[{d.element}].detector.map of "
            f"{show(scene.element[d.element].name)} (it is [{d.nx}, {d.ny}]"
        )
        if d.wavelengths:
            text += f", {1 + d.wavelengths} times by its wavelengths = true"
        more = len(maps) - 1
    else:
        lines = ""
        if scene.spectrum is not None:
            told = any(d.wavelengths for d in layout.detectors)
            lines = f", or {scene.spectrum.word}s (there are {scene.spectrum.n})"
            lines += ", or leave out wavelengths = true" if told else ""
        return f"take fewer elements and detectors{lines} ({layout.n_cells} quantities are counted)"
    bins = sum(map(_map_cells, maps)) + far
    return text + (f"; with {more} other maps {bins} bins)" if more else ")")


def _map_cells(d: DetectorCells) -> int:
    """Return the cells of a detector's map, and of those of each line."""
    return d.nx * d.ny * (1 + d.wavelengths)


def check_memory(
    compiled: CompiledScene,
    record: DeviceRecord | None,
    plan: ExecutionPlan | None,
    on_the_way: int = 0,
    look: Callable[[], Room | None] | None = None,
    *,
    saved: bool = False,
    batches: int | None = None,
) -> ExecutionPlan | None:
    """Return how a device is to run a scene, which is fewer batches at once where memory is short.

    What files take counts where the run is `saved`, and what each batch gave where it is
    known that there will be so many `batches`. Drawing never does: it can be left out, and
    `photizon report` does it later.

    Raises
    ------
    RunError
        Where it cannot fit, with the reason, see `refusal`.
    """
    needs = Needs.of(compiled, record, plan, on_the_way, batches)
    small = needs.most_at_a_time(saved=saved) + needs.more < _PROGRAM
    left = None if small else (look or room)()
    why = refusal(compiled, needs, record, left, saved=saved)
    if why and plan is not None and Sizes.of(compiled.tables, plan).slots > 1:
        plan = plan.with_(wave_rays=compiled.settings.rays_per_batch)
        needs = Needs.of(compiled, record, plan, on_the_way, batches)
        why = refusal(compiled, needs, record, left, saved=saved)
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
    most = needs.most_at_a_time(saved=True, drawn=True)
    text = (
        f"{human(most)} at most at a time: device {_listed(needs.device)}; host "
        f"{_listed(needs.while_running)}, at the end {_listed(needs.at_the_end)}, and "
        f"{human(needs.files)} more to write files, {human(needs.figures)} to draw figures"
    )
    if needs.more:
        text += f"; up to {human(needs.more)} more for sums, and to write them, as bins are lit"
    if needs.more_values > 999:
        text += (
            f"; up to {human(needs.more_values)} more for what single batches give, as they come"
        )
    if needs.waiting_more:
        text += f"; up to {human(needs.waiting_more)} more for rays that wait"
    for what, asked in (
        ("It", {}),
        ("Its files", {"saved": True}),
        ("Its figures (`--no-figures` leaves them out)", {"drawn": True}),
    ):
        why = refusal(compiled, needs, record, left, **asked)
        if why:
            return f"{text}. {what} will not fit: {why}"
    return text


def on_usual_device(compiled: CompiledScene) -> str:
    """Return the `statement` for the device that a run would have, on which nothing is done."""
    try:
        record = explain_choice(records=survey().records).record
    except DeviceError as error:
        return f"not known without a device ({str(error).splitlines()[0]})"
    return statement(compiled, record, usual_plan(record, compiled.tables), room())


def _listed(parts: dict[str, int]) -> str:
    shown = [f"{_SHORT[name]} {human(size)}" for name, size in parts.items() if size > 999]
    return f"{human(sum(parts.values()))} ({', '.join(shown)})" if shown else human(0)
