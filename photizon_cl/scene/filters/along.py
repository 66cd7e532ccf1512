"""Arrivals by a coordinate of the detector's own frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.edges import even_edges
from photizon_cl.scene.filters.base import Filter

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Along"]


@dataclass(frozen=True)
class Along(Filter):
    """Equal bins along u, v or w.

    Parameters
    ----------
    component : str
        ``"u"``, ``"v"`` or ``"w"``.
    low, high : float
        Where the first bin begins and the last one ends, in metres.
    name, unit : str
        Of the axis as people see it.
    shown : tuple of float
        What people see for `low` and `high`.
    """

    kind: ClassVar[str] = "along"
    kernel: ClassVar[str] = "along"
    what: ClassVar[str] = "a coordinate of the detector's own frame"

    component: str
    low: float
    high: float
    name: str
    unit: str
    shown: tuple[float, float]

    @property
    def option(self) -> str:
        """The component."""
        return self.component

    @property
    def axis(self) -> tuple[str, str, NDArray[np.float64]]:
        """Name, unit and edges of the axis as people see it."""
        n, k = self.bins, np.arange(self.bins + 1)
        low, high = self.shown
        edges = high * ((2 * k - n) / n) if low == -high else low + (high - low) * (k / n)
        return self.name, self.unit, edges

    def device_edges(self) -> list[float]:
        """Return the edges in metres, each rounded once."""
        return even_edges(self.low, self.high, self.bins)
