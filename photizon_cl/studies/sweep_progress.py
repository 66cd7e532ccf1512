"""How far a sweep is, and how much of its time is left."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from photizon_cl.run.progress import Progress

__all__ = ["SweepClock", "SweepProgress"]


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is; given to `progress` as it goes on.

    Parameters
    ----------
    points : int
        Of the sweep.
    done : int
        Points that have been run, in earlier calls too.
    number : int
        The point that is being run; -1 while they are looked at, before the first.
    doing : str
        What it sets, or what is being done.
    point : Progress or None
        How far that point is; None before its first batch.
    seconds : float
        Of this call so far.
    eta_seconds : float or None
        Time left for all points, as far as it can be told.
    """

    points: int
    done: int
    number: int
    doing: str
    point: Progress | None
    seconds: float
    eta_seconds: float | None


class SweepClock:
    """Time of a call, and how long the points took that ended in it.

    Parameters
    ----------
    limit : float or None
        Seconds that the call may take.
    """

    def __init__(self, limit: float | None) -> None:
        self.limit = limit
        self.started = self.began = time.perf_counter()
        self.took: list[float] = []

    def elapsed(self) -> float:
        """Return the seconds since the call began."""
        return time.perf_counter() - self.started

    def left(self) -> float | None:
        """Return the seconds that the call has left; None without a limit."""
        return None if self.limit is None else self.limit - self.elapsed()

    def over(self) -> bool:
        """Say whether the call's time is over."""
        left = self.left()
        return left is not None and left <= 0.0

    def begin(self) -> None:
        """Take down that a point begins."""
        self.began = time.perf_counter()

    def end(self) -> None:
        """Take down that a point has ended."""
        self.took.append(time.perf_counter() - self.began)

    def eta(self, behind: int, point: Progress | None) -> float | None:
        """Return the time left: of the point that is being run, and of those behind it.

        Each of those is taken to last as long as those that ended did, or, before one has, as the
        first is told to last.
        """
        spent = time.perf_counter() - self.began
        rest = None if point is None else point.eta_seconds
        if self.took:
            each = sum(self.took) / len(self.took)
            rest = max(each - spent, 0.0) if rest is None else rest
        elif rest is not None:
            each = spent + rest
        else:
            return None
        total = rest + behind * each
        left = self.left()
        return total if left is None else max(min(total, left), 0.0)
