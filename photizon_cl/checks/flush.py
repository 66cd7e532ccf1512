"""Flat elements that lie in each other: order decides which of them is hit, or rounding."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.flat import Flat

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from photizon_cl.scene.model import Scene

__all__ = ["flush_elements"]

_ROUNDING: Final = 2.0**-48
"""What rounding may make of a distance between planes or edges, relative to the coordinates."""
_APART: Final = 256.0
"""How many times that is a gap that is worth building."""


def flush_elements(scene: Scene) -> Iterator[str]:
    """Give a sentence for each flat element of which an earlier one takes hits, or rounding may.

    Two elements in a plane across an axis at the same coordinate, or around the same centre, are
    equally far from every ray: the one named first is hit. Elsewhere the distances round apart. A
    small element in a larger one that is named later is what users mean, and nothing is said.
    """
    flats, planes = _distinct(scene)
    if len(flats) < 2:
        return
    told: set[int] = set()
    for i, j, room in _flush_pairs(flats):
        over, under = flats[i], flats[j]
        if j in told or not _overlap(over, under):
            continue
        if planes[i] != planes[j]:
            told.add(j)
            yield (
                f'elements "{over.name}" and "{under.name}" lie in one plane to within rounding: '
                "which of them is hit where they overlap is left to rounding, ray by ray; move one "
                f"of them by {_APART * room:.0e} m or more"
            )
            continue
        whole = _lies_within(under, over)
        if not over.surface.splits and (whole or not _lies_within(over, under)):
            told.add(j)
            yield (
                f'element "{under.name}" lies {"" if whole else "partly "}flush in "{over.name}", '
                "which is named first and takes every hit where both are equally near"
                + (f': "{under.name}" is never hit' if whole else "")
                + "; name it first, or move it"
            )


def _distinct(scene: Scene) -> tuple[list[Flat], list[int]]:
    """Return the flat elements without those that an earlier one covers, and their planes."""
    numbers: dict[tuple[object, ...], int] = {}
    taken: set[tuple[object, ...]] = set()
    flats: list[Flat] = []
    planes: list[int] = []
    for flat in scene.element:
        if not isinstance(flat, Flat):
            continue
        shape = (flat.kind, flat.position, flat.frame, flat.half_sizes)
        if shape in taken:
            continue
        if not flat.surface.splits:
            taken.add(shape)
        flats.append(flat)
        axis, (x, y, z) = flat.class_axis, flat.frame[2]
        across = (axis, flat.position[axis]) if axis is not None else None
        plane = across or (flat.position, max((x, y, z), (-x, -y, -z)))
        planes.append(numbers.setdefault(plane, len(numbers)))
    return flats, planes


def _flush_pairs(flats: list[Flat]) -> Iterator[tuple[int, int, float]]:
    """Give pairs in one plane to rounding whose rectangles overlap, and that rounding."""
    frames = np.array([f.frame for f in flats])
    centres = np.array([f.position for f in flats])
    halves = np.array([f.half_sizes for f in flats])
    size = halves.max(axis=1)
    far = np.abs(centres).max(axis=1) + size
    for first, second in Neighbours(flats).pairs():
        ordered = first < second
        i, j = first[ordered], second[ordered]
        apart, room = centres[j] - centres[i], _ROUNDING * np.maximum(far[i], far[j])
        flush = np.abs(_dot(apart, frames[i, 2])) <= room
        # where they meet at an angle it lifts the smaller out of the plane
        cosine = _dot(frames[i, 2], frames[j, 2])[:, None]
        sine = np.linalg.norm(frames[j, 2] - cosine * frames[i, 2], axis=1)
        flush &= sine * np.minimum(size[i], size[j]) <= room
        for one, other in ((i, j), (j, i)):
            for k in (0, 1):
                along = frames[one, k]
                reach = halves[one, k] + sum(
                    halves[other, m] * np.abs(_dot(frames[other, m], along)) for m in (0, 1)
                )
                flush &= np.abs(_dot(apart, along)) < reach - room
        yield from zip(i[flush].tolist(), j[flush].tolist(), room[flush].tolist(), strict=True)


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((a * b).sum(axis=1))


def _overlap(a: Flat, b: Flat) -> bool:
    """Say whether two elements in one plane, whose bounding rectangles overlap, do so as well."""
    if isinstance(b, Disk):
        a, b = b, a
    if not isinstance(a, Disk):
        return True
    x, y, _ = b.local(a.position)
    if isinstance(b, Disk):
        return math.hypot(x, y) < (a.radius + b.radius) * (1.0 - _ROUNDING)
    u, v = b.half_sizes
    beside = math.hypot(max(abs(x) - u, 0.0), max(abs(y) - v, 0.0))
    return beside < a.radius * (1.0 - _ROUNDING)


def _lies_within(small: Flat, large: Flat) -> bool:
    """Say whether no point of an element is outside another one in the same plane."""
    grown = 1.0 + _ROUNDING
    (u, v), (half_u, half_v) = large.half_sizes, small.half_sizes
    x, y, _ = large.local(small.position)
    if isinstance(small, Disk):
        if isinstance(large, Disk):
            return math.hypot(x, y) + small.radius <= large.radius * grown
        return abs(x) + small.radius <= u * grown and abs(y) + small.radius <= v * grown
    corners = [
        large.local((x, y, z))
        for a, b in product((-half_u, half_u), (-half_v, half_v))
        for x, y, z in [np.add(small.position, np.dot((a, b), small.frame[:2])).tolist()]
    ]
    if isinstance(large, Disk):
        return all(math.hypot(x, y) <= large.radius * grown for x, y, _ in corners)
    return all(abs(x) <= u * grown and abs(y) <= v * grown for x, y, _ in corners)
