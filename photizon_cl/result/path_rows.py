"""What a path table has: its rows, the rest that has none, and groups of rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from photizon_cl.result.trails import Step

__all__ = ["PathGroup", "PathRest", "PathRow"]


@dataclass(frozen=True)
class PathRow:
    """A path: a sequence of faces and events, and the light that comes by it.

    Parameters
    ----------
    sequence : str
        ``window.front t > window.back r > … > sensor``: ``r`` reflected, ``t`` transmitted, ``i``
        totally reflected, ``s`` scattered.
    power, sigma : float, float or None
        W; σ is None with a single batch.
    count : int
        Arrivals.
    interactions : int
        With surfaces, the detector's not among them.
    ghost_order : int or None
        Number of ``r`` on refracting faces; None where the sequence is not known.
    example_ray : int
        Number of a launched ray that shows it: the first one.
    steps : tuple of Step
        The sequence in parts; empty where it is not known.
    """

    sequence: str
    power: float
    sigma: float | None
    count: int
    interactions: int
    ghost_order: int | None
    example_ray: int
    steps: tuple[Step, ...]

    @property
    def known(self) -> bool:
        """Whether its sequence is known: its example ray was followed."""
        return self.ghost_order is not None

    @property
    def events(self) -> str:
        """The letters alone: ``trrt``."""
        return "".join(step.event for step in self.steps)

    def summary(self) -> dict[str, Any]:
        """Return the row as the summary holds it."""
        return {
            "sequence": self.sequence,
            "value": self.power,
            "sigma": self.sigma,
            "count": self.count,
            "interactions": self.interactions,
            "ghost_order": self.ghost_order,
            "example_ray": self.example_ray,
        }


@dataclass(frozen=True)
class PathRest:
    """What all paths that have no row bring together.

    Parameters
    ----------
    power, sigma : float, float or None
        W; where not every batch's values are kept, σ is an upper bound.
    count : int
        Arrivals.
    paths : int
        How many different paths these are, those at least.
    exact : int
        The power as the tally has it, see `PathTable.exact`.
    """

    power: float
    sigma: float | None
    count: int
    paths: int
    exact: int

    def summary(self) -> dict[str, Any]:
        """Return it as the summary holds it."""
        return {"value": self.power, "sigma": self.sigma, "count": self.count, "paths": self.paths}


@dataclass(frozen=True)
class PathGroup:
    """Paths with something in common.

    Parameters
    ----------
    label : str
        What they have in common.
    power, sigma : float, float or None
        W, of all together; σ from their sums in each batch, or, where not all of these are kept, an
        upper bound.
    count : int
        Arrivals.
    rows : tuple of PathRow
        The strongest first.
    """

    label: str
    power: float
    sigma: float | None
    count: int
    rows: tuple[PathRow, ...]
