"""Two-reflection ghosts as a matrix over pairs of faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

__all__ = ["GhostPair", "Ghosts"]


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


@dataclass(frozen=True, eq=False, repr=False)
class Ghosts:
    """Power of the paths with two reflections at refracting faces, by the pair.

    Parameters
    ----------
    faces : tuple of str
        Refracting faces, in file order.
    power, sigma : ndarray, shape (n, n), float64
        W: row, the face of the first reflection; column, that of the second. σ is NaN with a single
        batch, and where there is nothing.
    count : ndarray, shape (n, n), int64
        Arrivals.
    """

    faces: tuple[str, ...]
    power: NDArray[np.float64]
    sigma: NDArray[np.float64]
    count: NDArray[np.int64]

    def __repr__(self) -> str:
        pairs = self.pairs()
        return f"<Ghosts: {len(pairs)} pairs of {len(self.faces)} faces, {self.power.sum():.6g} W>"

    def pairs(self) -> tuple[GhostPair, ...]:
        """Return the pairs that bring anything, the strongest first."""
        found = []
        for a, b in zip(*(at.tolist() for at in np.nonzero(self.count)), strict=True):
            sigma = float(self.sigma[a, b])
            found.append(
                GhostPair(
                    self.faces[a],
                    self.faces[b],
                    float(self.power[a, b]),
                    None if np.isnan(sigma) else sigma,
                    int(self.count[a, b]),
                )
            )
        return tuple(sorted(found, key=lambda pair: -pair.power))

    @classmethod
    def of(
        cls, faces: list[str], pairs: Mapping[tuple[str, str], tuple[float, float | None, int]]
    ) -> Ghosts:
        """Return the matrix of some pairs, each with power, σ and arrivals."""
        n = len(faces)
        power, sigma = np.zeros((n, n)), np.full((n, n), np.nan)
        count = np.zeros((n, n), np.int64)
        at = {face: k for k, face in enumerate(faces)}
        for (first, second), (value, error, arrivals) in pairs.items():
            where = at[first], at[second]
            power[where], count[where] = value, arrivals
            sigma[where] = np.nan if error is None else error
        return cls(tuple(faces), power, sigma, count)
