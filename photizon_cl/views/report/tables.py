"""What a report tabulates: ledger, detectors, ladders, far field.

A table here is data: headings, rows of cells, a caption. The templates turn it into HTML in one
place, which escapes every cell that is no markup.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup

from photizon_cl.compile.effects.table import EFFECT_ROWS
from photizon_cl.result.tallies import only_counts, ranked
from photizon_cl.result.text import lit_percent
from photizon_cl.views.figures.map_plots import length_unit
from photizon_cl.views.report.numbers import amount, brief, integer, number, pair, percent, share

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.maps import DetectorResult, IrradianceMap
    from photizon_cl.scene.filters.base import Axis

__all__ = [
    "MOST_ROWS",
    "Table",
    "checks_table",
    "detector_table",
    "ladder_table",
    "ledger_table",
    "map_table",
    "peak",
    "tally_tables",
]

MOST_ROWS: Final = 200
"""Rows of elements, detectors or generations that a table shows; more make no readable page."""


@dataclass(frozen=True)
class Table:
    """A table as data. The first cell of a row is its heading.

    Parameters
    ----------
    name : str
        Identifier on the page.
    caption : str
        What the table holds, with units where a heading does not say them.
    columns : sequence of (str, bool)
        Heading, and whether the column holds numbers.
    rows : sequence of sequences
        Cells: text, which is escaped, or markup, which is not.
    note : str
        What stands below the table.
    """

    name: str
    caption: str
    columns: Sequence[tuple[str, bool]]
    rows: Sequence[Sequence[str]]
    note: str = ""


_POWER: Final = (("power in W", True), ("± σ in W", True), ("share of emitted", True))
_SINGLE: Final = "σ is not known (–): it comes from the scatter between batches, and there is one."


def _sigma_note(result: Estimates) -> str:
    return _SINGLE if result.batches == 1 else ""


# -- ledger --------------------------------------------------------------------------------------


def ledger_table(result: Estimates, most: int = MOST_ROWS) -> Table:
    """Return the ledger with shares of the emitted power.

    Of more elements than `most` those that absorb the most are shown, in the order of the scene,
    and the others in one row.
    """
    ledger = result.ledger
    emitted = ledger.emitted.value
    rows: list[Sequence[str]] = []

    def add(name: str, row: Estimate) -> None:
        rows.append((name, *pair(row.value, row.sigma), share(row, emitted)))

    add("emitted", ledger.emitted)
    shown = _largest({name: row.value for name, row in ledger.absorbed.items()}, most)
    for name in shown:
        add(f"absorbed by {name}", ledger.absorbed[name])
    left = [row.value for name, row in ledger.absorbed.items() if name not in shown]
    if left:
        total = sum(left)
        head = f"absorbed by {integer(len(left))} other elements"
        rows.append((head, amount(total, 6), "–", percent(total / emitted, 4)))
    add("escaped", ledger.escaped)
    if "roulette" in result.compiled.effects:
        add("roulette: killed", ledger.roulette.killed)
        add("roulette: boosted", ledger.roulette.boosted)
        add("roulette: balance (killed − boosted)", ledger.roulette.balance)
    add("depth-capped", ledger.depth_capped)
    for title, row in ledger.others.items():
        add(title, row)
    closure = number(f"{ledger.closure:.1e}" if ledger.closure else "0")
    rows.append(("closure (emitted − all other rows)", closure, "", ""))
    notes = [_sigma_note(result)]
    if "roulette" in result.compiled.effects:
        notes.append("Of the roulette's rows the balance alone enters the closure.")
    if left:
        notes.append("The sum of many rows has no σ here: rows are correlated.")
    return Table(
        "table-ledger",
        "Energy ledger: where the emitted power ended, mean over batches",
        (("row", False), *_POWER),
        rows,
        " ".join(filter(None, notes)),
    )


def _largest(values: dict[str, float], most: int) -> dict[str, None]:
    """Return the names of the largest values in the order given."""
    if len(values) <= most:
        return dict.fromkeys(values)
    chosen = set(sorted(values, key=lambda name: -values[name])[:most])
    return dict.fromkeys(name for name in values if name in chosen)


# -- detectors -----------------------------------------------------------------------------------


def detector_table(result: Estimates, most: int = MOST_ROWS) -> Table:
    """Return the detectors' powers; of more than `most` those with the most power."""
    emitted = result.ledger.emitted.value
    found = result.detectors
    shown = _largest({name: d.power.value for name, d in found.items()}, most)
    rows = [
        (
            name,
            *pair(found[name].power.value, found[name].power.sigma),
            share(found[name].power, emitted),
            integer(found[name].power.count or 0),
        )
        for name in shown
    ]
    notes = [_sigma_note(result)]
    if len(shown) < len(found):
        notes.append(f"{integer(len(found) - len(shown))} detectors with less power are left out.")
    return Table(
        "table-detectors",
        "Detectors: power that arrived on the side that each faces",
        (("detector", False), *_POWER, ("arrivals", True)),
        rows,
        " ".join(filter(None, notes)),
    )


def ladder_table(name: str, element: str, detector: DetectorResult, emitted: float) -> Table | None:
    """Return a detector's power by the number of surface interactions; None without a ladder."""
    ladder = detector.ladder
    if ladder is None:
        return None
    lit = [rung for rung in ladder if rung.count]
    rows = [
        (
            f"{rung.generation}" + (" or more" if rung is ladder[-1] else ""),
            *pair(rung.value, rung.sigma),
            percent(rung.value / emitted, 4),
            integer(rung.count),
        )
        for rung in lit[:MOST_ROWS]
    ]
    notes = []
    if not lit:
        dark = "–" if ladder[0].sigma is None else "0"
        rows = [(f"0 to {len(ladder) - 1} or more", number("0"), number(dark), "0 %", "0")]
    elif len(lit) < len(ladder):
        empty = len(ladder) - len(lit)
        notes.append(f"{integer(empty)} of {len(ladder)} entries had no arrival and are left out.")
    if len(lit) > MOST_ROWS:
        notes.append(f"{integer(len(lit) - MOST_ROWS)} later entries are left out as well.")
    return Table(
        name,
        f"Ladder of {element}: power by the number of surface interactions before the arrival",
        (("interactions", False), *_POWER, ("arrivals", True)),
        rows,
        " ".join(notes),
    )


def map_table(name: str, element: str, m: IrradianceMap, power: Estimate) -> Table:
    """Return the key figures of an irradiance map."""
    ny, nx = m.count.shape
    area = float(m.area.sum())
    sigma = None if power.sigma is None else power.sigma / area
    rows: list[tuple[str, str]] = [
        (
            "bins",
            f"{integer(nx)} in {m.bins.x.axis.symbol} × {integer(ny)} in {m.bins.y.axis.symbol}",
        ),
        ("area of all bins", number(f"{area:.6g}") + " m²"),
        ("bins with 10 or more arrivals", lit_percent(m.lit_fraction)),
        ("irradiance, mean over the area", brief(power.value / area, sigma, "W/m²")),
    ]
    note = ""
    if m.lit.any():
        for head, sign in (("highest of these bins", 1.0), ("lowest of these bins", -1.0)):
            value, error, at = peak(m.irradiance, m.sigma, m.decisive, sign)
            rows.append((head, brief(value, error, "W/m²") + ", at " + _place(m, at)))
        relative = m.sigma[m.lit] / m.irradiance[m.lit]
        if np.isfinite(relative).any():
            rows.append(("median relative σ of these bins", percent(float(np.median(relative)))))
        left = int(np.count_nonzero(m.lit & ~m.decisive))
        if left:
            note = (
                f"Highest and lowest leave out {integer(left)} bin{'s' * (left != 1)} that a rim "
                "leaves less than three quarters of the area of others."
            )
    return Table(
        name,
        f"Irradiance map on {element}: key figures",
        (("quantity", False), ("value", False)),
        rows,
        note,
    )


def _place(m: IrradianceMap, at: tuple[int, int]) -> str:
    axes = (m.bins.x.axis, m.bins.y.axis)
    factor, unit = length_unit(m)
    places = [_middle(axis, k, factor, unit) for axis, k in zip(axes, at[::-1], strict=True)]
    return ", ".join(places).replace("-", "−")


def _middle(axis: Axis, k: int, factor: float, unit: str) -> str:
    """Return where the middle of a bin is."""
    value = 0.5 * (axis.edges[k] + axis.edges[k + 1])
    if axis.units == "rad":
        return f"{axis.symbol} = {np.degrees(value):.4g}°"
    if axis.units == "1":
        return f"{axis.symbol} = {value:.3g}"
    return f"{axis.symbol} = {factor * value:.4g} {unit}"


def peak(
    values: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    among: NDArray[np.bool_],
    sign: float = 1.0,
) -> tuple[float, float | None, tuple[int, int]]:
    """Return the highest value (lowest for sign −1) among some bins, its σ and its place."""
    flat = int(np.argmax(np.where(among, sign * values, -np.inf)))
    row, column = divmod(flat, values.shape[1])
    sigma = float(sigmas[row, column])
    return float(values[row, column]), None if np.isnan(sigma) else sigma, (row, column)


# -- checks of σ ---------------------------------------------------------------------------------


def checks_table(result: Estimates, most: int = MOST_ROWS) -> Table | None:
    """Return the statistical checks of every scalar that has some; None where none has.

    Of more than `most` those of which σ is not to be believed are shown first.
    """
    checks = result.checks
    if not checks:
        return None
    first = set(sorted(checks, key=lambda name: checks[name].believable)[:most])
    shown = [name for name in checks if name in first]
    rows = []
    for name in shown:
        found = checks[name]
        good, effective = found.good, found.effective_arrivals
        cells = (
            ("relative_sigma", percent(found.summary()["relative_sigma"])),
            ("variance_of_variance", amount(found.variance_of_variance, 2)),
            ("largest_share", percent(found.largest_share)),
            ("effective_arrivals", "–" if effective is None else amount(effective, 3)),
        )
        marked = [Markup("{}{}").format(text, "" if good[key] else " *") for key, text in cells]
        rows.append((name, *marked, "yes" if found.believable else "no"))
    notes = ["* not good: see “Can σ be believed?” in the page on error bars."]
    if len(shown) < len(checks):
        notes.append(f"{integer(len(checks) - len(shown))} quantities are left out.")
    return Table(
        "table-checks",
        "Statistical checks of every quantity that is one number and not 0",
        (
            ("quantity", False), ("relative σ", True), ("variance of the variance", True),
            ("largest arrival’s share", True), ("effective arrivals", True),
            ("σ is believable", False),
        ),
        rows,
        " ".join(notes),
    )  # fmt: skip


# -- what effects count --------------------------------------------------------------------------


def tally_tables(result: Estimates, most: int = MOST_ROWS) -> list[Table]:
    """Return a table for each effect that counts in labelled cells: its largest rows first."""
    found = []
    for n, (effect, cells) in enumerate(result.tallies.items()):
        counts = only_counts(cells)
        shown, left = ranked(cells, most)
        rows = [
            (label, *(() if counts else pair(cell.value, cell.sigma)), integer(cell.count or 0))
            for label, cell in shown.items()
        ]
        notes = ["" if counts else _sigma_note(result)]
        if left:
            rest = "row that is not larger is" if left == 1 else "rows that are not larger are"
            notes.append(f"{integer(left)} {rest} left out; result.nc has all.")
        power = () if counts else ((cells.unit, True), _POWER[1])
        columns = (("label", False), *power, ("count", True))
        caption = f"{effect}: {EFFECT_ROWS[effect].what}"
        found.append(
            Table(f"table-tally-{n}", caption, columns, rows, " ".join(filter(None, notes)))
        )
    return found
