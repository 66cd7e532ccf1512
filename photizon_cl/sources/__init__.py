"""Sources: where rays start. One class a file."""

from photizon_cl.sources.base import DirectedSource, Source
from photizon_cl.sources.collimated_disk import CollimatedDisk
from photizon_cl.sources.cosine_point import CosinePoint
from photizon_cl.sources.isotropic_point import IsotropicPoint
from photizon_cl.sources.lambertian_disk import LambertianDisk
from photizon_cl.sources.lambertian_sphere import LambertianSphere

__all__ = [
    "CollimatedDisk",
    "CosinePoint",
    "DirectedSource",
    "IsotropicPoint",
    "LambertianDisk",
    "LambertianSphere",
    "Source",
]
