"""Surfaces: what a ray that hits an element does. One class a file."""

from photizon_cl.surfaces.absorber import Absorber
from photizon_cl.surfaces.base import Surface
from photizon_cl.surfaces.fresnel import Fresnel
from photizon_cl.surfaces.lambertian import Lambertian
from photizon_cl.surfaces.mirror import Mirror

__all__ = ["Absorber", "Fresnel", "Lambertian", "Mirror", "Surface"]
