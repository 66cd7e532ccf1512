"""Coatings: what a border of two media reflects and lets pass. One class a file."""

from photizon_cl.scene.coatings.base import Coating

__all__ = ["Coating"]
