"""Faces of several elements in one place: what is met first, and what that means."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.geometry.coincidence import shared_places
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.planes import PlaneFaces, lies_within
from photizon_cl.scene.faces import Plane, Revolved
from photizon_cl.scene.outlines import Circular

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from photizon_cl.geometry.coincidence import Shared
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.surfaces import Surface

__all__ = ["coincident_faces"]

_NAMED: Final = 20
"""So many pairs of refracting faces are named; of the others only how many there are."""
_RIMS: Final = 1e-9
"""Relative difference of radii that is none: no light to speak of meets what lies between."""
_LOOKED: Final = 20_000
"""So many pairs are looked at, which takes a second."""


def coincident_faces(scene: Scene) -> Iterator[str]:
    """Give a sentence for each pair of elements with faces in one place that is worth a word.

    Of two opaque faces the one named first is hit. A small element in a larger one that is named
    later is what users mean, and nothing is said. Bodies in contact have a film of their outside
    medium between them. Nothing is said of elements that light passes as if nothing were there.
    """
    elements = _distinct(scene)
    near = Neighbours(elements)
    planes = PlaneFaces(elements)
    counts = np.array([any(s.counts for s in e.surfaces) for e in elements], bool)
    glass = np.array([any(s.refracts for s in e.surfaces) for e in elements], bool)
    covered = np.zeros(len(elements), bool)
    told: set[tuple[int, int]] = set()
    looked = cemented = 0

    def wanted(i: Any, j: Any) -> Any:
        return counts[i] & counts[j] & (glass[i] | glass[j] | ~covered[j])

    for looked, pair in enumerate(shared_places(near, wanted)):
        if looked >= _LOOKED:
            break
        i, j = pair.first, pair.second
        one, other = elements[i], elements[j]
        at, there = one.surface_of(pair.first_face), other.surface_of(pair.second_face)
        if not (at.counts and there.counts):
            unequal = _cement(pair, one, other)
            if unequal:
                cemented += 1
                if cemented <= _NAMED:
                    yield unequal
            continue
        if not (at.refracts or there.refracts):
            text = None if pair.point else _covered(planes, pair, one, other)
            if text is not None:
                covered[j] = True
                yield text
            continue
        if (i, j) in told:
            continue
        told.add((i, j))
        if len(told) > _NAMED:
            continue
        if at.refracts and there.refracts:
            yield _film(one, other, pair, scene.optics) if pair.opposed else _nested(one, other)
        elif at.refracts:
            yield _on_glass(pair, one, pair.first_face, other, scene.optics)
        else:
            yield _on_glass(pair, other, pair.second_face, one, scene.optics)
    if len(told) > _NAMED:
        yield f"{len(told) - _NAMED} more pairs of elements have refracting faces in one place"
    if cemented > _NAMED:
        yield f"{cemented - _NAMED} more pairs of cemented faces are not equally wide"
    if looked >= _LOOKED:
        yield (
            f"more than {_LOOKED} pairs of faces lie in one place: of the others nothing is said"
        )


def _distinct(scene: Scene) -> list[Element]:
    """Return the elements without those that an earlier one covers."""
    taken: set[tuple[object, ...]] = set()
    found: list[Element] = []
    for element in scene.element:
        shape = (element.position, element.frame, element.faces)
        plain = not any(s.transmits for s in element.surfaces)
        if plain and shape in taken:
            continue
        if plain:
            taken.add(shape)
        found.append(element)
    return found


def _covered(planes: PlaneFaces, pair: Shared, one: Element, other: Element) -> str | None:
    """Say that an element that is named first takes the hits of another one."""
    axis = one.class_axis if one.flat and one.class_axis == other.class_axis else None
    if axis is not None and one.position[axis] != other.position[axis]:
        return (
            f'elements "{one.name}" and "{other.name}" lie in one plane to within rounding: which '
            "of them is nearer is all but left to rounding; give both the same coordinate, then "
            "the one named first is hit, or move one of them farther off"
        )
    whole = False
    if one.sole_face is not None and other.sole_face is not None and one.flat and other.flat:
        small, large = (int(planes.begin[n]) for n in (pair.second, pair.first))
        whole = lies_within(planes, small, large)
        if not whole and lies_within(planes, large, small):
            return None
    return (
        f'element "{other.name}" lies {"" if whole else "partly "}flush in "{one.name}", '
        "which is named first and takes every hit where both are equally near"
        + (f': "{other.name}" is never hit' if whole else "")
        + "; name it first, or move it"
    )


def _cement(pair: Shared, one: Element, other: Element) -> str:
    """Say that one of two cemented bodies is wider than the other; nothing where neither is."""
    first, second = one.surface_of(pair.first_face), other.surface_of(pair.second_face)
    passed = one if not first.counts else other
    glued = (second if not first.counts else first).refracts
    if pair.point or not glued or not any(s.refracts for s in passed.surfaces):
        return ""
    rims = [_rim(one, pair.first_face), _rim(other, pair.second_face)]
    if None in rims or math.isclose(*rims, rel_tol=_RIMS):  # type: ignore[arg-type]
        return ""
    clear, bends = ("first", "second") if passed is one else ("second", "first")
    names = {
        "first": f'the {one.face_name(pair.first_face)} of "{one.name}"',
        "second": f'the {other.face_name(pair.second_face)} of "{other.name}"',
    }
    return (
        f"{names[clear]} is clear and lies in one place with {names[bends]}, as cement does, but "
        f"the two are not equally wide ({rims[0]:.9g} and {rims[1]:.9g} m): beyond the smaller one "
        "light does not bend where glass meets air, or bends as into the other glass; give both "
        "the same aperture"
    )


def _rim(element: Element, face: int) -> float | None:
    """Return the outer radius in metres of a round face, None of another one."""
    found = element.faces[face]
    if isinstance(found, Revolved):
        return float(found.profile(np.array([0.0, 1.0]))[0].max())
    outline = found.outline if isinstance(found, Plane) else None
    return outline.radius if isinstance(outline, Circular) else None


def _indices(element: Element, face: int, optics: Mapping[Surface, Surface]) -> tuple[float, float]:
    indices = optics[element.surface_of(face)].indices
    assert indices is not None  # it refracts
    return indices


def _outside_is(element: Element, face: int, index: float) -> str:
    """Return what makes what lies behind a face, of some index, the outside of another."""
    media = element.surface_of(face).media
    if media is None:
        return f"index_outside = {index:g}"
    return f'medium_outside = "{media[0]}"'


def _film(one: Element, other: Element, pair: Shared, optics: Mapping[Surface, Surface]) -> str:
    _, outside = _indices(one, pair.first_face, optics)
    index, apart = _indices(other, pair.second_face, optics)
    text = (
        f'elements "{one.name}" and "{other.name}" '
        + ("touch" if pair.point else "have faces in one place")
        + ": light that goes from one into the other passes a film "
    )
    if outside == apart:
        text += f"of index {outside:g} between them, whatever their order in the file"
    else:
        text += (
            f'between them, of index {outside:g} for "{one.name}" and {apart:g} for '
            f'"{other.name}": make the two equal'
        )
    if pair.point:
        return text
    if _by_face(one) and _by_face(other):
        return text + (
            f"; to cement them, give {_face(one, pair.first_face)} "
            f"{_outside_is(other, pair.second_face, index)} and "
            f"make {_face(other, pair.second_face)} clear"
            + _coated(other.surface_of(pair.second_face), "which loses its coating")
            + _coated(one.surface_of(pair.first_face), "the coating then stands in the cement")
        )
    return text


def _coated(surface: Surface, text: str) -> str:
    return "" if surface.coat is None else f", {text}"


def _by_face(element: Element) -> bool:
    """Say whether one face may have another surface than the rest, which most bodies have not."""
    return element.flat or "own-surfaces" in element.traits


def _face(element: Element, face: int) -> str:
    name = f'"{element.name}"'
    return name if element.flat else f"the {element.face_name(face)} of {name}"


def _nested(one: Element, other: Element) -> str:
    return (
        f'elements "{one.name}" and "{other.name}" have faces in one place that point the same '
        f'way: light crosses both, that of "{one.name}" first, which is named first; if one is in '
        "the other, leave a gap or make one of them clear"
    )


def _on_glass(
    pair: Shared, glass: Element, face: int, plain: Element, optics: Mapping[Surface, Surface]
) -> str:
    inside, outside = _indices(glass, face, optics)
    text = (
        f'element "{plain.name}" {"touches" if pair.point else "lies on"} the glass of '
        f'"{glass.name}": light inside leaves that first and passes a film of index {outside:g} '
        f'before it meets "{plain.name}", and what comes from outside meets "{plain.name}" first'
    )
    if inside == outside or pair.point or not _by_face(glass):
        return text
    return text + (
        f"; where it is meant to touch the glass without a film, give {_face(glass, face)} "
        f"{_outside_is(glass, face, inside)}"
    )
