"""The verb ``kinds``: what a scene can hold, as the registry and the declarations say."""

from __future__ import annotations

import dataclasses
import difflib
import re
from inspect import cleandoc
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable, Mapping

    from rich.console import Console

    from photizon_cl.scene.described import Described

    Group = Mapping[str, type[Described]]

__all__ = ["add_arguments", "call"]

_HARD_SPACE: Final = "\N{NO-BREAK SPACE}"
_HEADING: Final = re.compile(r"^\w[\w ]*\n-{3,}\n", re.MULTILINE)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument(
        "kind",
        metavar="KIND",
        nargs="?",
        help="describe this source, element, … table or effect",
    )


def call(arguments: argparse.Namespace) -> int:
    """List all kinds, or describe one; return the exit status."""
    from photizon_cl.cli.tables import console

    out = console()
    if arguments.kind is None:
        _list(out)
    else:
        _describe(arguments.kind, out)
    return 0


def _groups() -> dict[str, Group]:
    """Return the kinds of each group, by what the group's members are called."""
    from photizon_cl.scene.registry import (
        COATINGS,
        DETECTORS,
        DISPERSIONS,
        ELEMENTS,
        MEDIA,
        SCATTERS,
        SOURCES,
        SURFACES,
    )

    groups: tuple[Group, ...] = (
        SOURCES,
        ELEMENTS,
        SURFACES,
        SCATTERS,
        COATINGS,
        DETECTORS,
        MEDIA,
        DISPERSIONS,
    )
    return {next(iter(group.values())).label: group for group in groups}


def _tables() -> Group:
    """Return the tables of a scene file, and of a source, that have no kinds, by name."""
    from photizon_cl.scene.described import Nested, NestedList, parameters_of
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.sources import Source

    inner = {
        name: parameter.base
        for holder in (Scene, Source)
        for name, parameter in parameters_of(holder).items()
        if isinstance(parameter, Nested) and not isinstance(parameter, NestedList)
    }
    return {"scene": Scene, **inner}


def _effects() -> dict[str, tuple[str, str]]:
    """Return the effects that are no kind's own: name → (what it does, what it costs)."""
    from photizon_cl.compile.effects.table import EFFECT_ROWS as EFFECTS

    kinds = {f"{label}.{kind}" for label, group in _groups().items() for kind in group}
    return {name: (e.what, e.costs) for name, e in EFFECTS.items() if name not in kinds}


# -- all -----------------------------------------------------------------------------------------


def _list(out: Console, only: str | None = None) -> None:
    """List the kinds of every group, or of one."""
    from rich.text import Text

    from photizon_cl.cli.tables import paragraph
    from photizon_cl.scene.described import parameters_of

    groups = _groups()
    for label, group in ({only: groups[only]} if only in groups else groups).items():
        out.print(Text(f"{label}s" if len(group) > 1 else label, "bold"))
        common = _common(group.values()) if len(group) > 1 else []
        if common:
            first = next(iter(group.values()))
            text = ", ".join(_parameter(first, name) for name in common)
            out.print(_soft(paragraph(f"all take {text}")), soft_wrap=True)
        for kind, cls in group.items():
            out.print(paragraph(f"{kind}: {_sentence(cls)}"), soft_wrap=True)
            own = [_parameter(cls, name) for name in parameters_of(cls) if name not in common]
            if own:
                out.print(_soft(paragraph(", ".join(own), "    ")), soft_wrap=True)
        if only is None:
            out.print()
    if only is None:
        _list_others(out)


def _list_others(out: Console) -> None:
    """List the tables that have no kinds, and the effects."""
    from rich.text import Text

    from photizon_cl.cli.tables import paragraph
    from photizon_cl.scene.described import parameters_of

    out.print(Text("tables", "bold"))
    for name, cls in _tables().items():
        out.print(paragraph(f"{name}: {_sentence(cls)}"), soft_wrap=True)
        own = [_parameter(cls, parameter) for parameter in parameters_of(cls)]
        out.print(_soft(paragraph(", ".join(own), "    ")), soft_wrap=True)
    out.print()
    out.print(Text("effects, compiled in where a scene needs them", "bold"))
    for name, (what, _) in _effects().items():
        out.print(paragraph(f"{name}: {what}"), soft_wrap=True)


def _soft(text: str) -> str:
    return text.replace(_HARD_SPACE, " ")


def _common(classes: Iterable[type[Described]]) -> list[str]:
    """Return the parameters that all of some classes take."""
    from photizon_cl.scene.described import parameters_of

    first, *others = (parameters_of(cls) for cls in classes)
    return [name for name in first if all(name in other for other in others)]


def _parameter(cls: type[Described], name: str) -> str:
    """Return a parameter with its unit, and its default where it has one."""
    from photizon_cl.scene.described import parameters_of

    default, unit = _default(cls, name), parameters_of(cls)[name].unit
    text = f"{name} ({unit})" if unit else name
    return _kept_together(text if default is None else f"{text} = {default}")


def _kept_together(text: str) -> str:
    """Return text that no line ends within."""
    return text.replace(" ", _HARD_SPACE)


def _default(cls: type[Described], name: str) -> str | None:
    """Return a parameter's default as a scene file has it; None where it is required."""
    from photizon_cl.scene.described import Described, shown_default

    value = shown_default(cls, name)
    if value is dataclasses.MISSING:
        return None
    if isinstance(value, Described):
        return show(value.to_table()) if value.kind else "its defaults"
    return "none" if value is None else show(value)


def _prose(cls: type[Described]) -> list[str]:
    """Return the paragraphs that describe a class, without its parameters."""
    text = _HEADING.split(cleandoc(cls.__doc__ or ""))[0].replace("`", "")
    return [" ".join(part.split()) for part in text.split("\n\n") if part.strip()]


def _sentence(cls: type[Described]) -> str:
    return _prose(cls)[0].rstrip(".")


# -- one -----------------------------------------------------------------------------------------


def _describe(kind: str, out: Console) -> None:
    from rich.text import Text

    from photizon_cl.cli.tables import paragraph

    groups, effects = {**_groups(), "table": _tables()}, _effects()
    labels = [label for label, group in groups.items() if kind in group]
    for n, label in enumerate(labels):  # several groups may have one of a name
        if n:
            out.print()
        _describe_class(kind, label, groups[label][kind], out)
    if not labels and kind.removesuffix("s") in _groups():
        _list(out, kind.removesuffix("s"))
        return
    if not labels and kind not in effects:
        raise ArgumentError(_unknown(kind, groups, effects))
    if kind not in effects:
        return
    if labels:
        out.print()
    what, costs = effects[kind]
    out.print(Text.assemble((kind, "bold"), "  effect"))
    for text in (what, f"costs {costs}"):
        out.print(paragraph(text), soft_wrap=True)


def _describe_class(kind: str, label: str, cls: type[Described], out: Console) -> None:
    from rich.text import Text

    from photizon_cl.cli.tables import paragraph, print_table, table
    from photizon_cl.scene.described import parameters_of

    out.print(Text.assemble((kind, "bold"), f"  {label}"))
    for text in _prose(cls):
        out.print(paragraph(text), soft_wrap=True)
    declared = parameters_of(cls)
    out.print()
    if not declared:
        out.print(paragraph("It takes no parameters."), soft_wrap=True)
        return
    rows = table(("parameter", "left"), ("unit", "left"), ("default", "left"), ("", "left"))
    for name, parameter in declared.items():
        default = _default(cls, name) or "required"
        meaning = f"{parameter.meaning}: {parameter.expected}"
        rows.add_row(Text(name), parameter.unit, Text(default), Text(meaning))
    print_table(rows, out)


def _unknown(kind: str, groups: Mapping[str, Group], effects: Iterable[str]) -> str:
    """Return the message that a kind does not exist, with what there is."""
    there = {f"{label}s": list(group) for label, group in groups.items()} | {
        "effects": list(effects)
    }
    near = difflib.get_close_matches(
        kind.lower(), [name for names in there.values() for name in names], 1
    )
    hint = f"; did you mean {near[0]}?" if near else ""
    listed = "; ".join(f"{group}: {', '.join(names)}" for group, names in there.items())
    return f"KIND: found {show(kind)}, expected one of {listed}{hint}"
