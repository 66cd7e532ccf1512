"""Non-sequential Monte-Carlo ray tracing for illumination and stray light, in OpenCL.

``import photizon_cl as pz`` touches no OpenCL and imports next to nothing: every public name is
looked up at first use (PEP 562), in an explicit table or, for the kinds of sources, elements and
surfaces, in `photizon_cl.scene.registry`.

>>> import photizon_cl as pz
>>> scene = pz.load("integrating-sphere")
>>> result = pz.trace(scene, seed=1, target=0.05)  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

from photizon_cl.version import __version__ as __version__

# What type checkers see. Public is what is imported under its own name once more.
if TYPE_CHECKING:
    from photizon_cl.checks.advisories import advisories as advisories
    from photizon_cl.errors import ArgumentError as ArgumentError
    from photizon_cl.errors import PhotizonError as PhotizonError
    from photizon_cl.errors import RecipeError as RecipeError
    from photizon_cl.errors import ResultError as ResultError
    from photizon_cl.errors import RunError as RunError
    from photizon_cl.errors import RunWarning as RunWarning
    from photizon_cl.errors import SceneError as SceneError
    from photizon_cl.errors import UnknownNameError as UnknownNameError
    from photizon_cl.result.comparison import Comparison as Comparison
    from photizon_cl.result.cost import CostStudy as CostStudy
    from photizon_cl.result.effects import Effects as Effects
    from photizon_cl.result.paths import Paths as Paths
    from photizon_cl.result.sweep import SweepPoint as SweepPoint
    from photizon_cl.run.comparing import compare as compare
    from photizon_cl.run.drawing import draw as draw
    from photizon_cl.run.pathing import paths as paths
    from photizon_cl.run.probing import probe as probe
    from photizon_cl.run.recipe import Recipe as Recipe
    from photizon_cl.run.result import Result as Result
    from photizon_cl.run.result import open_result as open_result
    from photizon_cl.run.simulation import resume as resume
    from photizon_cl.run.simulation import trace as trace
    from photizon_cl.scene.angles import AngleCurve as AngleCurve
    from photizon_cl.scene.coatings.stack import Layer as Layer
    from photizon_cl.scene.curves import AbsorptionCurve as AbsorptionCurve
    from photizon_cl.scene.curves import Curve as Curve
    from photizon_cl.scene.detectors.detector import Detector as Detector
    from photizon_cl.scene.far_field import FarField as FarField
    from photizon_cl.scene.files import load as load
    from photizon_cl.scene.importance import Importance as Importance
    from photizon_cl.scene.media.dispersion import Cauchy as Cauchy
    from photizon_cl.scene.media.dispersion import IndexTable as IndexTable
    from photizon_cl.scene.media.dispersion import Polynomial as Polynomial
    from photizon_cl.scene.media.dispersion import Sellmeier as Sellmeier
    from photizon_cl.scene.media.medium import Medium as Medium
    from photizon_cl.scene.model import Scene as Scene
    from photizon_cl.scene.polarisation import Polarisation as Polarisation
    from photizon_cl.scene.presets import presets as presets
    from photizon_cl.scene.registry import *  # noqa: F403  (the kinds)
    from photizon_cl.scene.settings import RunSettings as RunSettings
    from photizon_cl.scene.spectrum import Spectrum as Spectrum
    from photizon_cl.studies.costing import cost as cost
    from photizon_cl.studies.effects import effects as effects
    from photizon_cl.studies.sweeps import Sweep as Sweep
    from photizon_cl.studies.sweeps import open_sweep as open_sweep
    from photizon_cl.studies.sweeps import sweep as sweep
    from photizon_cl.views import figures as figures

_MODULE_OF: Final[dict[str, str]] = {
    # verbs
    "load": "photizon_cl.scene.files",
    "advisories": "photizon_cl.checks.advisories",
    "presets": "photizon_cl.scene.presets",
    "draw": "photizon_cl.run.drawing",
    "trace": "photizon_cl.run.simulation",
    "resume": "photizon_cl.run.simulation",
    "probe": "photizon_cl.run.probing",
    "paths": "photizon_cl.run.pathing",
    "open_result": "photizon_cl.run.result",
    "compare": "photizon_cl.run.comparing",
    "cost": "photizon_cl.studies.costing",
    "effects": "photizon_cl.studies.effects",
    "sweep": "photizon_cl.studies.sweeps",
    "open_sweep": "photizon_cl.studies.sweeps",
    # what comes out
    "Result": "photizon_cl.run.result",
    "Comparison": "photizon_cl.result.comparison",
    "CostStudy": "photizon_cl.result.cost",
    "Effects": "photizon_cl.result.effects",
    "Sweep": "photizon_cl.studies.sweeps",
    "SweepPoint": "photizon_cl.result.sweep",
    "Paths": "photizon_cl.result.paths",
    "Recipe": "photizon_cl.run.recipe",
    # what goes in, besides the kinds
    "Scene": "photizon_cl.scene.model",
    "RunSettings": "photizon_cl.scene.settings",
    "FarField": "photizon_cl.scene.far_field",
    "Importance": "photizon_cl.scene.importance",
    "Polarisation": "photizon_cl.scene.polarisation",
    "Medium": "photizon_cl.scene.media.medium",
    "Spectrum": "photizon_cl.scene.spectrum",
    "Curve": "photizon_cl.scene.curves",
    "AbsorptionCurve": "photizon_cl.scene.curves",
    "AngleCurve": "photizon_cl.scene.angles",
    "Layer": "photizon_cl.scene.coatings.stack",
    "Sellmeier": "photizon_cl.scene.media.dispersion",
    "Polynomial": "photizon_cl.scene.media.dispersion",
    "Cauchy": "photizon_cl.scene.media.dispersion",
    "IndexTable": "photizon_cl.scene.media.dispersion",
    "Detector": "photizon_cl.scene.detectors.detector",
    # what can go wrong
    "PhotizonError": "photizon_cl.errors",
    "SceneError": "photizon_cl.errors",
    "ArgumentError": "photizon_cl.errors",
    "ResultError": "photizon_cl.errors",
    "RecipeError": "photizon_cl.errors",
    "UnknownNameError": "photizon_cl.errors",
    "RunError": "photizon_cl.errors",
    "RunWarning": "photizon_cl.errors",
}
"""Public name → the module that defines it; the registry has the kinds' names."""

_MODULES: Final[dict[str, str]] = {"figures": "photizon_cl.views.figures"}
"""Public name → the module that it is."""


if not TYPE_CHECKING:  # else every name would be there, and of any type

    def __getattr__(name):
        if name == "__all__":
            value = sorted({"__version__", *_MODULE_OF, *_MODULES, *_kinds()})
        elif name in _MODULE_OF:
            value = getattr(import_module(_MODULE_OF[name]), name)
        elif name in _MODULES:
            value = import_module(_MODULES[name])
        elif name[:1].isupper() and name in _kinds():  # no other name costs the registry
            value = _kinds()[name]
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value  # found once; the next look-up does not come here
        return value

    def _kinds():
        return import_module("photizon_cl.scene.registry").CLASSES

    def __dir__():
        return sorted({*globals(), *__getattr__("__all__")})
