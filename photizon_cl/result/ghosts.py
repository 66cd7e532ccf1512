"""Two-reflection ghosts as a matrix over pairs of faces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.errors import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import DTypeLike, NDArray

__all__ = ["GhostPair", "Ghosts"]

_MOST_FACES: Final = 4096


@dataclass(frozen=True)
class GhostPair:
    """A ghost: light reflected at one face, then at another.

    Parameters
    ----------
    first, second : str
        The faces, in the order in which light meets them.
    power, sigma : float, float or None
        W.
    count : int
        Arrivals.
    """

    first: str
    second: str
    power: float
    sigma: float | None
    count: int

    def __str__(self) -> str:
        return f"{self.first} → {self.second}"


class Ghosts:
    """Power of the paths with two reflections at refracting faces, by the pair.

    For NumPy it is the matrix `power`.

    Attributes
    ----------
    faces : tuple of str
        Refracting faces, in file order.
    power, sigma : ndarray, shape (n, n), float64
        W: row, the face of the first reflection; column, that of the second. σ is NaN with a single
        batch, and where there is nothing.
    count : ndarray, shape (n, n), int64
        Arrivals.
    """

    def __init__(
        self, faces: list[str], pairs: Mapping[tuple[str, str], tuple[float, float | None, int]]
    ) -> None:
        self.faces = tuple(faces)
        found = [GhostPair(a, b, *values) for (a, b), values in pairs.items()]
        self._pairs = tuple(sorted(found, key=lambda pair: -pair.power))

    def __repr__(self) -> str:
        power = sum(pair.power for pair in self._pairs)
        return f"<Ghosts: {len(self._pairs)} pairs of {len(self.faces)} faces, {power:.6g} W>"

    def __array__(
        self, dtype: DTypeLike | None = None, copy: bool | None = None
    ) -> NDArray[np.float64]:
        return np.array(self.power, dtype, copy=True if copy is None else copy)

    def pairs(self) -> tuple[GhostPair, ...]:
        """Return the pairs that bring anything, the strongest first."""
        return self._pairs

    @cached_property
    def power(self) -> NDArray[np.float64]:
        """W, shape (n, n)."""
        return self._matrix([pair.power for pair in self._pairs], 0.0)

    @cached_property
    def sigma(self) -> NDArray[np.float64]:
        """Standard errors in W, shape (n, n)."""
        errors = [math.nan if pair.sigma is None else pair.sigma for pair in self._pairs]
        return self._matrix(errors, math.nan)

    @cached_property
    def count(self) -> NDArray[np.int64]:
        """Arrivals, shape (n, n)."""
        counts = self._matrix([float(pair.count) for pair in self._pairs], 0.0)
        return np.asarray(counts, np.int64)

    def _matrix(self, values: list[float], empty: float) -> NDArray[np.float64]:
        n = len(self.faces)
        if n > _MOST_FACES:
            raise ArgumentError(
                f"ghosts: found {n} faces, expected at most {_MOST_FACES} for a matrix: pairs() "
                "lists those that bring anything"
            )
        out = np.full((n, n), empty)
        at = {face: k for k, face in enumerate(self.faces)}
        for pair, value in zip(self._pairs, values, strict=True):
            out[at[pair.first], at[pair.second]] = value
        return out
