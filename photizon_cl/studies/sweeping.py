"""Running a sweep: point after point, each exactly as a trace of its scene would be."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import ArgumentError, ResultError, RunError
from photizon_cl.result.batch_values import MOST_VALUES
from photizon_cl.result.estimates import RunInfo
from photizon_cl.result.measures import measured_by
from photizon_cl.result.statistics import Accumulator
from photizon_cl.result.sweep import empty_point, point_of, with_change
from photizon_cl.run.batches import go_on
from photizon_cl.run.checkpoint import Keeper
from photizon_cl.run.distribution import open_chosen
from photizon_cl.run.interruption import interruptible
from photizon_cl.run.result import Result
from photizon_cl.studies.sweep_progress import SweepClock, SweepProgress

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping
    from concurrent.futures import Executor

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.program.spec import ProgramSpec
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.measures import Measured
    from photizon_cl.result.stopping import Goal
    from photizon_cl.result.sweep import SweepPoint
    from photizon_cl.run.progress import Progress
    from photizon_cl.studies.sweep_folder import SweepFolder
    from photizon_cl.studies.sweep_points import Checked

__all__ = ["Job"]

_REACHED: Final = ("batches", "target")
_ENDED: Final = (*_REACHED, "time", "memory")


class PointKeeper(Keeper):
    """Writes the checkpoints of a point on its way: none before, and none where it has ended.

    The sweep's file knows its goal, and its result is written at once.
    """

    def __init__(self, path: str | os.PathLike[str], start: Estimates) -> None:
        super().__init__(path, start, at_once=False)

    def note(self, now: Callable[[], Estimates], *, last: bool = False) -> None:
        """Write a checkpoint where one is due, or the run ends before its goal."""
        if not (last and now().info.stopped in _REACHED):
            super().note(now, last=last)


class Job:
    """A sweep under way.

    Parameters
    ----------
    checked : Checked
        The sweep.
    folder : SweepFolder or None
        Where its points are kept; the caller holds it.
    device, executor, plan
        As `photizon_cl.trace` takes them.
    progress : callable
        Given a `SweepProgress`.
    max_seconds : float or None
        That this call may take.
    """

    def __init__(
        self,
        checked: Checked,
        folder: SweepFolder | None,
        *,
        device: DeviceRecord | str | int | None,
        executor: Executor | None,
        plan: ExecutionPlan | None,
        progress: Callable[[SweepProgress], object],
        max_seconds: float | None,
    ) -> None:
        self.checked, self.plan, self.folder = checked, checked.plan, folder
        self.device = str(device) if isinstance(device, int) else device
        self.executor, self.how, self.progress = executor, plan, progress
        self.clock = SweepClock(max_seconds)
        self.names = tuple(measure.name for measure in checked.measured)
        self.points: list[SweepPoint] = [
            empty_point(number, self.plan) for number in range(len(self.plan))
        ]
        self.batch_values: dict[int, Mapping[str, Measured]] = {}
        self.specs: set[ProgramSpec] = set()
        self.interrupted = False

    def run(self) -> None:
        """Run every point that is not done, until time is over or Ctrl-C is pressed.

        Raises
        ------
        RunError
            Where there is no usable device.
        ResultError
            Where what is kept cannot be gone on with.
        """
        if self.folder is not None:
            self.points = self.folder.points(self.plan, self.names)
            for point in self.points:
                self.folder.check_engine(point.engine, point.batches)
        todo = [point.number for point in self.points if not point.done]
        if todo and self.executor is None:
            open_chosen(self.device)  # without one no point could be run
        with interruptible() as asked:
            for at, number in enumerate(todo):
                if asked() or self.clock.over():
                    break
                self.clock.begin()
                made = self._point(number, len(todo) - at - 1, asked)
                if made is None:
                    break
                self.points[number] = made
                self.clock.end()
            self.interrupted = asked()
        if self.folder is not None:
            self._fill_changes()

    # -- a point -------------------------------------------------------------------------------

    def _point(self, number: int, behind: int, asked: Callable[[], bool]) -> SweepPoint | None:
        """Run a point, or what is left of it; None where the call is to end before it has."""
        scene = self.plan.scene_at(number)
        self._tell(number, behind, None)
        result = None
        if self.folder is not None:
            found, whole = self.folder.left(number, scene, self.checked.precision)
            result = Result.of(found) if found is not None else None
            if whole and result is not None:  # it died between its run and the last file
                return self._ended(number, result)
        goal = self.checked.goal(scene)
        compiled = self.checked.compiled(scene)
        self.specs.add(compiled.tables.spec)
        if result is None:
            tally = Accumulator.of(compiled.layout)
            result = Result(compiled, tally, RunInfo(precision=self.checked.precision, goal=goal))
        else:
            result = Result(compiled, result.tally, result.info)
        if result.batches and goal.reached(compiled.layout, result.tally):
            # it died behind its last batch, before it could say so
            ended = "batches" if result.batches == goal.batches else "target"
            info = dataclasses.replace(result.info, stopped=ended)
            result = Result(compiled, result.tally, info)
        else:
            limited, ours = self._limited(goal, result)
            try:
                result = go_on(
                    result, limited, self.device,
                    lambda now: self._tell(number, behind, now),
                    self.executor, self.how,
                    None if self.folder is None else self.folder.home(number),
                    PointKeeper,
                )  # fmt: skip
            except KeyboardInterrupt:
                if asked():
                    return None  # before its first batch
                raise
            except RunError as error:
                if ours and self.clock.over():
                    return None
                return empty_point(number, self.plan, " ".join(str(error).split()))
            stopped = result.info.stopped
            if stopped not in _ENDED or (stopped == "time" and ours):
                return None
        return self._ended(number, result)

    def _limited(self, goal: Goal, result: Result) -> tuple[Goal, bool]:
        """Return the goal within what time is left, and whether it is this call's that is."""
        own = goal.max_seconds
        if own is not None:  # what earlier calls took of it
            own = max(own - result.info.seconds, 1e-3)
        left = self.clock.left()
        if left is None or (own is not None and own <= left):
            return dataclasses.replace(goal, max_seconds=own), False
        return dataclasses.replace(goal, max_seconds=max(left, 1e-3)), True

    def _ended(self, number: int, result: Result) -> SweepPoint:
        """Keep a point that has been run."""
        measured = measured_by(self.checked.measured, result)
        point = point_of(number, self.plan, result, measured)
        if self.folder is None:
            self._remember(number, measured)
        else:
            self.folder.keep(number, result)
        firsts = measured if number == 0 else self.firsts()
        if firsts is not None:
            point = with_change(point, point if number == 0 else self.points[0], measured, firsts)
        if self.folder is not None:
            if number == 0:
                self.batch_values[0] = measured
            self.folder.end(point)
        return point

    def _remember(self, number: int, measured: Mapping[str, Measured]) -> None:
        """Keep what each batch gave, while that is not too much."""
        self.batch_values[number] = measured
        kept = sum(
            0 if m.batches is None else len(m.batches)
            for point in self.batch_values.values()
            for m in point.values()
        )
        if kept > MOST_VALUES:
            self.batch_values[number] = {
                name: dataclasses.replace(m, batches=None) for name, m in measured.items()
            }

    def firsts(self) -> Mapping[str, Measured] | None:
        """Return what each batch of the first point gave; None where it has not been run."""
        if not self.points[0].done:
            return None
        if 0 not in self.batch_values and self.folder is not None:
            try:
                self.batch_values[0] = self.of_batches(0)
            except ResultError:  # somebody took it away: what was measured there is known
                self.batch_values[0] = {}
        return self.batch_values.get(0)

    def of_batches(self, number: int) -> Mapping[str, Measured]:
        """Return what each batch of a point gave."""
        if self.folder is None:
            return self.batch_values.get(number, {})
        result = self.folder.open(number)
        return measured_by(self.checked.measured, result)

    def _fill_changes(self) -> None:
        """Say what points differ by from the first one that were run before it."""
        assert self.folder is not None
        firsts = None
        for point in self.points:
            if not point.done or point.change or not self.points[0].done:
                continue
            firsts = firsts or self.firsts()
            if firsts is None:
                return
            own = self.of_batches(point.number)
            changed = with_change(point, self.points[0], own, firsts)
            self.points[point.number] = changed
            self.folder.end(changed)

    def _tell(self, number: int, behind: int, now: Progress | None) -> None:
        self.progress(
            SweepProgress(
                points=len(self.plan),
                done=sum(point.done for point in self.points),
                number=number,
                doing=self.plan.said(number),
                point=now,
                seconds=self.clock.elapsed(),
                eta_seconds=self.clock.eta(behind, now),
            )
        )


def check_seconds(max_seconds: Any) -> float | None:
    """Return the seconds that a call may take.

    Raises
    ------
    ArgumentError
        Where it is no positive number.
    """
    if max_seconds is None:
        return None
    good = isinstance(max_seconds, int | float) and not isinstance(max_seconds, bool)
    if not (good and 0.0 < max_seconds <= 1e9):
        raise ArgumentError(
            f"max_seconds: found {max_seconds!r}, expected a positive time in seconds, up to 1e9"
        )
    return float(max_seconds)


def no_folder() -> ResultError:
    """Return the error that a sweep was kept nowhere."""
    return ResultError("the sweep was kept in no directory: give out= to have its points' results")
