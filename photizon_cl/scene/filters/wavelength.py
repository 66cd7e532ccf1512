"""Arrivals by wavelength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from photizon_cl.scene.filters.base import Axis, Filter

__all__ = ["Wavelength"]


@dataclass(frozen=True, eq=False)
class Wavelength(Filter):
    """One bin for each line or band of the spectrum, in their order."""

    kind: ClassVar[str] = "wavelength"
    kernel: ClassVar[str] = "wavelength"
    what: ClassVar[str] = "the line or band of the spectrum that they are of"

    @property
    def axis(self) -> Axis:
        """The axis as people see it: bin i holds line i."""
        return Axis(
            name="line",
            units="1",
            edges=np.arange(self.bins + 1, dtype=np.float64),
            symbol="line",
            text="number of the line of the spectrum",
            said="line",
        )
