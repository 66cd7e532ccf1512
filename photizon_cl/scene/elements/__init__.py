"""Elements: the geometry that rays hit. One class a file."""

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.base import Element
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere

__all__ = [
    "BaffledTube",
    "Biconvex",
    "Cpc",
    "Disk",
    "Element",
    "PlanoConvex",
    "Rectangle",
    "Sphere",
]
