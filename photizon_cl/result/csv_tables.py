"""The tables of a result as CSV, for spreadsheets and for people without Python."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.maps import Rung
    from photizon_cl.result.tallies import EffectTally

__all__ = ["detectors_csv", "ledger_csv", "tally_csv"]


def ledger_csv(result: Estimates) -> str:
    """Return the ledger: row, watts, σ in watts (empty with a single batch), share of emitted."""
    ledger = result.ledger
    emitted = ledger.emitted.value
    rows = ((name, *_numbers(row), row.value / emitted) for name, row in ledger.labelled_rows())
    return _text(("row", "value_W", "sigma_W", "share"), rows)


def detectors_csv(result: Estimates) -> str:
    """Return the detectors' totals (no generation) and ladders: watts, σ in watts, arrivals."""

    def rows() -> Iterable[tuple[object, ...]]:
        for name, detector in result.detectors.items():
            yield (name, "", *_numbers(detector.power), detector.power.count)
            for rung in detector.ladder or ():
                yield (name, rung.generation, *_numbers(rung), rung.count)

    return _text(("detector", "generation", "value_W", "sigma_W", "count"), rows())


def tally_csv(cells: EffectTally) -> str:
    """Return what an effect counts: label, value, σ (empty with a single batch), count."""
    rows = ((label, *_numbers(cell), cell.count) for label, cell in cells.items())
    return _text(("label", f"value_{cells.unit}", f"sigma_{cells.unit}", "count"), rows)


def _numbers(row: Estimate | Rung) -> tuple[object, object]:
    return row.value, "" if row.sigma is None else row.sigma


def _text(head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)  # floats as their shortest text that reads back to the bit
    return out.getvalue()
