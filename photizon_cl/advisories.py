"""What is valid in a scene and yet probably not meant."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.elements import Disk, Element, Sphere
from photizon_cl.elements.flat import Flat
from photizon_cl.frames import to_local
from photizon_cl.neighbours import Neighbours
from photizon_cl.sources import LambertianSphere, Source

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene import Scene

_CAPPED = 1e-6  # expected depth-capped part of the flux that is worth a word
_SPLITTING_CAP = 24  # generations after which 2^n children are too many to follow
_ROUNDING: Final = 2.0**-48  # of the sums here, relative


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
    yield from _flush_elements(scene)


def _flush_elements(scene: Scene) -> Iterator[str]:
    """Find flat elements that lie wholly in an opaque one named before.

    Only where every ray is at the very same distance from both: in a plane across an axis at the
    same coordinate, or around the same centre. Elsewhere rounding decides which is hit.
    """
    planes: dict[tuple[object, ...], int] = {}
    taken: set[tuple[object, ...]] = set()
    flats: list[Flat] = []
    plane_of: list[int] = []
    for flat in scene.element:
        if not isinstance(flat, Flat):
            continue
        shape = (flat.kind, flat.position, flat.frame, flat.half_sizes)
        if shape in taken:
            continue  # the very geometry
        if not flat.surface.splits:
            taken.add(shape)
        flats.append(flat)
        axis, (x, y, z) = flat.class_axis, flat.frame[2]
        across = (axis, flat.position[axis]) if axis is not None else None
        plane = across or (flat.position, max((x, y, z), (-x, -y, -z)))
        plane_of.append(planes.setdefault(plane, len(planes)))
    if len(flats) < 2:
        return
    number, opaque = np.array(plane_of), np.array([not f.surface.splits for f in flats])
    centres = np.array([f.position for f in flats])
    least = np.array([min(f.half_sizes) for f in flats])  # from the centre to the edge
    farthest = np.array([math.hypot(*f.half_sizes) for f in flats])
    told: set[int] = set()
    for first, second in Neighbours(flats).pairs():
        apart = np.linalg.norm(centres[second] - centres[first], axis=1)
        flush = (first < second) & (number[first] == number[second]) & opaque[first]
        flush &= apart + least[second] <= farthest[first] * (1.0 + _ROUNDING)
        for i, j in zip(first[flush].tolist(), second[flush].tolist(), strict=True):
            over, under = flats[i], flats[j]
            if j not in told and _lies_within(under, over):
                told.add(j)
                yield (
                    f'element "{under.name}" lies flush in "{over.name}", which is named first and '
                    f'takes every hit where both are equally near: "{under.name}" is never hit; '
                    "name it first, or move it"
                )


def _lies_within(small: Flat, large: Flat) -> bool:
    """Say whether no point of a flat element is outside another one in the same plane."""
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
