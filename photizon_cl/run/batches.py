"""Adding batches to a tally, in order, until a goal is reached."""

from __future__ import annotations

import dataclasses
import operator
import warnings
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, TypeVar

from hostcode.run.tally import whole_of
from hostcode.run.usual import usual_plan
from photizon_cl.compile.compiled import MAX_RAY_NUMBER, CompiledScene
from photizon_cl.compile.quantities import watched
from photizon_cl.errors import (
    ArgumentError,
    NoRoomError,
    ResultError,
    RunError,
    RunWarning,
    SceneError,
    show,
)
from photizon_cl.result.engine import engine_digest
from photizon_cl.result.estimates import Estimates, RunInfo
from photizon_cl.result.forecast import Outlook
from photizon_cl.result.keyed_sums import check_paths
from photizon_cl.result.ledger import check_batch
from photizon_cl.result.statistics import complete
from photizon_cl.result.stopping import Goal, History
from photizon_cl.run.checkpoint import Keeper
from photizon_cl.run.dask import of_dask
from photizon_cl.run.distribution import Local, Runner, open_chosen
from photizon_cl.run.interruption import interruptible
from photizon_cl.run.memory import check_memory, no_room_for
from photizon_cl.run.pilot import pilot_of_capped
from photizon_cl.run.progress import Clock, Progress
from photizon_cl.run.trails import missing, with_trails
from photizon_cl.run.window import bytes_on_the_way
from photizon_cl.run.workers import Executed
from photizon_cl.version import __version__

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.scene.model import Scene

__all__ = ["go_on", "goal_of", "refine", "with_settings"]

_E = TypeVar("_E", bound=Estimates)


def refine(
    result: _E,
    *,
    target: float | None = None,
    target_on: Sequence[str] | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    plan: ExecutionPlan | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
) -> _E:
    """Add batches to the stream of a result, see `photizon_cl.Result.refine`."""
    if target is None and target_on is None and batches is None:
        goal = result.info.goal
        if max_seconds is not None:
            _check_seconds(result.scene, max_seconds)
            goal = dataclasses.replace(goal, max_seconds=max_seconds)
        compiled = result.compiled
    else:
        as_run = with_settings(
            result.scene, target_sigma=target, target_on=target_on, max_seconds=max_seconds
        )
        goal = goal_of(as_run, batches, target, max_seconds)
        # The stream does not depend on when it stops: the tables stay what they are.
        layout = result.compiled.layout
        layout = dataclasses.replace(layout, watched=watched(as_run, layout, as_run.run.target_on))
        compiled = dataclasses.replace(
            result.compiled, scene=as_run, settings=as_run.run, layout=layout
        )
    if goal.batches is not None and goal.batches < result.batches:
        raise ArgumentError(
            f"batches: found {goal.batches}, expected at least the {result.batches} that the "
            "result has already (the number is that of all batches)"
        )
    forecast = result.info.forecast if goal == result.info.goal else None
    info = dataclasses.replace(result.info, goal=goal, forecast=forecast)
    if not result.batches:
        info = dataclasses.replace(info, version=__version__, engine=engine_digest())
    elif info.engine not in ("", engine_digest()):
        raise ResultError(
            f"the result was made by photizon_cl {info.version} with the engine {info.engine}, and "
            f"this is {__version__} with the engine {engine_digest()}: their batches may differ in "
            "bits and are not mixed; go on with that version, or run the scene again"
        )
    start = type(result)(compiled, result.tally.copy(), info)
    if start.batches and goal.reached(compiled.layout, start.tally):
        info = dataclasses.replace(info, forecast=result.info.forecast)
        start = type(result)(compiled, start.tally, info)
        if not len(missing(start)):
            return start
        return type(result)(compiled, start.tally, with_trails(start, _selector(device)))
    return go_on(start, goal, device, progress, executor, plan, checkpoint)


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


def goal_of(
    scene: Scene, batches: int | None, target: float | None, max_seconds: float | None
) -> Goal:
    """Return what a run is to reach that is given these, the scene's settings for the others.

    Raises
    ------
    ArgumentError
        Where `batches` is no number of batches, or one of too many rays.
    """
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


def go_on(
    start: _E,
    goal: Goal,
    device: DeviceRecord | str | int | None,
    progress: Callable[[Progress], object] | None,
    executor: Executor | None,
    plan: ExecutionPlan | None,
    checkpoint: str | os.PathLike[str] | None,
    keeping: Callable[[str | os.PathLike[str], Estimates], Keeper] = Keeper,
) -> _E:
    """Add batches to a result that nobody else holds until its goal is reached.

    `keeping` makes what writes the checkpoints.
    """
    if progress is not None and not callable(progress):
        raise ArgumentError(f"progress: found {show(progress)}, expected a function or None")
    executor = of_dask(executor)
    plan = _fitting(start.compiled, device, executor, plan, goal, saved=checkpoint is not None)
    keeper = None if checkpoint is None else keeping(checkpoint, start)
    try:
        return _add_batches(start, goal, device, progress, executor, plan, keeper)
    except MemoryError as error:  # others took what was there when it began
        kept = "" if keeper is None else "; its checkpoint is kept, for `photizon resume`"
        raise NoRoomError(
            "no memory was left in mid-run: `photizon check` says what this scene takes; run it "
            f"where more is free, or take fewer bins in maps and far field{kept}"
        ) from error
    finally:
        if keeper is not None:
            keeper.close()


def _fitting(
    compiled: CompiledScene,
    device: DeviceRecord | str | int | None,
    executor: Executor | None,
    plan: ExecutionPlan | None,
    goal: Goal,
    *,
    saved: bool,
) -> ExecutionPlan | None:
    """Return a plan that fits; refuse a run that has no memory, before anything is done for it."""
    tables = compiled.tables
    if executor is not None:  # workers look at what they have themselves
        way = bytes_on_the_way(executor, tables)
        check_memory(compiled, None, None, way, saved=saved, batches=goal.batches)
        return plan
    record = open_chosen(_selector(device)).record
    plan = plan or usual_plan(record, tables)
    return check_memory(compiled, record, plan, saved=saved, batches=goal.batches)


def _selector(device: DeviceRecord | str | int | None) -> DeviceRecord | str | None:
    return str(device) if isinstance(device, int) else device


def _add_batches(
    start: _E,
    goal: Goal,
    device: DeviceRecord | str | int | None,
    progress: Callable[[Progress], object] | None,
    executor: Executor | None,
    plan: ExecutionPlan | None,
    keeper: Keeper | None,
) -> _E:
    compiled, tally, info = start.compiled, start.tally, start.info
    chosen = _selector(device)
    runner: Runner
    if executor is None:
        runner = Local(compiled.tables, chosen, plan)
    else:
        runner = Executed(executor, compiled.scene.digest(), compiled.tables, chosen, plan)
    clock = Clock(goal, tally.batches)
    last = MAX_RAY_NUMBER // compiled.settings.rays_per_batch
    last = last if goal.batches is None else min(last, goal.batches)
    worst, interactions, label, build = info.worst_closure, 0, info.device, 0.0
    full, portable = "", info.portable
    history = History(info.history, info.seconds)
    outlook = Outlook(goal, info.seconds, tally.batches, info.forecast)

    def so_far(stopped: str = "") -> RunInfo:
        seconds = info.seconds + clock.elapsed()
        return dataclasses.replace(
            info,
            device=label,
            interactions=info.interactions + interactions,
            seconds=seconds,
            build_seconds=info.build_seconds + build,
            worst_closure=worst,
            history=history.rows,
            stopped=stopped,
            forecast=outlook.at_end(tally.batches, seconds) if stopped else outlook.kept,
            portable=portable,
        )

    chunks = runner.chunks(tally.batches, last, clock.batches_in_time)
    with interruptible() as interrupted:
        runner.watch(clock, interrupted)
        try:
            for chunk in chunks:
                done = False
                for cells, keyed in zip_longest(chunk.cells, chunk.keyed):
                    whole = complete(compiled.layout, cells)
                    check_paths(compiled.layout, whole, keyed)
                    full = full or no_room_for(whole, tally)
                    if full:
                        break
                    worst = max(worst, check_batch(compiled, tally.batches, whole))
                    tally.add(whole, keyed)
                    interactions += int(whole_of(whole, compiled.layout.interactions, 1)[0, 3])
                    done = goal.reached(compiled.layout, tally)
                    if done:
                        break  # what was computed beyond is dropped: the goal fixes the bits
                label, build = chunk.device, max(build, chunk.build_seconds)
                portable = portable and chunk.portable
                clock.note(tally.batches)
                history.note(compiled.layout, tally, clock.elapsed())
                if not done:
                    outlook.note(compiled.layout, tally, clock.elapsed())
                if keeper is not None:
                    keeper.note(lambda: Estimates(compiled, tally, so_far()))
                if progress is not None:
                    told = outlook.latest
                    progress(Progress.of(compiled, tally, goal, info, interactions, clock, told))
                if done or full or interrupted() or clock.over():
                    break
                del (
                    chunk,
                    cells,
                    whole,
                    keyed,
                )  # the next ones are computed before they are replaced
        finally:
            close = getattr(chunks, "close", None)
            if close is not None:
                close()
        if not tally.batches:
            if interrupted():
                raise KeyboardInterrupt
            raise RunError(full or runner.complaint() or _no_batch(compiled, clock))
        history.note(compiled.layout, tally, clock.elapsed(), last=True)
        full = full or (runner.complaint() if runner.full() else "")
        stopped = "interrupt" if interrupted() else "memory" if full else "time"
        if stopped == "memory":
            warnings.warn(full, RunWarning, stacklevel=4)
        if goal.reached(compiled.layout, tally):
            stopped = "batches" if tally.batches == goal.batches else "target"
        # what was run is kept, with its time, before anything is done to tell more of it
        result = type(start)(compiled, tally, so_far(stopped))
        if keeper is not None:
            keeper.note(lambda: result, last=True)
        if tally.keyed is not None:
            # a run with a time limit ends within a fifth more and two seconds
            spare = None if goal.max_seconds is None else 1.0 + 0.1 * goal.max_seconds
            result = type(start)(compiled, tally, with_trails(result, chosen, spare))
            info = result.info
            if keeper is not None:
                keeper.note(lambda: result, last=True)
        if executor is None and info.pilot is None:
            pilot = pilot_of_capped(
                compiled, tally, chosen, plan, lambda: interrupted() or clock.over()
            )
            if pilot is not None:
                info = dataclasses.replace(result.info, pilot=pilot)
                result = type(start)(compiled, tally, info)
                if keeper is not None:
                    keeper.note(lambda: result, last=True)
    return result


def _no_batch(compiled: CompiledScene, clock: Clock) -> str:
    run = compiled.settings
    advice = "lower rays_per_batch or raise max_seconds"
    splitter = compiled.scene.splitter
    if splitter is not None and compiled.scene.splits(run):
        advice = (
            f'every hit on a surface that splits, as that of "{splitter.name}" does, makes two '
            "rays of one, and where they come back to such a surface little may end them before "
            f"the generation cap of {run.generation_cap}: raise roulette_floor (1e-6, say) or "
            f"lower generation_cap; else {advice}"
        )
    return (
        f"not one batch of {run.rays_per_batch} rays ended within {clock.elapsed():.0f} s "
        f"(max_seconds is {clock.limit:g}), so there is nothing to report: {advice}"
    )
