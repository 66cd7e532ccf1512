"""What a run gives: files, then ledger, detectors and advisories, or the summary as JSON."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Final

from rich.text import Text

from photizon_cl.checks.precision import DEFAULT
from photizon_cl.cli.tables import console, heading, paragraph, print_table, table
from photizon_cl.errors import ResultError, printable, printable_lines
from photizon_cl.result.tallies import only_counts, ranked
from photizon_cl.result.text import batches, lit_percent, with_error

if TYPE_CHECKING:
    from collections.abc import Collection

    from rich.console import Console

    from photizon_cl.result.ledger import Estimate
    from photizon_cl.run.result import Result

__all__ = ["give", "print_result"]

_MOST_ROWS: Final = 50
"""A longer curve of the far field is not printed; the files have it."""
_MOST_BESIDE: Final = 3
"""Detectors whose powers by wavelength stand beside each other."""
_MOST_TALLIED: Final = 10
"""Rows of what an effect counts that are printed; the files have all."""
_STOPPED: Final = {
    "interrupt": "by Ctrl-C or another signal",
    "time": "by max_seconds",
    "memory": "as there was no more memory for it",
}
"""What ends a run before its goal."""


def give(
    result: Result,
    folder: str | None,
    *,
    figures: bool = True,
    as_json: bool,
    said: Collection[str] = (),
) -> int:
    """Write and print a result, without what was said already; return the exit status."""
    # Files first: a reader that closes the pipe must not cost the result.
    failed: ResultError | None = None
    if folder is not None:
        try:
            # what goes was said before the run
            result.save(folder, figures=figures, replace=True)
        except ResultError as error:
            failed = error  # the numbers are still worth printing
    if as_json:
        print(json.dumps(result.summary(), indent=2, ensure_ascii=True, allow_nan=False))
        return _told(failed)
    out = console()
    print_result(result, out, said)
    if folder is not None and failed is None:
        out.print(f"\nwritten to {printable(folder)}", soft_wrap=True)
    return _told(failed)


def _told(failed: ResultError | None) -> int:
    """Say that the files could not be written; return the exit status."""
    if failed is None:
        return 0
    print(printable_lines(str(failed)), file=sys.stderr)
    return 1


def print_result(result: Result, out: Console, said: Collection[str] = ()) -> None:
    """Print ledger, detectors and advisories, these without what was said before."""
    out.print(heading(result.scene.heading))
    run = result.scene.run
    out.print(
        paragraph(
            f"{batches(result.batches)} of {run.rays_per_batch} rays, seed {run.seed}, "
            f"{result.info.interactions / 1e6:.4g} M interactions in {result.info.seconds:.2f} s "
            f"{_mode(result)}on {result.info.device}",
            "",
        ),
        soft_wrap=True,
    )
    out.print()
    _print_ledger(result, out)
    _print_detectors(result, out)
    _print_by_wavelength(result, out)
    _print_far_field(result, out)
    _print_tallies(result, out)
    achieved = result.achieved_sigma
    sigma = "unknown" if achieved is None else f"{achieved:.3g}"
    verdict = "met" if result.converged else "not met"
    out.print()
    on = result.scene.run.target_on
    what = f"{result.sigma_is} of {', '.join(on)}" if on else result.sigma_is
    text = f"{what} {sigma}, target {result.target_sigma:.3g} {verdict}"
    if result.least_lit is not None and not on:
        name, lit, maps = result.least_lit
        text += f"; {lit_percent(lit)} of the bins lit"
        text += f" on {name}, the least of {maps} maps" if maps > 1 else ""
    out.print(paragraph(text, ""), soft_wrap=True)
    far = None if result.far_field is None else result.far_field.median_sigma
    if far is not None:
        text = f"median relative σ {far:.3g} over the lit bins of the far field"
        out.print(paragraph(text, ""), soft_wrap=True)
    if result.info.stopped in _STOPPED:
        text = f"stopped {_STOPPED[result.info.stopped]} after {batches(result.batches)}"
        out.print(paragraph(text, ""), soft_wrap=True)
    out.print(result.tally_digest, soft_wrap=True)
    for text in result.advisories:
        if text not in said:
            out.print(paragraph(f"advisory: {text}", ""), soft_wrap=True)


def _print_ledger(result: Result, out: Console) -> None:
    ledger = result.ledger
    emitted = ledger.emitted.value
    rows = table(("ledger", "left"), ("W", "right"), ("± σ", "right"), ("of emitted", "right"))

    def add(name: str, row: Estimate, style: str = "") -> None:
        part = 100.0 * row.value / emitted
        shown = f"{part:.1e} %" if 0.0 < abs(part) < 5e-5 else f"{part:.4f} %"
        rows.add_row(Text(name, style), *with_error(row.value, row.sigma), shown)

    add("emitted", ledger.emitted, "bold")
    for name, row in ledger.absorbed.items():
        add(f"absorbed by {name}", row)
    add("escaped", ledger.escaped)
    roulette = ledger.roulette
    if roulette.killed.value or roulette.boosted.value:
        add("roulette killed", roulette.killed)
        add("roulette boosted", roulette.boosted)
        add("roulette balance", roulette.balance)
    add("depth-capped", ledger.depth_capped)
    for title, row in ledger.others.items():
        add(title, row)
    rows.add_row("closure", f"{ledger.closure:.1e}" if ledger.closure else "0", "", "")
    print_table(rows, out)


def _print_detectors(result: Result, out: Console) -> None:
    if not result.detectors:
        return
    out.print()
    rows = table(("detector", "left"), ("W", "right"), ("± σ", "right"), ("arrivals", "right"))
    for name, detector in result.detectors.items():
        power = detector.power
        rows.add_row(Text(name), *with_error(power.value, power.sigma), str(power.count))
        for rung in detector.ladder or ():
            if rung.count:
                last = " or more" if rung.generation == len(detector.ladder or ()) - 1 else ""
                label = Text(f"  generation {rung.generation}{last}")
                rows.add_row(label, *with_error(rung.value, rung.sigma), str(rung.count))
        if detector.map is not None:
            lit = detector.map.lit
            values = detector.map.irradiance[lit]
            ny, nx = lit.shape
            text = f"  map {nx} × {ny}"
            if values.size:
                text += f", lit {values.min():.4g} … {values.max():.4g} W/m²"
            rows.add_row(Text(text), "", "", "")
    print_table(rows, out)


def _print_by_wavelength(result: Result, out: Console) -> None:
    """Print the powers of detectors that tell lines apart, where there are not too many."""
    spectrum = result.scene.spectrum
    told = {name: d.power for name, d in result.detectors.items() if d.power.by_wavelength}
    if spectrum is None or not told or spectrum.n > _MOST_ROWS:
        return
    for first in range(0, len(told), _MOST_BESIDE):
        names = list(told)[first : first + _MOST_BESIDE]
        out.print()
        heads = [head for name in names for head in ((f"W at {name}", "right"), ("± σ", "right"))]
        rows = table(("wavelength", "left"), ("W emitted", "right"), *heads)
        for k, line in enumerate(spectrum.names):
            parts = [told[name].by_wavelength[k] for name in names]
            cells = [text for part in parts for text in with_error(part.value, part.sigma)]
            emitted = f"{result.ledger.emitted.by_wavelength[k].value:.6g}"
            rows.add_row(Text(line), emitted, *cells)
        print_table(rows, out)


def _print_far_field(result: Result, out: Console) -> None:
    """Print intensity over θ where that is one curve, not too long."""
    bins = result.scene.far_field
    if bins is None or not bins.by_theta or bins.n_phi > 1 or bins.rows > _MOST_ROWS:
        return
    far = result.far_field
    assert far is not None
    out.print()
    rows = table(("far field", "left"), ("W/sr", "right"), ("± σ", "right"), ("rays", "right"))
    for row in far.curve():
        low, high = row["theta_deg"]
        label = Text(f"θ {low:g}° – {high:g}°")
        rows.add_row(label, *with_error(row["value"], row["sigma"]), str(row["count"]))
    print_table(rows, out)


def _print_tallies(result: Result, out: Console) -> None:
    """Print the largest rows of what each effect counts."""
    for effect, cells in result.tallies.items():
        out.print()
        powers = [] if only_counts(cells) else [(cells.unit, "right"), ("± σ", "right")]
        rows = table((effect, "left"), *powers, ("count", "right"))
        shown, left = ranked(cells, _MOST_TALLIED)
        for label, cell in shown.items():
            power = with_error(cell.value, cell.sigma) if powers else ()
            rows.add_row(Text(label), *power, str(cell.count))
        if left:
            rows.add_row(Text(f"… {left} more"))
        print_table(rows, out)


def _mode(result: Result) -> str:
    """Return in which precision a result was traced, where that is not the usual one."""
    mode = result.info.precision
    return "" if mode == DEFAULT else f"in {mode} "
