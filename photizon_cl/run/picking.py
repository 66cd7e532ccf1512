"""Which of the paths that were followed arrive where they are wanted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hostcode.run.paths import RawPaths
from photizon_cl.result.paths import ENDINGS
from photizon_cl.scene.names import unknown_name

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.scene.model import Scene

__all__ = ["Wanted"]

_ABSORBED = ENDINGS.index("absorbed")
_GOES_ON = ENDINGS.index("goes on")


@dataclass
class Wanted:
    """Paths that arrive at an element, and meet others before.

    Parameters
    ----------
    element : int
        Number of the element.
    passing : bool
        Whether its surface lets light pass as if it were not there: then that is an arrival.
    via : list of set of (int, str)
        Elements and faces; of each set the path must meet one.
    faces : list of tuple of str
        Names of each element's faces by their numbers.
    rays : int
        How many launched rays were found in what was looked at last.
    """

    element: int
    passing: bool
    via: list[set[tuple[int, str]]]
    faces: list[tuple[str, ...]]
    rays: int = 0

    @classmethod
    def of(cls, scene: Scene, ending_on: str, via: tuple[str, ...]) -> Wanted:
        """Return what is wanted, by names.

        Raises
        ------
        UnknownNameError
            Where the scene has no such element or face.
        """
        names = scene.element.names
        if ending_on not in names:
            raise unknown_name("ending_on", ending_on, names)
        known: dict[str, set[tuple[int, str]]] = {}
        for n, item in enumerate(scene.element):
            for face in item.face_names:
                known.setdefault(item.name, set()).add((n, face))
                known.setdefault(f"{item.name}.{face}", set()).add((n, face))
        for name in via:
            if name not in known:
                raise unknown_name("via", name, known)
        faces = [tuple(face.name for face in item.faces) for item in scene.element]
        number = names.index(ending_on)
        passing = not all(s.counts for s in scene.element[number].surfaces)
        return cls(number, passing, [known[name] for name in via], faces)

    def of_these(self, raw: RawPaths, most: int) -> RawPaths:
        """Return the segments that lead to arrivals of the first `most` rays, and no others."""
        element, parent, ending, face = raw.wholes[:, [2, 3, 5, 6]].T
        arrives = (element == self.element) & (
            (ending == _ABSORBED) | (self.passing & (ending == _GOES_ON))
        )
        ends = np.flatnonzero(arrives)
        met = np.zeros((len(self.via), len(ends)), np.bool_)
        tests = [self._meets(found, element, face) for found in self.via]
        at = parent[ends]
        while (at >= 0).any():
            for row, test in zip(met, tests, strict=True):
                row |= test[np.maximum(at, 0)] & (at >= 0)
            at = np.where(at >= 0, parent[np.maximum(at, 0)], -1)
        chosen = ends[met.all(axis=0)]
        numbers = np.unique(raw.ray[chosen])[:most]
        chosen = chosen[np.isin(raw.ray[chosen], numbers)]
        self.rays = len(numbers)
        kept = np.zeros(len(parent), np.bool_)
        at = chosen
        while len(at):
            kept[at] = True
            at = parent[at]
            at = np.unique(at[at >= 0])
        return _some(raw, kept)

    def _meets(
        self, found: set[tuple[int, str]], element: NDArray[np.int64], face: NDArray[np.int64]
    ) -> NDArray[np.bool_]:
        """Return which segments end on one of some faces."""
        out = np.zeros(len(element), np.bool_)
        for number, name in found:
            numbers = [k for k, one in enumerate(self.faces[number]) if one == name]
            out |= (element == number) & np.isin(face, numbers)
        return out


def _some(raw: RawPaths, kept: NDArray[np.bool_]) -> RawPaths:
    """Return some segments, each with its parent; what goes on elsewhere begins a line."""
    number = np.cumsum(kept) - 1
    wholes = raw.wholes[kept].copy()
    parent = wholes[:, 3]
    wholes[:, 3] = np.where(parent >= 0, number[np.maximum(parent, 0)], -1)
    # a line goes on where the segment before it is the one that it continues
    continues = (wholes[:, 3] == np.arange(len(wholes)) - 1) & (wholes[:, 3] >= 0)
    wholes[:, 4] = ~continues
    return RawPaths(raw.ray[kept], raw.reals[kept], wholes, raw.cut, raw.cells)
