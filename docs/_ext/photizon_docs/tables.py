"""Tables and fragments that handwritten pages ask for by name, from the package's declarations."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any

from photizon_cl.compile.effects.table import EFFECT_ROWS as EFFECTS
from photizon_cl.errors import show
from photizon_cl.scene.described import (
    Described,
    Nested,
    NestedList,
    parameters_of,
    shown_default,
)
from photizon_cl.scene.elements import Element
from photizon_cl.scene.far_field import FarField
from photizon_cl.scene.frames import AXES, frame
from photizon_cl.scene.importance import Importance
from photizon_cl.scene.media.medium import Medium
from photizon_cl.scene.model import Scene
from photizon_cl.scene.polarisation import Polarisation
from photizon_cl.scene.presets import presets
from photizon_cl.scene.registry import COATINGS, DETECTORS, ELEMENTS, SCATTERS, SOURCES, SURFACES
from photizon_cl.scene.settings import RunSettings
from photizon_cl.scene.sources import DirectedSource
from photizon_cl.scene.spectrum import Spectrum

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from photizon_cl.scene.parameters import Parameter

__all__ = ["FRAGMENTS", "GROUPS", "link", "parameter_table", "table"]

GROUPS: dict[str, Mapping[str, type[Described]]] = {
    "element": ELEMENTS,
    "surface": SURFACES,
    "source": SOURCES,
    "detector": DETECTORS,
    "scatter": SCATTERS,
    "coating": COATINGS,
}
"""The registry: name of a group → its kinds."""


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table; an empty string where there is no row."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    if not lines:
        return ""
    heads = list(head)
    return "\n".join(["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads), *lines]) + "\n"


def link(group: str, kind: str, at: str = "/parts") -> str:
    """Return a Markdown link to a kind's page."""
    return f"[`{kind}`]({at}/{group}s/{kind}.md)"


def parameter_table(cls: type[Described], leave_out: Iterable[str] = ()) -> str:
    """Return the table of a class's declared parameters."""
    without = set(leave_out)
    rows = [
        (
            f"`{name}`",
            parameter.meaning or _meaning(parameter),
            _unit(parameter),
            _accepted(parameter),
            _default(cls, name),
        )
        for name, parameter in parameters_of(cls).items()
        if name not in without
    ]
    return table(("parameter", "meaning", "unit", "accepted", "default"), rows)


def _meaning(parameter: Parameter) -> str:
    if isinstance(parameter, NestedList):
        return f"the scene's {parameter.base.label}s"
    if isinstance(parameter, Nested):
        return f"the `[{parameter.base.label}]` table"
    return ""


def _unit(parameter: Parameter) -> str:
    return {"deg": "°"}.get(parameter.unit, parameter.unit)


def _accepted(parameter: Parameter) -> str:
    label = parameter.base.label if isinstance(parameter, Nested) else ""
    if label in GROUPS:
        return f"[{parameter.expected}](/parts/{label}s/index.md)"
    return parameter.expected


def _default(cls: type[Described], name: str) -> str:
    value = shown_default(cls, name)
    if value is dataclasses.MISSING:
        return "**required**"
    if value is None or value == ():
        return "none"
    if isinstance(value, Described) and value.kind:
        return f"`{show(value.to_table())}`"
    return "all defaults" if dataclasses.is_dataclass(value) else f"`{show(value)}`"


# -- fragments of handwritten pages ---------------------------------------------------------------


def _kinds(group: str) -> str:
    rows = []
    for kind, cls in GROUPS[group].items():
        first = (cls.__doc__ or "").strip().splitlines()[0]
        own = [f"`{p}`" for p in parameters_of(cls) if p not in _SHARED]
        rows.append((link(group, kind), first.replace("`", ""), " ".join(own)))
    return table(("kind", "what it is", "parameters of its own"), rows)


_SHARED = frozenset({*parameters_of(Element), *parameters_of(DirectedSource)})


def _frames() -> str:
    def name(row: tuple[float, float, float]) -> str:
        place = next(i for i in range(3) if row[i])
        return ("+" if row[place] > 0 else "−") + "xyz"[place]

    rows = [(f"`{axis}`", name(frame(axis)[0]), name(frame(axis)[1])) for axis in AXES]
    return table(("axis (w)", "u", "v"), rows)


def _effects() -> str:
    rows = [(f"`{effect.name}`", effect.what, effect.costs) for effect in EFFECTS.values()]
    return table(("effect", "what it does", "what it costs"), rows)


def _presets() -> str:
    rows = [(f"[`{p.name}`](/presets.md#{p.name})", p.title) for p in presets().values()]
    return table(("preset", "what it is"), rows)


def _anchors() -> str:
    def plain(text: str) -> str:
        return re.sub(r"([\\`*_<>\[\]|#])", r"\\\1", text)

    return "\n".join(
        f"## {p.name}\n\n{plain(p.title)}.\n\n{plain(p.anchor)}\n" for p in presets().values()
    )


FRAGMENTS: dict[str, Callable[[], Any]] = {
    "scene": lambda: parameter_table(Scene),
    "run": lambda: parameter_table(RunSettings),
    "far-field": lambda: parameter_table(FarField),
    "importance": lambda: parameter_table(Importance),
    "medium": lambda: parameter_table(Medium),
    "spectrum": lambda: parameter_table(Spectrum),
    "polarisation": lambda: parameter_table(Polarisation),
    "source": lambda: parameter_table(DirectedSource),
    "element": lambda: parameter_table(Element),
    "frames": _frames,
    "effects": _effects,
    "presets": _presets,
    "preset-anchors": _anchors,
    **{f"{group}-kinds": lambda group=group: _kinds(group) for group in GROUPS},
}
"""What ``<!-- generated: NAME -->`` in a page stands for."""
