"""Surfaces: what a ray that hits an element does. One class a file."""

from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.scene.surfaces.base import Surface
from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror

__all__ = ["Absorber", "Fresnel", "Lambertian", "Mirror", "Surface"]
