"""Tracing a scene, and going on with a run that was kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.checks.precision import fitting_mode
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import ArgumentError
from photizon_cl.result.estimates import RunInfo
from photizon_cl.result.statistics import Accumulator
from photizon_cl.run.batches import go_on, goal_of, refine, with_settings
from photizon_cl.run.checkpoint import latest
from photizon_cl.run.engines import taken
from photizon_cl.run.result import Result
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping, Sequence
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.run.progress import Progress
    from photizon_cl.scene.model import Scene

__all__ = ["resume", "trace"]


def trace(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    seed: int | None = None,
    target: float | None = None,
    target_on: Sequence[str] | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    rays_per_batch: int | None = None,
    device: DeviceRecord | str | int | None = None,
    precision: str = "fp64",
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
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
    target_on : sequence of str, optional
        Quantities that must each meet the target, ``["detectors.floor.power"]``; default the
        scene's, and without any the median over its maps, detectors or rows.
    batches : int, optional
        Batches in all.
    max_seconds : float, optional
        Seconds for tracing, from when the program is built. The run ends within a fifth more and
        two seconds, with the batches that are whole, or in an error where there is none.
    device : str, int or DeviceRecord, optional
        As ``photizon devices`` lists it; default ``PHOTIZON_DEVICE``, else the best.
    precision : str, optional
        ``"fp64"``; ``"mixed"``, geometry in single precision and weights in double; or ``"fp32"``,
        single precision throughout. The random stream is the same, and sums are exact in each.
    progress : callable, optional
        Given a `Progress` after each wave.
    executor : concurrent.futures.Executor, optional
        Computes the batches on its workers, each of which opens a device; the same bits. Worker
        processes must be spawned, not forked, once this process has used OpenCL. A task that is
        lost or answered wrongly is asked for again, then traced in this process. A
        `distributed.Client` may stand here as well, and under ``python -m mpi4py.futures`` an
        ``MPIPoolExecutor``.
    workers : int, optional
        Instead, processes of this machine that compute for this call. A CPU device's threads are
        shared out among them.
    scheduler : str, optional
        Instead, the address of a Dask scheduler, ``"tcp://HOST:PORT"``, whose cluster computes.
    plan : ExecutionPlan, optional
        How a device runs a wave; changes no bit.
    checkpoint : str or path, optional
        Directory, made where it is not there, that keeps a checkpoint of the run; `resume` goes on
        with it should the process die. It goes when the result is saved there. Where it cannot be
        written on the way, the run goes on.

    Returns
    -------
    Result
        Its scene is the scene as run: with these settings in ``[run]``.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid, or the precision cannot carry the scene.
    ResultError
        Where `checkpoint` cannot be used, or holds another unfinished run.
    RunError
        Where there is no usable device, or the run fails.

    Warns
    -----
    RunWarning
        Where an executor or a checkpoint fails and the run goes on all the same.
    """
    as_run = with_settings(
        load(scene),
        seed=seed,
        target_sigma=target,
        target_on=target_on,
        max_seconds=max_seconds,
        rays_per_batch=rays_per_batch,
    )
    fitting_mode(precision, as_run)
    goal = goal_of(as_run, batches, target, max_seconds)
    if as_run.run.rays_per_batch < as_run.fewest_rays:
        raise ArgumentError(
            f"rays_per_batch: found {as_run.run.rays_per_batch}, expected at least "
            f"{as_run.fewest_rays}, one for each {as_run.ray_needs}"
        )
    compiled = compile_scene(as_run, as_run.run, precision=precision)
    tally = Accumulator.of(compiled.layout)
    start = Result(compiled, tally, RunInfo(precision=precision, goal=goal))
    with taken(executor, workers, scheduler) as chosen:
        return go_on(start, goal, device, progress, chosen, plan, checkpoint)


def resume(
    path: str | os.PathLike[str],
    *,
    target: float | None = None,
    target_on: Sequence[str] | None = None,
    batches: int | None = None,
    max_seconds: float | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[Progress], object] | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
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
    target_on, max_seconds, device, progress, executor, workers, scheduler, plan : optional
        As in `trace`.

    Raises
    ------
    ResultError
        Where there is no run, or it is damaged.
    ArgumentError, RunError
        As in `trace`.
    """
    start = Result.of(latest(path))
    with taken(executor, workers, scheduler) as chosen:
        return refine(
            start, target=target, target_on=target_on, batches=batches, max_seconds=max_seconds,
            device=device, progress=progress, executor=chosen, plan=plan, checkpoint=path,
        )  # fmt: skip
