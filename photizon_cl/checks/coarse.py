"""What its coordinates cannot carry: far from the origin numbers are coarse.

A hit counts as within an element up to some roundings of the coordinates beyond its edges, so that
elements that share an edge leave no gap (`photizon_cl.scene.elements.flat`). These are roundings
of the position as it was given: an element that is tiny beside its distance from the origin comes
out too large by as much, and the points and normals of a curved one are off by as much.

In single precision that is so of what is small beside the scene, and its products have a range.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.placing import bounded, recentre
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.elements.flat import EDGES_TILTED
from photizon_cl.scene.faces import Ball, Plane, Revolved, Straight

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.faces import Face
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source

__all__ = ["coarse", "lost", "relative_error"]

_NOTED: Final = 1e-6
"""Relative error that is worth a word: no run sees less, since a standard error of as much takes
about 10^12 rays; a run of an hour on a fast device reaches 10^-5."""
_NOTED_SINGLE: Final = 1e-4
"""The same in single precision, whose results are good to some 10^-6 wherever elements stand: who
asks for it is after less."""
_LOST: Final = 0.1
"""From such an error on an element is lost in single precision: a run says something else."""
_RANGE: Final = (1e-12, 1e15)
"""Metres of which single precision still holds the squares with the rounding of their sums."""
_SHORTEST: Final = 32.0
"""Roundings of an element's coordinates that a length of it must have, as a vertex radius."""
_THINNEST: Final = 4.0
"""The same of its thickness."""
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


def coarse(scene: Scene, roundoff: float = ROUNDOFF) -> Iterator[str]:
    """Give a sentence for each element and source that is too small for its coordinates.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    roundoff : float, optional
        Unit roundoff of the coordinates that the kernels compute in.
    """
    grid = _Grid(scene, roundoff)
    small = "are as small beside their distances"
    yield from _limited((_element(e, grid) for e in scene.element), f"elements {small}")
    yield from _limited((_source(s, grid) for s in scene.source), f"sources {small}")
    absorption = {m.name: m.most_absorption for m in scene.medium if m.absorbs}
    borders = (_border(e, absorption, grid) for e in scene.element)
    yield from _limited(borders, "elements are such borders")


def lost(scene: Scene, roundoff: float) -> str:
    """Say what of a scene coordinates of single precision cannot carry at all; empty where nothing.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    roundoff : float
        As `coarse` takes it; of doubles nothing is lost that was given in them.
    """
    if roundoff == ROUNDOFF:
        return ""
    grid = _Grid(scene, roundoff)
    for element in scene.element:
        error, size = relative_error(element, grid)
        if error > _LOST:
            return (
                f'element "{element.name}" is lost in it: {grid.where(size, element)}, so '
                f"that its area or its openings would come out wrong by {min(error, 1.0):.1e}"
            )
        below = _below(element, grid)
        if below:
            return below
        least, most = _RANGE
        if not (least <= size or size == 0.0) or grid.reached(element) > most:
            found = size if size < least else grid.reached(element)
            return (
                f'element "{element.name}" has lengths of {found:.1e} m, and single precision '
                f"holds squares of those from {least:g} to {most:g} m"
            )
    return ""


def _below(element: Element, grid: _Grid) -> str:
    """Say which of an element's lengths is below the rounding of its coordinates, or nothing."""
    rounding = grid.roundoff * grid.reached(element)
    for name, parameter in parameters_of(type(element)).items():
        value = getattr(element, name)
        length = getattr(parameter, "unit", "") == "m" and isinstance(value, float)
        if length and 0.0 < abs(value) < _SHORTEST * rounding:
            return (
                f'element "{element.name}" is lost in it: its {name} of {value:.3g} m is below '
                f"{_SHORTEST * rounding:.1e} m, what {_SHORTEST:.0f} roundings of its coordinates "
                "amount to"
            )
    low, high = element.local_box
    thickness = min(b - a for a, b in zip(low, high, strict=True))
    if not element.flat and thickness < _THINNEST * rounding:
        return (
            f'element "{element.name}" is lost in it: it is {thickness:.1e} m thick, and its faces '
            f"are good to {rounding:.1e} m"
        )
    return ""


class _Grid:
    """How fine the kernels' coordinates are at a place.

    Parameters
    ----------
    scene : Scene or None
        Whose coordinates; in single precision those of the recentred scene.
    roundoff : float
        Unit roundoff of them.
    """

    def __init__(self, scene: Scene | None = None, roundoff: float = ROUNDOFF) -> None:
        self.roundoff, self.single = roundoff, roundoff != ROUNDOFF
        self._shift = recentre(scene) if scene and self.single else (0.0, 0.0, 0.0)

    @property
    def noted(self) -> float:
        """Relative error that is worth a word."""
        return _NOTED_SINGLE if self.single else _NOTED

    def far(self, position: Sequence[float]) -> float:
        """Return the farthest coordinate of a position, in metres, that its rounding follows."""
        return max(bounded(position, self._shift, self.roundoff))

    def reached(self, thing: Element | Source) -> float:
        """Return the farthest coordinate of what is compared with the size of something.

        Of doubles an element's own size is many.
        """
        return self.far(thing.position) + (thing.reach if self.single else 0.0)

    def spacing(self, thing: Element | Source) -> float:
        """Return the distance in metres of neighbouring numbers there."""
        return math.ulp(self.reached(thing)) * (self.roundoff / ROUNDOFF)

    def where(self, size: float, thing: Element | Source) -> str:
        """Say how large something is beside the grid where it stands."""
        what = "single-precision numbers" if self.single else "doubles"
        return (
            f"{size:.3g} m across at {self.reached(thing):.3g} m, where {what} are "
            f"{self.spacing(thing):.1e} m apart"
        )

    @property
    def remedy(self) -> str:
        """What to do."""
        if self.single:
            return "run it in fp64"
        return "give all positions relative to a point near it"

    @property
    def beside(self) -> str:
        """What small things are small beside."""
        if self.single:
            return "its length or its distance from the middle of the scene, in single precision"
        return "its distance from the origin"


_DOUBLES: Final = _Grid()


def _limited(found: Iterable[str | None], what: str) -> Iterator[str]:
    texts = [text for text in found if text is not None]
    yield from texts[:_NAMED]
    if len(texts) > _NAMED:
        yield f"{len(texts) - _NAMED} more {what}"


def _element(element: Element, grid: _Grid) -> str | None:
    error, size = relative_error(element, grid)
    if error <= grid.noted:
        return None
    most = f"{error:.1e} of what they are" if error < 1.0 else "all of what they are, or more"
    return (
        f'element "{element.name}" is small beside {grid.beside}, or an opening in it is: '
        f"{grid.where(size, element)}. Its area or its openings may come out wrong by "
        f"up to {most}, and normals of curved faces by as much; {grid.remedy}"
    )


def _border(element: Element, absorption: Mapping[str, float], grid: _Grid) -> str | None:
    """Tell a border of a medium that absorbs much on a rounding of where the border is."""
    beside = {name for s in element.surfaces for name in s.media or () if name in absorption}
    name = max(beside, key=absorption.__getitem__, default="")
    step = _MET * grid.roundoff * grid.reached(element)
    error = absorption.get(name, 0.0) * step
    if error <= grid.noted:
        return None
    middle = "the middle of the scene, in single precision" if grid.single else "the origin"
    return (
        f'element "{element.name}", a border of medium "{name}" of {absorption[name]:.3g}/m, '
        f"reaches to {grid.reached(element):.3g} m from {middle}: ways in it are good to "
        f"{step:.1e} m, so that what they leave may be wrong by {min(error, 1.0):.1e} of it; "
        f"{grid.remedy}"
    )


def _source(source: Source, grid: _Grid) -> str | None:
    if source.face is None:
        return None
    size = source.reach
    step = grid.spacing(source)
    if step <= grid.noted * size:
        return None
    return (
        f'source "{source.name}" is small beside {grid.beside}: '
        f"{grid.where(2.0 * size, source)}. That is the grid that its rays start on; "
        f"{grid.remedy}"
    )


def relative_error(element: Element, grid: _Grid = _DOUBLES) -> tuple[float, float]:
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
    edge = _EDGES * grid.roundoff * grid.reached(element)
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
