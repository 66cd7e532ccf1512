"""Sweeps: `photizon_cl.sweep`, and what it gives."""

from __future__ import annotations

import os
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photizon_cl.errors import ArgumentError, ResultError, show
from photizon_cl.result.measures import measured_by
from photizon_cl.result.sweep import SweepTable
from photizon_cl.run.distribution import open_chosen
from photizon_cl.run.engines import taken
from photizon_cl.scene.sweep_reader import read_sweep
from photizon_cl.studies.sweep_folder import SweepFolder
from photizon_cl.studies.sweep_points import checked, measures_at
from photizon_cl.studies.sweep_progress import SweepProgress
from photizon_cl.studies.sweeping import Job, check_seconds, no_folder

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from concurrent.futures import Executor

    import pandas as pd

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.result.measures import Measured
    from photizon_cl.run.result import Result
    from photizon_cl.studies.sweep_points import Checked

__all__ = ["Sweep", "open_sweep", "sweep"]


class Sweep(SweepTable):
    """What a sweep gives: a table of its points, with errors. Immutable.

    ``sweep[17]`` is a `SweepPoint`, with ``sweep[17]["PST"]`` and its ``sigma``; iterating gives
    all. ``sweep.difference("PST", 0, 17)`` is paired.

    Attributes
    ----------
    points : tuple of SweepPoint
        All points, run or not.
    names : tuple of str
        What was measured.
    programs : int or None
        Different programs that this call's points needed.
    folder : Path or None
        Where it is kept.
    interrupted : bool
        Whether Ctrl-C ended the call.
    """

    def open(self, number: int) -> Result:
        """Return the result of a point, as `photizon_cl.open_result` does.

        Raises
        ------
        ArgumentError
            Where there is no such point, or it has not been run.
        ResultError
            Where the sweep was kept in no directory.
        """
        if not -len(self) <= number < len(self):
            raise ArgumentError(f"point: found {number}, expected one below {len(self)}")
        if self.folder is None:
            raise no_folder()
        point = self.points[number]
        if not point.done:
            raise ArgumentError(f"point {point.number} has not been run")
        return SweepFolder(self.folder).open(point.number)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the table as a data frame of pandas, a row for each point.

        Columns ``point``, the axes, ``NAME``, ``NAME_sigma``, ``NAME_change`` and
        ``NAME_change_sigma`` of each measure, ``batches``, ``rays``, ``seconds``, ``stopped`` and
        ``digest``; NaN where a point has not been run.

        Raises
        ------
        PhotizonError
            Where pandas is not installed.
        """
        from photizon_cl.views.report.notebook import sweep_frame

        return sweep_frame(self)

    def resume(
        self,
        *,
        max_seconds: float | None = None,
        device: DeviceRecord | str | int | None = None,
        progress: Callable[[SweepProgress], object] | None = None,
        executor: Executor | None = None,
        workers: int | None = None,
        scheduler: str | None = None,
        plan: ExecutionPlan | None = None,
        figure: bool = True,
    ) -> Sweep:
        """Go on with a sweep in its directory; return it with what was left.

        Points that are done are not run again, one that was begun goes on from its last checkpoint:
        the outcome is that of one uninterrupted sweep, bit for bit. Points that failed are tried
        again.

        Parameters
        ----------
        max_seconds, device, progress, executor, workers, scheduler, plan, figure : optional
            As in `photizon_cl.sweep`.

        Raises
        ------
        ResultError
            Where the sweep was kept in no directory, or what is there is damaged or was made by
            another version of the engine.
        RunError
            Where there is no usable device.
        """
        if self.folder is None:
            raise no_folder()
        folder = SweepFolder(self.folder)
        return _run(
            checked(folder.plan(), _teller(progress, len(self))), folder,
            max_seconds=max_seconds, device=device, progress=progress,
            executor=executor, workers=workers, scheduler=scheduler, plan=plan, figure=figure,
        )  # fmt: skip


def sweep(
    source: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    batches: int | None = None,
    target: float | None = None,
    rays_per_batch: int | None = None,
    precision: str | None = None,
    max_seconds: float | None = None,
    device: DeviceRecord | str | int | None = None,
    progress: Callable[[SweepProgress], object] | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    plan: ExecutionPlan | None = None,
    figure: bool = True,
) -> Sweep:
    """Trace a scene at many values of its parameters.

    Every point is looked at before any is run. Each is then traced exactly as `trace` would trace
    its scene, with the same seed, so that differences between points are paired; all share one
    program where only values change. A point that fails is told in the table, and the others go on.
    Ctrl-C ends the sweep with the points that are done.

    Parameters
    ----------
    source : str, path or mapping
        A sweep file, or its tables, in which ``scene`` may be a `Scene`.
    out : str or path, optional
        Directory, new or empty, for the results of all points, tables and a figure. Only what is
        kept there can be gone on with, by `Sweep.resume` or ``photizon resume``.
    seed, batches, target, rays_per_batch, precision : optional
        As in `trace`, for every point; they go before the file's ``[run]``.
    max_seconds : float, optional
        Seconds that this call may take, all points together; the sweep is then unfinished. The
        ``max_seconds`` of ``[run]`` is that of each point.
    device : str, int or DeviceRecord, optional
        As in `trace`.
    progress : callable, optional
        Given a `photizon_cl.studies.sweep_progress.SweepProgress` after each wave.
    executor : concurrent.futures.Executor, optional
        Computes the batches of one point after the other on its workers; the same bits.
    workers, scheduler : optional
        As in `trace`.
    plan : ExecutionPlan, optional
        How a device runs a wave; changes no bit.
    figure : bool, optional
        Whether to draw a figure into `out`.

    Returns
    -------
    Sweep

    Raises
    ------
    SceneError, ArgumentError
        Where the sweep file, a point or an argument is not valid.
    ResultError
        Where `out` cannot be used, or holds another sweep, or this one unfinished.
    RunError
        Where there is no usable device.

    Examples
    --------
    >>> import photizon_cl as pz
    >>> file = {
    ...     "schema": "photizon-sweep/1",
    ...     "scene": "integrating-sphere",
    ...     "vary": [{"path": "element.wall.surface.reflectance", "values": [0.9, 0.95]}],
    ...     "measure": {"escaped": "ledger.escaped"},
    ... }
    >>> found = pz.sweep(file, batches=8, rays_per_batch=256)
    >>> found.difference("escaped", 0, 1).paired
    True
    """
    given = {
        "seed": seed,
        "batches": batches,
        "target_sigma": target,
        "rays_per_batch": rays_per_batch,
        "precision": precision,
    }
    if isinstance(source, str | os.PathLike) and Path(os.fsdecode(source)).is_dir():
        raise ResultError(
            f"{show(os.fsdecode(source))} is a directory: pz.open_sweep opens that of a sweep, and "
            "its resume() goes on with it"
        )
    asked = read_sweep(source, {name: value for name, value in given.items() if value is not None})
    check_seconds(max_seconds)
    found = checked(asked, _teller(progress, len(asked)))
    folder = None if out is None else SweepFolder(out)
    if folder is not None:
        names = tuple(measure.name for measure in found.measured)
        if folder.check_new(asked, names):
            return open_sweep(folder.folder)
    if executor is None and workers is None and scheduler is None:
        open_chosen(str(device) if isinstance(device, int) else device)  # before DIR is made
    return _run(
        found, folder, max_seconds=max_seconds, device=device, progress=progress,
        executor=executor, workers=workers, scheduler=scheduler, plan=plan, figure=figure,
        begin=True,
    )  # fmt: skip


def _teller(
    progress: Callable[[SweepProgress], object] | None, points: int
) -> Callable[[str], object]:
    """Return what tells that points are looked at."""
    if progress is None:
        return lambda _: None
    return lambda text: progress(SweepProgress(points, 0, -1, text, None, 0.0, None))


def _run(
    found: Checked,
    folder: SweepFolder | None,
    *,
    max_seconds: float | None,
    device: DeviceRecord | str | int | None,
    progress: Callable[[SweepProgress], object] | None,
    executor: Executor | None,
    workers: int | None,
    scheduler: str | None,
    plan: ExecutionPlan | None,
    figure: bool,
    begin: bool = False,
) -> Sweep:
    held = nullcontext() if folder is None else folder.held()
    with taken(executor, workers, scheduler) as chosen, held:
        job = Job(
            found, folder, device=device, executor=chosen, plan=plan,
            progress=progress or (lambda _: None), max_seconds=check_seconds(max_seconds),
        )  # fmt: skip
        if begin and folder is not None:
            # looked at again, now that nobody else can write there
            if folder.check_new(found.plan, job.names):
                return open_sweep(folder.folder)
            folder.begin(found.plan)
        job.run()
        made = Sweep(
            found.plan,
            found.measured,
            tuple(job.points),
            len(job.specs) or None,
            job.of_batches,
            None if folder is None else folder.folder,
            job.interrupted,
        )
        if folder is not None:
            folder.write_tables(made, figure=figure)
    return made


def open_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Return a sweep that was kept, finished or not.

    Parameters
    ----------
    path : str or path
        The directory that ``photizon sweep --out`` or ``sweep(out=…)`` wrote.

    Raises
    ------
    ResultError
        Where there is no sweep, or it is damaged.
    """
    folder = SweepFolder(path)
    asked = folder.plan()
    measured = measures_at(asked)
    points = folder.points(asked, tuple(measure.name for measure in measured))

    def of_batches(number: int) -> Mapping[str, Measured]:
        return measured_by(measured, folder.open(number))

    return Sweep(asked, measured, tuple(points), None, of_batches, folder.folder)
