"""Elements: the geometry that rays hit. One class a file."""

from photizon_cl.elements.base import Element
from photizon_cl.elements.disk import Disk
from photizon_cl.elements.rectangle import Rectangle
from photizon_cl.elements.sphere import Sphere

__all__ = ["Disk", "Element", "Rectangle", "Sphere"]
