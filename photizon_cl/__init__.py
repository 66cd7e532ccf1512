"""Non-sequential Monte-Carlo ray tracing for illumination and stray light, in OpenCL.

``import photizon_cl as pz`` touches no OpenCL and imports next to nothing: every public name is
looked up in an explicit table at first use (PEP 562).

>>> import photizon_cl as pz
>>> scene = pz.load("integrating-sphere")
>>> result = pz.trace(scene, seed=1, target=0.05)  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

__version__: Final = "0.1.0"

if TYPE_CHECKING:
    from photizon_cl import figures as figures
    from photizon_cl.detectors.detector import Detector
    from photizon_cl.elements.baffled_tube import BaffledTube
    from photizon_cl.elements.biconvex import Biconvex
    from photizon_cl.elements.cpc import Cpc
    from photizon_cl.elements.disk import Disk
    from photizon_cl.elements.plano_convex import PlanoConvex
    from photizon_cl.elements.rectangle import Rectangle
    from photizon_cl.elements.sphere import Sphere
    from photizon_cl.errors import (
        ArgumentError,
        PhotizonError,
        RecipeError,
        ResultError,
        RunError,
        SceneError,
    )
    from photizon_cl.pathing import Paths, paths
    from photizon_cl.probing import probe
    from photizon_cl.recipe import Recipe
    from photizon_cl.result import Result, open_result
    from photizon_cl.scene import Scene
    from photizon_cl.scene_io import load
    from photizon_cl.settings import FarField, RunSettings
    from photizon_cl.simulation import resume, trace
    from photizon_cl.sources.collimated_disk import CollimatedDisk
    from photizon_cl.sources.cosine_point import CosinePoint
    from photizon_cl.sources.isotropic_point import IsotropicPoint
    from photizon_cl.sources.lambertian_disk import LambertianDisk
    from photizon_cl.sources.lambertian_sphere import LambertianSphere
    from photizon_cl.surfaces.absorber import Absorber
    from photizon_cl.surfaces.fresnel import Fresnel
    from photizon_cl.surfaces.lambertian import Lambertian
    from photizon_cl.surfaces.mirror import Mirror

_MODULE_OF: Final[dict[str, str]] = {
    # verbs
    "load": "photizon_cl.scene_io",
    "trace": "photizon_cl.simulation",
    "resume": "photizon_cl.simulation",
    "probe": "photizon_cl.probing",
    "paths": "photizon_cl.pathing",
    "open_result": "photizon_cl.result",
    # what comes out
    "Result": "photizon_cl.result",
    "Paths": "photizon_cl.pathing",
    "Recipe": "photizon_cl.recipe",
    "figures": "photizon_cl.figures",
    # what goes in
    "Scene": "photizon_cl.scene",
    "RunSettings": "photizon_cl.settings",
    "FarField": "photizon_cl.settings",
    "Detector": "photizon_cl.detectors.detector",
    "BaffledTube": "photizon_cl.elements.baffled_tube",
    "Biconvex": "photizon_cl.elements.biconvex",
    "Cpc": "photizon_cl.elements.cpc",
    "PlanoConvex": "photizon_cl.elements.plano_convex",
    "Rectangle": "photizon_cl.elements.rectangle",
    "Disk": "photizon_cl.elements.disk",
    "Sphere": "photizon_cl.elements.sphere",
    "Absorber": "photizon_cl.surfaces.absorber",
    "Mirror": "photizon_cl.surfaces.mirror",
    "Lambertian": "photizon_cl.surfaces.lambertian",
    "Fresnel": "photizon_cl.surfaces.fresnel",
    "IsotropicPoint": "photizon_cl.sources.isotropic_point",
    "CosinePoint": "photizon_cl.sources.cosine_point",
    "LambertianDisk": "photizon_cl.sources.lambertian_disk",
    "LambertianSphere": "photizon_cl.sources.lambertian_sphere",
    "CollimatedDisk": "photizon_cl.sources.collimated_disk",
    # what can go wrong
    "PhotizonError": "photizon_cl.errors",
    "SceneError": "photizon_cl.errors",
    "ArgumentError": "photizon_cl.errors",
    "ResultError": "photizon_cl.errors",
    "RecipeError": "photizon_cl.errors",
    "RunError": "photizon_cl.errors",
}
"""Public name → the module that defines it, or that it is; a name is public by standing here."""

__all__ = [
    "Absorber",
    "ArgumentError",
    "BaffledTube",
    "Biconvex",
    "CollimatedDisk",
    "CosinePoint",
    "Cpc",
    "Detector",
    "Disk",
    "FarField",
    "Fresnel",
    "IsotropicPoint",
    "Lambertian",
    "LambertianDisk",
    "LambertianSphere",
    "Mirror",
    "Paths",
    "PhotizonError",
    "PlanoConvex",
    "Recipe",
    "RecipeError",
    "Rectangle",
    "Result",
    "ResultError",
    "RunError",
    "RunSettings",
    "Scene",
    "SceneError",
    "Sphere",
    "__version__",
    "figures",
    "load",
    "open_result",
    "paths",
    "probe",
    "resume",
    "trace",
]


def __getattr__(name: str) -> Any:
    try:
        module = _MODULE_OF[name]
    except KeyError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
    found = import_module(module)
    value = found if module == f"{__name__}.{name}" else getattr(found, name)
    globals()[name] = value  # found once; the next look-up does not come here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
