"""The directory of a sweep.

``sweep.json`` is the sweep, with its scene; ``points/0017`` the directory of point 17, with the
result of its run as ``photizon run --out`` writes one, its checkpoint while it is under way, and
``point.json``, which is written last and says that it is done. ``sweep.nc``, ``sweep.csv`` and
``sweep.png`` are made of the points. Whatever the moment at which a sweep dies, a point is done and
never run again, or goes on from its last checkpoint, or has not begun.
"""

from __future__ import annotations

import os
import warnings
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import TEMPORARY, reason, replacing
from photizon_cl.errors import ArgumentError, ResultError, RunError, RunWarning, show
from photizon_cl.result.engine import engine_digest
from photizon_cl.result.sweep import empty_point
from photizon_cl.result.sweep_file import (
    POINT_FILE,
    SWEEP_ARRAYS,
    SWEEP_FILE,
    SWEEP_TABLE,
    differs,
    plan_text,
    point_text,
    read_plan,
    read_point,
)
from photizon_cl.run.directory import ARRAYS, read, save, unfinished
from photizon_cl.run.result import Result
from photizon_cl.run.target import held

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.sweep import SweepPoint, SweepTable
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sweeps import SweepPlan

__all__ = ["SWEEP_FIGURE", "SweepFolder", "is_sweep"]

SWEEP_FIGURE: Final = "sweep.png"
_POINTS: Final = "points"
_LAST: Final = "summary.json"
"""The file that is written last of a result."""


def is_sweep(path: str | os.PathLike[str]) -> bool:
    """Say whether a directory is that of a sweep."""
    try:
        return (Path(os.fsdecode(path)) / SWEEP_FILE).is_file()
    except (OSError, ValueError):
        return False


class SweepFolder:
    """The directory of a sweep.

    Parameters
    ----------
    path : str or path
        It need not be there.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.folder = Path(os.fsdecode(path))
        self.shown = show(str(self.folder))

    def plan(self) -> SweepPlan:
        """Return the sweep that is there.

        Raises
        ------
        ResultError
            Where there is none, or it is damaged.
        """
        if not is_sweep(self.folder):
            raise ResultError(
                f"{self.shown} holds no sweep: give the directory that `photizon sweep --out` wrote"
            )
        return read_plan(self.folder / SWEEP_FILE)

    def check_new(self, plan: SweepPlan, names: tuple[str, ...]) -> bool:
        """See that a sweep may be written there; say whether the very same one is there, done.

        Raises
        ------
        ResultError
            Where there is another sweep, an unfinished one, or something else.
        """
        try:
            if self.folder.exists() and not self.folder.is_dir():
                raise ResultError(f"{self.shown} is a file: give a directory for the sweep")
            there = {e.name for e in self.folder.iterdir()} if self.folder.exists() else set()
        except (OSError, ValueError) as error:
            raise ResultError(f"{self.shown} cannot be used: {reason(error)}") from None
        if SWEEP_FILE not in there:
            others = sorted(name for name in there if not name.startswith(TEMPORARY))
            if others:
                raise ResultError(
                    f"{self.shown} holds files and no sweep ({', '.join(map(show, others[:3]))}): "
                    "give a new or empty directory, so that nothing is overwritten"
                )
            return False
        own = self.plan()
        other = differs(own, plan)
        if other:
            raise ResultError(
                f"{self.shown} holds another sweep of {own.scene.name!r}: {other} differ"
                f"{'s' * (' and ' not in other)}; give another directory, so that its points are "
                "kept"
            )
        done = sum(point.done for point in self.points(own, names))
        if done < len(own):
            raise ResultError(
                f"{self.shown} holds this sweep, unfinished, with {done} of {len(own)} points "
                "done: `photizon resume` goes on with it"
            )
        return True

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the directory, which is made where it is not there."""
        with held(self.folder):
            yield

    def begin(self, plan: SweepPlan) -> None:
        """Write what the sweep is."""
        self._write(SWEEP_FILE, plan_text(plan))

    def _write(self, name: str, text: str) -> None:
        try:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            with replacing(self.folder / name) as temporary:
                temporary.write_text(text, encoding="utf-8", newline="")
        except OSError as error:
            raise RunError(f"{self.shown}: {name} cannot be written: {reason(error)}") from error

    # -- points --------------------------------------------------------------------------------

    def home(self, number: int) -> Path:
        """Return the directory of a point."""
        return self.folder / _POINTS / f"{number:04d}"

    def points(self, plan: SweepPlan, names: tuple[str, ...]) -> list[SweepPoint]:
        """Return all points: those that are done as they were written, the others empty."""
        return [self.point(plan, number, names) for number in range(len(plan))]

    def point(self, plan: SweepPlan, number: int, names: tuple[str, ...]) -> SweepPoint:
        """Return a point, empty where it is not done."""
        file = self.home(number) / POINT_FILE
        empty = empty_point(number, plan)
        return read_point(file, number, empty.values, names) if file.is_file() else empty

    def left(self, number: int, scene: Scene, precision: str) -> tuple[Estimates | None, bool]:
        """Return what there is of a point that is not done, and whether its run had ended.

        Raises
        ------
        ResultError
            Where what is there is damaged, of another scene, or of another engine.
        """
        home = self.home(number)
        whole = (home / ARRAYS).is_file()
        found = read(home) if whole else unfinished(home)
        if found is None:
            return None, False
        if found.stream != (scene.digest(), precision):
            raise ResultError(f"{show(str(home))} holds a run that is none of this sweep")
        self.check_engine(found.info.engine, found.batches)
        return found, whole

    def check_engine(self, engine: str, batches: int) -> None:
        """Refuse to mix points of several engines."""
        if batches and engine != engine_digest():
            raise ResultError(
                f"{self.shown} was made by the engine {engine}, and this is {engine_digest()}: "
                "points of both may differ in bits and are not mixed; go on with that version, or "
                "run the sweep again, in another directory"
            )

    def keep(self, number: int, result: Result) -> None:
        """Write a point's result, unless all of it is there.

        Raises
        ------
        RunError
            Where it cannot be written: what is there is kept, for the sweep to be gone on with.
        """
        home = self.home(number)
        if (home / ARRAYS).is_file() and (home / _LAST).is_file():
            return
        try:
            save(result, home, figures=False, replace=True)
        except ResultError as error:
            raise RunError(
                f"{error}; the sweep ends at point {number}: `photizon resume` goes on with it"
            ) from error

    def end(self, point: SweepPoint) -> None:
        """Write that a point is done."""
        self._write(f"{_POINTS}/{point.number:04d}/{POINT_FILE}", point_text(point))

    def open(self, number: int) -> Result:
        """Return a point's result."""
        return Result.of(read(self.home(number)))

    # -- what is made of them ------------------------------------------------------------------

    def write_tables(self, sweep: SweepTable, *, figure: bool) -> None:
        """Write the tables, and the figure where anything can be drawn."""
        self._write(SWEEP_TABLE, sweep.to_csv())
        try:
            arrays = sweep.to_dataset()
            arrays.attrs["programs"] = sweep.programs or 0  # that the last call needed
            with replacing(self.folder / SWEEP_ARRAYS) as temporary:
                arrays.to_netcdf(temporary, engine="h5netcdf")
        except (OSError, RuntimeError) as error:  # HDF5 raises either
            raise RunError(
                f"{self.shown}: {SWEEP_ARRAYS} cannot be written: {reason(error)}"
            ) from error
        if figure and sweep.n_done:
            self._draw(sweep)

    def _draw(self, sweep: SweepTable) -> None:
        from photizon_cl.views.figures.style import replace_figure, write
        from photizon_cl.views.figures.sweep_plot import draw_sweep

        file = self.folder / SWEEP_FIGURE
        try:
            replace_figure(file, lambda path: write(lambda: draw_sweep(sweep), path, "png"))
        except ArgumentError as error:
            warnings.warn(f"no figure is drawn: {error}", RunWarning, stacklevel=4)
        except OSError as error:
            raise RunError(f"{show(str(file))} cannot be written: {reason(error)}") from error
