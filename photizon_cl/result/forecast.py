"""How long a run will take, told from its first batches and kept beside what it took."""

from __future__ import annotations

import json
import math
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any, Final, Self

from photizon_cl.result.stopping import LEAST_BATCHES, achieved_sigma

if TYPE_CHECKING:
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.result.stopping import Goal

__all__ = ["Forecast"]

_PACE: Final = 0.1
"""Relative standard error of the time that a batch takes, as machines go."""
_SIDES: Final = 2.0
"""Standard errors to either side: about 95 of 100 runs should end within."""
_LATE: Final = 1.2
_LATE_SECONDS: Final = 2.0
"""By how much a run may end after its time: a batch takes what it takes."""
_TEXT: Final = 400


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
        Between which it should lie, in 95 of 100 runs. Wide after few batches: σ² of n batches is
        itself uncertain by √(2/(n − 1)).
    """

    after_batches: int
    seconds: float
    low: float
    high: float

    @classmethod
    def of(
        cls, layout: TallyLayout, tally: Accumulator, goal: Goal, seconds: float, before: float
    ) -> Self | None:
        """Return the forecast of a run that has come so far.

        Parameters
        ----------
        layout, tally : TallyLayout, Accumulator
            What it has, and what that means.
        goal : Goal
            Where it ends.
        seconds : float
            That it took so far, in all calls.
        before : float
            Those of earlier calls; `goal.max_seconds` counts from there.

        Returns
        -------
        Forecast or None
            None with fewer batches than a target can be met from, or where nothing has a σ yet.
        """
        n = tally.batches
        if n < LEAST_BATCHES:
            return None
        batches, spread = math.inf, 0.0
        if goal.target is not None:
            achieved = achieved_sigma(layout, tally)
            if achieved is not None:
                free = n - 1
                # the median of an estimated variance lies below the variance
                median = (1.0 - 2.0 / (9.0 * free)) ** 3
                batches = max(n * (achieved / goal.target) ** 2 / median, LEAST_BATCHES)
                spread = math.sqrt(2.0 / free)
        if goal.batches is not None and goal.batches <= batches:
            batches, spread = float(goal.batches), 0.0
        if not math.isfinite(batches):
            return None
        factor = math.exp(_SIDES * math.hypot(spread, _PACE))
        ends = [max(seconds, seconds / n * batches * by) for by in (1.0, 1.0 / factor, factor)]
        if goal.max_seconds is not None:
            # the promise of a run that its time ends
            most = before + goal.max_seconds
            late = before + _LATE * goal.max_seconds + _LATE_SECONDS
            ends = [min(ends[0], most), min(ends[1], most), min(ends[2], late)]
        return cls(n, *ends)

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
