"""The plane faces of elements in world coordinates, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from photizon_cl.scene.faces import Plane

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element

__all__ = ["PlaneFaces", "dot", "sole_plane"]


class PlaneFaces:
    """The plane faces of elements that have no other ones, one after the other.

    Plane faces of a solid with curved ones are left out: its kernel has bounds of its own.

    Parameters
    ----------
    elements : sequence of Element
        In order.

    Attributes
    ----------
    begin : ndarray, shape (n + 1,), int64
        Where each element's faces begin.
    centres : ndarray, shape (faces, 3), float64
        In metres.
    frames : ndarray, shape (faces, 3, 3), float64
        Rows u, v and normal.
    halves : ndarray, shape (faces, 2), float64
        Half extents along u and v in metres.
    """

    def __init__(self, elements: Sequence[Element]) -> None:
        planes: list[Plane] = []
        owners: list[int] = []
        begin = [0]
        for n, element in enumerate(elements):
            found = [face for face in element.faces if isinstance(face, Plane)]
            if len(found) == len(element.faces):
                planes += found
                owners += [n] * len(found)
            begin.append(len(planes))
        self.begin = np.array(begin)
        position = np.array([elements[n].position for n in owners]).reshape(-1, 3)
        turn = np.array([elements[n].frame for n in owners]).reshape(-1, 3, 3)
        # written out, so that no machine's matrix product decides a bit
        centres = np.array([face.centre for face in planes]).reshape(-1, 3)
        self.centres = _turned(centres, turn) + position
        frames = np.array([face.frame for face in planes]).reshape(-1, 3, 3)
        self.frames = np.stack([_turned(frames[:, k], turn) for k in range(3)], axis=1)
        self.halves = np.array([face.outline.half_sizes for face in planes]).reshape(-1, 2)


def _turned(local: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return local vectors, shape (n, 3), in the world, by the rows of their frames."""
    x, y, z = (local[:, k : k + 1] for k in range(3))
    return np.asarray(x * rows[:, 0] + y * rows[:, 1] + z * rows[:, 2])


def sole_plane(element: Element) -> Plane | None:
    """Return the plane face of an element that has no other face."""
    face = element.sole_face
    return face if isinstance(face, Plane) else None


def dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scalar products of vectors, shape (n, 3) each."""
    return np.asarray((a * b).sum(axis=1))
