"""Arrivals by generation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.filters.base import Filter

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Generation"]


@dataclass(frozen=True)
class Generation(Filter):
    """One bin for each number of surface interactions; the last one collects all that have more."""

    kind: ClassVar[str] = "generation"
    kernel: ClassVar[str] = "generation"
    what: ClassVar[str] = "the surface interactions before the arrival"

    @property
    def axis(self) -> tuple[str, str, NDArray[np.float64]]:
        """Name, unit and edges of the axis: bin g holds generation g."""
        return "generation", "1", np.arange(self.bins + 1, dtype=np.float64)
