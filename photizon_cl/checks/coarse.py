"""What its coordinates cannot carry: far from the origin doubles are coarse.

A hit counts as within an element up to some roundings of the coordinates beyond its edges, so that
elements that share an edge leave no gap (`photizon_cl.scene.elements.flat`). These are roundings
of the position as it was given: an element that is tiny beside its distance from the origin comes
out too large by as much, and the points and normals of a curved one are off by as much.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.elements.flat import EDGES_TILTED
from photizon_cl.scene.faces import Ball, Plane, Revolved, Straight

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source

__all__ = ["coarse", "relative_error", "spacing"]

_NOTED: Final = 1e-6
"""Relative error that is worth a word: no run sees less, since a standard error of as much takes
about 10^12 rays; a run of an hour on a fast device reaches 10^-5."""
_MET: Final = 2.0
"""Roundings of the place at which a ray meets an element."""
_EDGES: Final = EDGES_TILTED[0] + _MET
"""Roundings (2^-53 of the farthest coordinate) by which an edge may seem to stand off: as many as a
hit may lie beyond it and count, at most (those of a tilted one), and those of the hit."""
_NAMED: Final = 20
"""So many elements are named; of the others only how many there are."""
_CLOSED: Final = 2.0**-40
"""A rim that is so small beside its face is a pole; sin π is not 0 in floating point."""
_PLACES: Final = np.linspace(0.0, 1.0, 33)


def coarse(scene: Scene) -> Iterator[str]:
    """Give a sentence for each element and source that is too small for its coordinates."""
    yield from _limited(map(_element, scene.element), "elements")
    yield from _limited(map(_source, scene.source), "sources")


def _limited(found: Iterable[str | None], what: str) -> Iterator[str]:
    texts = [text for text in found if text is not None]
    yield from texts[:_NAMED]
    if len(texts) > _NAMED:
        yield f"{len(texts) - _NAMED} more {what} are as small beside their distances"


def _element(element: Element) -> str | None:
    error, size = relative_error(element)
    if error <= _NOTED:
        return None
    most = f"{error:.1e} of what they are" if error < 1.0 else "all of what they are, or more"
    return (
        f'element "{element.name}" is small beside its distance from the origin, or an opening in '
        f"it is: {_where(size, element.position)}. Its area or its openings may come out wrong by "
        f"up to {most}, and normals of curved faces by as much; {_REMEDY}"
    )


def _source(source: Source) -> str | None:
    if source.face is None:
        return None
    size = source.reach
    step = spacing(source.position)
    if step <= _NOTED * size:
        return None
    return (
        f'source "{source.name}" is small beside its distance from the origin: '
        f"{_where(2.0 * size, source.position)}. That is the grid that its rays start on; {_REMEDY}"
    )


_REMEDY: Final = "give all positions relative to a point near it"


def _where(size: float, position: Iterable[float]) -> str:
    far = max(map(abs, position))
    return f"{size:.3g} m across at {far:.3g} m, where doubles are {math.ulp(far):.1e} m apart"


def spacing(position: Iterable[float]) -> float:
    """Return the distance in metres of neighbouring doubles at the farthest coordinate."""
    return math.ulp(max(map(abs, position)))


def relative_error(element: Element) -> tuple[float, float]:
    """Return by how much an element's areas may be wrong because of where it stands, and its size.

    An edge stands off by at most δ, `_EDGES` roundings of the position's farthest coordinate. A
    face of half sizes s and t changes its area by δ/s + δ/t to first order: faces count by their
    areas, so that a narrow one of little area is no fault, and openings each by its own, since
    light goes through them. The rim of an opening in a ball is where a plane cuts it, at the angle
    θ: it moves aside by δ/sin θ.

    Returns
    -------
    error : float
        Relative, of an area; not negative.
    size : float
        What is worst carried, in metres from edge to edge; 0 for an element without area.
    """
    edge = _EDGES * 2.0**-53 * max(map(abs, element.position))
    faces, openings = [], []
    for face in element.faces:
        sizes, through = _extents(face)
        faces.append(sizes)
        cut = face.radius if isinstance(face, Ball) and element.opening else 0.0
        openings += [(edge / half * (2.0 * max(cut / half, 1.0)), half) for half in through]
    largest = max((size for size, _ in faces), default=0.0)
    if not largest > 0.0:
        return 0.0, 0.0
    # an area is a product of two lengths: relative to the largest none overflows
    areas = [size / largest * (width / largest) for size, width in faces]
    total = math.fsum(areas)
    if not total > 0.0:
        return 0.0, 0.0
    # a face of no width has no area either: what its edges add counts all the same
    added = math.fsum(edge / largest * (size / largest + width / largest) for size, width in faces)
    whole = added / total
    worst = max(openings, default=(0.0, 0.0))
    if worst[0] > whole:
        return worst[0], 2.0 * worst[1]
    narrowest = min(width for (_, width), area in zip(faces, areas, strict=True) if area > 0.0)
    return whole, 2.0 * narrowest


def _extents(face: Face) -> tuple[tuple[float, float], list[float]]:
    """Return a face's two half sizes, along and across, and those of the openings in it."""
    if isinstance(face, Plane):
        if face.empty:
            return (0.0, 0.0), []
        u, v = face.outline.half_sizes
        if face.hole is None:
            return (max(u, v), min(u, v)), []
        inner = face.hole.half_sizes
        # a frame: half as wide as what is left of its half size, and four times as long
        width = min(u - inner[0], v - inner[1]) / 2.0
        return (max(u, v), width), [min(inner)] if min(inner) > 0.0 else []
    if not isinstance(face, Revolved):
        return (0.0, 0.0), []  # of its extents nothing is known
    ends, widest, along = _profile(face)
    return (max(widest, along), min(widest, along)), [r for r in ends if r > _CLOSED * widest]


def _profile(face: Revolved) -> tuple[tuple[float, float], float, float]:
    """Return a profile's radii at its ends, its largest one, and half its length.

    From the parameters of the usual ones; there may be thousands.
    """
    if isinstance(face, Straight):
        low, high = face.radii
        return face.radii, max(low, high), math.hypot(high - low, face.length) / 2.0
    if isinstance(face, Ball):
        first, last = face.polar
        ends = (abs(face.radius * math.sin(first)), abs(face.radius * math.sin(last)))
        over = first <= math.pi / 2.0 <= last
        return ends, face.radius if over else max(ends), face.radius * (last - first) / 2.0
    radius, height = face.profile(_PLACES)
    along = math.fsum(map(math.hypot, np.diff(radius).tolist(), np.diff(height).tolist())) / 2.0
    return (float(radius[0]), float(radius[-1])), float(radius.max()), along
