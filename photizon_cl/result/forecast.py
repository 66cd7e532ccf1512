"""How long a run will take, told from its first batches and kept beside what it took."""

from __future__ import annotations

import json
import math
import time
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any, Final, Self

from photizon_cl.result.needed import batches_needed
from photizon_cl.result.stopping import LEAST_BATCHES

if TYPE_CHECKING:
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.result.stopping import Goal

__all__ = ["Forecast", "Outlook"]

_PACE: Final = 0.1
"""Relative standard error of the time that a batch takes, as machines go."""
_SIDES: Final = 2.0
"""Standard errors to either side: about 95 of 100 runs should end within."""
_LATE: Final = 1.2
_LATE_SECONDS: Final = 2.0
"""By how much a run may end after its time: a batch takes what it takes."""
_TEXT: Final = 400
_NARROW: Final = 1.3
"""By which factor at most the end may lie behind the time that is told, for it to be kept early."""
_EARLY: Final = 0.1
_SECONDS: Final = 10.0
"""Part of a run, or seconds, from which on a narrow one is kept: a pace is no pace before."""
_LATEST: Final = 1.0 / 3.0
"""Part of a run from which on any is kept; later it would tell little that is new."""


@dataclass(frozen=True)
class Forecast:
    """When a run should end.

    Parameters
    ----------
    after_batches : int
        Batches that it was made from.
    seconds : float
        Of the whole run, as the summary's ``seconds`` counts them.
    low, high : float
        Between which it should lie, in 95 of 100 runs. Wide after few batches where a single
        number is asked for: σ² of n batches is itself uncertain by √(2/(n − 1)). Of a map's many
        bins the median is known far better.
    """

    after_batches: int
    seconds: float
    low: float
    high: float

    def settled(self, passed: float) -> bool:
        """Say whether it is to be kept, made when so many seconds of the run had passed.

        As early as it is narrow and the time of a batch is known, and early enough to be of use.
        """
        if passed >= _LATEST * self.seconds:
            return True
        narrow = self.high <= _NARROW * self.seconds
        return narrow and passed >= min(_EARLY * self.seconds, _SECONDS)

    def summary(self) -> dict[str, Any]:
        """Return it as the summary holds it."""
        return {
            "after_batches": self.after_batches,
            "seconds": self.seconds,
            "low": self.low,
            "high": self.high,
        }

    def text(self) -> str:
        """Return it as text for `read`."""
        return json.dumps(astuple(self), allow_nan=False)

    @classmethod
    def read(cls, text: object) -> Self:
        """Return what `text` wrote.

        Raises
        ------
        ValueError
            Where it is none.
        """
        if not isinstance(text, str) or len(text) > _TEXT:
            raise ValueError("its forecast is no line of text")
        try:
            after, seconds, low, high = json.loads(text)
            made = cls(after, float(seconds), float(low), float(high))
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise ValueError(f"its forecast is none: {error}") from None
        fits = type(after) is int and after > 0 and 0.0 <= low <= seconds <= high < math.inf
        if not fits:
            raise ValueError("its forecast has numbers that cannot be")
        return made


class Outlook:
    """The forecasts of a run while it goes on: the latest one, and the one that is kept.

    Parameters
    ----------
    goal : Goal
        Where it ends.
    before : float
        Seconds of earlier calls; `goal.max_seconds` counts from there.
    batches : int
        Those that they made.
    kept : Forecast or None
        The one that they kept; it is made anew where it came too early in the run to be kept, or
        at its end.
    """

    _SHARE: Final = 0.02
    """Part of a run's time that making them may take."""

    def __init__(self, goal: Goal, before: float, batches: int, kept: Forecast | None) -> None:
        self.goal, self.before = goal, before
        if kept is not None and kept.low == kept.high and kept.after_batches == batches:
            kept = None
        self.kept = self.latest = kept
        self._settled = kept is not None and kept.settled(before)
        self._first: tuple[int, float] | None = None
        self._last = batches
        self._next = 0.0

    def note(self, layout: TallyLayout, tally: Accumulator, elapsed: float) -> None:
        """Take down that batches came, and tell the end anew where it is time.

        Parameters
        ----------
        layout, tally : TallyLayout, Accumulator
            What the run has, and what that means.
        elapsed : float
            Seconds of this call.
        """
        step, self._last = tally.batches - self._last, tally.batches
        if self._first is None:
            self._first = tally.batches, elapsed
        if not step or elapsed < self._next:
            return
        started = time.perf_counter()
        told = self._told(layout, tally, elapsed, step)
        self._next = elapsed + (time.perf_counter() - started) / self._SHARE
        if told is None:
            return
        self.latest = told
        if not self._settled:
            self.kept = told
            self._settled = told.settled(self.before + elapsed)

    def at_end(self, batches: int, seconds: float) -> Forecast:
        """Return the one to keep of a run that ended after so many batches and seconds.

        Where it was over before anything could be told it is what the run took.
        """
        return self.kept or Forecast(batches, seconds, seconds, seconds)

    def _told(
        self, layout: TallyLayout, tally: Accumulator, elapsed: float, step: int
    ) -> Forecast | None:
        """Return the forecast of a run that has come so far, which went `step` batches at last.

        None with fewer batches than a target can be met from, or where nothing has a σ yet.
        """
        n, goal = tally.batches, self.goal
        if n < LEAST_BATCHES:
            return None
        batches, spread = math.inf, 0.0
        if goal.target is not None:
            batches, spread = batches_needed(layout, tally, goal.target)
        if goal.batches is not None and goal.batches <= batches:
            batches, spread = float(goal.batches), 0.0
        if not math.isfinite(batches):
            return None
        passed, pace = self.before + elapsed, self._pace(tally, elapsed)
        most = math.inf if goal.batches is None else goal.batches - n

        def left(wanted: float, of_step: float) -> float:
            # what is under way together ends together: up to a step later than it is wanted
            more = max(wanted - n, 0.0) + of_step * (step - 1)
            return min(more, most)

        middle = left(batches, 0.5)
        ends = [passed + pace * middle]
        for sign, of_step in ((-1.0, 0.0), (1.0, 1.0)):
            by_batches = left(batches * math.exp(sign * _SIDES * spread), of_step) - middle
            by_pace = middle * (math.exp(sign * _SIDES * _PACE) - 1.0)
            off = sign * math.hypot(by_batches, by_pace)
            ends.append(passed + pace * max(middle + off, 0.0))
        if goal.max_seconds is not None:
            # the promise of a run that its time ends
            last = self.before + goal.max_seconds
            late = self.before + _LATE * goal.max_seconds + _LATE_SECONDS
            ends = [min(ends[0], last), min(ends[1], last), min(ends[2], late)]
        return Forecast(n, *ends)

    def _pace(self, tally: Accumulator, elapsed: float) -> float:
        """Return the seconds of a batch: those since the first ones, which warm everything up."""
        first, then = self._first or (0, 0.0)
        n = tally.batches - first
        if n > 0 and elapsed > then:
            return (elapsed - then) / n
        return (self.before + elapsed) / tally.batches
