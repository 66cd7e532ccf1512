"""Scatter: what a surface sends aside of its specular ray. One class a file, in the registry."""

from photizon_cl.scene.scatters.base import Scatter

__all__ = ["Scatter"]
