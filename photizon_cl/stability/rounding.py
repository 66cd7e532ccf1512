"""Cases as single precision can be given them, and what of them it cannot hold.

What a mode computes is judged by the inputs that it has: origins, directions, positions and lengths
are rounded before the oracle sees them. What rounding makes of a scene is another question: where
the gap between two elements goes, or an element is small beside the rounding of its place, the case
is lost, and told as that.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.checks.coarse import lost
from photizon_cl.errors import SceneError
from photizon_cl.geometry.placing import recentre
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.model import Scene
from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
from photizon_cl.stability.bodies import exact_frame, faces_of, sizes_of
from photizon_cl.stability.digits import DIGITS, add, dot, load_digits, vector
from photizon_cl.stability.oracle import FIRM

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from photizon_cl.scene.elements import Element
    from photizon_cl.stability.case import Case, Triple

__all__ = [
    "ray_is_lost",
    "rounded_case",
    "rounded_elements",
    "scene_of",
    "single",
    "start_is_lost",
    "what_is_lost",
]

_KEPT: Final = 0.1
"""Part of a difference between two lengths by which rounding may change it."""


def scene_of(elements: Sequence[Element]) -> Scene:
    """Return a scene of some elements, with a source that nobody uses."""
    source = IsotropicPoint(name="unused", flux=1.0, position=elements[0].position)
    return Scene(name="stability", source=(source,), element=tuple(elements))


def single(x: float) -> float:
    """Return a number rounded to single precision."""
    return float(np.float32(x))


def rounded_elements(elements: tuple[Element, ...]) -> tuple[Element, ...]:
    """Return elements whose positions and lengths single precision has.

    Raises
    ------
    SceneError
        Where one is none that can be, so rounded.
    """
    shift = recentre(scene_of(elements))
    found = []
    for element in elements:
        changes: dict[str, Any] = {name: single(x) for name, x in _lengths(element)}
        found.append(
            dataclasses.replace(element, position=_place(element.position, shift), **changes)
        )
    return tuple(found)


def rounded_case(case: Case, elements: tuple[Element, ...], shift: Triple) -> Case:
    """Return a case with these elements, of which single precision has the ray."""
    x, y, z = map(single, case.direction)
    return dataclasses.replace(
        case, elements=elements, origin=_place(case.origin, shift), direction=(x, y, z)
    )


def what_is_lost(elements: tuple[Element, ...], roundoff: float) -> str:
    """Say what single precision does not hold of a case's scene; empty where it holds all."""
    try:
        rounded = rounded_elements(elements)
    except SceneError as error:
        return f"rounded it is no scene: {error}"
    found = lost(scene_of(elements), roundoff)
    if found:
        return found
    before, after = _numbers(elements), _numbers(rounded)
    for one, other in itertools.combinations(range(len(before)), 2):
        if before[one][0] != before[other][0]:
            continue
        apart = before[other][1] - before[one][1]
        now = after[other][1] - after[one][1]
        if abs(now - apart) > _KEPT * abs(apart):
            return f"lengths {abs(apart):.1e} m apart are {abs(now):.1e} m apart in it"
    return ""


def ray_is_lost(case: Case, roundoff: float) -> str:
    """Say what of a case's ray is below the rounding of its coordinates; empty where nothing."""
    for element in case.elements:
        away = math.dist(case.origin, element.position)
        if element.reach < FIRM * roundoff * away:
            return (
                f"{element.reach:.1e} m seen from {away:.1e} m, where coordinates are good to "
                f"{roundoff * away:.1e} m"
            )
    return ""


def start_is_lost(case: Case, roundoff: float) -> str:
    """Say where a ray starts nearer to a face, which it did not leave, than rounding tells apart.

    It is then taken to start on the face: the bound is the same all over an element. Nor does a ray
    start on the face that it left where a rounded length has moved that, as an aperture does of a
    lens that is as wide as its ellipsoid.
    """
    mp = load_digits()
    with mp.workdps(DIGITS):
        for number, element in enumerate(case.elements):
            rows, sizes = exact_frame(element), sizes_of(element)
            apart = add(vector(case.origin), -1, vector(element.position))
            local = [dot(row, apart) for row in rows]
            far = element.reach + max(map(abs, (*case.origin, *element.position)))
            for index, face in enumerate(faces_of(element)):
                off = abs(float(face.value(local, sizes)))
                if case.left and (case.left.element, case.left.face) == (number, index):
                    if off > FIRM * roundoff * far:
                        return f"the face that the ray left lies {off:.1e} m from its start in it"
                    continue
                if 0.0 < off <= FIRM * roundoff * far:
                    return (
                        f"a ray starts {off:.1e} m off a face, which is within "
                        f"{FIRM * roundoff * far:.1e} m of rounding"
                    )
    return ""


def _place(position: Sequence[float], shift: Sequence[float]) -> Triple:
    x, y, z = (single(a - b) + b for a, b in zip(position, shift, strict=True))
    return (x, y, z)


def _lengths(element: Element) -> Iterator[tuple[str, float]]:
    """Give an element's parameters in metres, but for its position."""
    for name, parameter in parameters_of(type(element)).items():
        value: Any = getattr(element, name)
        if getattr(parameter, "unit", "") == "m" and isinstance(value, float):
            yield name, value


def _numbers(elements: Sequence[Element]) -> list[tuple[str, float]]:
    """Return the coordinates and lengths of a scene, each with what it may be compared with."""
    found = [(axis, x) for e in elements for axis, x in zip("xyz", e.position, strict=True)]
    return found + [(name, x) for e in elements for name, x in _lengths(e)]
