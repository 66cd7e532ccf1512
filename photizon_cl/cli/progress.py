"""How far a run is, on one line of the terminal."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self

from rich.text import Text

from photizon_cl.cli.tables import console
from photizon_cl.errors import printable

if TYPE_CHECKING:
    from types import TracebackType

    from photizon_cl.run.progress import Progress
    from photizon_cl.studies.sweep_progress import SweepProgress

__all__ = ["Display", "Lines", "SweepDisplay", "progress_line", "sweep_line"]


class _Line:
    """One line on standard error that is redrawn; silent where that is no terminal."""

    starts = "building the program, tracing the first batch …"

    def __init__(self, title: str) -> None:
        self.title = printable(title)
        self.live: Any = None

    def __enter__(self) -> Self:
        err = console(stderr=True)
        if err.is_terminal:
            from rich.live import Live

            self.live = Live(
                Text(f"{self.title}: {self.starts}"),
                console=err,
                refresh_per_second=8,
                transient=True,
            )
            self.live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.live is not None:
            with suppress(OSError):  # a terminal that is gone
                self.live.stop()

    def show(self, text: str) -> None:
        """Show a line in place of the last one."""
        if self.live is not None:
            self.live.update(Text(text))


class Display(_Line):
    """How far a run is."""

    def update(self, now: Progress) -> None:
        """Show how far the run is."""
        if self.live is not None:
            self.show(progress_line(now))


class Lines(_Line):
    """What a study is doing."""

    starts = "…"

    def update(self, text: str) -> None:
        """Show what is being done."""
        self.show(f"{self.title}: {printable(text)}")


class SweepDisplay(_Line):
    """How far a sweep is."""

    starts = "looking at its points …"

    def update(self, now: SweepProgress) -> None:
        """Show how far the sweep is."""
        if self.live is not None:
            self.show(sweep_line(now))


def sweep_line(now: SweepProgress) -> str:
    """Return one line: points done, what is being run and how far that is, time left for all."""
    doing = printable(now.doing)
    if now.number < 0:
        return doing
    done = f"{now.done} of {now.points} point{'s' * (now.points != 1)} done"
    point = f"point {now.number}: {doing}"
    if now.point is not None:
        sigma = now.point.achieved_sigma
        point += f", batch {now.point.batches}" + ("" if sigma is None else f", σ {sigma:.2e}")
    left = "" if now.eta_seconds is None else f"  {_time(now.eta_seconds)} left"
    return f"{done}{left}  {point}"


def progress_line(now: Progress) -> str:
    """Return one line: σ now, batches, interactions a second, time left."""
    sigma = "σ –" if now.achieved_sigma is None else f"σ {now.achieved_sigma:.2e}"
    if now.target is not None:
        sigma += f" (target {now.target:.2e})"
    batches = f"batch {now.batches}" + (f"/{now.goal_batches}" if now.goal_batches else "")
    rate = f"{now.interactions_per_second / 1e6:.1f} M interactions/s"
    left = "" if now.eta_seconds is None else f"  {_time(now.eta_seconds)} left"
    told = now.forecast
    of = "" if told is None or not left else f" of {_time(told.low)} to {_time(told.high)}"
    return f"{sigma}  {batches}  {rate}{left}{of}"


def _time(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes < 100 else f"{minutes / 60:.1f} h"
