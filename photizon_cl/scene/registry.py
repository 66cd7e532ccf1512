"""Everything that a scene can hold, by the kind that a file names.

Nothing registers itself by being imported: a kind exists when it has an import and an entry here.
Each is imported under its own name once more (``as``), which is how type checkers know it as a
class of `photizon_cl`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeVar

from photizon_cl.scene.coatings.fixed import FixedCoating as FixedCoating
from photizon_cl.scene.coatings.stack import StackCoating as StackCoating
from photizon_cl.scene.coatings.table import TableCoating as TableCoating
from photizon_cl.scene.described import Described
from photizon_cl.scene.detectors.detector import Detector as _Detector
from photizon_cl.scene.elements.baffled_tube import BaffledTube as BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex as Biconvex
from photizon_cl.scene.elements.cone import Cone as Cone
from photizon_cl.scene.elements.conic import Conic as Conic
from photizon_cl.scene.elements.cpc import Cpc as Cpc
from photizon_cl.scene.elements.cylinder import Cylinder as Cylinder
from photizon_cl.scene.elements.disk import Disk as Disk
from photizon_cl.scene.elements.general_lens import Lens as Lens
from photizon_cl.scene.elements.plano_convex import PlanoConvex as PlanoConvex
from photizon_cl.scene.elements.rectangle import Rectangle as Rectangle
from photizon_cl.scene.elements.sphere import Sphere as Sphere
from photizon_cl.scene.filters.along import Along as _Along
from photizon_cl.scene.filters.azimuth import Azimuth as _Azimuth
from photizon_cl.scene.filters.generation import Generation as _Generation
from photizon_cl.scene.filters.wavelength import Wavelength as _Wavelength
from photizon_cl.scene.media.dispersion import DISPERSIONS as DISPERSIONS
from photizon_cl.scene.media.medium import Medium as _Medium
from photizon_cl.scene.scatters.abg import AbgScatter as AbgScatter
from photizon_cl.scene.scatters.gaussian import GaussianScatter as GaussianScatter
from photizon_cl.scene.scatters.harvey_shack import HarveyShackScatter as HarveyShackScatter
from photizon_cl.scene.scatters.lambertian import LambertianScatter as LambertianScatter
from photizon_cl.scene.scatters.table import TableScatter as TableScatter
from photizon_cl.scene.sources.collimated_disk import CollimatedDisk as CollimatedDisk
from photizon_cl.scene.sources.cone_point import ConePoint as ConePoint
from photizon_cl.scene.sources.cosine_point import CosinePoint as CosinePoint
from photizon_cl.scene.sources.isotropic_point import IsotropicPoint as IsotropicPoint
from photizon_cl.scene.sources.lambertian_disk import LambertianDisk as LambertianDisk
from photizon_cl.scene.sources.lambertian_rectangle import (
    LambertianRectangle as LambertianRectangle,
)
from photizon_cl.scene.sources.lambertian_sphere import LambertianSphere as LambertianSphere
from photizon_cl.scene.surfaces.absorber import Absorber as Absorber
from photizon_cl.scene.surfaces.clear import Clear as Clear
from photizon_cl.scene.surfaces.fresnel import Fresnel as Fresnel
from photizon_cl.scene.surfaces.lambertian import Lambertian as Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror as Mirror
from photizon_cl.scene.surfaces.mixed import Mixed as Mixed

if TYPE_CHECKING:
    from photizon_cl.scene.coatings.base import Coating as _Coating
    from photizon_cl.scene.elements.base import Element as _Element
    from photizon_cl.scene.filters.base import Filter as _Filter
    from photizon_cl.scene.scatters.base import Scatter as _Scatter
    from photizon_cl.scene.sources.base import Source as _Source
    from photizon_cl.scene.surfaces.base import Surface as _Surface

_D = TypeVar("_D", bound=Described)


def _by_kind(*classes: type[_D]) -> dict[str, type[_D]]:
    found = {cls.kind: cls for cls in classes}
    if len(found) != len(classes):
        kinds = [cls.kind for cls in classes]
        twice = sorted({kind for kind in kinds if kinds.count(kind) > 1})
        raise ValueError(f"two classes of the kind {', '.join(twice)}: give each a name of its own")
    return found


ELEMENTS: Final[dict[str, type[_Element]]] = _by_kind(
    Rectangle,
    Disk,
    Sphere,
    Cpc,
    BaffledTube,
    PlanoConvex,
    Biconvex,
    Cylinder,
    Cone,
    Conic,
    Lens,
)

SURFACES: Final[dict[str, type[_Surface]]] = _by_kind(
    Absorber,
    Mirror,
    Lambertian,
    Fresnel,
    Clear,
    Mixed,
)

SCATTERS: Final[dict[str, type[_Scatter]]] = _by_kind(
    AbgScatter,
    HarveyShackScatter,
    GaussianScatter,
    LambertianScatter,
    TableScatter,
)

COATINGS: Final[dict[str, type[_Coating]]] = _by_kind(
    FixedCoating,
    TableCoating,
    StackCoating,
)

SOURCES: Final[dict[str, type[_Source]]] = _by_kind(
    IsotropicPoint,
    CosinePoint,
    LambertianDisk,
    LambertianSphere,
    CollimatedDisk,
    ConePoint,
    LambertianRectangle,
)

DETECTORS: Final[dict[str, type[_Detector]]] = _by_kind(_Detector)

MEDIA: Final[dict[str, type[_Medium]]] = _by_kind(_Medium)

FILTERS: Final[dict[str, type[_Filter]]] = {
    cls.kind: cls
    for cls in (
        _Generation,
        _Along,
        _Azimuth,
        _Wavelength,
    )
}

_GROUPS: Final = (SOURCES, ELEMENTS, SURFACES, SCATTERS, COATINGS)

CLASSES: Final[dict[str, type[Described]]] = {
    cls.__name__: cls for group in _GROUPS for cls in group.values()
}
"""The classes of all kinds that a scene can hold by their names, which are public."""
