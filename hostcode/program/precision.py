"""How many bits a program computes in: the modes, and what follows from each."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["FP64", "PRECISIONS", "Precision"]

_ROUNDOFF: Final = {"double": 2.0**-53, "float": 2.0**-24}


@dataclass(frozen=True)
class Precision:
    """A mode: what a program's numbers are.

    Random words, tallies, tables and queues are the same in every mode.

    Parameters
    ----------
    name : str
        As users say it.
    real : str
        C type of lengths and directions, ``double`` or ``float``.
    weight : str
        C type of rays' weights, the same or ``double``.
    what : str
        What that is, in words.
    """

    name: str
    real: str
    weight: str
    what: str

    @property
    def single(self) -> bool:
        """Whether anything is computed in single precision."""
        return self.real == "float"

    @property
    def roundoff(self) -> float:
        """Unit roundoff of lengths and directions: half the relative distance of neighbours."""
        return _ROUNDOFF[self.real]

    @property
    def weight_roundoff(self) -> float:
        """Unit roundoff of weights."""
        return _ROUNDOFF[self.weight]

    def weighed(self, weight: float) -> float:
        """Return a weight as a ray carries it."""
        if self.weight == "double":
            return weight
        (rounded,) = struct.unpack("f", struct.pack("f", weight))
        return float(rounded)


FP64: Final = Precision("fp64", "double", "double", "double precision throughout")

PRECISIONS: Final[Mapping[str, Precision]] = MappingProxyType(
    {
        mode.name: mode
        for mode in (
            FP64,
            Precision("mixed", "float", "double", "single precision, weights in double"),
            Precision("fp32", "float", "float", "single precision throughout; exact sums"),
        )
    }
)
"""The modes by name, the most exact first."""
