"""Elements: the geometry that rays hit. One class a file, listed in the registry."""

from photizon_cl.scene.elements.base import Element

__all__ = ["Element"]
