"""The result of a trace: what its batches say, going on from them, and keeping them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.result.estimates import Estimates

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    import pandas as pd
    import xarray as xr

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from photizon_cl.run.progress import Progress

__all__ = ["Result", "open_result"]

# What draws, runs or reads is imported where it is called: a result that only tells its numbers
# needs none of it.


class Result(Estimates):
    """What a trace gives. Immutable: `refine` returns a new one.

    Attributes
    ----------
    ledger : Ledger
        Power by where it ended, in watts.
    detectors : mapping of str to DetectorResult
        By element, in the order of the scene.
    far_field : FarFieldResult or None
        Intensity by direction, in W/sr; None where the scene bins none.
    scene : Scene
        The scene as run, with the settings of this run.
    info : RunInfo
        Device, time, interactions.
    """

    @classmethod
    def of(cls, estimates: Estimates) -> Result:
        """Return estimates as a result that can go on and be kept; they share the tally."""
        return cls(estimates.compiled, estimates.tally, estimates.info)

    def __repr__(self) -> str:
        return (
            f"<photizon_cl.Result {self.scene.name!r}: {self.batches} batches, {self.rays} rays, "
            f"{self.tally_digest[:19]}…>"
        )

    # -- other forms ---------------------------------------------------------------------------

    def _repr_html_(self) -> str:
        from photizon_cl.views.report.notebook import html

        return html(self)

    @property
    def recipe(self) -> str:
        """A short token with which ``photizon run --recipe`` makes the same bits again."""
        from photizon_cl.result.recipe import RecipeText

        return RecipeText.of(self).token

    def to_dataframe(self, detector: str | None = None) -> pd.DataFrame:
        """Return the ledger, or a detector's ladder, as a data frame of pandas.

        Maps and the far field have two dimensions and are in `to_dataset`.

        Parameters
        ----------
        detector : str, optional
            Name of a detector with a ladder; without it, the ledger.

        Returns
        -------
        pandas.DataFrame
            Columns ``row``, ``value_W``, ``sigma_W``, ``share``; of a ladder ``generation``,
            ``value_W``, ``sigma_W``, ``share``, ``count``. A share is a part of the emitted power;
            a σ is NaN with a single batch.

        Raises
        ------
        ArgumentError
            Where there is no such detector, or it has no ladder.
        PhotizonError
            Where pandas is not installed.
        """
        from photizon_cl.views.report.notebook import data_frame

        return data_frame(self, detector)

    def to_dataset(self) -> xr.DataTree:
        """Return every array, labelled, as groups of xarray.

        ``ledger`` (``power``, ``sigma`` by ``row``), a group for each detector by the name of its
        element (``power``, and where asked for ``ladder``, ``irradiance``, ``sigma``, ``count``,
        ``area`` with the centres of the bins as coordinates and their edges), ``far_field``
        (``intensity``, ``sigma``, ``count``) and ``tallies`` of effects. Attributes have the units;
        what is an axis label is in ``long_name``, and what it means in ``comment``. A σ is NaN
        with a single batch.

        ``result.nc`` holds the same arrays at one level, named ``DETECTOR.irradiance`` and so on.

        Returns
        -------
        xarray.DataTree
            ``result.to_dataset()["target"]["irradiance"].plot()`` draws a map.
        """
        from photizon_cl.result.arrays import tree

        return tree(self)

    # -- going on, keeping ---------------------------------------------------------------------

    def refine(
        self,
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
        checkpoint: str | os.PathLike[str] | None = None,
    ) -> Result:
        """Go on with the same stream and return the result of all batches; this one stays.

        The outcome is bit for bit that of one uninterrupted run.

        Parameters
        ----------
        target : float, optional
            Relative standard error to reach.
        target_on : sequence of str, optional
            Quantities that must each meet it, or, given alone, the scene's target; default those
            that the run had.
        batches : int, optional
            Batches in all, the ones that are there included. Without either, the goal that the run
            had holds.
        max_seconds : float, optional
            Seconds that this call may take.
        device, progress, executor, workers, scheduler, plan, checkpoint : optional
            As in `photizon_cl.trace`.

        Raises
        ------
        ArgumentError
            Where an argument is not valid, or `batches` are fewer than there are.
        RunError
            Where the run fails.
        """
        from photizon_cl.run.batches import refine
        from photizon_cl.run.engines import taken

        with taken(executor, workers, scheduler) as chosen:
            return refine(
                self,
                target=target,
                target_on=target_on,
                batches=batches,
                max_seconds=max_seconds,
                device=device,
                progress=progress,
                executor=chosen,
                plan=plan,
                checkpoint=checkpoint,
            )

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        figures: bool = True,
        formats: str | Sequence[str] = ("png",),
        replace: bool = False,
    ) -> None:
        """Write the result into a directory, which is made where it is not there.

        ``summary.json``, ``scene.toml`` (as run), ``result.nc`` (every array with its coordinates
        and units, and the exact tallies that `refine` goes on from), ``ledger.csv`` and
        ``detectors.csv`` (totals and ladders), ``tally-EFFECT.csv`` for each effect in `tallies`,
        ``recipe.txt`` and ``figures/``. Each file is replaced in one step, and the run's checkpoint
        there goes. An earlier result of the same run is replaced, but for one with more batches;
        that of another scene or of other settings only where `replace` says so. Files that were not
        written here, or were changed since, are never replaced.

        Parameters
        ----------
        path : str or path
            The directory.
        figures : bool, optional
            Whether to draw figures.
        formats : str or sequence of str, optional
            In which formats: one or some of ``"png"``, ``"svg"`` and ``"pdf"``.
        replace : bool, optional
            Whether the result of another scene, seed or setting that is there may go.

        Raises
        ------
        ArgumentError
            Where a format is another one.
        ResultError
            Where the directory holds files and no result, or another's result, or files of these
            names that were not written here; where a run is writing to it, or it cannot be written.

        Warns
        -----
        RunWarning
            Where there is no memory for figures; all else is written then.
        """
        from photizon_cl.run.directory import save

        save(self, path, figures=figures, formats=formats, replace=replace)


def open_result(path: str | os.PathLike[str]) -> Result:
    """Return a result that was saved.

    Parameters
    ----------
    path : str or path
        The directory, or the ``result.nc`` in it; both give the same numbers, to the bit.

    Raises
    ------
    ResultError
        Where there is no result, it is damaged, it holds no batch yet, or there is no memory for
        its maps and far field.
    """
    from photizon_cl.run.directory import open_directory

    return Result.of(open_directory(path))
