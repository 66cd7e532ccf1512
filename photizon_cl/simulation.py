"""Tracing a scene: batches in order until a goal is reached."""

from __future__ import annotations

import dataclasses
import math
import operator
import signal
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.compile import MAX_RAY_NUMBER, CompiledScene, compile_scene
from photizon_cl.distribution import Executed, Local, Runner
from photizon_cl.errors import ArgumentError, RunError, SceneError, show
from photizon_cl.ledger import check_batch
from photizon_cl.result import Result, RunInfo
from photizon_cl.scene_io import load
from photizon_cl.statistics import Accumulator, complete
from photizon_cl.stopping import LEAST_BATCHES, Goal, achieved_sigma

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterator, Mapping
    from concurrent.futures import Executor

    from hostcode.device import DeviceRecord
    from hostcode.plan import ExecutionPlan
    from photizon_cl.scene import Scene

__all__ = ["PRECISIONS", "Progress", "refine", "trace"]

PRECISIONS: Final = ("fp64",)
"""Precisions that a trace can have."""


@dataclass(frozen=True)
class Progress:
    """How far a run is; given to `progress` after each wave.

    Parameters
    ----------
    batches : int
        Batches in the result so far.
    goal_batches : int or None
        Batches at which the run ends, where that is fixed.
    target : float or None
        Relative standard error at which the run ends, where one is asked for.
    achieved_sigma : float or None
        The one reached; None with a single batch, or where nothing has one.
    interactions : int
        Surface interactions of these batches.
    seconds : float
        Time of this call so far.
    interactions_per_second : float
        In this call.
    eta_seconds : float or None
        Time left, as far as it can be told: σ falls with the square root of the batches.
    """

    batches: int
    goal_batches: int | None
    target: float | None
    achieved_sigma: float | None
    interactions: int
    seconds: float
    interactions_per_second: float
    eta_seconds: float | None


def trace(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    seed: int | None = None,
    target: float | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    rays_per_batch: int | None = None,
    device: DeviceRecord | str | int | None = None,
    precision: str = "fp64",
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    plan: ExecutionPlan | None = None,
) -> Result:
    """Trace a scene and return power, irradiance and intensity with their standard errors.

    Stops at `target` or, where only `batches` is given, after exactly so many batches; with both,
    at whichever comes first. Without either, the scene's own target holds. A target counts from
    the eighth batch on, and is asked for behind every batch in order, so the number of batches
    alone fixes every bit of the result. A run towards a target also ends at `max_seconds` (by
    default the scene's); one of a fixed number of batches only where `max_seconds` is given. Ctrl-C
    ends the run with what is there, a second Ctrl-C at once.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    seed, rays_per_batch : int, optional
        The random stream; default those of the scene's ``[run]``.
    target : float, optional
        Median relative standard error to reach, in (0, 1]; see the summary's ``achieved_sigma``.
    batches : int, optional
        Batches in all.
    max_seconds : float, optional
        Seconds, checked between waves; at least one batch is made.
    device : str, int or DeviceRecord, optional
        As ``photizon devices`` lists it; default ``PHOTIZON_DEVICE``, else the best.
    precision : str, optional
        ``"fp64"``.
    progress : callable, optional
        Given a `Progress` after each wave.
    executor : concurrent.futures.Executor, optional
        Computes the batches on its workers, each of which opens a device; the same bits. Worker
        processes must be spawned, not forked, once this process has used OpenCL.
    plan : ExecutionPlan, optional
        How a device runs a wave; changes no bit.

    Returns
    -------
    Result
        Its scene is the scene as run: with these settings in ``[run]``.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, or the run fails.
    """
    if precision not in PRECISIONS:
        raise ArgumentError(
            f"precision: found {show(precision)}, expected one of "
            f"{', '.join(map(show, PRECISIONS))} (results are exact integer tallies of doubles; "
            "nothing else is available in this version)"
        )
    as_run = _as_run(
        load(scene),
        seed=seed,
        target_sigma=target,
        max_seconds=max_seconds,
        rays_per_batch=rays_per_batch,
    )
    goal = _goal(as_run, batches, target, max_seconds)
    if as_run.run.rays_per_batch < len(as_run.source):
        raise ArgumentError(
            f"rays_per_batch: found {as_run.run.rays_per_batch}, expected at least "
            f"{len(as_run.source)}, one for each source"
        )
    compiled = compile_scene(as_run, as_run.run)
    layout = compiled.layout
    tally = Accumulator(layout.n_cells, [(layout.killed, layout.boosted)])
    start = Result(compiled, tally, RunInfo(precision=precision, goal=goal))
    return _go_on(start, goal, device, progress, executor, plan)


def refine(
    result: Result,
    *,
    target: float | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    plan: ExecutionPlan | None = None,
) -> Result:
    """Add batches to the stream of a result, see `Result.refine`."""
    if target is None and batches is None:
        goal = result.info.goal
        if max_seconds is not None:
            _check_seconds(result.scene, max_seconds)
            goal = dataclasses.replace(goal, max_seconds=max_seconds)
        compiled = result.compiled
    else:
        as_run = _as_run(result.scene, target_sigma=target, max_seconds=max_seconds)
        goal = _goal(as_run, batches, target, max_seconds)
        # The stream does not depend on when it stops: the tables stay what they are.
        compiled = dataclasses.replace(result.compiled, scene=as_run, settings=as_run.run)
    if goal.batches is not None and goal.batches < result.batches:
        raise ArgumentError(
            f"batches: found {goal.batches}, expected at least the {result.batches} that the "
            "result has already (the number is that of all batches)"
        )
    start = Result(compiled, result.tally.copy(), dataclasses.replace(result.info, goal=goal))
    if start.batches and goal.reached(compiled.layout, start.tally):
        return start
    return _go_on(start, goal, device, progress, executor, plan)


def _as_run(scene: Scene, **settings: Any) -> Scene:
    given = {name: value for name, value in settings.items() if value is not None}
    if not given:
        return scene
    try:
        return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **given))
    except SceneError as error:
        lines = [str(dataclasses.replace(problem, owner="")) for problem in error.problems]
        raise ArgumentError("\n".join(lines)) from None


def _check_seconds(scene: Scene, max_seconds: float) -> None:
    _as_run(scene, max_seconds=max_seconds)


def _goal(
    scene: Scene, batches: int | None, target: float | None, max_seconds: float | None
) -> Goal:
    if batches is None:
        return Goal(None, scene.run.target_sigma, scene.run.max_seconds)
    most = MAX_RAY_NUMBER // scene.run.rays_per_batch
    try:
        number = operator.index(batches)
    except TypeError:
        number = 0
    if isinstance(batches, bool) or not 1 <= number <= most:
        raise ArgumentError(
            f"batches: found {show(batches)}, expected an integer from 1 to {most} "
            f"(rays are numbered up to 2^48, and a batch has {scene.run.rays_per_batch})"
        )
    if target is None:
        return Goal(number, None, None if max_seconds is None else scene.run.max_seconds)
    return Goal(number, scene.run.target_sigma, scene.run.max_seconds)


def _go_on(
    start: Result,
    goal: Goal,
    device: DeviceRecord | str | int | None,
    progress: Callable[[Progress], object] | None,
    executor: Executor | None,
    plan: ExecutionPlan | None,
) -> Result:
    """Add batches to a result that nobody else holds until its goal is reached."""
    compiled, tally, info = start.compiled, start.tally, start.info
    chosen = str(device) if isinstance(device, int) else device
    runner: Runner
    if executor is None:
        runner = Local(compiled.tables, chosen, plan)
    else:
        runner = Executed(executor, compiled.scene.digest(), compiled.tables, chosen, plan)
    clock = _Clock(goal, tally.batches)
    if isinstance(runner, Local):
        runner.engine.give_up = clock.must_stop
    last = MAX_RAY_NUMBER // compiled.settings.rays_per_batch
    last = last if goal.batches is None else min(last, goal.batches)
    worst, interactions, label, build = info.worst_closure, 0, info.device, 0.0
    chunks = runner.chunks(tally.batches, last, clock.batches_in_time)
    with _interruptible() as interrupted:
        try:
            for chunk in chunks:
                done = False
                for cells in chunk.cells:
                    whole = complete(compiled.layout, cells)
                    worst = max(worst, check_batch(compiled, tally.batches, whole))
                    tally.add(whole)
                    interactions += int(whole[compiled.layout.depth_capped, 3])
                    done = goal.reached(compiled.layout, tally)
                    if done:
                        break  # what was computed beyond is dropped: the goal fixes the bits
                label, build = chunk.device, max(build, chunk.build_seconds)
                clock.note(tally.batches)
                if progress is not None:
                    progress(_progress(compiled, tally, goal, info, interactions, clock))
                if done or interrupted() or clock.over():
                    break
        finally:
            close = getattr(chunks, "close", None)
            if close is not None:
                close()
    if not tally.batches:
        raise RunError(_no_batch(compiled, clock))
    info = dataclasses.replace(
        info,
        device=label,
        interactions=info.interactions + interactions,
        seconds=info.seconds + clock.elapsed(),
        build_seconds=info.build_seconds + build,
        worst_closure=worst,
    )
    return Result(compiled, tally, info)


class _Clock:
    """Time of one call, and how many batches still fit into it."""

    def __init__(self, goal: Goal, first: int) -> None:
        self.limit = goal.max_seconds
        self.first = self.batches = first
        self.started = time.perf_counter()

    def elapsed(self) -> float:
        return time.perf_counter() - self.started

    def note(self, batches: int) -> None:
        self.batches = batches

    def over(self) -> bool:
        return self.limit is not None and self.elapsed() >= self.limit

    def must_stop(self) -> bool:
        """Say whether the batches in flight are to be given up: time is up and there are others.

        The first batch of a call has twice the time and ten seconds more.
        """
        if self.limit is None:
            return False
        first = self.batches == self.first
        return self.elapsed() >= (2.0 * self.limit + 10.0 if first else self.limit)

    def batches_in_time(self) -> int | None:
        """Return how many batches may go into a wave: one at first, to learn how long it takes."""
        if self.limit is None:
            return None
        made = self.batches - self.first
        if not made:
            return 1
        left = max(self.limit - self.elapsed(), 0.0)
        return max(int(min(left * made / max(self.elapsed(), 1e-9), 1e9)), 1)


def _progress(
    compiled: CompiledScene,
    tally: Accumulator,
    goal: Goal,
    info: RunInfo,
    interactions: int,
    clock: _Clock,
) -> Progress:
    achieved = achieved_sigma(compiled.layout, tally)
    seconds = max(clock.elapsed(), 1e-9)
    pace = seconds / max(tally.batches - clock.first, 1)
    left = []
    if goal.batches is not None:
        left.append((goal.batches - tally.batches) * pace)
    if goal.target is not None and achieved is not None:
        needed = max(tally.batches * (achieved / goal.target) ** 2, LEAST_BATCHES)
        left.append(max(needed - tally.batches, 0.0) * pace)
    if goal.max_seconds is not None:
        left.append(max(goal.max_seconds - seconds, 0.0))
    return Progress(
        batches=tally.batches,
        goal_batches=goal.batches,
        target=goal.target,
        achieved_sigma=achieved,
        interactions=info.interactions + interactions,
        seconds=seconds,
        interactions_per_second=interactions / seconds,
        eta_seconds=min(left) if left and math.isfinite(min(left)) else None,
    )


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Give a function that says whether Ctrl-C was pressed; the second one interrupts at once."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = False
    before = signal.getsignal(signal.SIGINT)

    def note(number: int, frame: object) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    if before is None or before is signal.SIG_IGN:  # not Python's to replace, or asked to ignore
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)


def _no_batch(compiled: CompiledScene, clock: _Clock) -> str:
    run = compiled.settings
    advice = "lower rays_per_batch or raise max_seconds"
    if "splitting" in compiled.effects:
        advice = (
            "every split makes two rays of one, and between Fresnel surfaces and reflecting ones "
            f"nothing ends them before the generation cap of {run.generation_cap}: set "
            f"roulette_floor (1e-6, say) or lower generation_cap; else {advice}"
        )
    return (
        f"not one batch of {run.rays_per_batch} rays ended within {clock.elapsed():.0f} s "
        f"(max_seconds is {clock.limit:g}), so there is nothing to report: {advice}"
    )
