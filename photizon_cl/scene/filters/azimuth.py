"""Arrivals by azimuth about the detector's axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from photizon_cl.scene.edges import azimuth_edges
from photizon_cl.scene.filters.base import Axis, Filter

__all__ = ["Azimuth"]


@dataclass(frozen=True, eq=False)
class Azimuth(Filter):
    """Equal bins in φ over [0, 2π), from u towards v."""

    kind: ClassVar[str] = "azimuth"
    kernel: ClassVar[str] = "azimuth"
    what: ClassVar[str] = "the azimuth about the detector's axis"

    @property
    def axis(self) -> Axis:
        """The axis as people see it."""
        return Axis(
            name="phi",
            units="rad",
            edges=2.0 * np.pi * np.arange(self.bins + 1) / self.bins,
            symbol="φ",
            text="azimuth about the axis, from u towards v",
            said="azimuth",
            about="about the axis from u towards v",
        )

    def device_edges(self) -> list[float]:
        """Return cosine and sine of each bin's lower edge, one after the other: 2n for n bins."""
        return azimuth_edges(self.bins)
