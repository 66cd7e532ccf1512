"""Sources: where rays start. One class a file."""

from photizon_cl.scene.sources.base import DirectedSource, Source
from photizon_cl.scene.sources.collimated_disk import CollimatedDisk
from photizon_cl.scene.sources.cosine_point import CosinePoint
from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
from photizon_cl.scene.sources.lambertian_disk import LambertianDisk
from photizon_cl.scene.sources.lambertian_sphere import LambertianSphere

__all__ = [
    "CollimatedDisk",
    "CosinePoint",
    "DirectedSource",
    "IsotropicPoint",
    "LambertianDisk",
    "LambertianSphere",
    "Source",
]
