"""How much room for rounding the edges of flat elements need where they meet at a small angle.

Two faces that share an edge agree on where it is only to the rounding of their positions, δ. Where
they meet at an angle α, or π − α, a ray between them finds no gap if each goes on beyond its edge
by about δ/sin α, and a point put back onto one of them is on the right side of the other if it
stays as far within. The kernels' bounds hold for sin α ≥ 1/2 (gated); for less they are multiplied
by what is found here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.planes import PlaneFaces, dot
from photizon_cl.scene.faces import Plane, Revolved
from photizon_cl.scene.frames import to_local
from photizon_cl.scene.outlines import Circular, Rectangular

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element

__all__ = ["edge_factors"]

_SHARP: Final = 0.5
"""Sine of the angle from which on the bounds hold as they are."""
_AT_ONCE: Final = 1 << 16
"""Pairs looked at at once, which bounds the memory."""


def edge_factors(near: Neighbours) -> NDArray[np.float64]:
    """Return by how much each element's bounds at its edges are to be multiplied.

    Parameters
    ----------
    near : Neighbours
        The elements of a scene.

    Returns
    -------
    ndarray, shape (n, 4), float64
        For the edges at +u, −u, +v and −v: 1/sin of the smallest angle that a rectangle makes with
        a plane face on which this edge lies, or a disk with the surface of revolution on which its
        rim or that of its hole lies, if that is more than 2; else 1.
    """
    elements = near.elements
    factors = np.ones((len(elements), 4))
    kinds = _Kinds(elements)
    # plane faces along the axes meet at right angles
    if kinds.curved.any() or kinds.tilted[kinds.plane].any():
        meant = np.flatnonzero(kinds.plane | kinds.curved).tolist()
        if len({elements[n].position for n in meant}) == len(meant):
            return _factors(near, kinds)
        # coincident elements have the same edges: the first stands for all
        first: dict[Any, int] = {}
        stands_for = {}
        for n in meant:
            e = elements[n]
            stands_for[n] = first.setdefault((e.position, e.frame, e.faces), n)
        asked = list(first.values())
        if len(asked) < len(stands_for):
            some = [elements[n] for n in asked]
            factors[asked] = _factors(Neighbours(some, near.roundoff), _Kinds(some))
        else:
            factors = _factors(near, kinds)
        factors[list(stands_for)] = factors[list(stands_for.values())]
    return factors


class _Kinds:
    """What the faces of elements are, as arrays of shape (n,), bool.

    plane
        All of them are planes.
    sides, rims
        One plane in a rectangle; one in a circle.
    curved
        One surface of revolution, where there are rims that may lie on it.
    tilted
        Their frame is no permutation of the axes.
    """

    def __init__(self, elements: Sequence[Element]) -> None:
        sole = [e.sole_face for e in elements]
        outlines = [face.outline if isinstance(face, Plane) else None for face in sole]
        self.sides = np.array([isinstance(o, Rectangular) for o in outlines], bool)
        self.rims = np.array([isinstance(o, Circular) for o in outlines], bool)
        curved = np.array([isinstance(face, Revolved) for face in sole], bool)
        self.curved = curved & self.rims.any()
        self.tilted = np.array([e.tilt_deg != (0.0, 0.0) for e in elements], bool)
        many = [
            face is None and all(isinstance(f, Plane) for f in e.faces)
            for face, e in zip(sole, elements, strict=True)
        ]
        self.plane = self.sides | self.rims | np.array(many, bool)


def _factors(near: Neighbours, kinds: _Kinds) -> NDArray[np.float64]:
    elements, rooms = near.elements, near.rooms
    factors = np.ones((len(elements), 4))
    faces = PlaneFaces(elements)
    for first, second in near.pairs():
        tilted = kinds.tilted[first] | kinds.tilted[second]
        angle = kinds.sides[first] & kinds.plane[second] & tilted
        _sharpen(factors, faces, first[angle], second[angle], rooms)
        on_curved = kinds.rims[first] & kinds.curved[second]
        for i, j in zip(first[on_curved].tolist(), second[on_curved].tolist(), strict=True):
            room = float(max(rooms[i], rooms[j]))
            sine = _rim_on(elements[i], elements[j], faces, int(faces.begin[i]), room)
            factors[i] = np.maximum(factors[i], 1.0 / sine)
    factors[factors < 1.0 / _SHARP] = 1.0
    return factors


def _rim_on(flat: Element, other: Element, faces: PlaneFaces, at: int, room: float) -> float:
    """Return the sine of the angle of a disk with the surface on which its rim lies, else 1."""
    plane, curved = flat.sole_face, other.sole_face
    assert isinstance(plane, Plane)
    assert isinstance(curved, Revolved)
    centre, normal = (tuple(v[at].tolist()) for v in (faces.centres, faces.frames[:, 2]))
    place, along = other.local(centre), to_local(other.frame, normal)
    rims = [plane.outline] if plane.hole is None else [plane.outline, plane.hole]
    found = [curved.rim_sine(place, along, rim.rounding, room) for rim in rims]
    return min((sine for sine in found if sine is not None), default=1.0)


# -- plane faces ---------------------------------------------------------------------------------


def _sharpen(
    factors: NDArray[np.float64],
    faces: PlaneFaces,
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    rooms: NDArray[np.float64],
) -> None:
    """Raise the factors of rectangles `first` by the angles they make with faces of `second`."""
    begin = faces.begin
    many = begin[second + 1] - begin[second]
    one = np.repeat(first, many)
    within = np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    other = np.repeat(begin[second], many) + within
    room = np.repeat(np.maximum(rooms[first], rooms[second]), many)
    for start in range(0, len(one), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        sine = _sharpest(faces, begin[one[part]], other[part], room[part])
        np.maximum.at(factors, one[part], 1.0 / sine)


def _sharpest(
    faces: PlaneFaces,
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    room: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the sines of the angles at which the edges of rectangles end on faces, else 1."""
    centre, half = faces.centres[one], faces.halves[one]
    normal, origin = faces.frames[other, 2], faces.centres[other]
    sine = np.ones((len(one), 4))
    for along, across in ((0, 1), (1, 0)):
        e, f = faces.frames[one, along], faces.frames[one, across]
        for k, sign in enumerate((1.0, -1.0)):
            edge = centre + sign * half[:, along, None] * e - origin
            height = dot(edge, normal)
            slope = half[:, across] * np.abs(dot(f, normal))
            rise = np.abs(dot(e, normal))
            # the edge lies in the face's plane, and not the whole rectangle
            ends = (np.abs(height) + slope <= room) & (2.0 * half[:, along] * rise > room)
            sine[ends, 2 * along + k] = rise[ends]
    return sine
