"""The table of effects."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Effect:
    """One thing that a scene may need and another does without.

    Parameters
    ----------
    name : str
        ``group.kind`` for the kinds of the registry, a word for the others.
    what : str
        What it does, in one line.
    costs : str
        What the device does more because of it, in one line.
    """

    name: str
    what: str
    costs: str


_ROWS: Final = (
    Effect(
        "source.isotropic-point",
        "rays from a point, uniform over the sphere",
        "one sine and cosine a ray",
    ),
    Effect(
        "source.cosine-point", "rays from a point with a cosine lobe", "one sine and cosine a ray"
    ),
    Effect(
        "source.lambertian-disk",
        "rays from a disk of uniform radiance",
        "two sines and cosines a ray",
    ),
    Effect(
        "source.lambertian-sphere",
        "rays from a shell of uniform radiance",
        "two sines and cosines a ray",
    ),
    Effect("source.collimated-disk", "parallel rays from a disk", "one sine and cosine a ray"),
    Effect(
        "element.rectangle", "plane hit inside a rectangle", "one division an element a segment"
    ),
    Effect("element.disk", "plane hit inside a circle", "one division an element a segment"),
    Effect(
        "element.sphere", "sphere hit", "one square root and up to two roots an element a segment"
    ),
    Effect(
        "element.cpc",
        "compound parabolic concentrator hit",
        "Newton steps on the profile, a square root each, an element a segment",
    ),
    Effect(
        "element.baffled-tube",
        "walls and baffles of a square tube hit",
        "one division a wall and a baffle a segment",
    ),
    Effect("element.plano-convex", "plane and cap of a lens hit", "two roots an element a segment"),
    Effect("element.biconvex", "both caps of a lens hit", "two roots a cap a segment"),
    Effect("surface.absorber", "ends what arrives", "one tally event a path"),
    Effect("surface.mirror", "specular reflection", "a few multiplications an interaction"),
    Effect(
        "surface.lambertian",
        "diffuse reflection",
        "one random block, sine and cosine an interaction",
    ),
    Effect(
        "surface.fresnel",
        "refraction and partial reflection",
        "two square roots and a division an interaction",
    ),
    Effect(
        "splitting",
        "both children of a Fresnel surface are followed",
        "a queue write for each split",
    ),
    Effect(
        "roulette",
        "rays of low weight survive by chance, with more weight",
        "one comparison an interaction, a random block for each play, two ledger rows",
    ),
    Effect(
        "tilt",
        "elements or sources that are turned off the axes",
        "a full matrix instead of a permutation",
    ),
    Effect(
        "acceleration",
        "a tree of boxes over many elements",
        "box tests instead of element tests; the plain scan is faster for few elements",
    ),
    Effect(
        "contact",
        "elements that touch or cross: which side of each a ray is on",
        "five to fifteen words more a ray",
    ),
    Effect("port", "spheres with an opening", "a test of each root of a sphere"),
    Effect(
        "far-field",
        "what escapes is binned by direction",
        "a terminal record and an exact-edge search an escape",
    ),
    Effect(
        "detector",
        "arrivals on the faced side of an absorber are counted",
        "one tally event an arrival",
    ),
    Effect("map", "irradiance maps", "a terminal record and a bin an arrival"),
    Effect("ladder", "power by generation", "one row more an arrival"),
    Effect(
        "shares",
        "rays divided other than by flux, or among several sources",
        "a choice of source and a launched weight a ray",
    ),
)

EFFECTS: Final[Mapping[str, Effect]] = MappingProxyType({effect.name: effect for effect in _ROWS})
"""Every effect by name."""
