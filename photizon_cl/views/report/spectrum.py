"""What a report tabulates by wavelength."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.views.figures.spectrum_plot import curves
from photizon_cl.views.report.numbers import brief, integer, number
from photizon_cl.views.report.tables import MOST_ROWS, Table

if TYPE_CHECKING:
    from photizon_cl.result.estimates import Estimates

__all__ = ["spectrum_table"]


def spectrum_table(result: Estimates) -> Table | None:
    """Return the largest rows by wavelength; None where the scene has no spectrum."""
    spectrum = result.scene.spectrum
    if spectrum is None:
        return None
    shown = curves(result)
    emitted = result.ledger.emitted.by_wavelength
    rows = [
        (
            name,
            number(f"{emitted[k].value:.6g}"),
            *(brief(r.by_wavelength[k].value, r.by_wavelength[k].sigma, "") for _, r in shown),
        )
        for k, name in enumerate(spectrum.names[:MOST_ROWS])
    ]
    left = spectrum.n - len(rows)
    notes = [f"{integer(left)} {spectrum.word}s are left out."] if left else []
    return Table(
        "table-by-wavelength",
        f"Where the power of each {spectrum.word} ended, in W with ± σ: the largest rows "
        "(spectrum.csv has all)",
        (("wavelength", False), ("emitted", True), *((name, True) for name, _ in shown)),
        rows,
        " ".join(notes),
    )
