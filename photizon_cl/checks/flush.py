"""Flat elements that lie in each other: order decides which of them is hit, or rounding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.planes import PlaneFaces, dot, sole_plane

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.faces import Outline, Plane
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.model import Scene

__all__ = ["flush_elements"]

_ROUNDING: Final = 2.0**-48
"""What rounding may make of a distance between planes or edges, relative to the coordinates."""
_GROWN: Final = 1.0 + _ROUNDING
_APART: Final = 256.0
"""How many times that is a gap that is worth building."""


@dataclass(frozen=True, eq=False)
class _Flat:
    """An element that is a part of a plane, and a number of that plane."""

    element: Element
    face: Plane
    plane: int

    def place(self, point: Vec3) -> tuple[float, float]:
        """Return u and v of a world point from the centre of the face."""
        x, y, _ = self.face.within(self.element.local(point))
        return x, y


def flush_elements(scene: Scene) -> Iterator[str]:
    """Give a sentence for each flat element of which an earlier one takes hits, or rounding may.

    Two elements in a plane across an axis at the same coordinate, or around the same centre, are
    equally far from every ray: the one named first is hit. Elsewhere the distances round apart. A
    small element in a larger one that is named later is what users mean, and nothing is said.
    """
    flats = _distinct(scene)
    if len(flats) < 2:
        return
    faces = PlaneFaces([flat.element for flat in flats])
    told: set[int] = set()
    for i, j, room in _flush_pairs(flats, faces):
        over, under = flats[i].element, flats[j].element
        if j in told or not _overlap(flats, faces, i, j):
            continue
        if flats[i].plane != flats[j].plane:
            told.add(j)
            yield (
                f'elements "{over.name}" and "{under.name}" lie in one plane to within rounding: '
                "which of them is hit where they overlap is left to rounding, ray by ray; move one "
                f"of them by {_APART * room:.0e} m or more"
            )
            continue
        whole = _lies_within(flats, faces, j, i)
        if not over.surface.transmits and (whole or not _lies_within(flats, faces, i, j)):
            told.add(j)
            yield (
                f'element "{under.name}" lies {"" if whole else "partly "}flush in "{over.name}", '
                "which is named first and takes every hit where both are equally near"
                + (f': "{under.name}" is never hit' if whole else "")
                + "; name it first, or move it"
            )


def _distinct(scene: Scene) -> list[_Flat]:
    """Return the flat elements without those that an earlier one covers."""
    numbers: dict[tuple[object, ...], int] = {}
    taken: set[tuple[object, ...]] = set()
    flats: list[_Flat] = []
    for element in scene.element:
        face = sole_plane(element)
        if face is None:
            continue
        shape = (element.position, element.frame, face)
        if shape in taken:
            continue
        if not element.surface.transmits:
            taken.add(shape)
        axis, (x, y, z) = element.class_axis, element.frame[2]
        across = (axis, element.position[axis]) if axis is not None else None
        plane = across or (element.position, max((x, y, z), (-x, -y, -z)))
        flats.append(_Flat(element, face, numbers.setdefault(plane, len(numbers))))
    return flats


def _flush_pairs(flats: list[_Flat], faces: PlaneFaces) -> Iterator[tuple[int, int, float]]:
    """Give pairs in one plane to rounding whose rectangles overlap, and that rounding."""
    frames, centres, halves = faces.frames, faces.centres, faces.halves
    size = halves.max(axis=1)
    far = np.abs(centres).max(axis=1) + size
    for first, second in Neighbours([flat.element for flat in flats]).pairs():
        ordered = first < second
        i, j = first[ordered], second[ordered]
        apart, room = centres[j] - centres[i], _ROUNDING * np.maximum(far[i], far[j])
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
        yield from zip(i[flush].tolist(), j[flush].tolist(), room[flush].tolist(), strict=True)


def _overlap(flats: list[_Flat], faces: PlaneFaces, i: int, j: int) -> bool:
    """Say whether two elements in one plane, whose bounding rectangles overlap, do so as well."""
    for large, small in ((i, j), (j, i)):  # one in the other's hole
        hole = flats[large].face.hole
        if hole is not None and _holds(flats[large], hole, flats[small], faces, small):
            return False
    a, b = flats[i].face.outline, flats[j].face.outline
    if b.rounding:
        i, j, a, b = j, i, b, a
    if not a.rounding:
        return True
    x, y = flats[j].place(_centre(faces, i))
    return b.from_core(x, y) < (a.rounding + b.rounding) * (1.0 - _ROUNDING)


def _lies_within(flats: list[_Flat], faces: PlaneFaces, small: int, large: int) -> bool:
    """Say whether no point of an element is outside another one in the same plane."""
    one, other = flats[small], flats[large]
    if not _holds(other, other.face.outline, one, faces, small):
        return False
    if other.face.hole is None:
        return True
    own = one.face.hole  # then the other's hole is in its own
    return own is not None and _holds(one, own, other, faces, large, other.face.hole)


def _holds(
    large: _Flat,
    outline: Outline,
    small: _Flat,
    faces: PlaneFaces,
    number: int,
    what: Outline | None = None,
) -> bool:
    """Say whether an outline of one face holds that of another one, or another outline there."""
    what = what or small.face.outline
    centre, (u, v, _) = faces.centres[number], faces.frames[number]
    return all(
        outline.holds(*large.place(tuple((centre + a * u + b * v).tolist())), what.rounding, _GROWN)
        for a, b in what.corners
    )


def _centre(faces: PlaneFaces, number: int) -> Vec3:
    x, y, z = faces.centres[number].tolist()
    return (x, y, z)
