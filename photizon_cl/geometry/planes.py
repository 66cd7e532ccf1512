"""The plane faces of elements in world coordinates, as arrays, and which share a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.scene.faces import Plane

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from photizon_cl.geometry.neighbours import Neighbours
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.outlines import Outline

    Numbers = NDArray[np.int64]
    Wanted = Callable[[Any, Any], Any]
    """Says of the elements with some numbers, or with two, whether a pair of them is looked at."""

__all__ = ["ROUNDING", "PlaneFaces", "coplanar", "dot", "face_pairs", "lies_within", "overlap"]

ROUNDING: Final = 2.0**-48
"""What rounding may make of a distance between faces or edges, relative to the coordinates."""
_GROWN: Final = 1.0 + ROUNDING
_AT_ONCE: Final = 1 << 18
"""Pairs of faces looked at at once, which bounds the memory."""


class PlaneFaces:
    """The plane faces of elements, one after the other.

    Parameters
    ----------
    elements : sequence of Element
        In order.
    every : bool
        Whether those of solids that have curved faces as well are among them; their kernels have
        bounds of their own.

    Attributes
    ----------
    begin : ndarray, shape (n + 1,), int64
        Where each element's faces begin.
    owner, number : ndarray, shape (faces,), int64
        Whose face it is, and which.
    centres : ndarray, shape (faces, 3), float64
        In metres.
    frames : ndarray, shape (faces, 3, 3), float64
        Rows u, v and normal.
    halves : ndarray, shape (faces, 2), float64
        Half extents along u and v in metres.
    far : ndarray, shape (faces,), float64
        Bound of their coordinates in metres.
    """

    def __init__(self, elements: Sequence[Element], *, every: bool = False) -> None:
        self.elements = elements
        self.faces: list[Plane] = []
        owners: list[int] = []
        numbers: list[int] = []
        begin = [0]
        for n, element in enumerate(elements):
            found = [(k, face) for k, face in enumerate(element.faces) if isinstance(face, Plane)]
            if every or len(found) == len(element.faces):
                self.faces += [face for _, face in found]
                numbers += [k for k, _ in found]
                owners += [n] * len(found)
            begin.append(len(self.faces))
        self.begin = np.array(begin)
        self.owner, self.number = np.array(owners, np.int64), np.array(numbers, np.int64)
        position = np.array([elements[n].position for n in owners]).reshape(-1, 3)
        turn = np.array([elements[n].frame for n in owners]).reshape(-1, 3, 3)
        # written out, so that no machine's matrix product decides a bit
        centres = np.array([face.centre for face in self.faces]).reshape(-1, 3)
        self.centres = _turned(centres, turn) + position
        frames = np.array([face.frame for face in self.faces]).reshape(-1, 3, 3)
        self.frames = np.stack([_turned(frames[:, k], turn) for k in range(3)], axis=1)
        self.halves = np.array([face.outline.half_sizes for face in self.faces]).reshape(-1, 2)
        self.far = np.abs(self.centres).max(axis=1, initial=0.0) + self.halves.max(
            axis=1, initial=0.0
        )

    def place(self, face: int, point: Vec3) -> tuple[float, float]:
        """Return u and v of a world point from the centre of a face."""
        x, y, _ = self.faces[face].within(self.elements[self.owner[face]].local(point))
        return x, y

    def at(self, face: int, u: float, v: float) -> Vec3:
        """Return the world point at u and v from the centre of a face."""
        along_u, along_v, _ = self.frames[face]
        x, y, z = (self.centres[face] + u * along_u + v * along_v).tolist()
        return (x, y, z)


def _turned(local: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return local vectors, shape (n, 3), in the world, by the rows of their frames."""
    x, y, z = (local[:, k : k + 1] for k in range(3))
    return np.asarray(x * rows[:, 0] + y * rows[:, 1] + z * rows[:, 2])


def dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scalar products of vectors, shape (n, 3) each."""
    return np.asarray((a * b).sum(axis=1))


def face_pairs(
    near: Neighbours, first_begin: Numbers, second_begin: Numbers, wanted: Wanted
) -> Iterator[tuple[Numbers, Numbers]]:
    """Give the pairs of faces of different elements whose boxes meet, the smaller number first.

    Parameters
    ----------
    near : Neighbours
        The elements.
    first_begin, second_begin : ndarray, shape (n + 1,), int64
        Where each element's faces begin, of the first and of the second faces.
    wanted : callable
        Says which pairs of elements are looked at, by their numbers.

    Yields
    ------
    first, second : ndarray, shape (pairs,), int64
        Numbers of faces; a part of them, which bounds the memory.
    """
    for one, other in near.pairs():
        ordered = one < other
        ordered[ordered] = wanted(one[ordered], other[ordered])
        i, j = one[ordered], other[ordered]
        rows = second_begin[j + 1] - second_begin[j]
        many = (first_begin[i + 1] - first_begin[i]) * rows
        ends = np.cumsum(many)
        start = 0
        while start < len(i):
            stop = max(start + 1, int(np.searchsorted(ends, ends[start] - many[start] + _AT_ONCE)))
            part = slice(start, stop)
            which = np.repeat(np.arange(start, min(stop, len(i))), many[part])
            within = np.arange(len(which)) - np.repeat(
                ends[part] - many[part] - (ends[start] - many[start]), many[part]
            )
            yield (
                first_begin[i[which]] + within // rows[which],
                second_begin[j[which]] + within % rows[which],
            )
            start = stop


def coplanar(near: Neighbours, faces: PlaneFaces, wanted: Wanted) -> Iterator[tuple[int, int]]:
    """Give pairs of faces of different elements in one plane to rounding that overlap.

    That of the first element comes first. `wanted` is asked which pairs of elements are looked at,
    by their numbers, some thousands at once and each again before it is given.
    """
    frames, centres, halves, far = faces.frames, faces.centres, faces.halves, faces.far
    size = halves.max(axis=1, initial=0.0)
    for i, j in face_pairs(near, faces.begin, faces.begin, wanted):
        apart, room = centres[j] - centres[i], near.rounding * np.maximum(far[i], far[j])
        flush = np.abs(dot(apart, frames[i, 2])) <= room
        # where they meet at an angle it lifts the smaller out of the plane
        cosine = dot(frames[i, 2], frames[j, 2])[:, None]
        sine = np.linalg.norm(frames[j, 2] - cosine * frames[i, 2], axis=1)
        flush &= sine * np.minimum(size[i], size[j]) <= room
        for one, other in ((i, j), (j, i)):
            for k in (0, 1):
                along = frames[one, k]
                reach = halves[one, k] + sum(
                    halves[other, m] * np.abs(dot(frames[other, m], along)) for m in (0, 1)
                )
                flush &= np.abs(dot(apart, along)) < reach - room
        for k, m in zip(i[flush].tolist(), j[flush].tolist(), strict=True):
            if wanted(faces.owner[k], faces.owner[m]) and overlap(faces, k, m):
                yield k, m


def overlap(faces: PlaneFaces, i: int, j: int) -> bool:
    """Say whether two faces in one plane, whose bounding rectangles overlap, do so as well."""
    for large, small in ((i, j), (j, i)):  # one in the other's hole
        hole = faces.faces[large].hole
        if hole is not None and _holds(faces, large, hole, small):
            return False
    a, b = faces.faces[i].outline, faces.faces[j].outline
    if b.rounding:
        i, j, a, b = j, i, b, a
    if not a.rounding:
        return True
    x, y = faces.place(j, faces.at(i, 0.0, 0.0))
    return b.from_core(x, y) < (a.rounding + b.rounding) * (1.0 - ROUNDING)


def lies_within(faces: PlaneFaces, small: int, large: int) -> bool:
    """Say whether no point of a face is outside another one in the same plane."""
    one, other = faces.faces[small], faces.faces[large]
    if not _holds(faces, large, other.outline, small):
        return False
    if other.hole is None:
        return True
    # then the other's hole is in its own
    return one.hole is not None and _holds(faces, small, one.hole, large, other.hole)


def _holds(
    faces: PlaneFaces, large: int, outline: Outline, small: int, what: Outline | None = None
) -> bool:
    """Say whether an outline of one face holds that of another one, or another outline there."""
    what = what or faces.faces[small].outline
    return all(
        outline.holds(*faces.place(large, faces.at(small, u, v)), what.rounding, _GROWN)
        for u, v in what.corners
    )
