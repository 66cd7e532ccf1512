"""What all filters share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Axis", "Filter"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Axis:
    """An axis as people see it.

    Parameters
    ----------
    name : str
        In arrays and files, for example ``cos_theta``.
    units : str
        ``m``, ``rad`` or ``1``.
    edges : ndarray, shape (n + 1,), float64
        Edges of the bins, ascending.
    symbol : str
        In figures and tables, for example ``cos θ``.
    text : str
        What it is, for a file's attributes.
    said : str
        What stands before a value in a sentence, for example ``cosine``.
    about : str
        What a figure adds to the symbol and the unit; may be empty.
    """

    name: str
    units: str
    edges: NDArray[np.float64]
    symbol: str
    text: str
    said: str
    about: str = ""


@dataclass(frozen=True, eq=False)
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
    @abstractmethod
    def axis(self) -> Axis:
        """The axis as people see it."""

    @property
    def option(self) -> str:
        """What its kernel is rendered with, a suffix of its function; empty where there is one."""
        return ""

    def device_edges(self) -> list[float]:
        """Return the numbers that its kernel is given, in the kernel's layout; here none.

        `Along` has n + 1 edges in metres, ascending; `Azimuth` 2n cosines and sines by turns;
        `Generation`, where a bin is a number of interactions, none.
        """
        return []
