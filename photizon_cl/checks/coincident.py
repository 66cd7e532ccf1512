"""Faces of several elements in one place: what is met first, and what that means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from photizon_cl.geometry.coincidence import shared_places
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.planes import PlaneFaces, lies_within

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.geometry.coincidence import Shared
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene

__all__ = ["coincident_faces"]

_NAMED: Final = 20
"""So many pairs of a kind are named; of the others only how many there are."""


def coincident_faces(scene: Scene) -> Iterator[str]:
    """Give a sentence for each pair of elements with faces in one place that is worth a word.

    Of two opaque faces the one named first is hit. A small element in a larger one that is named
    later is what users mean, and nothing is said. Bodies in contact have a film of their outside
    medium between them. Nothing is said of elements that light passes as if nothing were there.
    """
    elements = _distinct(scene)
    near = Neighbours(elements)
    planes = PlaneFaces(elements)
    covered: set[int] = set()
    told: set[tuple[int, int]] = set()
    more = 0
    for pair in shared_places(near):
        i, j = pair.first, pair.second
        one, other = elements[i], elements[j]
        glass = [e for e in (one, other) if e.surface.refracts]
        if not (one.surface.counts and other.surface.counts) or (i, j) in told:
            continue
        if not glass:
            if j not in covered and not pair.point:
                text = _covered(planes, pair, one, other)
                if text is not None:
                    covered.add(j)
                    yield text
            continue
        told.add((i, j))
        if len(told) > _NAMED:
            more += 1
        elif len(glass) == 1:
            yield _on_glass(pair, glass[0], other if glass[0] is one else one)
        else:
            yield _film(one, other, pair) if pair.opposed else _nested(one, other)
    if more:
        yield f"{more} more pairs of elements have refracting faces in one place"


def _distinct(scene: Scene) -> list[Element]:
    """Return the elements without those that an earlier one covers."""
    taken: set[tuple[object, ...]] = set()
    found: list[Element] = []
    for element in scene.element:
        shape = (element.position, element.frame, element.faces)
        plain = not element.surface.transmits
        if plain and shape in taken:
            continue
        if plain:
            taken.add(shape)
        found.append(element)
    return found


def _covered(planes: PlaneFaces, pair: Shared, one: Element, other: Element) -> str | None:
    """Say that an element that is named first takes the hits of another one."""
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


def _indices(element: Element) -> tuple[float, float]:
    indices = element.surface.indices
    assert indices is not None  # it refracts
    return indices


def _film(one: Element, other: Element, pair: Shared) -> str:
    (inside, outside), (index, apart) = _indices(one), _indices(other)
    text = (
        f'elements "{one.name}" and "{other.name}" '
        + ("touch" if pair.point else "have faces in one place")
        + ": light that goes from one into the other passes a film "
    )
    if outside == apart:
        text += f"of index {outside:g} between them, whatever their order in the file"
    else:
        text += (
            f'between them, of index {outside:g} for "{one.name}" and {apart:g} for "{other.name}": '
            "make the two equal"
        )
    if pair.point:
        return text
    if one.flat or other.flat:
        kept, gone = (one, other) if other.flat else (other, one)
        beyond = index if kept is one else inside
        return text + (
            f'; to cement them, give "{kept.name}" index_outside = {beyond:g} and make '
            f'"{gone.name}" clear'
        )
    return text


def _nested(one: Element, other: Element) -> str:
    return (
        f'elements "{one.name}" and "{other.name}" have faces in one place that point the same way: '
        f'light crosses both, that of "{one.name}" first, which is named first; if one is in the '
        "other, leave a gap or make one of them clear"
    )


def _on_glass(pair: Shared, glass: Element, plain: Element) -> str:
    inside, outside = _indices(glass)
    text = (
        f'element "{plain.name}" {"touches" if pair.point else "lies on"} the glass of '
        f'"{glass.name}": light inside leaves that first and passes a film of index {outside:g} '
        f'before it meets "{plain.name}", and what comes from outside meets "{plain.name}" first'
    )
    if inside == outside or pair.point:
        return text
    return text + (
        f'; where it is meant to touch the glass without a film, give "{glass.name}" '
        f"index_outside = {inside:g}"
    )
