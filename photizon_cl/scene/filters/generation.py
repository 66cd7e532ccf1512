"""Arrivals by generation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from photizon_cl.scene.filters.base import Axis, Filter

__all__ = ["Generation"]


@dataclass(frozen=True, eq=False)
class Generation(Filter):
    """One bin for each number of surface interactions; the last one collects all that have more."""

    kind: ClassVar[str] = "generation"
    kernel: ClassVar[str] = "generation"
    what: ClassVar[str] = "the surface interactions before the arrival"

    @property
    def axis(self) -> Axis:
        """The axis as people see it: bin g holds generation g."""
        return Axis(
            name="generation",
            units="1",
            edges=np.arange(self.bins + 1, dtype=np.float64),
            symbol="generation",
            text="surface interactions before the arrival",
            said="generation",
        )
