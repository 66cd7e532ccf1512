"""Tracing a scene: batches in order until a goal is reached."""

from __future__ import annotations

import dataclasses
import operator
import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.compile.compiled import MAX_RAY_NUMBER, CompiledScene, compile_scene
from photizon_cl.errors import ArgumentError, ResultError, RunError, SceneError, show
from photizon_cl.result.engine import engine_digest
from photizon_cl.result.ledger import check_batch
from photizon_cl.result.result import Result, RunInfo
from photizon_cl.result.statistics import Accumulator, complete
from photizon_cl.result.stopping import Goal, History
from photizon_cl.run.distribution import Executed, Local, Runner
from photizon_cl.run.progress import Clock, Progress
from photizon_cl.scene.files import load
from photizon_cl.version import __version__

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterator, Mapping
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.run.checkpoint import Keeper
    from photizon_cl.scene.model import Scene

__all__ = ["PRECISIONS", "Progress", "refine", "resume", "trace", "with_settings"]

PRECISIONS: Final = ("fp64",)
"""Precisions that a trace can have."""


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
    checkpoint: str | os.PathLike[str] | None = None,
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
    checkpoint : str or path, optional
        Directory, made where it is not there, that keeps a checkpoint of the run; `resume` goes on
        with it should the process die. It goes when the result is saved there.

    Returns
    -------
    Result
        Its scene is the scene as run: with these settings in ``[run]``.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    ResultError
        Where `checkpoint` cannot be used, or holds another unfinished run.
    RunError
        Where there is no usable device, or the run fails.
    """
    if precision not in PRECISIONS:
        raise ArgumentError(
            f"precision: found {show(precision)}, expected one of "
            f"{', '.join(map(show, PRECISIONS))} (results are exact integer tallies of doubles; "
            "nothing else is available in this version)"
        )
    as_run = with_settings(
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
    tally = Accumulator.of(compiled.layout)
    start = Result(compiled, tally, RunInfo(precision=precision, goal=goal))
    return _go_on(start, goal, device, progress, executor, plan, checkpoint)


def resume(
    path: str | os.PathLike[str],
    *,
    target: float | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    plan: ExecutionPlan | None = None,
) -> Result:
    """Go on with the run in a directory, wherever it ended or was killed.

    The outcome is bit for bit that of one uninterrupted run. While it goes on the directory keeps a
    checkpoint; `Result.save` writes the outcome there.

    Parameters
    ----------
    path : str or path
        The directory that ``run --out``, `Result.save` or ``trace(checkpoint=…)`` wrote.
    target : float, optional
        Relative standard error to reach.
    batches : int, optional
        Batches in all. Without either, the goal that the run had holds.
    max_seconds, device, progress, executor, plan : optional
        As in `trace`.

    Raises
    ------
    ResultError
        Where there is no run, or it is damaged.
    ArgumentError, RunError
        As in `trace`.
    """
    from photizon_cl.run.checkpoint import latest

    return refine(
        latest(path), target=target, batches=batches, max_seconds=max_seconds, device=device,
        progress=progress, executor=executor, plan=plan, checkpoint=path,
    )  # fmt: skip


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
    checkpoint: str | os.PathLike[str] | None = None,
) -> Result:
    """Add batches to the stream of a result, see `Result.refine`."""
    if target is None and batches is None:
        goal = result.info.goal
        if max_seconds is not None:
            _check_seconds(result.scene, max_seconds)
            goal = dataclasses.replace(goal, max_seconds=max_seconds)
        compiled = result.compiled
    else:
        as_run = with_settings(result.scene, target_sigma=target, max_seconds=max_seconds)
        goal = _goal(as_run, batches, target, max_seconds)
        # The stream does not depend on when it stops: the tables stay what they are.
        compiled = dataclasses.replace(result.compiled, scene=as_run, settings=as_run.run)
    if goal.batches is not None and goal.batches < result.batches:
        raise ArgumentError(
            f"batches: found {goal.batches}, expected at least the {result.batches} that the "
            "result has already (the number is that of all batches)"
        )
    info = dataclasses.replace(result.info, goal=goal)
    if not result.batches:
        info = dataclasses.replace(info, version=__version__, engine=engine_digest())
    elif info.engine not in ("", engine_digest()):
        raise ResultError(
            f"the result was made by photizon_cl {info.version} with the engine {info.engine}, and "
            f"this is {__version__} with the engine {engine_digest()}: their batches may differ in "
            "bits and are not mixed; go on with that version, or run the scene again"
        )
    start = Result(compiled, result.tally.copy(), info)
    if start.batches and goal.reached(compiled.layout, start.tally):
        return start
    return _go_on(start, goal, device, progress, executor, plan, checkpoint)


def with_settings(scene: Scene, **settings: Any) -> Scene:
    """Return a scene with those settings of ``[run]`` that are given and not None.

    Raises
    ------
    ArgumentError
        Where one is not valid.
    """
    given = {name: value for name, value in settings.items() if value is not None}
    if not given:
        return scene
    try:
        return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **given))
    except SceneError as error:
        lines = [str(dataclasses.replace(problem, owner="")) for problem in error.problems]
        raise ArgumentError("\n".join(lines)) from None


def _check_seconds(scene: Scene, max_seconds: float) -> None:
    with_settings(scene, max_seconds=max_seconds)


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
    checkpoint: str | os.PathLike[str] | None,
) -> Result:
    """Add batches to a result that nobody else holds until its goal is reached."""
    if checkpoint is None:
        return _add_batches(start, goal, device, progress, executor, plan, None)
    from photizon_cl.result.directory import prepare_target
    from photizon_cl.run.checkpoint import Keeper

    keeper = Keeper(prepare_target(checkpoint, start), start)
    try:
        return _add_batches(start, goal, device, progress, executor, plan, keeper)
    finally:
        keeper.close()


def _add_batches(
    start: Result,
    goal: Goal,
    device: DeviceRecord | str | int | None,
    progress: Callable[[Progress], object] | None,
    executor: Executor | None,
    plan: ExecutionPlan | None,
    keeper: Keeper | None,
) -> Result:
    compiled, tally, info = start.compiled, start.tally, start.info
    chosen = str(device) if isinstance(device, int) else device
    runner: Runner
    if executor is None:
        runner = Local(compiled.tables, chosen, plan)
    else:
        runner = Executed(executor, compiled.scene.digest(), compiled.tables, chosen, plan)
    clock = Clock(goal, tally.batches)
    if isinstance(runner, Local):
        runner.engine.give_up = clock.must_stop
    last = MAX_RAY_NUMBER // compiled.settings.rays_per_batch
    last = last if goal.batches is None else min(last, goal.batches)
    worst, interactions, label, build = info.worst_closure, 0, info.device, 0.0
    history = History(info.history, info.seconds)

    def so_far(stopped: str = "") -> RunInfo:
        return dataclasses.replace(
            info,
            device=label,
            interactions=info.interactions + interactions,
            seconds=info.seconds + clock.elapsed(),
            build_seconds=info.build_seconds + build,
            worst_closure=worst,
            history=history.rows,
            stopped=stopped,
        )

    chunks = runner.chunks(tally.batches, last, clock.batches_in_time)
    with _interruptible() as interrupted:
        try:
            for chunk in chunks:
                done = False
                for cells in chunk.cells:
                    whole = complete(compiled.layout, cells)
                    worst = max(worst, check_batch(compiled, tally.batches, whole))
                    tally.add(whole)
                    interactions += int(whole[compiled.layout.interactions, 3])
                    done = goal.reached(compiled.layout, tally)
                    if done:
                        break  # what was computed beyond is dropped: the goal fixes the bits
                label, build = chunk.device, max(build, chunk.build_seconds)
                clock.note(tally.batches)
                history.note(compiled.layout, tally, clock.elapsed())
                if keeper is not None:
                    keeper.note(lambda: Result(compiled, tally, so_far()))
                if progress is not None:
                    progress(Progress.of(compiled, tally, goal, info, interactions, clock))
                if done or interrupted() or clock.over():
                    break
        finally:
            close = getattr(chunks, "close", None)
            if close is not None:
                close()
    if not tally.batches:
        raise RunError(_no_batch(compiled, clock))
    history.note(compiled.layout, tally, clock.elapsed(), last=True)
    stopped = "interrupt" if interrupted() else "time"
    if goal.reached(compiled.layout, tally):
        stopped = "batches" if tally.batches == goal.batches else "target"
    result = Result(compiled, tally, so_far(stopped))
    if keeper is not None:
        keeper.note(lambda: result, last=True)
    return result


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


def _no_batch(compiled: CompiledScene, clock: Clock) -> str:
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
