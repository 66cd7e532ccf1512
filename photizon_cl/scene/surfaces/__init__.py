"""Surfaces: what a ray that hits an element does. One class a file, listed in the registry."""

from photizon_cl.scene.surfaces.base import Surface

__all__ = ["Surface"]
