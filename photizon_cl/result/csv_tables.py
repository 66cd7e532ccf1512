"""The tables of a result as CSV, for spreadsheets and for people without Python.

Spreadsheets compute a cell that begins like a formula, and names are anybody's text: such a name is
written with an apostrophe before it. Numbers are never touched.
"""

from __future__ import annotations

import csv
import io
import re
from typing import TYPE_CHECKING, Final

from photizon_cl.result.path_table import OTHER_PATHS

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.maps import Rung
    from photizon_cl.result.tallies import EffectTally

__all__ = ["csv_text", "detectors_csv", "ledger_csv", "paths_csv", "spectrum_csv", "tally_csv"]

# With apostrophes and blanks before it: what is written can be told from what was so before. The
# last four are the wide forms, which some spreadsheets take for the others.
_FORMULA: Final = re.compile(r"['\s]*[=+\-@\uff1d\uff0b\uff0d\uff20]|[\t\r\n]")


def ledger_csv(result: Estimates) -> str:
    """Return the ledger: row, watts, σ in watts (empty with a single batch), share of emitted."""
    ledger = result.ledger
    emitted = ledger.emitted.value
    rows = ((name, *_numbers(row), row.value / emitted) for name, row in ledger.labelled_rows())
    return csv_text(("row", "value_W", "sigma_W", "share"), rows)


def detectors_csv(result: Estimates) -> str:
    """Return the detectors' totals (no generation) and ladders: watts, σ in watts, arrivals."""

    def rows() -> Iterable[tuple[object, ...]]:
        for name, detector in result.detectors.items():
            yield (name, "", *_numbers(detector.power), detector.power.count)
            for rung in detector.ladder or ():
                yield (name, rung.generation, *_numbers(rung), rung.count)

    return csv_text(("detector", "generation", "value_W", "sigma_W", "count"), rows())


def spectrum_csv(result: Estimates) -> str:
    """Return what each line brings to the ledger's rows and the detectors' powers and ladders."""

    def rows() -> Iterable[tuple[object, ...]]:
        named: list[tuple[str, str, object, Estimate]] = [
            ("ledger", name, "", row) for name, row in result.ledger.labelled_rows()
        ]
        for name, detector in result.detectors.items():
            named.append(("detector", name, "", detector.power))
            named += [("detector", name, r.generation, r) for r in detector.ladder or ()]
        for what, name, generation, whole in named:
            pairs = zip(result.scene.wavelengths, whole.by_wavelength, strict=False)
            for nm, part in pairs:
                count = "" if part.count is None else part.count
                yield (what, name, generation, nm, *_numbers(part), count)

    head = ("what", "name", "generation", "wavelength_nm", "value_W", "sigma_W", "count")
    return csv_text(head, rows())


def paths_csv(result: Estimates) -> str:
    """Return the path tables: the strongest paths of each detector, then what the rest brings."""

    def rows() -> Iterable[tuple[object, ...]]:
        for name, detector in result.detectors.items():
            table = detector.paths
            if table is not None:
                for n, row in enumerate(table, start=1):
                    sigma = "" if row.sigma is None else row.sigma
                    order = "" if row.ghost_order is None else row.ghost_order
                    ends = (row.count, row.interactions, order, row.example_ray)
                    yield (name, n, row.sequence, row.power, sigma, *ends)
                rest = table.rest
                sigma = "" if rest.sigma is None else rest.sigma
                yield (name, "", OTHER_PATHS, rest.power, sigma, rest.count, "", "", "")

    head = ("detector", "rank", "sequence", "value_W", "sigma_W", "count", "interactions")
    return csv_text((*head, "ghost_order", "example_ray"), rows())


def tally_csv(cells: EffectTally) -> str:
    """Return what an effect counts: label, value, σ (empty with a single batch), count."""
    rows = ((label, *_numbers(cell), cell.count) for label, cell in cells.items())
    return csv_text(("label", f"value_{cells.unit}", f"sigma_{cells.unit}", "count"), rows)


def _numbers(row: Estimate | Rung) -> tuple[object, object]:
    return row.value, "" if row.sigma is None else row.sigma


def csv_text(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table: names in its head are anybody's text too."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(map(_plain, head))
    # floats as their shortest text that reads back to the bit
    writer.writerows([_plain(cell) for cell in row] for row in rows)
    return out.getvalue()


def _plain(cell: object) -> object:
    """Return a cell that no spreadsheet takes for a formula."""
    return f"'{cell}" if isinstance(cell, str) and _FORMULA.match(cell) else cell
