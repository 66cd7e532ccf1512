"""Quantities by name: what ``target_on``, comparisons and sweeps ask for.

``ledger.escaped``, ``ledger.depth_capped``, ``ledger.roulette.killed`` and ``.boosted``, other rows
that effects bring by their names, as ``ledger.absorbed_in.MEDIUM``, ``ledger.absorbed.NAME``,
``detectors.NAME.power`` and
``detectors.NAME.ladder[g]`` are scalars: one cell of the tally. Where lines of a spectrum are told
apart each has ``.by_wavelength[i]`` besides, and so has the map. ``detectors.NAME.map`` and
``far_field`` are many bins; as a target they stand for the median over those that are lit. Names
are quoted where they need it, as in TOML: ``ledger.absorbed."wall -x"``.
"""

from __future__ import annotations

import difflib
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from photizon_cl.compile.layout import Quantity
from photizon_cl.errors import ArgumentError, Problem, SceneError, show
from photizon_cl.scene.names import unknown_name
from photizon_cl.scene.parameter_paths import path_parts, quoted

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from photizon_cl.compile.layout import DetectorCells, LedgerRow, TallyLayout
    from photizon_cl.scene.model import Scene

__all__ = ["BY_LINE", "quantity_of", "scalars", "watched"]

_ROWS: Final = {
    "escaped": "escaped",
    "capped": "depth_capped",
    "killed": "roulette.killed",
    "boosted": "roulette.boosted",
}
"""Quantities of the rows that every ledger has; others go by their own names."""
BY_LINE: Final = "by_wavelength"
"""What each line or band of the spectrum brings to a quantity: ``….by_wavelength[i]``."""
_FORM: Final = (
    "a quantity such as detectors.NAME.power, detectors.NAME.ladder[2], detectors.NAME.map, "
    "far_field, ledger.escaped or ledger.absorbed.NAME"
)


def scalars(scene: Scene, layout: TallyLayout) -> Iterator[Quantity]:
    """Give every quantity that is one cell: the ledger, then the detectors."""
    names = {f"ledger.absorbed.{quoted(e.name)}": n for n, e in enumerate(scene.element)}
    names |= {f"ledger.{name}": cell for name, cell in _rows(layout).items()}
    for name, cell in names.items():
        yield Quantity(name, cell)
        for k in range(layout.parts if scene.spectrum else 0):
            yield Quantity(f"{name}.{BY_LINE}[{k}]", layout.part(cell, k))
    for d in layout.detectors:
        name = f"detectors.{quoted(scene.element[d.element].name)}"
        yield Quantity(f"{name}.power", d.power)
        for k in range(d.wavelengths):
            yield Quantity(f"{name}.power.{BY_LINE}[{k}]", d.by_wavelength("power", k))
        for g in range(d.n_generations):
            yield Quantity(f"{name}.ladder[{g}]", d.ladder + g)
            for k in range(d.wavelengths):
                cell = d.by_wavelength("ladder", k) + g
                yield Quantity(f"{name}.ladder[{g}].{BY_LINE}[{k}]", cell)


def quantity_of(name: str, scene: Scene, layout: TallyLayout) -> Quantity:
    """Return the quantity of a name.

    Parameters
    ----------
    name : str
        With or without quotes where they are not needed.
    scene, layout : Scene, TallyLayout
        Whose quantities.

    Raises
    ------
    ArgumentError
        Where the name is none.
    UnknownNameError
        Where the scene has nothing of that name.
    """
    if not isinstance(name, str):
        raise ArgumentError(f"quantity: found {show(name)}, expected {_FORM}")
    try:
        parts = path_parts(name)
    except ArgumentError:
        parts = []
    if parts[:2] == ["far_field", BY_LINE]:
        raise ArgumentError(
            f"{name}: found a line of the far field, expected all of it: it is told over all "
            "wavelengths together; for one alone, let the spectrum of every source have no power "
            "elsewhere"
        )
    if any(isinstance(part, int) for part in parts[:3]):  # objects have names here
        parts = []
    if parts[-1:] == [BY_LINE]:
        whole = None
        with suppress(ArgumentError):  # an element or a medium may be called so
            whole = quantity_of(name.rpartition(".")[0], scene, layout)
        if whole is not None:
            raise ArgumentError(
                f"quantity: found {show(name)}, expected one line or band of it: "
                f"{whole.name}.{BY_LINE}[i], with i from 0"
            )
    line = None
    if len(parts) > 2 and parts[-2] == BY_LINE and isinstance(parts[-1], int):
        line, parts = parts[-1], parts[:-2]
    if parts == ["far_field"] and line is None:
        if not layout.n_mu:
            raise ArgumentError(
                f"{name}: found no far field in the scene, expected a scene with one: "
                "[far_field] adds it"
            )
        return Quantity("far_field", layout.far_field, layout.n_mu * layout.n_phi)
    if parts[:2] == ["ledger", "absorbed"] and len(parts) == 3:
        n = _element(str(parts[2]), scene, list(scene.element.names), "ledger.absorbed")
        of = f"ledger.absorbed.{quoted(scene.element[n].name)}"
        return _part(name, Quantity(of, n), line, scene, layout)
    if parts[:1] == ["ledger"]:
        rows = _rows(layout)
        row = ".".join(quoted(str(part)) for part in parts[1:])
        if row not in rows:
            raise unknown_name("ledger", row, [*rows, "absorbed.NAME"])
        return _part(name, Quantity(f"ledger.{row}", rows[row]), line, scene, layout)
    if parts[:1] == ["detectors"] and len(parts) > 2:
        return _of_detector(name, parts, line, scene, layout)
    near = difflib.get_close_matches(name, [q.name for q in _some(scene, layout)], 1)
    hint = f" (did you mean {near[0]}?)" if near else ""
    raise ArgumentError(f"quantity: found {show(name)}, expected {_FORM}{hint}")


def watched(scene: Scene, layout: TallyLayout, names: Sequence[str] | None) -> tuple[Quantity, ...]:
    """Return the quantities that a run's settings name as its target.

    Raises
    ------
    SceneError
        Where one is none, with every one that is.
    """
    problems, found = [], []
    for name in names or ():
        try:
            found.append(quantity_of(name, scene, layout))
        except ArgumentError as error:
            found_there, _, expected = str(error).partition(", expected ")
            why = found_there.rpartition(": found ")[2]
            hint = "" if why == show(name) else f"found {why}"
            problems.append(Problem("run.target_on", show(name), expected, hint=hint))
    if problems:
        raise SceneError(problems)
    return tuple(found)


def _some(scene: Scene, layout: TallyLayout) -> Iterator[Quantity]:
    """Give the scalars of a scene that is not large, for a hint."""
    if layout.n_elements <= 1000:
        yield from scalars(scene, layout)


def _rows(layout: TallyLayout) -> dict[str, int]:
    """Return the cells of the ledger's rows, but those of single elements, by name."""
    return {_row_name(row): layout.n_elements + n for n, row in enumerate(layout.rows)}


def _row_name(row: LedgerRow) -> str:
    """Return a row's name behind ``ledger.``, its parts quoted where they need it."""
    group, dot, name = _ROWS.get(row.name, row.name).partition(".")
    return f"{group}{dot}{quoted(name) if name else name}"


def _element(name: str, scene: Scene, names: list[str], what: str) -> int:
    if name not in names:
        raise unknown_name(what, name, names)
    return list(scene.element.names).index(name)


def _part(
    name: str, row: Quantity, line: int | None, scene: Scene, layout: TallyLayout
) -> Quantity:
    """Return what a line brings to a row of the ledger; the row itself without one."""
    if line is None:
        return row
    if scene.spectrum is None:
        raise ArgumentError(f"{name}: found no [spectrum] in the scene, expected a scene with one")
    _check_line(name, line, layout.parts)
    return Quantity(f"{row.name}.{BY_LINE}[{line}]", layout.part(row.first, line))


def _check_line(name: str, line: int, lines: int) -> None:
    if line >= lines:
        raise ArgumentError(f"{name}: found the line {line}, expected one below {lines}")


def _of_detector(
    name: str, parts: list[str | int], line: int | None, scene: Scene, layout: TallyLayout
) -> Quantity:
    by_name = {scene.element[d.element].name: d for d in layout.detectors}
    if not by_name:
        raise ArgumentError(
            f"quantity: found {show(name)}, expected a row of the ledger: the scene has no detector"
        )
    n = _element(str(parts[1]), scene, list(by_name), "detectors")
    d = by_name[scene.element[n].name]
    stem = f"detectors.{quoted(scene.element[n].name)}"
    by = ""
    if line is not None:
        if not d.wavelengths:
            raise ArgumentError(
                f"{name}: found no lines told apart on that detector, expected one that tells "
                "them apart: detector = { wavelengths = true }"
            )
        _check_line(name, line, d.wavelengths)
        by = f".{BY_LINE}[{line}]"

    def first(tally: str, cell: int) -> int:
        return cell if line is None else d.by_wavelength(tally, line)

    if parts[2:] == ["power"]:
        return Quantity(f"{stem}.power{by}", first("power", d.power))
    if parts[2:] == ["map"]:
        if not d.nx:
            raise ArgumentError(
                f"{name}: found no map on that detector, expected one with a map: "
                "detector = { map = [nx, ny] }"
            )
        return Quantity(f"{stem}.map{by}", first("map", d.map), d.nx * d.ny)
    if len(parts) == 4 and parts[2] == "ladder" and isinstance(parts[3], int):
        _check_generation(name, parts[3], d)
        return Quantity(f"{stem}.ladder[{parts[3]}]{by}", first("ladder", d.ladder) + parts[3])
    raise ArgumentError(
        f"quantity: found {show(name)}, expected {stem}.power, .ladder[g] or .map, or one line or "
        f"band of one: .{BY_LINE}[i]"
    )


def _check_generation(name: str, generation: int, d: DetectorCells) -> None:
    if not d.n_generations:
        raise ArgumentError(
            f"{name}: found no ladder on that detector, expected one with a ladder: "
            "detector = { generations = N }"
        )
    if generation >= d.n_generations:
        raise ArgumentError(
            f"{name}: found generation {generation}, expected one below {d.n_generations}"
        )
