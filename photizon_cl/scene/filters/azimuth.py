"""Arrivals by azimuth about the detector's axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.edges import azimuth_edges
from photizon_cl.scene.filters.base import Filter

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Azimuth"]


@dataclass(frozen=True)
class Azimuth(Filter):
    """Equal bins in φ over [0, 2π), from u towards v."""

    kind: ClassVar[str] = "azimuth"
    kernel: ClassVar[str] = "azimuth"
    what: ClassVar[str] = "the azimuth about the detector's axis"

    @property
    def axis(self) -> tuple[str, str, NDArray[np.float64]]:
        """Name, unit and edges of the axis as people see it."""
        return "phi", "rad", 2.0 * np.pi * np.arange(self.bins + 1) / self.bins

    def device_edges(self) -> list[float]:
        """Return cosine and sine of each bin's lower edge."""
        return azimuth_edges(self.bins)
