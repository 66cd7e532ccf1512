"""Checkpoints: what a run under way needs to go on after it was killed.

``checkpoint.nc`` is a ``result.nc`` without the arrays: scene, goal and exact tallies. It is there
while a run writes to its directory, from before the first batch on, and goes when the result is
saved. Whatever the moment of death, the run goes on from a whole number of batches, and since a
batch depends on nothing but its number, to the same bits.
"""

from __future__ import annotations

import os
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import reason, replacing
from photizon_cl.errors import ArgumentError, ResultError, RunError, RunWarning, show
from photizon_cl.result.file import write_state
from photizon_cl.result.sweep_file import SWEEP_FILE
from photizon_cl.run.directory import ARRAYS, CHECKPOINT, check_there, read, steady, unfinished
from photizon_cl.run.target import check_target, claim

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.result.estimates import Estimates

__all__ = ["Keeper", "latest"]

PERIOD: Final = 2.0
"""Seconds between checkpoints at least."""
_SHARE: Final = 0.02
"""Part of a run's time that checkpoints may take."""
_AGAIN: Final = 10.0
"""Seconds after which one that could not be written is tried again."""


class Keeper:
    """Writes the checkpoints of a run.

    Parameters
    ----------
    path : str or path
        The directory; made where it is not there, and held until the keeper is closed.
    start : Estimates
        What the run starts from; written at once, so that its goal is known.
    at_once : bool, optional
        Whether it is: not where the goal is known otherwise, as that of a point of a sweep.

    Raises
    ------
    ResultError
        Where it cannot be used, is in use, holds another unfinished run, or what is not ours.
    RunError
        Where the first checkpoint cannot be written.
    """

    def __init__(
        self, path: str | os.PathLike[str], start: Estimates, *, at_once: bool = True
    ) -> None:
        import h5netcdf  # noqa: F401  (what is imported once is no part of a checkpoint's cost)
        import xarray  # noqa: F401

        folder = check_target(path)
        self._file = folder / CHECKPOINT
        self._lock = claim(folder)
        self._cost, self._written = 0.0, time.perf_counter()
        self._failed = False
        try:
            check_there(folder, start)
            if at_once:
                self._write(start)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let other runs have the directory."""
        self._lock.free()

    def note(self, now: Callable[[], Estimates], *, last: bool = False) -> None:
        """Write a checkpoint where one is due or the run ends; `now` gives the result so far.

        Where it cannot be written the run goes on, and it is tried again: a full disk may be
        emptied, and a share that is away may come back.
        """
        least = _AGAIN if self._failed else PERIOD
        due = self._written + max(least, self._cost / _SHARE)
        if not last and time.perf_counter() < due:
            return
        try:
            self._write(now())
        except RunError as error:
            self._written = time.perf_counter()
            if not self._failed or last:
                what = "" if last else "; the run goes on, and it is tried again"
                warnings.warn(f"{error}{what}", RunWarning, stacklevel=2)
            self._failed = True
        else:
            self._failed = False

    def _write(self, result: Estimates) -> None:
        started = time.perf_counter()
        try:
            with replacing(self._file) as temporary:
                write_state(result, temporary)
        except (OSError, RuntimeError) as error:  # HDF5 raises either
            raise RunError(
                f"{show(str(self._file))} cannot be written: {reason(error)}; the "
                "checkpoint before it, if there is one, is kept for `photizon resume`"
            ) from error
        self._written = time.perf_counter()
        self._cost = self._written - started


def latest(path: str | os.PathLike[str]) -> Estimates:
    """Return what a directory's run has reached: its checkpoint, else its result.

    The result may have no batch yet.

    Raises
    ------
    ResultError
        Where there is neither, or it is damaged.
    """
    if not str(path):
        raise ArgumentError("DIR: found nothing, expected a directory")
    folder = Path(os.fsdecode(path))
    if folder.is_file():
        raise ResultError(
            f"{show(str(folder))} is a file: give the directory that `photizon run --out` wrote"
        )
    return steady(folder, lambda: _latest(folder))


def _latest(folder: Path) -> Estimates:
    left = unfinished(folder)
    if left is None and folder.is_dir() and not (folder / ARRAYS).exists():
        if (folder / SWEEP_FILE).is_file():
            raise ResultError(
                f"{show(str(folder))} holds a sweep: `photizon resume`, or the resume() of "
                "pz.open_sweep, goes on with it"
            )
        raise ResultError(
            f"{show(str(folder))} holds neither a result nor a checkpoint: give the directory "
            "that `photizon run --out` wrote"
        )
    if left is not None and not (folder / ARRAYS).is_file():
        return left
    whole = read(folder)
    if left is None:
        return whole
    # the same run begun anew over its own result: nothing that is there is lost
    return whole if whole.stream == left.stream and whole.batches > left.batches else left
