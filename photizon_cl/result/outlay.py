"""What a run will take, told before it: seconds to its target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from photizon_cl.errors import show

__all__ = ["Outlay", "Untold"]

_MOST_LIT: Final = 0.8
"""Part of the bins below which the others are worth a word."""
_NAMED: Final = 4
"""Detectors that a sentence names."""
_LONG: Final = 1.5
"""Times `max_seconds` that a target must take for a word: what is told may be off by a third."""


@dataclass(frozen=True)
class Outlay:
    """Seconds to a run's target, by some rays of it.

    Parameters
    ----------
    rays : int
        Traced for it.
    target : float
        The run's target.
    seconds, low, high : float
        Of tracing until it is met, and between which they should lie in 95 of 100 runs.
    batches : float
        Of the run's rays.
    lit : float
        Part of the maps' bins that those rays light, 1 where the target is on none.
    max_seconds : float
        Time at which the run ends.
    dark : tuple of str
        Elements at whose detectors none of the rays arrived.
    """

    rays: int
    target: float
    seconds: float
    low: float
    high: float
    batches: float
    lit: float
    max_seconds: float
    dark: tuple[str, ...] = ()

    def __str__(self) -> str:
        aim = f"{100.0 * self.target:g} %"
        n = round(self.batches)
        dark = ""
        if self.lit < _MOST_LIT:
            dark = (
                f"; of the bins these light {100.0 * self.lit:.0f} %, and where the others come "
                "to count it may take far longer"
            )
        return (
            f"about {_time(self.seconds)} of tracing to the target of {aim} ({_time(self.low)} to "
            f"{_time(self.high)}), {n} batch{'es' * (n != 1)}, as {self.rays} rays tell{dark}"
        )

    def advice(self) -> list[str]:
        """Return what deserves a second look: dark detectors, time that will not do."""
        found = _unlit(self.rays, self.dark)
        if self.seconds < _LONG * self.max_seconds:
            return found
        reached = self.target * (self.seconds / self.max_seconds) ** 0.5
        late = (
            f"the target of {100.0 * self.target:g} % takes about {_time(self.seconds)} here, "
            f"and max_seconds ends the run after {_time(self.max_seconds)}, at about "
            f"{100.0 * reached:.2g} %: raise max_seconds, or target_sigma"
        )
        return [*found, late]


@dataclass(frozen=True)
class Untold:
    """Why nothing is told of a run's time.

    Parameters
    ----------
    why : str
        A clause.
    rays : int
        Traced.
    dark : tuple of str
        Elements at whose detectors none of them arrived.
    """

    why: str
    rays: int = 0
    dark: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"not told: {self.why}"

    def advice(self) -> list[str]:
        """Return what deserves a second look: dark detectors."""
        return _unlit(self.rays, self.dark)


def _unlit(rays: int, dark: tuple[str, ...]) -> list[str]:
    """Return a sentence about the detectors at which no ray arrived; none where there are none."""
    if not dark:
        return []
    named = ", ".join(map(show, dark[:_NAMED]))
    more = f" and {len(dark) - _NAMED} more" if len(dark) > _NAMED else ""
    detectors = "detector" if len(dark) == 1 else "detectors"
    said = (
        f"of {rays} rays none arrives at the {detectors} on {named}{more}: is it where light goes, "
        "and does it face it (photizon show draws that)? Where next to no light is meant to "
        "arrive, a run takes long"
    )
    return [said]


def _time(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.2g} s"
    if seconds < 6000.0:
        return f"{seconds / 60.0:.2g} min"
    return f"{seconds / 3600.0:.2g} h" if seconds < 360000.0 else f"{seconds / 86400.0:.2g} days"
