"""The verb ``check``: what a scene describes, what follows from it, what may not be meant."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.cli.arguments import PRECISION, add_scene, load_scene, number

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from photizon_cl.checks.precision import Precision
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.result.outlay import Outlay
    from photizon_cl.scene.described import Described
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.surfaces import Surface

__all__ = ["add_arguments", "call"]

_MOST_NUMBERS: Final = 12
"""Of a longer list the first ones and the last one are shown."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    add_scene(parser)
    parser.add_argument("--precision", metavar="P", help=f"for a run in {PRECISION}")
    parser.add_argument(
        "--target", type=number, metavar="S",
        help="tell the time to this median relative σ instead of the scene's, in (0, 1]",
    )  # fmt: skip
    parser.add_argument(
        "--no-pilot",
        action="store_true",
        help="trace nothing, neither a pilot nor to time devices: at once, and without a device",
    )


def call(arguments: argparse.Namespace) -> int:
    """Check a scene; return the exit status."""
    from photizon_cl.checks.precision import DEFAULT, fitting_mode
    from photizon_cl.run.batches import with_settings

    scene = with_settings(load_scene(arguments), target_sigma=arguments.target)
    _print(scene, fitting_mode(arguments.precision or DEFAULT, scene), not arguments.no_pilot)
    return 0


def _print(scene: Scene, mode: Precision, tracing: bool) -> None:
    """Print what a valid scene describes, what follows from it, and the advisories."""
    from rich.text import Text

    from photizon_cl.checks.advisories import advisories
    from photizon_cl.cli.tables import console, heading, paragraph
    from photizon_cl.compile.compiled import compile_scene
    from photizon_cl.run.speed import faster_runtime
    from photizon_cl.scene.frames import direction_words

    compiled = compile_scene(scene, scene.run, precision=mode.name)
    out = console()
    out.print(heading(scene.name, f"  {scene.title}"))

    def line(text: str, indent: str = "  ") -> None:
        out.print(paragraph(text, indent), soft_wrap=True)

    line(f"run: {_describe(scene.run)}")
    if mode.single:
        line(f"precision: {mode.name}, {mode.what}")
    if scene.far_field is not None:
        far = scene.far_field
        line(f"far field: {_describe(far)}; {_derived(far)}")
        u, v, axis = map(direction_words, far.frame)
        if far.turned or far.by_theta:
            line(f"θ is from {axis}, φ from {u} towards {v}", "    ")
        if not far.whole:
            first, last = far.edges_deg[0], far.edges_deg[-1]
            text = f"what leaves outside θ = {first:.9g} … {last:.9g} deg escapes unbinned"
            line(text, "    ")
    if scene.importance is not None:
        line(f"importance: {_describe(scene.importance)}")
    if scene.spectrum is not None:
        line(f"spectrum: {scene.spectrum.about}")
    line(f"memory: {_memory(compiled)}")
    if scene.medium:
        out.print()
        out.print(Text("media, by name", "bold"))
    for medium in scene.medium:
        line(f"{medium.name}: {_describe(medium)}")
        if medium.derived():
            line(_derived(medium), "    ")
        if scene.spectrum is not None and medium.index is None:
            shown = (f"{medium.index_at(nm):.9g} at {nm:.9g} nm" for nm in _some(scene))
            line(f"index {', '.join(shown)}", "    ")
    out.print()
    out.print(Text("sources", "bold"))
    for source, rays in zip(scene.source, compiled.rays_of_source, strict=True):
        line(f"{source.name}: {source.kind}, {_describe(source)}; {rays} rays a batch")
        for name, inner in _tables_in(source):
            line(f"{name}: {_describe(inner)}", "    ")
        if hasattr(source, "derived") and source.derived():
            line(_derived(source), "    ")
    if scene.element:
        out.print()
        out.print(Text("elements", "bold"))
    for element in scene.element:
        line(f"{element.name}: {element.kind}, {_describe(element)}")
        for name, surface in _surfaces(element):
            line(f"{name}: {' '.join([surface.kind, _describe(surface)]).strip()}", "    ")
            if surface.lobe is not None:
                line(f"scatter: {surface.lobe.kind}, {_describe(surface.lobe)}", "        ")
                line(_derived(surface.lobe), "        ")
            for text in _coating(scene, surface):
                line(text, "        ")
        line(_derived(element), "    ")
        if element.detector is not None:
            what = _describe(element.detector) or "power"
            line(f"detector: {what}; counts the side {element.detector_side}", "    ")
            if element.detector.map is not None:
                u, v, w = map(direction_words, element.frame)
                line(f"map: u is {u}, v is {v}, the axis {w}", "    ")
    out.print()
    found = advisories(scene, mode.name)
    if tracing:
        texts, more = _pilot(scene, mode.name)
        for text in texts:
            line(text, "")
        found += more
        out.print()
    out.print(Text(f"advisories: {len(found) or 'none'}", "bold"))
    for text in found:
        line(f"- {text}")
    faster = faster_runtime(_tell) if tracing else ""
    if faster:
        out.print()
        line(f"device: {faster}")
    out.print(f"{scene.digest()}", soft_wrap=True)


def _coating(scene: Scene, surface: Surface) -> Iterator[str]:
    """Give what a surface's coating is, and what it does to light head on."""
    coating = getattr(surface, "coating", None)
    if coating is None:
        return
    more = f"; {_derived(coating)}" if coating.derived() else ""
    yield f"coating: {coating.kind}, {_describe(coating)}{more}"
    told = []
    for nm in _some(scene) if scene.spectrum is not None else [None]:
        bare = surface.among(scene.index_of(nm))
        assert bare.indices is not None  # as a border has
        r, t = coating.powers(0.0, *bare.indices, nm=nm)
        at = "" if nm is None else f" at {nm:.9g} nm"
        told.append(f"{float(r):.6g} and {float(t):.6g}{at}")
    yield f"reflectance and transmittance at normal incidence from outside {', '.join(told)}"


def _some(scene: Scene) -> list[float]:
    """Return a few wavelengths of a scene's spectrum: first, middle and last."""
    assert scene.spectrum is not None
    all_of_it = scene.spectrum.middles_nm
    return list(dict.fromkeys((all_of_it[0], all_of_it[scene.spectrum.reference], all_of_it[-1])))


def _tell(text: str) -> None:
    """Say what takes a while, beside what was asked for."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _pilot(scene: Scene, precision: str) -> tuple[list[str], list[str]]:
    """Return what a pilot found, a line each, and what of that is worth a second look."""
    from hostcode.errors import HostError
    from photizon_cl.errors import PhotizonError
    from photizon_cl.result.outlay import Untold
    from photizon_cl.run.media import clashing_media
    from photizon_cl.run.outlay import outlay
    from photizon_cl.run.pilot import counted_by_pilot, pilot

    try:
        found = pilot(scene, precision=precision)
        clashes = [*counted_by_pilot(scene, precision=precision), *clashing_media(scene)]
    except (PhotizonError, HostError, MemoryError) as error:  # the check stands without it
        return [f"pilot: none was traced: {str(error) or 'no memory is left for it'}"], []
    time: Outlay | Untold = Untold("the pilot's rays take too long")
    try:
        time = outlay(scene, precision=precision) if found.complete else time
    except (PhotizonError, HostError, MemoryError) as error:  # fewer rays than a run has may not do
        time = Untold(str(error) or "no memory is left for it")
    told = [f"pilot: {found}", f"time: {time}"]
    before = found.before(scene.run.rays_per_batch)
    return told, [*clashes, *filter(None, [before]), *time.advice()]


def _memory(compiled: CompiledScene) -> str:
    """Say what a run takes on the device that it would have."""
    from photizon_cl.run.memory import on_usual_device

    return on_usual_device(compiled)


def _surfaces(element: Element) -> Iterator[tuple[str, Surface]]:
    """Give an element's surface, and those that faces have of their own, by their keys."""
    from photizon_cl.scene.described import parameters_of
    from photizon_cl.scene.surfaces import Surface

    for name in parameters_of(type(element)):
        value = getattr(element, name)
        if isinstance(value, Surface):
            yield name, value


def _number(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, tuple):
        shown = [_number(item) for item in value]
        if len(shown) > _MOST_NUMBERS:
            shown[2:-1] = ["…"]
            return f"({', '.join(shown)}: {len(value)} numbers)"
        return f"({', '.join(shown)})"
    return str(value)


def _describe(item: Described) -> str:
    """Return the parameters of an object on one line, with units where they have one.

    What is 0 by default, and is 0, is left out: there is no such thing.
    """
    from photizon_cl.scene.described import Described, default_of, parameters_of

    parts = []
    for name, parameter in parameters_of(type(item)).items():
        value = getattr(item, name)
        if name == "name" or value is None:
            continue
        if isinstance(value, Described):
            if value.one_value:
                parts.append(f"{name} {value}" + (f" {parameter.unit}" if parameter.unit else ""))
            continue
        if parameter.silent and value == default_of(type(item), name):
            continue
        zero = value == (0.0, 0.0) or (value == 0.0 and item.kind)
        if zero and default_of(type(item), name) == value:
            continue
        unit = parameter.unit
        value = str(value).lower() if isinstance(value, bool) else value
        parts.append(f"{name} {_number(value)}" + (f" {unit}" if unit else ""))
    return ", ".join(parts)


def _tables_in(item: Described) -> Iterator[tuple[str, Described]]:
    """Give the objects within an object, by their keys."""
    from photizon_cl.scene.described import Described, parameters_of

    for name in parameters_of(type(item)):
        value = getattr(item, name)
        if isinstance(value, Described):
            yield name, value


def _derived(item: Any) -> str:
    values: dict[str, tuple[float, str]] = item.derived()
    return ", ".join(
        f"{name} {_number(value)}" + (f" {unit}" if unit else "")
        for name, (value, unit) in values.items()
    )
