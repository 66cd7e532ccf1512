"""What is valid in a scene and yet probably not meant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from photizon_cl.checks.flush import flush_elements
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import to_local
from photizon_cl.scene.sources.lambertian_sphere import LambertianSphere

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source

_CAPPED = 1e-6  # expected depth-capped part of the flux that is worth a word
_SPLITTING_CAP = 24  # generations after which 2^n children are too many to follow


def advisories(scene: Scene) -> list[str]:
    """Return one sentence for each thing that deserves a second look, in scene order."""
    found: list[str] = []
    found += _sources_on_faces(scene)
    found += _covered_elements(scene)
    found += _blind_detectors(scene)
    found += _capped_spheres(scene)
    found += _fresnel_surfaces(scene)
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
    radius = _radius(source)
    if isinstance(source, LambertianSphere):
        same_centre = math.hypot(*local) <= slack
        return isinstance(element, Sphere) and same_centre and math.isclose(radius, element.radius)
    reach = 0.0
    if radius and element.flat:
        # A disk in the plane of a flat element may overlap it although its centre lies outside.
        along = to_local(element.frame, source.frame[2])
        reach = radius if abs(along[2]) >= 1.0 - 1e-15 else 0.0
    return element.touches(local, slack, reach)


def _covered_elements(scene: Scene) -> Iterator[str]:
    first: dict[tuple[object, ...], str] = {}
    for element in scene.element:
        shape = (
            element.kind,
            element.position,
            element.frame,
            element.packed(element.position, None),
        )
        if shape in first:
            yield (
                f'element "{element.name}" has the very geometry of "{first[shape]}", which is '
                f'named first and takes every hit: "{element.name}" is never hit'
            )
        elif not element.surface.splits:  # what goes through meets the other
            first[shape] = element.name
    yield from flush_elements(scene)


def _blind_detectors(scene: Scene) -> Iterator[str]:
    """Find detectors that no light can reach on the side that they face."""
    if any(element.surface.kind != "absorber" for element in scene.element):
        return  # it may be lit by reflection (an element with a detector is an absorber itself)
    for element in scene.element:
        if element.detector is None:
            continue
        if all(_is_behind(element, source) for source in scene.source):
            advice = "turn its axis" if element.flat else "name the other side"
            yield (
                f'the detector on "{element.name}" faces away from every source and nothing '
                f"reflects light to its face: it will read zero; {advice}"
            )


def _is_behind(element: Element, source: Source) -> bool:
    local, radius = element.local(source.position), _radius(source)
    if element.flat:
        return local[2] + radius <= 0.0
    if not isinstance(element, Sphere) or element.port_fraction > 0.0:
        return False
    centre = math.hypot(*local)
    if element.detector_side == "inside":
        return centre - radius > element.radius
    return centre + radius < element.radius


def _capped_spheres(scene: Scene) -> Iterator[str]:
    for sphere in scene.element:
        if not isinstance(sphere, Sphere) or sphere.surface.kind != "lambertian":
            continue
        inside = any(math.hypot(*sphere.local(s.position)) < sphere.radius for s in scene.source)
        kept = sphere.surface.packed()[0] * (1.0 - sphere.port_fraction)
        left = kept**scene.run.generation_cap
        if inside and left > _CAPPED:
            advice = "; it never decays, so open a port or lower the reflectance"
            if kept < 1.0:
                advice = f"; a cap of {math.ceil(math.log(1e-12) / math.log(kept))} leaves 1e-12"
            yield (
                f'in sphere "{sphere.name}" about {left:.1e} of the flux is still alive at the '
                f"generation cap of {scene.run.generation_cap} and goes to the depth-capped row"
                + advice
            )


def _fresnel_surfaces(scene: Scene) -> Iterator[str]:
    reflectors = [e.name for e in scene.element if e.surface.kind in ("mirror", "lambertian")]
    lenses = [e for e in scene.element if e.surface.kind == "fresnel"]
    for element in lenses:
        m, _, inverse, _ = element.surface.packed()
        if m == inverse:
            yield (
                f'element "{element.name}" has the same index on both sides: '
                "it reflects nothing and bends nothing"
            )
    run = scene.run
    if lenses and reflectors and run.roulette_floor == 0.0 and run.generation_cap > _SPLITTING_CAP:
        yield (
            f'every hit on "{lenses[0].name}" splits a ray in two and "{reflectors[0]}" can send '
            f"both back: with a generation cap of {run.generation_cap} and no roulette the number "
            "of children may grow without practical bound; set roulette_floor, for example 1e-6"
        )


def _radius(source: Source) -> float:
    packed = source.packed()
    return packed[0] if packed else 0.0
