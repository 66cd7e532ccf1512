"""How far a run is, and how much of its time is left."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from photizon_cl.result.stopping import LEAST_BATCHES, Goal, achieved_sigma

if TYPE_CHECKING:
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.result.estimates import RunInfo
    from photizon_cl.result.forecast import Forecast
    from photizon_cl.result.statistics import Accumulator

__all__ = ["Clock", "Progress"]


_GRACE: Final = 2.0
"""Seconds for the first batch to end once Ctrl-C was pressed."""


class Clock:
    """Time of one call, and how many batches still fit into it."""

    def __init__(self, goal: Goal, first: int) -> None:
        self.limit = goal.max_seconds
        self.first = self.batches = first
        self.started = time.perf_counter()
        self.interrupted: float | None = None  # when Ctrl-C was noticed

    def elapsed(self) -> float:
        """Return the seconds since the call began."""
        return time.perf_counter() - self.started

    def note(self, batches: int) -> None:
        """Take down how many batches there are now."""
        self.batches = batches

    def over(self) -> bool:
        """Say whether the time is up."""
        return self.limit is not None and self.elapsed() >= self.limit

    def must_stop(self, *, interrupted: bool = False) -> bool:
        """Say whether the batches in flight are to be given up: time is up, or Ctrl-C was pressed.

        The first batch of a call has a fifth more and a second, and two seconds from Ctrl-C on.
        """
        now, first = self.elapsed(), self.batches == self.first
        if interrupted and self.interrupted is None:
            self.interrupted = now
        if self.interrupted is not None and (not first or now > self.interrupted + _GRACE):
            return True
        if self.limit is None:
            return False
        return now >= (1.2 * self.limit + 1.0 if first else self.limit)

    def waited_enough(self) -> bool:
        """Say whether workers are not waited for any more.

        The first batch of a call has a tenth of the time and a second more.
        """
        if self.limit is None:
            return False
        first = self.batches == self.first
        return self.elapsed() >= (1.1 * self.limit + 1.0 if first else self.limit)

    def seconds_for_workers(self) -> float | None:
        """Return after how long nobody will wait for a task that is given out now."""
        if self.limit is None:
            return None
        return max(1.1 * self.limit + 1.0 - self.elapsed(), 0.0)

    def batches_in_time(self) -> int | None:
        """Return how many batches may go into a wave: one at first, to learn how long it takes."""
        if self.limit is None:
            return None
        made = self.batches - self.first
        if not made:
            return 1
        left = max(self.limit - self.elapsed(), 0.0)
        return max(int(min(left * made / max(self.elapsed(), 1e-9), 1e9)), 1)


@dataclass(frozen=True)
class Progress:
    """How far a run is; given to `progress` after each wave.

    Parameters
    ----------
    batches : int
        Batches in the result so far.
    goal_batches : int or None
        Batches at which the run ends, where that is fixed.
    target : float or None
        Relative standard error at which the run ends, where one is asked for.
    achieved_sigma : float or None
        The one reached; None with a single batch, or where nothing has one.
    interactions : int
        Surface interactions of these batches.
    seconds : float
        Time of this call so far.
    interactions_per_second : float
        In this call.
    eta_seconds : float or None
        Time left, as far as it can be told: the forecast's, and before there is one by σ, which
        falls with the square root of the batches.
    forecast : Forecast or None
        How long the run takes in all, as told last; an earlier one is kept with the result.
    """

    batches: int
    goal_batches: int | None
    target: float | None
    achieved_sigma: float | None
    interactions: int
    seconds: float
    interactions_per_second: float
    eta_seconds: float | None
    forecast: Forecast | None = None

    @classmethod
    def of(
        cls,
        compiled: CompiledScene,
        tally: Accumulator,
        goal: Goal,
        info: RunInfo,
        interactions: int,
        clock: Clock,
        forecast: Forecast | None = None,
    ) -> Progress:
        """Return how far a call is that made so many interactions."""
        achieved = achieved_sigma(compiled.layout, tally)
        seconds = max(clock.elapsed(), 1e-9)
        pace = seconds / max(tally.batches - clock.first, 1)
        left = []
        if goal.batches is not None:
            left.append((goal.batches - tally.batches) * pace)
        if goal.target is not None and achieved is not None:
            needed = max(tally.batches * (achieved / goal.target) ** 2, LEAST_BATCHES)
            left.append(max(needed - tally.batches, 0.0) * pace)
        if goal.max_seconds is not None:
            left.append(max(goal.max_seconds - seconds, 0.0))
        if forecast is not None and left and min(left) > 0.0:  # which knows better
            left = [max(forecast.seconds - info.seconds - seconds, 0.0)]
        return cls(
            batches=tally.batches,
            goal_batches=goal.batches,
            target=goal.target,
            achieved_sigma=achieved,
            interactions=info.interactions + interactions,
            seconds=seconds,
            interactions_per_second=interactions / seconds,
            eta_seconds=min(left) if left and math.isfinite(min(left)) else None,
            forecast=forecast,
        )
