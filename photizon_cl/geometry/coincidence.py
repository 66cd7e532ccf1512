"""Faces of different elements in one place: in one plane, on one ball, touching in a point.

There several faces are hit at one distance, which rounding makes differ. What their surfaces are
says which of them comes first (kernels/lib/coincidence.mako).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.planes import PlaneFaces, coplanar, face_pairs
from photizon_cl.scene.elements.base import ROUNDOFF
from photizon_cl.scene.faces import Ball, Revolved

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from photizon_cl.geometry.planes import Wanted
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.surfaces import Surface

__all__ = ["Shared", "shared_places", "unordered"]

_HEIGHTS: Final = (0.001, 0.25, 0.5, 0.75, 0.999)
"""Where along the heights that two surfaces of revolution share they are compared."""


@dataclass(frozen=True)
class Shared:
    """Two faces in one place.

    Parameters
    ----------
    first, second : int
        Numbers of their elements, the smaller one first.
    first_face, second_face : int
        Which of their faces.
    point : bool
        Whether they touch in a point only.
    opposed : bool
        Whether their normals point against each other there, as those of bodies in contact.
    exact : bool
        Whether rounding never makes the farther one seem nearer.
    """

    first: int
    second: int
    first_face: int
    second_face: int
    point: bool
    opposed: bool
    exact: bool


def shared_places(near: Neighbours, wanted: Wanted) -> Iterator[Shared]:
    """Give the faces of different elements that lie in one place within rounding.

    `wanted` is asked which pairs of elements are looked at, see `coplanar`.
    """
    planes = PlaneFaces(near.elements, every=True)
    rounds = _Rounds(near.elements)
    for k, m in coplanar(near, planes, wanted):
        i, j = int(planes.owner[k]), int(planes.owner[m])
        senses = planes.faces[k].sense * planes.faces[m].sense
        yield Shared(
            i,
            j,
            int(planes.number[k]),
            int(planes.number[m]),
            point=False,
            opposed=bool(senses * np.dot(planes.frames[k, 2], planes.frames[m, 2]) < 0.0),
            exact=_ordered(near.elements[i], near.elements[j]),
        )
    if len(rounds.faces):
        found = (
            *_round_pairs(near, rounds, wanted),
            *_touching_planes(near, planes, rounds, wanted),
        )
        yield from (pair for pair in found if wanted(pair.first, pair.second))


def unordered(elements: Sequence[Element], roundoff: float = ROUNDOFF) -> Iterator[tuple[int, int]]:
    """Give pairs of elements whose order in one place is for the kernels to settle.

    All elements for which that is so are among them, not all pairs. Elsewhere the order follows
    from the distances and the file: where rounding cannot exchange two opaque faces, or light
    passes both as if nothing were there. Of opaque bodies that are not flat any face may be hit.
    """
    plain = np.array([all(map(_plain, e.surfaces)) for e in elements], bool)
    flat = np.array([e.flat for e in elements], bool)
    passed = np.array([all(map(_passed, e.surfaces)) for e in elements], bool)
    axes = np.array([e.class_axis if e.flat and e.class_axis is not None else -1 for e in elements])
    if plain.all():  # then it is about flat ones of which some are tilted, often few
        if not (flat & (axes < 0)).any():
            return
        if not flat.all():
            few = np.flatnonzero(flat).tolist()
            yield from (
                (few[i], few[j]) for i, j in unordered([elements[n] for n in few], roundoff)
            )
            return
    marked = np.zeros(len(elements), bool)

    def wanted(i: Any, j: Any) -> Any:
        ordered = (axes[i] == axes[j]) & (axes[i] >= 0)
        ordered = plain[i] & plain[j] & (ordered | ~(flat[i] & flat[j]))
        return ~(ordered | (passed[i] & passed[j]) | (marked[i] & marked[j]))

    for pair in shared_places(Neighbours(elements, roundoff), wanted):
        i, j = pair.first, pair.second
        at = elements[i].surface_of(pair.first_face), elements[j].surface_of(pair.second_face)
        if all(map(_passed, at)):
            continue
        if not (all(map(_plain, at)) and (pair.exact or pair.point)):
            marked[i] = marked[j] = True
            yield i, j


def _plain(surface: Surface) -> bool:
    return surface.counts and not surface.refracts


def _passed(surface: Surface) -> bool:
    return not surface.counts


def _ordered(a: Element, b: Element) -> bool:
    """Say whether the kernels tell by the distances alone which of two flat elements is nearer.

    Planes across one axis differ in a coordinate or not at all, and rounding keeps their order.
    """
    if not (a.flat and b.flat):
        return False
    if a.class_axis is not None and a.class_axis == b.class_axis:
        return True
    normal, other = a.frame[2], b.frame[2]
    opposite = tuple(-x for x in other)
    return a.position == b.position and normal in (other, opposite)


# -- curved faces --------------------------------------------------------------------------------


class _Rounds:
    """The surfaces of revolution among elements' faces, as arrays like those of `PlaneFaces`.

    Attributes
    ----------
    centres, axes : ndarray, shape (faces, 3), float64
        Of the ball in metres, else of the element; and the axis.
    radii : ndarray, shape (faces,), float64
        Of the ball in metres that the face is a part of; not a number of other faces.
    balls : ndarray, shape (faces,), bool
        Whether it is given as a ball, whose centre says where it is.
    whole : ndarray, shape (faces,), bool
        Whether it is all of a ball.
    far : ndarray, shape (faces,), float64
        Bound of their coordinates in metres.
    """

    def __init__(self, elements: Sequence[Element]) -> None:
        self.elements = elements
        self.faces: list[Revolved] = []
        owners: list[int] = []
        numbers: list[int] = []
        begin = [0]
        for n, element in enumerate(elements):
            for k, face in enumerate(element.faces):
                if isinstance(face, Revolved):
                    self.faces.append(face)
                    owners.append(n)
                    numbers.append(k)
            begin.append(len(self.faces))
        self.begin = np.array(begin)
        self.owner, self.number = np.array(owners, np.int64), np.array(numbers, np.int64)
        balls = [face.osculating for face in self.faces]
        self.balls = np.array([isinstance(face, Ball) for face in self.faces], bool)
        rise = np.array([ball.height if ball else 0.0 for ball in balls])
        self.radii = np.array([ball.radius if ball else math.nan for ball in balls])
        self.whole = np.array([ball is not None and ball.whole for ball in balls], bool)
        self.axes = np.array([elements[n].frame[2] for n in owners]).reshape(-1, 3)
        position = np.array([elements[n].position for n in owners]).reshape(-1, 3)
        self.centres = position + rise[:, None] * self.axes
        reach = np.array([elements[n].reach for n in owners])
        self.far = np.abs(position).max(axis=1, initial=0.0) + reach

    def world(self, face: int, radius: float, height: float) -> list[Vec3]:
        """Return three world points of a face's profile."""
        element = self.elements[self.owner[face]]
        local = [(radius * math.cos(a), radius * math.sin(a), height) for a in (0.1, 2.2, 4.3)]
        points = np.array(element.position) + np.array(local) @ np.array(element.frame)
        return [(float(x), float(y), float(z)) for x, y, z in points]

    def lies_on(self, points: Sequence[Vec3], element: Element, face: int, room: float) -> bool:
        """Say whether all of some world points lie on a face of an element."""
        whole = element.faces[face]
        return all(whole.touches(element.local(point), room) for point in points)


def _round_pairs(near: Neighbours, rounds: _Rounds, wanted: Wanted) -> Iterator[Shared]:
    """Give the pairs of surfaces of revolution that coincide or touch."""
    centres, radii, axes = rounds.centres, rounds.radii, rounds.axes
    for i, j in face_pairs(near, rounds.begin, rounds.begin, wanted):
        room = near.rounding * (rounds.far[i] + rounds.far[j])
        apart = np.linalg.norm(centres[j] - centres[i], axis=1)
        sum_, difference = radii[i] + radii[j], np.abs(radii[i] - radii[j])
        balls = ~np.isnan(sum_)
        touching = balls & (np.abs(apart - sum_) <= room)
        touching |= balls & (apart > room) & (np.abs(apart - difference) <= room)
        across = np.linalg.norm(np.cross(axes[i], axes[j]), axis=1)
        parallel = across * np.minimum(rounds.far[i], rounds.far[j]) <= room
        # a whole ball has every axis through its centre
        axis = np.where(rounds.whole[i, None], axes[j], axes[i])
        aside = np.linalg.norm(np.cross(centres[j] - centres[i], axis), axis=1)
        coaxial = (parallel | rounds.whole[i] | rounds.whole[j]) & (aside <= room)
        # not of shallow ones, whose centres are far away: there the profiles are compared
        centred = rounds.balls[i] & rounds.balls[j]
        alike = (apart <= room) & (difference <= room)
        same = np.where(centred, alike, coaxial)
        # conics of one curvature, which are no balls, may share but their vertex
        touching |= balls & ~centred & coaxial & alike
        for k in np.flatnonzero(touching | same).tolist():
            a, b, slack = int(i[k]), int(j[k]), 4.0 * float(room[k])
            shared = None
            if same[k]:
                shared = _compared(rounds, a, b, slack, point=False)
            if shared is None and touching[k]:
                shared = _compared(rounds, a, b, slack, point=True)
            if shared is not None:
                yield shared


def _compared(rounds: _Rounds, a: int, b: int, room: float, *, point: bool) -> Shared | None:
    one, other = rounds.faces[a], rounds.faces[b]
    first, second = (rounds.elements[rounds.owner[n]] for n in (a, b))
    at = int(rounds.number[a]), int(rounds.number[b])
    if point:
        first_ball, second_ball = one.osculating, other.osculating
        assert first_ball is not None
        assert second_ball is not None
        way = rounds.centres[b] - rounds.centres[a]
        length = float(np.linalg.norm(way))
        # of two about one centre it is the vertex
        way = way / length if length > room else first_ball.pole * rounds.axes[a]
        outside = first_ball.radius + second_ball.radius
        inner = abs(length - outside) > room  # one ball in the other
        smaller = length > room and first_ball.radius < second_ball.radius
        sign = -1.0 if inner and smaller else 1.0
        touched = [tuple((rounds.centres[a] + sign * first_ball.radius * way).tolist())]
        if not (
            rounds.lies_on(touched, first, at[0], room)
            and rounds.lies_on(touched, second, at[1], room)
        ):
            return None
        opposed = (first_ball.sense * second_ball.sense > 0.0) != inner
    else:
        if not _coincide(rounds, a, b, room):
            return None
        opposed = one.sense * other.sense < 0.0
    exact = (first.position, first.frame, first.faces) == (
        second.position,
        second.frame,
        second.faces,
    )
    return Shared(
        int(rounds.owner[a]),
        int(rounds.owner[b]),
        *at,
        point=point,
        opposed=opposed,
        exact=exact,
    )


def _coincide(rounds: _Rounds, a: int, b: int, room: float) -> bool:
    """Say whether surfaces about one axis, or balls about one centre, share an area."""
    one, other = rounds.faces[a], rounds.faces[b]
    whole = isinstance(other, Ball) and other.whole
    if isinstance(one, Ball) and one.whole:
        if whole:
            return True
        a, b, one, other, whole = b, a, other, one, True
    element = rounds.elements[rounds.owner[b]]
    ends = one.profile(np.array([0.0, 1.0]))[1]
    low, high = float(ends.min()), float(ends.max())
    if not whole:
        owner = rounds.elements[rounds.owner[a]]
        rims = [
            owner.local(rounds.world(b, 0.0, float(h))[0])[2]
            for h in other.profile(np.array([0.0, 1.0]))[1]
        ]
        low, high = max(low, min(rims)), min(high, max(rims))
    if not high - low > room:
        return False
    for part in _HEIGHTS:
        height = low + part * (high - low)
        radius = float(one.profile(np.array([one.place_at(height)]))[0][0])
        if not rounds.lies_on(
            rounds.world(a, radius, height), element, int(rounds.number[b]), room
        ):
            return False
    return True


def _touching_planes(
    near: Neighbours, planes: PlaneFaces, rounds: _Rounds, wanted: Wanted
) -> Iterator[Shared]:
    """Give the pairs of a plane and a ball that touch."""
    if not len(planes.faces):
        return
    for plane_first in (True, False):
        begins = (planes.begin, rounds.begin)
        for one, other in face_pairs(
            near, *(begins if plane_first else begins[::-1]), wanted=wanted
        ):
            p, b = (one, other) if plane_first else (other, one)
            yield from _tangent(near, planes, rounds, p, b)


def _tangent(
    near: Neighbours,
    planes: PlaneFaces,
    rounds: _Rounds,
    p: NDArray[np.int64],
    b: NDArray[np.int64],
) -> Iterator[Shared]:
    normals = planes.frames[p, 2]
    height = ((rounds.centres[b] - planes.centres[p]) * normals).sum(axis=1)
    room = near.rounding * (planes.far[p] + rounds.far[b])
    for k in np.flatnonzero(np.abs(np.abs(height) - rounds.radii[b]) <= room).tolist():
        plane, ball = int(p[k]), int(b[k])
        foot = tuple((rounds.centres[ball] - height[k] * normals[k]).tolist())
        slack = 4.0 * float(room[k])
        numbers = int(planes.owner[plane]), int(rounds.owner[ball])
        faces = int(planes.number[plane]), int(rounds.number[ball])
        flat, curved = (near.elements[n] for n in numbers)
        if not (
            rounds.lies_on([foot], flat, faces[0], slack)
            and rounds.lies_on([foot], curved, faces[1], slack)
        ):
            continue
        curved_ball = rounds.faces[ball].osculating
        assert curved_ball is not None
        sense = planes.faces[plane].sense * curved_ball.sense
        turned = numbers[0] > numbers[1]
        first, second = numbers[::-1] if turned else numbers
        first_face, second_face = faces[::-1] if turned else faces
        yield Shared(
            first,
            second,
            first_face,
            second_face,
            point=True,
            opposed=bool(sense * height[k] > 0.0),
            exact=False,
        )
