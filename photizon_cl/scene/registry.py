"""Explicit tables of everything that a scene can hold, by the kind that a file names.

Nothing registers itself by being imported: a kind exists when it has a row here.
"""

from __future__ import annotations

from typing import Final

from photizon_cl.scene.detectors import Detector
from photizon_cl.scene.elements import (
    BaffledTube,
    Biconvex,
    Cpc,
    Disk,
    Element,
    PlanoConvex,
    Rectangle,
    Sphere,
)
from photizon_cl.scene.sources import (
    CollimatedDisk,
    CosinePoint,
    IsotropicPoint,
    LambertianDisk,
    LambertianSphere,
    Source,
)
from photizon_cl.scene.surfaces import Absorber, Fresnel, Lambertian, Mirror, Surface

ELEMENTS: Final[dict[str, type[Element]]] = {
    "rectangle": Rectangle,
    "disk": Disk,
    "sphere": Sphere,
    "cpc": Cpc,
    "baffled-tube": BaffledTube,
    "plano-convex": PlanoConvex,
    "biconvex": Biconvex,
}

SURFACES: Final[dict[str, type[Surface]]] = {
    "absorber": Absorber,
    "mirror": Mirror,
    "lambertian": Lambertian,
    "fresnel": Fresnel,
}

SOURCES: Final[dict[str, type[Source]]] = {
    "isotropic-point": IsotropicPoint,
    "cosine-point": CosinePoint,
    "lambertian-disk": LambertianDisk,
    "lambertian-sphere": LambertianSphere,
    "collimated-disk": CollimatedDisk,
}

DETECTORS: Final[dict[str, type[Detector]]] = {"detector": Detector}
