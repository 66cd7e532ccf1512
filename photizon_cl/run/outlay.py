"""Tracing a little of a run, to tell how long it will take to its target."""

from __future__ import annotations

import dataclasses
import math
import time
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.errors import Abandoned
from hostcode.run.usual import usual_plan
from photizon_cl.checks.precision import DEFAULT
from photizon_cl.result.needed import batches_needed
from photizon_cl.result.outlay import Outlay, Untold
from photizon_cl.result.statistics import LIT_COUNT, Accumulator, complete
from photizon_cl.result.stopping import LEAST_BATCHES, judged
from photizon_cl.run.distribution import compute, make_engine, open_chosen
from photizon_cl.run.pilot import compiled_for_few

if TYPE_CHECKING:
    from hostcode.device.device import DeviceRecord
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.scene.model import Scene

__all__ = ["outlay"]

_SECONDS: Final = 0.5
"""Time that is spent on it, beside one batch."""
_RAYS: Final = 2048
"""Rays of a batch: small, so that a slow scene has some in the time."""
_MOST_BATCHES: Final = 64
_MOST_CELLS: Final = 1 << 20
"""Cells of a tally beyond which nothing is told: clearing them takes longer than the rays."""
_PACE: Final = 0.2
"""Relative standard error of a pace that was measured in so short a time."""
_SIDES: Final = 2.0


def outlay(
    scene: Scene, device: DeviceRecord | str | None = None, *, precision: str = DEFAULT
) -> Outlay | Untold:
    """Tell how long a scene's run takes to its target.

    The program is that of the run, so that one which follows need not build it.

    Parameters
    ----------
    scene : Scene
        With the target in its ``[run]``.
    device : DeviceRecord or str, optional
    precision : str, optional
        As in `photizon_cl.trace`.

    Returns
    -------
    Outlay or Untold
        `Untold` where the rays that there was time for do not tell: a batch of few takes longer,
        too little arrives, or the scene has very many bins.

    Raises
    ------
    ArgumentError, RunError
        Where there is no usable device, or it fails, or the scene cannot be traced at all.
    """
    run = scene.run
    rays = max(min(_RAYS, run.rays_per_batch), scene.fewest_rays)
    compiled = compiled_for_few(scene, dataclasses.replace(run, rays_per_batch=rays), precision)
    if compiled.layout.n_cells > _MOST_CELLS:
        return Untold("the scene has very many bins, and each batch takes long by them alone")
    record = open_chosen(device).record
    engine = make_engine(device, compiled.tables, usual_plan(record, compiled.tables))
    tally = Accumulator.of(compiled.layout)
    start = time.perf_counter()
    engine.give_up = lambda: time.perf_counter() - start > 2.0 * _SECONDS
    timed, n = 0.0, 1
    try:
        while tally.batches < _MOST_BATCHES and time.perf_counter() - start < _SECONDS:
            before = time.perf_counter()
            chunk = compute(engine, tally.batches, n)
            took = time.perf_counter() - before
            for cells in chunk.cells:
                tally.add(complete(compiled.layout, cells))
            timed += took if tally.batches > 1 else 0.0  # the first one warms up
            n = min(2 * n, max(round(0.3 * _SECONDS * n / took), 1), _MOST_BATCHES - tally.batches)
    except Abandoned:
        pass
    traced = tally.batches * rays
    if tally.batches < LEAST_BATCHES:
        return Untold(f"a batch of {rays} rays takes longer than there was time for")
    layout = compiled.layout
    dark = tuple(
        scene.element[d.element].name for d in layout.detectors if not tally.counts(d.power, 1)[0]
    )
    needed, spread = batches_needed(layout, tally, run.target_sigma)
    if not math.isfinite(needed):
        few = (
            "too little arrives of"
            if len(dark) < len(layout.detectors) or not dark
            else ("nothing arrives of")
        )
        return Untold(f"{few} {traced} rays where the target is", traced, dark)
    pace = timed / (tally.batches - 1) / rays
    batches = max(needed * rays / run.rays_per_batch, float(LEAST_BATCHES))
    factor = math.exp(_SIDES * math.hypot(spread, _PACE))
    seconds = batches * run.rays_per_batch * pace
    return Outlay(
        traced, run.target_sigma, seconds, seconds / factor, seconds * factor,
        batches, _lit(layout, tally), run.max_seconds, dark,
    )  # fmt: skip


def _lit(layout: TallyLayout, tally: Accumulator) -> float:
    """Return which part of the bins that the target is on are lit; 1 where it is on none."""
    ranges = [r for found, bins in judged(layout) if bins for r in found]
    if not ranges:
        return 1.0
    return float(np.concatenate([tally.counts(*r) >= LIT_COUNT for r in ranges]).mean())
