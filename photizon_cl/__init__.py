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

from photizon_cl.version import __version__

if TYPE_CHECKING:
    from photizon_cl.errors import (
        ArgumentError,
        PhotizonError,
        RecipeError,
        ResultError,
        RunError,
        SceneError,
    )
    from photizon_cl.result.recipe import Recipe
    from photizon_cl.result.result import Result, open_result
    from photizon_cl.run.pathing import Paths, paths
    from photizon_cl.run.probing import probe
    from photizon_cl.run.simulation import resume, trace
    from photizon_cl.scene.detectors.detector import Detector
    from photizon_cl.scene.elements.baffled_tube import BaffledTube
    from photizon_cl.scene.elements.biconvex import Biconvex
    from photizon_cl.scene.elements.cpc import Cpc
    from photizon_cl.scene.elements.disk import Disk
    from photizon_cl.scene.elements.plano_convex import PlanoConvex
    from photizon_cl.scene.elements.rectangle import Rectangle
    from photizon_cl.scene.elements.sphere import Sphere
    from photizon_cl.scene.files import load
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import FarField, RunSettings
    from photizon_cl.scene.sources.collimated_disk import CollimatedDisk
    from photizon_cl.scene.sources.cosine_point import CosinePoint
    from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
    from photizon_cl.scene.sources.lambertian_disk import LambertianDisk
    from photizon_cl.scene.sources.lambertian_sphere import LambertianSphere
    from photizon_cl.scene.surfaces.absorber import Absorber
    from photizon_cl.scene.surfaces.fresnel import Fresnel
    from photizon_cl.scene.surfaces.lambertian import Lambertian
    from photizon_cl.scene.surfaces.mirror import Mirror
    from photizon_cl.views import figures as figures

_MODULE_OF: Final[dict[str, str]] = {
    # verbs
    "load": "photizon_cl.scene.files",
    "trace": "photizon_cl.run.simulation",
    "resume": "photizon_cl.run.simulation",
    "probe": "photizon_cl.run.probing",
    "paths": "photizon_cl.run.pathing",
    "open_result": "photizon_cl.result.result",
    # what comes out
    "Result": "photizon_cl.result.result",
    "Paths": "photizon_cl.run.pathing",
    "Recipe": "photizon_cl.result.recipe",
    "figures": "photizon_cl.views.figures",
    # what goes in
    "Scene": "photizon_cl.scene.model",
    "RunSettings": "photizon_cl.scene.settings",
    "FarField": "photizon_cl.scene.settings",
    "Detector": "photizon_cl.scene.detectors.detector",
    "BaffledTube": "photizon_cl.scene.elements.baffled_tube",
    "Biconvex": "photizon_cl.scene.elements.biconvex",
    "Cpc": "photizon_cl.scene.elements.cpc",
    "PlanoConvex": "photizon_cl.scene.elements.plano_convex",
    "Rectangle": "photizon_cl.scene.elements.rectangle",
    "Disk": "photizon_cl.scene.elements.disk",
    "Sphere": "photizon_cl.scene.elements.sphere",
    "Absorber": "photizon_cl.scene.surfaces.absorber",
    "Mirror": "photizon_cl.scene.surfaces.mirror",
    "Lambertian": "photizon_cl.scene.surfaces.lambertian",
    "Fresnel": "photizon_cl.scene.surfaces.fresnel",
    "IsotropicPoint": "photizon_cl.scene.sources.isotropic_point",
    "CosinePoint": "photizon_cl.scene.sources.cosine_point",
    "LambertianDisk": "photizon_cl.scene.sources.lambertian_disk",
    "LambertianSphere": "photizon_cl.scene.sources.lambertian_sphere",
    "CollimatedDisk": "photizon_cl.scene.sources.collimated_disk",
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
    value = found if module.endswith(f".{name}") else getattr(found, name)
    globals()[name] = value  # found once; the next look-up does not come here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
