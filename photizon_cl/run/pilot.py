"""Tracing a few hundred rays of a scene, by the kernels of the trace, to see what will hurt."""

from __future__ import annotations

import dataclasses
import time
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

from hostcode.errors import Abandoned, HostError
from hostcode.run.tally import exact, whole_of
from hostcode.run.usual import usual_plan
from hostcode.run.wavefront import Engine
from photizon_cl.checks.precision import DEFAULT
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.compile.rays import (
    LEAST_WEIGHT,
    beams_of,
    ray_weights,
    share_rays,
)
from photizon_cl.errors import PhotizonError
from photizon_cl.result.pilot import NEGLIGIBLE, Pilot
from photizon_cl.result.statistics import complete
from photizon_cl.run.distribution import device_failures, open_chosen
from photizon_cl.scene.parameters import LARGEST
from photizon_cl.scene.settings import MAX_GENERATION_CAP

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tally import SparseTally
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings

__all__ = ["compiled_for_few", "counted_by_pilot", "pilot", "pilot_of_capped", "without_bins"]

_RAYS: Final = 512
_SEED: Final = 0x70696C6F74
"""A stream of its own: what a run draws is not touched."""
_BUDGET: Final = 1 << 21
"""Interactions that are made in all: a fraction of a second on two cores. A number, not a time, so
that what is said does not depend on the machine."""
_SECONDS: Final = 1.0
"""Time at which a device that is far slower gives up all the same."""
_ENOUGH: Final = 1.0 + 2.0**-40
"""Times the least weight that a ray is raised to, which rounding does not take below it."""
_RAISED: Final = 8
"""Times that weak rays are made stronger."""
_FAINTEST: Final = 1e-290
"""Weight that one such time goes by at least, where it may be nothing in a double."""
_STEPS: Final = 128
"""Steps of a packet between two looks at the budget."""


def pilot(
    scene: Scene,
    device: DeviceRecord | str | None = None,
    plan: ExecutionPlan | None = None,
    *,
    stop: Callable[[], bool] = lambda: False,
    precision: str = DEFAULT,
) -> Pilot:
    """Trace a pilot.

    The program is that of a trace of the scene, so that a run which follows need not build it.

    Parameters
    ----------
    scene : Scene
        With the generation cap that is asked about in its ``[run]``.
    device : DeviceRecord or str, optional
        As in `photizon_cl.trace`.
    plan : ExecutionPlan, optional
        How; changes nothing of what is found.
    stop : callable, optional
        Asked now and then: whether to give up.
    precision : str, optional
        As in `photizon_cl.trace`.

    Raises
    ------
    ArgumentError, RunError
        Where there is no usable device, or it fails, or the scene cannot be traced at all.
    """
    cap = scene.run.generation_cap
    rays = max(_RAYS, scene.fewest_rays)
    settings = dataclasses.replace(scene.run, seed=_SEED, rays_per_batch=rays)
    flight = _Flight(compiled_for_few(without_bins(scene), settings, precision), device, plan, stop)
    left: list[tuple[int, float]] = []
    missed = interactions = 0.0
    complete = False
    try:
        missed = flight.follow(1)[1]
        for m in [*([cap // 2] if cap > 1 else []), cap]:
            left.append((m, flight.follow(m)[0]))
        interactions, complete = flight.made / rays, True
        while left[-1][1] > NEGLIGIBLE and 2 * flight.made <= flight.room:
            m = min(2 * left[-1][0], MAX_GENERATION_CAP)
            if m == left[-1][0]:
                break
            left.append((m, flight.follow(m)[0]))
    except Abandoned:
        interactions = interactions or flight.made / rays
    return Pilot(rays, cap, interactions, missed, tuple(left), complete)


def counted_by_pilot(
    scene: Scene, device: DeviceRecord | str | None = None, precision: str = DEFAULT
) -> list[str]:
    """Return what effects have to say of what they counted of a pilot's rays.

    Parameters
    ----------
    scene : Scene
        Any; nothing is traced where no effect counts.
    device, precision : optional
        As in `photizon_cl.trace`.

    Raises
    ------
    ArgumentError, RunError
        As `pilot` does.
    """
    rays = max(_RAYS, scene.fewest_rays)
    settings = dataclasses.replace(scene.run, seed=_SEED, rays_per_batch=rays)
    compiled = compiled_for_few(without_bins(scene), settings, precision)
    counting = [group for group in compiled.layout.groups if group.counted_as]
    if not counting:
        return []
    flight = _Flight(compiled, device, None, lambda: False)
    try:
        flight.follow(settings.generation_cap)
    except Abandoned:
        return []
    counts = {g.effect: whole_of(flight.cells, g.first, g.size)[:, 3].tolist() for g in counting}
    return [
        f"by a pilot of {rays} rays: {text}"
        for effect in EFFECTS
        if effect.name in counts
        for text in effect.advice(scene, counts[effect.name])
    ]


def pilot_of_capped(
    compiled: CompiledScene,
    tally: Accumulator,
    device: DeviceRecord | str | None,
    plan: ExecutionPlan | None,
    stop: Callable[[], bool],
) -> Pilot | None:
    """Trace a pilot where a run's rays reached the generation cap, to tell what can be done.

    None where they did not, where the pilot was asked to end, or where it fails, in whatever way:
    the run's outcome stands without it. One that could not follow its rays to the cap is told as
    such, so that a run which goes on does not send it again.
    """
    if not tally.batches or stop():
        return None
    emitted = compiled.emitted * tally.batches
    if tally.exact(compiled.layout.depth_capped) <= NEGLIGIBLE * emitted:
        return None
    try:
        found = pilot(compiled.scene, device, plan, stop=stop, precision=compiled.precision.name)
    except (PhotizonError, HostError, MemoryError):
        return None
    return found if found.complete or not stop() else None


def compiled_for_few(scene: Scene, settings: RunSettings, precision: str) -> CompiledScene:
    """Compile a scene for a pilot's few rays.

    Where a source, or one of its lines, has one ray of a few hundred and one of the run's many,
    that ray may be too weak for the tally beside the others' heavier ones. It is then made as
    strong as need be: all of the source, or line, is some 10^-12 of the power all the same.
    """
    for _ in range(_RAISED):  # once, but for what it changes of how rays are shared
        _, weights = ray_weights(scene, share_rays(scene, settings.rays_per_batch))
        if min(weights) >= LEAST_WEIGHT:
            break
        scene = _raised(scene, weights)
    return compile_scene(scene, settings, precision=precision)


def _raised(scene: Scene, weights: list[float]) -> Scene:
    """Return a scene with as much power in its weakest beams as the tally can hold.

    Parameters
    ----------
    scene : Scene
        Any.
    weights : list of float
        Of each beam's rays.
    """
    enough = _ENOUGH * LEAST_WEIGHT
    factors: list[list[float]] = [[] for _ in scene.source]
    for beam, weight in zip(beams_of(scene), weights, strict=True):
        factors[beam.source].append(max(enough / max(weight, _FAINTEST), 1.0))
    # shares are what they were, whatever the flux is now
    sources = []
    for source, by in zip(scene.source, factors, strict=True):
        changes: dict[str, Any] = {"share": source.flux if source.share is None else source.share}
        if max(by) > 1.0 and scene.spectrum is None:
            changes["flux"] = source.flux * by[0]
        elif max(by) > 1.0:
            powers, least = list(source.spectrum or (1.0,) * len(scene.wavelengths)), min(by)
            before = sum(map(Fraction, powers))
            lit = (k for k, power in enumerate(powers) if power)
            for k, factor in zip(lit, by, strict=True):
                # what all are raised by is the flux's
                powers[k] = min(powers[k] * (factor / least), LARGEST)
            changes["spectrum"] = powers
            more = sum(map(Fraction, powers)) / before * Fraction(least)
            changes["flux"] = float(Fraction(source.flux) * more)
        sources.append(dataclasses.replace(source, **changes))
    return dataclasses.replace(scene, source=tuple(sources))


class _Flight:
    """The rays of a pilot, followed from the start to one cap after another.

    Parameters
    ----------
    compiled : CompiledScene
        The scene with the pilot's settings.
    device, plan, stop
        As `pilot` takes them.
    """

    def __init__(
        self,
        compiled: CompiledScene,
        device: DeviceRecord | str | None,
        plan: ExecutionPlan | None,
        stop: Callable[[], bool],
    ) -> None:
        self.compiled = compiled
        self.opened = open_chosen(device)
        plan = plan or usual_plan(self.opened.record, compiled.tables)
        self.plan = plan.with_(
            wave_rays=compiled.settings.rays_per_batch, max_bounces=min(_STEPS, plan.max_bounces)
        )
        self.stop = stop
        self.room = _BUDGET
        self.made = 0
        """Interactions to the last cap."""
        self.ends: float | None = None
        self.cells: NDArray[np.int64] | SparseTally
        """What was counted to the last cap."""

    def follow(self, cap: int) -> tuple[float, float]:
        """Return which parts of the power are under way at a cap, and have escaped.

        Raises
        ------
        Abandoned
            Where the budget is spent on the way.
        """
        tables, layout = self.compiled.tables, self.compiled.layout
        tables = dataclasses.replace(tables, launch={**tables.launch, "generation_cap": cap})
        with device_failures(self.opened.record.label):
            engine = Engine(self.opened, tables, self.plan)
            if self.ends is None:  # building the program is not counted
                self.ends = time.monotonic() + _SECONDS
            engine.give_up = lambda: self._spent(engine)
            try:
                (batch,) = engine.run(0, 1)
            finally:
                self.made = engine.statistics.interactions
                self.room -= self.made
        self.cells = complete(layout, batch.cells)
        rows = (layout.depth_capped, layout.escaped)
        powers = [exact(whole_of(self.cells, row, 1))[0] for row in rows]
        under_way, escaped = (float(Fraction(n, self.compiled.emitted)) for n in powers)
        return under_way, escaped

    def _spent(self, engine: Engine) -> bool:
        assert self.ends is not None
        late = time.monotonic() > self.ends
        return late or self.stop() or engine.statistics.interactions > self.room


def without_bins(scene: Scene) -> Scene:
    """Return a scene with a single bin in each map: the same program, and no memory to speak of."""
    one = {
        n: dataclasses.replace(e, detector=dataclasses.replace(e.detector, map=(1, 1)))
        for n, e in enumerate(scene.element)
        if e.detector is not None and e.detector.map is not None
    }
    far = None if scene.far_field is None else scene.far_field.single()
    elements = tuple(one.get(n, e) for n, e in enumerate(scene.element))
    return dataclasses.replace(scene, element=elements, far_field=far)
