"""What the command line prints that is no run: presets, checks, devices."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.model import Scene

__all__ = [
    "WIDTH",
    "console",
    "paragraph",
    "print_check",
    "print_devices",
    "print_presets",
    "print_table",
    "table",
]

WIDTH: Final = 80


class _Console(Console):
    """A console that leaves a closed pipe to the command: rich would exit with status 1."""

    def on_broken_pipe(self) -> None:
        """Hand the error on."""
        raise BrokenPipeError


def console(stderr: bool = False) -> Console:
    """Return a console of at most 80 columns; names in its output are never read as markup."""
    made = _Console(stderr=stderr, markup=False, emoji=False, highlight=False)
    made.width = min(made.width, WIDTH)
    return made


def table(*columns: tuple[str, str], title: str = "") -> Table:
    """Return an empty table; columns are (heading, ``left`` or ``right``)."""
    made = Table(title=Text(title, "bold") if title else None, title_justify="left", box=None)
    made.pad_edge = False
    for heading, side in columns:
        last = heading == ""
        justify: Any = side
        made.add_column(Text(heading), justify=justify, no_wrap=not last and side == "right")
    return made


def print_table(rows: Table, out: Console) -> None:
    """Print a table without the blanks that pad its lines."""
    with out.capture() as captured:
        out.print(rows)
    for line in captured.get().splitlines():
        out.file.write(line.rstrip() + "\n")


def paragraph(text: str, indent: str = "  ") -> str:
    """Return text wrapped to 80 columns with an indent."""
    return textwrap.fill(
        text, WIDTH - 1, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
    )


def print_presets() -> None:
    """Print name, title and anchor of every preset."""
    from photizon_cl.scene.presets import presets

    out = console()
    for n, preset in enumerate(presets()):
        if n:
            out.print()
        out.print(Text.assemble((preset.name, "bold"), f"  {preset.title}"))
        out.print(paragraph(preset.anchor), soft_wrap=True)


def _number(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_number, value)) + ")"
    return str(value)


def _describe(item: Described) -> str:
    """Return the parameters of an object on one line, with units where they have one."""
    from photizon_cl.scene.described import parameters_of

    parts = []
    for name, parameter in parameters_of(type(item)).items():
        value = getattr(item, name)
        if name in ("name", "surface", "detector") or value is None:
            continue
        if name == "tilt_deg" and value == (0.0, 0.0):
            continue
        unit = getattr(parameter, "unit", "")
        parts.append(f"{name} {_number(value)}" + (f" {unit}" if unit else ""))
    return ", ".join(parts)


def print_check(scene: Scene) -> None:
    """Print what a valid scene describes, what follows from it, and the advisories."""
    from photizon_cl.compile.compiled import compile_scene

    compiled = compile_scene(scene, scene.run)
    out = console()
    out.print(Text.assemble((scene.name, "bold"), f"  {scene.title}"))

    def line(text: str, indent: str = "  ") -> None:
        out.print(paragraph(text, indent), soft_wrap=True)

    line(f"run: {_describe(scene.run)}")
    if scene.far_field is not None:
        line(f"far field: {_describe(scene.far_field)}; {_derived(scene.far_field)}")
    out.print()
    out.print(Text("sources", "bold"))
    for source, rays in zip(scene.source, compiled.rays_of_source, strict=True):
        line(f"{source.name}: {source.kind}, {_describe(source)}; {rays} rays a batch")
        if hasattr(source, "derived") and source.derived():
            line(_derived(source), "    ")
    if scene.element:
        out.print()
        out.print(Text("elements", "bold"))
    for element in scene.element:
        line(f"{element.name}: {element.kind}, {_describe(element)}")
        line(
            f"surface: {' '.join([element.surface.kind, _describe(element.surface)]).strip()}",
            "    ",
        )
        line(_derived(element), "    ")
        if element.detector is not None:
            what = _describe(element.detector) or "power"
            line(f"detector: {what}; counts the side {element.detector_side}", "    ")
    out.print()
    advisories = scene.advisories()
    out.print(Text(f"advisories: {len(advisories) or 'none'}", "bold"))
    for text in advisories:
        line(f"- {text}")
    out.print(f"{scene.digest()}", soft_wrap=True)


def _derived(item: Any) -> str:
    values: dict[str, tuple[float, str]] = item.derived()
    return ", ".join(
        f"{name} {_number(value)}" + (f" {unit}" if unit else "")
        for name, (value, unit) in values.items()
    )


def print_devices() -> int:
    """Print every device with what it can do and why it is refused; return the exit status."""
    from hostcode.device.capability import INSTALL_HINT, survey
    from hostcode.device.device import explain_choice, qualify
    from hostcode.errors import DeviceError

    out = console()
    found = survey()
    for record in found.records:
        reasons = qualify(record, self_test=True)
        number = f"{record.index} ({record.platform_index}:{record.device_index})"
        verdict = ("refused", "bold red") if reasons else ("usable", "bold green")
        out.print(Text.assemble((number, "bold"), f"  {record.type}  {record.name}  ", verdict))
        out.print(paragraph(f"{record.platform}, driver {record.driver}", "    "), soft_wrap=True)
        memory = record.global_memory / 2**30
        precision = "fp64" if record.fp64 else "no fp64"
        atomics = "int64 atomics" if record.int64_atomics else "no int64 atomics"
        facts = (
            f"{record.compute_units} compute units, {memory:.1f} GiB, {precision}, {atomics}, "
            f"{max(record.native_vector_width_double, 1)} doubles wide"
        )
        out.print(paragraph(facts, "    "), soft_wrap=True)
        for reason in reasons:
            out.print(paragraph(f"refused: {reason}", "    "), soft_wrap=True)
    for problem in found.problems:
        out.print(paragraph(f"not readable: {problem}", ""), soft_wrap=True)
    try:
        choice = explain_choice()
    except DeviceError as error:
        out.print(paragraph(str(error) if found.records else f"no device: {INSTALL_HINT}", ""))
        return 1
    out.print()
    out.print(paragraph(f"chosen: {choice.record.label}, {choice.reason}", ""), soft_wrap=True)
    return 0
