"""What is valid in a scene and yet probably not meant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from photizon_cl.checks.coarse import coarse
from photizon_cl.checks.coatings import coarse_phases, idle_films
from photizon_cl.checks.coincident import coincident_faces
from photizon_cl.checks.directions import coarse_directions
from photizon_cl.checks.gaps import lost_gaps
from photizon_cl.checks.importance import idle_importance
from photizon_cl.checks.polarisation import idle_polarisation
from photizon_cl.checks.precision import DEFAULT, mode_of
from photizon_cl.checks.spectrum import (
    other_glasses,
    paths_of_all,
    tables_that_end,
    tiny_waves,
)
from photizon_cl.scene.elements.base import OTHER_SIDE
from photizon_cl.scene.faces import Ball
from photizon_cl.scene.frames import to_local
from photizon_cl.scene.media.names import named_by
from photizon_cl.scene.spectral import curves_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source
    from photizon_cl.scene.surfaces import Surface

_ALIKE = 3e-3  # relative difference of indices that mean the same, as 1.33 and 1.333 do
_CAPPED = 1e-6  # expected depth-capped part of the flux that is worth a word
_SPLITTING_CAP = 24  # generations after which 2^n children are too many to follow


def advisories(scene: Scene, precision: str = DEFAULT) -> list[str]:
    """Return one sentence for each thing that deserves a second look, in scene order.

    Parameters
    ----------
    scene : Scene
        What is looked at.
    precision : str, optional
        In which it is to be run, as in `photizon_cl.trace`.

    Raises
    ------
    ArgumentError
        Where there is no such precision.
    """
    roundoff = mode_of(precision).roundoff
    found: list[str] = []
    found += _sources_on_faces(scene)
    found += _covered_elements(scene)
    found += _blind_detectors(scene)
    found += coarse(scene, roundoff)
    found += lost_gaps(scene, roundoff)
    found += coarse_directions(scene, roundoff)
    found += coarse_phases(scene, roundoff)
    found += idle_films(scene)
    found += idle_importance(scene)
    found += idle_polarisation(scene)
    found += _idle_media(scene)
    found += _nameless_media(scene)
    found += tables_that_end(scene)
    found += tiny_waves(scene)
    found += other_glasses(scene)
    found += paths_of_all(scene)
    found += _capped_cavities(scene)
    found += _surfaces(scene)
    return found


def _sources_on_faces(scene: Scene) -> Iterator[str]:
    for source in scene.source:
        for element in scene.element:
            if _lies_on(source, element):
                yield (
                    f'source "{source.name}" lies on element "{element.name}" within rounding: '
                    "its rays are taken to leave that face and do not hit it where they start; "
                    "move one of the two if that is not meant"
                )


def _lies_on(source: Source, element: Element) -> bool:
    slack = element.rounding(source.position)
    local = element.local(source.position)
    shines = source.face
    if isinstance(shines, Ball):
        wall = element.sole_face
        same_centre = math.hypot(*local) <= slack
        return isinstance(wall, Ball) and same_centre and math.isclose(shines.radius, wall.radius)
    reach = 0.0
    if shines is not None and element.flat:
        # A disk in the plane of a flat element may overlap it although its centre lies outside.
        along = to_local(element.frame, source.frame[2])
        reach = source.reach if abs(along[2]) >= 1.0 - 1e-15 else 0.0
    return element.touches(local, slack, reach)


def _covered_elements(scene: Scene) -> Iterator[str]:
    first: dict[tuple[object, ...], str] = {}
    for element in scene.element:
        shape = (element.position, element.frame, element.faces)
        if shape in first:
            if not any(
                s.counts for s in element.surfaces
            ):  # what light passes lies before it, wherever it is named
                continue
            yield (
                f'element "{element.name}" has the very geometry of "{first[shape]}", which is '
                f'named first and takes every hit: "{element.name}" is never hit'
            )
        elif not any(s.transmits for s in element.surfaces):  # what goes through meets the other
            first[shape] = element.name
    yield from coincident_faces(scene)


def _blind_detectors(scene: Scene) -> Iterator[str]:
    """Find detectors that no light can reach on the side that they face."""
    if any(_turns(element) for element in scene.element):
        return  # it may be lit from there
    for element in scene.element:
        if element.detector is None:
            continue
        if all(_is_behind(element, source) for source in scene.source):
            other = OTHER_SIDE[element.detector_side or element.default_side]
            advice = f'set its side to "{other}"'
            yield (
                f'the detector on "{element.name}" faces away from every source and nothing '
                f"reflects light to its face: it will read zero; {advice}"
            )


def _turns(element: Element) -> bool:
    """Say whether light may leave an element in another direction than it came in."""
    return any(
        s.reflects or s.lobe is not None or (s.transmits and s.counts) for s in element.surfaces
    )


def _is_behind(element: Element, source: Source) -> bool:
    face, plus, passed = element.sole_face, element.detector_plus, element.surface.transmits
    if face is None:
        return False
    local = element.local(source.position)
    return face.hidden(local, source.reach, plus=plus, passed=passed)


def _idle_media(scene: Scene) -> Iterator[str]:
    """Find media that nothing names."""
    if not scene.medium:
        return
    used = {name for thing in (*scene.source, *scene.element) for name in named_by(thing)}
    for medium in scene.medium:
        if medium.name not in used:
            yield (
                f'medium "{medium.name}": nothing is made of it; a surface names it as its medium '
                "or medium_outside, a source as its medium"
            )


def _nameless_media(scene: Scene) -> Iterator[str]:
    """Find borders given by indices, beside a medium that absorbs and has one of them."""
    absorbing = [(m, m.index_at(scene.reference_nm)) for m in scene.medium if m.absorbs]
    for element in scene.element:
        for surface in dict.fromkeys(element.surfaces):
            if surface.media is not None or surface.indices is None:
                continue
            like = next(
                (
                    (index, medium)
                    for index in surface.indices
                    for medium, its in absorbing
                    if index != 1.0 and abs(index - its) <= _ALIKE * its
                ),
                None,
            )
            if like is not None:
                index, medium = like
                yield (
                    f'element "{element.name}": its index of {index:.9g} is that of medium '
                    f'"{medium.name}", but a border of indices leads to no medium: behind it '
                    "nothing is absorbed; name medium and medium_outside instead"
                )


def _passing(depth: float) -> float:
    """Return what a medium leaves of matt light on its way across a ball.

    `depth` is αR; the mean of exp(−2αRμ) over the cosines μ, of density 2μ.
    """
    a = 2.0 * depth
    return 1.0 - 2.0 * a / 3.0 if a < 1e-4 else -2.0 * (math.expm1(-a) + a * math.exp(-a)) / a**2


def _capped_cavities(scene: Scene) -> Iterator[str]:
    # the least of all wavelengths: that light lives longest
    absorption = {m.name: min(map(m.absorption_at, scene.wavelengths)) for m in scene.medium}
    for element in scene.element:
        wall, again = element.sole_face, element.self_view_factor
        if not isinstance(wall, Ball) or again is None:
            continue
        by_line = [
            element.surface.at(nm).diffuse_reflectance
            for nm in (scene.wavelengths if any(curves_of(element)) else (None,))
        ]
        reflectance = None if None in by_line else max(filter(None, by_line), default=0.0)
        if reflectance is None:
            continue
        inside = [s for s in scene.source if wall.holds(element.local(s.position))]
        fills = [absorption.get(s.medium, 0.0) for s in inside]
        kept = reflectance * again * _passing(min(fills, default=0.0) * wall.radius)
        left = kept**scene.run.generation_cap
        if inside and left > _CAPPED:
            advice = "; it never decays, so open a port or lower the reflectance"
            if kept < 1.0:
                advice = f"; a cap of {math.ceil(math.log(1e-12) / math.log(kept))} leaves 1e-12"
            yield (
                f'in {element.kind} "{element.name}" about {left:.1e} of the flux is still alive '
                f"at the generation cap of {scene.run.generation_cap} and goes to the depth-capped "
                "row" + advice
            )


def _always(scene: Scene, surface: Surface) -> list[str]:
    """Return what a surface advises at every wavelength: two indices may meet at one."""
    said = scene.optics[surface].advice()
    for nm in scene.wavelengths if said else ():
        here = surface.among(scene.index_of(nm)).at(nm).advice()
        said = [text for text in said if text in here]
    return said


def _surfaces(scene: Scene) -> Iterator[str]:
    for element in scene.element:
        for surface in element.surfaces:
            named = f'element "{element.name}"'
            if len(element.surfaces) > 1:
                faces = [
                    f.name for n, f in enumerate(element.faces) if element.surface_of(n) == surface
                ]
                named = f"{' and '.join(faces)} of {named}"
            for text in _always(scene, surface):
                yield f"{named} {text}"
    splitters = [e.name for e in scene.element if any(s.branches for s in e.surfaces)]
    splitters = splitters if scene.splits() else []
    reflectors = [
        e.name
        for e in scene.element
        if any((s.reflects or s.lobe is not None) and not s.transmits for s in e.surfaces)
    ]
    run = scene.run
    growing = scene.roulette_floor() == 0.0 and run.generation_cap > _SPLITTING_CAP
    if splitters and reflectors and growing:
        other = next((name for name in reflectors if name != splitters[0]), None)
        back = f'and "{other}" can send both back' if other else "and either may meet it again"
        first = scene.element[splitters[0]].surfaces
        many = "four" if any(s.splits and s.lobe is not None for s in first) else "two"
        yield (
            f'every hit on "{splitters[0]}" splits a ray in {many} {back}: '
            f"with a generation cap of {run.generation_cap} and no roulette the number "
            "of children may grow without practical bound; set roulette_floor, for example 1e-6"
        )
