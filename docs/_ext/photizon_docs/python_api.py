"""The Python reference: every public name, from ``photizon_cl.__all__``."""

from __future__ import annotations

import inspect

import photizon_cl as pz
from photizon_cl.scene.described import Described

__all__ = ["python_api"]

_BESIDES = (
    ("photizon_cl.result.maps", "DetectorResult"),
    ("photizon_cl.result.maps", "IrradianceMap"),
    ("photizon_cl.result.maps", "Rung"),
    ("photizon_cl.result.far_field", "FarFieldResult"),
    ("photizon_cl.result.ledger", "Ledger"),
    ("photizon_cl.result.ledger", "Estimate"),
    ("photizon_cl.result.ledger", "Roulette"),
    ("photizon_cl.result.estimates", "RunInfo"),
    ("photizon_cl.result.cost", "CostSetting"),
    ("photizon_cl.result.cost", "TargetTime"),
    ("photizon_cl.result.effects", "EffectUse"),
    ("photizon_cl.result.effects", "ProgramUse"),
    ("photizon_cl.result.effects", "Price"),
    ("photizon_cl.result.effects", "ProgramCost"),
    ("photizon_cl.result.effects", "Ratio"),
    ("photizon_cl.run.progress", "Progress"),
    ("photizon_cl.studies.sweep_progress", "SweepProgress"),
    ("photizon_cl.scene.sweeps", "SweepPlan"),
    ("photizon_cl.scene.sweeps", "Axis"),
    ("photizon_cl.run.probing", "ProbeResult"),
    ("photizon_cl.result.paths", "Polyline"),
    ("photizon_cl.scene.names", "ByName"),
    ("photizon_cl.scene.presets", "Preset"),
    ("photizon_cl.errors", "Problem"),
)
"""Classes that are not public by name but are what public calls give."""

_SEE = (
    "Ranges and units stand on the pages of the [elements](/parts/elements/index.md), "
    "[surfaces](/parts/surfaces/index.md), [sources](/parts/sources/index.md) and "
    "[detectors](/parts/detectors/index.md).\n"
)


def python_api() -> str:
    """Return the directives that document every public name, by what it is."""
    verbs, results, scene, errors, modules = [], [], [], [], []
    for name in pz.__all__:
        item = getattr(pz, name)
        if inspect.isclass(item):
            if issubclass(item, Exception):
                errors.append(name)
            else:
                (scene if issubclass(item, Described) else results).append(name)
        elif inspect.ismodule(item):
            modules.append((name, item))
        elif callable(item):
            verbs.append(name)
    parts = ["## What to call\n", *(_function(name) for name in sorted(verbs))]
    parts += [
        "## What comes out\n",
        *(_class("photizon_cl", name, inherited=True) for name in results),
    ]
    parts += [_class(module, name) for module, name in _BESIDES]
    for name, module in modules:
        parts += [f"## pz.{name}\n", f"{inspect.getdoc(module).splitlines()[0]}\n"]
        parts += [f"```{{eval-rst}}\n.. py:module:: photizon_cl.{name}\n```\n"]
        functions = ((n, getattr(module, n)) for n in module.__all__)
        called = [n for n, f in functions if inspect.isfunction(f) and f.__name__ == n]
        parts += [_function(f"{name}.{n}") for n in called]
    parts += ["## What goes in\n", _SEE]
    parts += [_class("photizon_cl", name) for name in scene]
    parts += ["## What can go wrong\n", *(_class("photizon_cl", name) for name in errors)]
    return "\n".join(parts)


def _function(name: str) -> str:
    return f"```{{eval-rst}}\n.. autofunction:: photizon_cl.{name}\n```\n"


def _class(module: str, name: str, *, inherited: bool = False) -> str:
    more = "   :inherited-members:\n" if inherited else ""
    return f"```{{eval-rst}}\n.. autoclass:: {module}.{name}\n   :members:\n{more}```\n"
