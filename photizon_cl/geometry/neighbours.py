"""Which elements stand so near each other that their boxes meet."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.tree import build_tree, world_boxes
from photizon_cl.scene.elements.base import ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element

__all__ = ["Neighbours"]

_DENSE: Final = 1000
"""Up to this many boxes each is compared with each."""
_AT_ONCE: Final = 256
"""Boxes sought in the tree at once."""
_ROOM: Final = 2.0**13
"""Distance at which elements count as touching, in unit roundoffs of their farthest coordinate."""
_ROUNDING: Final = 2.0**5
"""What rounding may make of a distance between faces or edges, in the same."""

Pairs = tuple["NDArray[np.int64]", "NDArray[np.int64]"]


class Neighbours:
    """Elements of a scene and which of them are near each other.

    Parameters
    ----------
    elements : sequence of Element
        In order.
    roundoff : float, optional
        Unit roundoff of the coordinates that the kernels compute in.

    Attributes
    ----------
    rounding : float
        What rounding may make of a distance between faces or edges, relative to the coordinates.
    boxes : ndarray, shape (n, 6), float64
        Low and high corners in metres.
    rooms : ndarray, shape (n,), float64
        The distance in metres at which something counts as touching each.
    """

    def __init__(self, elements: Sequence[Element], roundoff: float = ROUNDOFF) -> None:
        self.elements, self.roundoff = elements, roundoff
        self.rounding = _ROUNDING * roundoff
        boxes = np.empty((0, 6))
        if elements:
            boxes = world_boxes(elements, (0.0, 0.0, 0.0), roundoff=roundoff)
        self.boxes = boxes
        self.rooms = np.asarray(_ROOM * roundoff * np.abs(self.boxes).max(axis=1, initial=0.0))

    @cached_property
    def _wide(self) -> NDArray[np.float64]:
        room = self.rooms[:, None]
        return np.hstack((self.boxes[:, :3] - room, self.boxes[:, 3:] + room))

    @cached_property
    def _tree(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        return build_tree(self._wide)

    def pairs(self) -> Iterator[Pairs]:
        """Give the ordered pairs of different elements whose boxes meet, rounding allowed for.

        Yields
        ------
        first, second : ndarray, shape (pairs,), int64
            A part of them, which bounds the memory. Both (i, j) and (j, i) are among them, in the
            order of i and then of j.
        """
        boxes, n = self._wide, len(self.elements)
        if n <= _DENSE:
            below = (boxes[:, None, :3] <= boxes[None, :, 3:]).all(axis=2)
            first, second = np.nonzero(below & below.T & ~np.eye(n, dtype=bool))
            yield first, second
            return
        for start in range(0, n, _AT_ONCE):
            sought = np.arange(start, min(start + _AT_ONCE, n))
            yield _seek(boxes, sought, *self._tree)


def _seek(
    boxes: NDArray[np.float64],
    sought: NDArray[np.int64],
    nodes: NDArray[np.float64],
    children: NDArray[np.int64],
) -> Pairs:
    """Return the pairs of some boxes with any, down the tree a level at a time."""
    low, high = boxes[:, :3, None], boxes[:, 3:, None]
    pairs = [np.empty((2, 0), np.int64)]
    node = np.zeros(len(sought), np.int64)
    while len(sought):
        at = nodes[node]
        met = (at[:, :3] <= high[sought]).all(axis=1) & (at[:, 3:] >= low[sought]).all(axis=1)
        which, child = np.nonzero(met)
        sought, link = sought[which], children[node[which], child]
        leaf = link >= 0
        pairs.append(np.array([sought[leaf], link[leaf]]))
        sought, node = sought[~leaf], ~link[~leaf]
    first, second = np.concatenate(pairs, axis=1)
    other = first != second
    first, second = first[other], second[other]
    order = np.lexsort((second, first))
    return first[order], second[order]
