"""What a sweep gives: a point for each set of values, with what was measured there."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import ArgumentError, ResultError
from photizon_cl.result.comparison import Difference, difference_of
from photizon_cl.result.ledger import Estimate
from photizon_cl.result.sweep_arrays import SWEEP_RESULT_SCHEMA, dataset, table
from photizon_cl.scene.names import unknown_name
from photizon_cl.scene.sweep_values import plain_value

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

    import xarray as xr

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.measures import Measure, Measured
    from photizon_cl.scene.sweeps import SweepPlan

__all__ = ["SweepPoint", "SweepTable", "compared", "empty_point", "point_of", "with_change"]


_NAMED: Final = 12
"""Points that an advisory of several names."""
_NUMBERS: Final = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


@dataclass(frozen=True)
class SweepPoint:
    """A point of a sweep: what was set, and what came out.

    Parameters
    ----------
    number : int
        Its place in the sweep, from 0; the last axis changes fastest.
    values : mapping
        What each axis is set to, by its name.
    digest : str
        Of its tallies; empty where it has not been run.
    measures : mapping of str to Estimate
        What was measured: a number, with its ``sigma``, and ``count`` where arrivals are counted;
        NaN for a ratio to nothing. Empty where it has not been run.
    change : mapping of str to Estimate
        Difference of each from the first point, paired batch by batch where both share a stream,
        with its own ``sigma``.
    scene_digest : str
        Of its scene as run.
    seed, rays_per_batch, batches : int
        Its stream.
    seconds : float
        That tracing it took.
    stopped : str
        What ended it: ``batches``, ``target``, ``time`` or ``memory``; ``failed`` where it has no
        result; empty where it has not been run.
    why : str
        Why it failed.
    engine : str
        Digest of the sources that fix its bits.
    advisories : tuple of str
        What deserves a second look, such as a σ that is not to be believed yet.
    """

    number: int
    values: Mapping[str, Any]
    digest: str = ""
    measures: Mapping[str, Estimate] = field(default_factory=dict)
    change: Mapping[str, Estimate] = field(default_factory=dict)
    scene_digest: str = ""
    seed: int = 0
    rays_per_batch: int = 0
    batches: int = 0
    seconds: float = 0.0
    stopped: str = ""
    why: str = ""
    engine: str = ""
    advisories: tuple[str, ...] = ()

    @property
    def done(self) -> bool:
        """Whether it has been run."""
        return bool(self.digest)

    @property
    def rays(self) -> int:
        """Rays launched."""
        return self.batches * self.rays_per_batch

    def __getitem__(self, name: str) -> Estimate:
        if name not in self.measures:
            raise unknown_name(f"point {self.number}", name, list(self.measures))
        return self.measures[name]

    def summary(self) -> dict[str, Any]:
        """Return it as plain values that JSON can hold."""
        out: dict[str, Any] = {
            "number": self.number,
            "values": {name: plain_value(value) for name, value in self.values.items()},
            "digest": self.digest or None,
            "scene_digest": self.scene_digest,
            "seed": self.seed,
            "rays_per_batch": self.rays_per_batch,
            "batches": self.batches,
            "seconds": self.seconds,
            "stopped": self.stopped,
            "measures": {name: _plain(found) for name, found in self.measures.items()},
            "change": {name: _plain(found) for name, found in self.change.items()},
            "advisories": list(self.advisories),
        }
        return out | ({"why": self.why} if self.why else {})


def _plain(found: Estimate) -> dict[str, Any]:
    out = found.summary()
    out["value"] = None if math.isnan(found.value) else found.value
    return out


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable:
    """A sweep's points and what was measured.

    Iterating gives a `SweepPoint` for each; ``sweep[17]`` gives one.

    Parameters
    ----------
    plan : SweepPlan
        What was asked for.
    measured : tuple of Measure
        What was measured, in order.
    points : tuple of SweepPoint
        All points, run or not.
    programs : int or None
        Different programs that the points needed: one, where only values change. None where that
        was not looked at, as when a sweep is opened.
    batch_values : callable
        Gives what each batch of a point gave, by measure.
    folder : Path or None
        Where it is kept.
    interrupted : bool
        Whether Ctrl-C ended the call.
    """

    plan: SweepPlan
    measured: tuple[Measure, ...]
    points: tuple[SweepPoint, ...]
    programs: int | None = None
    batch_values: Callable[[int], Mapping[str, Measured]] = field(default=lambda _: {})
    folder: Path | None = None
    interrupted: bool = False

    def __iter__(self) -> Iterator[SweepPoint]:
        return iter(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, number: int) -> SweepPoint:
        return self.points[number]

    def __repr__(self) -> str:
        across = " × ".join(str(n) for n in self.plan.shape)
        axes = ", ".join(axis.name for axis in self.plan.axes)
        left = "" if self.finished else f", {self.n_done} of them done"
        return (
            f"<photizon_cl.{type(self).__name__} of {self.plan.scene.name!r}: {across} points over "
            f"{axes}{left}>"
        )

    @property
    def n_done(self) -> int:
        """Points that have been run."""
        return sum(point.done for point in self.points)

    @property
    def failed(self) -> tuple[SweepPoint, ...]:
        """Points that could not be run; ``why`` says why."""
        return tuple(point for point in self.points if point.why)

    @property
    def finished(self) -> bool:
        """Whether every point has been run."""
        return self.n_done == len(self.points)

    @property
    def advisories(self) -> tuple[str, ...]:
        """What deserves a second look at some points, each once, with how many they are.

        Texts that differ in numbers alone count as one: that of the first point.
        """
        found: dict[str, dict[int, str]] = {}
        for point in self.points:
            for text in point.advisories:
                found.setdefault(_NUMBERS.sub("#", text), {}).setdefault(point.number, text)
        return tuple(_at(told, self.n_done) for told in found.values())

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what was measured."""
        return tuple(measure.name for measure in self.measured)

    def difference(self, name: str, a: int, b: int) -> Difference:
        """Return how a measure differs between two points, `b` against `a`.

        Batch is held against batch where both have the same seed and rays per batch: what they have
        in common cancels (common random numbers).

        Parameters
        ----------
        name : str
            Of the measure.
        a, b : int
            Numbers of the points.

        Returns
        -------
        Difference
            Values, difference and ratio with their standard errors.

        Raises
        ------
        ArgumentError
            Where there is no such measure or point, or one has not been run.
        """
        if name not in self.names:
            raise unknown_name("sweep", name, list(self.names))
        for number in (a, b):
            if not -len(self) <= number < len(self):
                raise ArgumentError(f"point: found {number}, expected one below {len(self)}")
            if not self.points[number].done:
                raise ArgumentError(f"point {number} has not been run")
        first, second = self.points[a], self.points[b]
        try:
            one, other = self.batch_values(first.number), self.batch_values(second.number)
        except ResultError as error:
            raise ArgumentError(f"what single batches gave is not there: {error}") from None
        return compared(name, first, second, one.get(name), other.get(name))

    def summary(self) -> dict[str, Any]:
        """Return the sweep as plain values that JSON can hold."""
        plan = self.plan
        return {
            "schema": SWEEP_RESULT_SCHEMA,
            "scene": plan.scene.name,
            "title": plan.heading,
            "axes": [
                {
                    "name": axis.name,
                    "path": axis.path,
                    "unit": axis.unit,
                    "values": plain_value(list(axis.values)),
                    "together": axis.together,
                }
                for axis in plan.axes
            ],
            "shape": list(plan.shape),
            "measures": [
                {"name": m.name, "unit": m.unit, "meaning": m.meaning} for m in self.measured
            ],
            "programs": self.programs,
            "done": self.n_done,
            "advisories": list(self.advisories),
            "points": [point.summary() for point in self.points],
        }

    def to_dataset(self) -> xr.Dataset:
        """Return every measure as an array over the axes, labelled, with units.

        A dimension for each axis, or group of axes that step together, by the name of the first.
        For each measure ``NAME``, ``NAME.sigma`` and, against the first point and paired where both
        share a stream, ``NAME.change`` and ``NAME.change_sigma``; besides ``digest``, ``batches``,
        ``rays``, ``seconds`` and ``stopped``. NaN where a point has not been run.
        """
        return dataset(self)

    def to_csv(self) -> str:
        """Return the table as CSV, a row for each point."""
        return table(self)


def _at(told: dict[int, str], done: int) -> str:
    """Return what is told at some points, by their numbers, maybe with others in it at each."""
    numbers, text = list(told), next(iter(told.values()))
    if len(numbers) == 1:
        return f"at point {numbers[0]}: {text}"
    if len(numbers) == done:
        where = "at every point"
    else:
        where = "at points " + ", ".join(map(str, numbers[:_NAMED]))
        where += f" and {len(numbers) - _NAMED} more" if len(numbers) > _NAMED else ""
    alike = len(set(told.values())) == 1
    return f"{where}: {text}" if alike else f"{where}; at the first of them {text}"


def compared(
    name: str, a: SweepPoint, b: SweepPoint, one: Measured | None, other: Measured | None
) -> Difference:
    """Return how a measure differs between two points that have been run.

    Parameters
    ----------
    name : str
        Of the measure.
    a, b : SweepPoint
        The points.
    one, other : Measured or None
        What their batches gave, where that is known.
    """
    x = one.batches if one else None
    y = other.batches if other else None
    same = (a.seed, a.rays_per_batch, a.engine) == (b.seed, b.rays_per_batch, b.engine)
    n = 0 if x is None or y is None or not same else min(len(x), len(y))
    if n < 2 or x is None or y is None:
        return difference_of(name, a.measures[name], b.measures[name], None)
    return difference_of(name, a.measures[name], b.measures[name], (x[:n], y[:n]))


def point_of(
    number: int, plan: SweepPlan, result: Estimates, measured: Mapping[str, Measured]
) -> SweepPoint:
    """Return the point of a result."""
    names = (axis.name for axis in plan.axes)
    run = result.scene.run
    return SweepPoint(
        number=number,
        values=dict(zip(names, plan.values(number), strict=True)),
        digest=result.tally_digest,
        measures={name: estimate(found) for name, found in measured.items()},
        scene_digest=result.scene.digest(),
        seed=run.seed,
        rays_per_batch=run.rays_per_batch,
        batches=result.batches,
        seconds=result.info.seconds,
        stopped=result.info.stopped,
        engine=result.info.engine,
        advisories=tuple(result.advisories),
    )


def with_change(
    point: SweepPoint,
    first: SweepPoint,
    own: Mapping[str, Measured],
    firsts: Mapping[str, Measured],
) -> SweepPoint:
    """Return a point with what it differs by from the first one."""
    change = {}
    for name in point.measures:
        found = compared(name, first, point, firsts.get(name), own.get(name))
        change[name] = Estimate(found.difference, found.sigma)
    return dataclasses.replace(point, change=change)


def empty_point(number: int, plan: SweepPlan, why: str = "") -> SweepPoint:
    """Return a point that has not been run, or could not be."""
    names = (axis.name for axis in plan.axes)
    values = dict(zip(names, plan.values(number), strict=True))
    return SweepPoint(number, values, stopped="failed" if why else "", why=why)


def estimate(found: Measured) -> Estimate:
    """Return what was measured as a number with its error."""
    value = math.nan if found.value is None else found.value
    return Estimate(value, found.sigma, found.count)
