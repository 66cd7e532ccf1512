"""What all filters share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Filter"]


@dataclass(frozen=True)
class Filter(ABC):
    """One axis of a tally's cells.

    Parameters
    ----------
    bins : int
        Cells along the axis, at least 1.
    """

    kind: ClassVar[str]
    kernel: ClassVar[str]
    """Stem of the file in ``kernels/filters`` that has ``bin_<kernel>``."""
    what: ClassVar[str]
    """What arrivals are divided by, in one line."""

    bins: int

    @property
    def option(self) -> str:
        """What its kernel is rendered with, a suffix of its function; empty where there is one."""
        return ""

    @property
    @abstractmethod
    def axis(self) -> tuple[str, str, NDArray[np.float64]]:
        """Name, unit and edges of the axis as people see it; ``bins + 1`` edges, ascending."""

    def device_edges(self) -> list[float]:
        """Return the edges that its kernel is given."""
        return []
