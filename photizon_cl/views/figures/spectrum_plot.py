"""Figure by wavelength: what lines or bands of the spectrum bring to ledger and detectors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.errors import ArgumentError
from photizon_cl.views.figures.style import (
    BLUE,
    GRID,
    INK,
    LABEL,
    ORANGE,
    QUIET,
    SMALL,
    sheet,
    styled,
    whole,
)
from photizon_cl.views.figures.words import escaped, fitted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.ledger import Estimate

__all__ = ["curves", "draw_by_wavelength"]

_MOST: Final = 6
"""Rows that are drawn, the largest; more are not told apart."""
# Okabe and Ito's, dark enough on white, each with a mark of its own
_COLOURS: Final = (BLUE, ORANGE, "#009e73", "#cc79a7", "#56b4e9", INK)
_MARKS: Final = "osD^v*"
_LEAST: Final = 1e-6
"""Part of the emitted power below which a row is not drawn."""


@styled
def draw_by_wavelength(result: Estimates, *, ax: Axes | None = None) -> Figure:
    """Draw what of a line's or band's emitted power ends where, with standard errors.

    The six largest of the ledger's rows, each with a mark and a colour of its own; the detectors'
    powers where they are told by wavelength, in place of what their elements absorb.

    Parameters
    ----------
    result : Result
        The result of a scene that has a spectrum.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Part of the emitted power over the wavelength in nm; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no spectrum.
    """
    spectrum = result.scene.spectrum
    if spectrum is None:
        raise ArgumentError("found no spectrum in the scene, expected one: [spectrum] adds it")
    shown = curves(result)
    if ax is not None:
        _draw(ax, result, shown)
        return whole(ax)
    bars = "dots with ±σ" if result.batches > 1 else "dots"
    notes = [bars + (", and the width of each band" if spectrum.edges_nm else "")]
    left = sum(1 for _ in _lit(result)) - len(shown)
    if left:
        notes.append(f"{left} smaller row{'s' * (left != 1)} left out")
    page = sheet(result, f"by wavelength: {spectrum.about}", 3.4, [" · ".join(notes)])
    page.arrange()
    _draw(page.figure.add_subplot(), result, shown)
    return page.figure


def _lit(result: Estimates) -> list[tuple[str, Estimate]]:
    """Return the rows that have power, by what they are called."""
    told = {name: d.power for name, d in result.detectors.items() if d.power.by_wavelength}
    rows = [(f"detector {name}", power) for name, power in told.items()]
    rows += [
        (f"absorbed by {name}", row)
        for name, row in result.ledger.absorbed.items()
        if name not in told or row.value != told[name].value
    ]
    rows += result.ledger.rows()[len(result.ledger.absorbed) :]
    least = _LEAST * result.ledger.emitted.value
    return [(name, row) for name, row in rows if abs(row.value) > least]


def curves(result: Estimates) -> list[tuple[str, Estimate]]:
    """Return the rows that are drawn, the largest first."""
    return sorted(_lit(result), key=lambda item: -abs(item[1].value))[:_MOST]


def _draw(axes: Axes, result: Estimates, shown: list[tuple[str, Estimate]]) -> None:
    spectrum = result.scene.spectrum
    assert spectrum is not None
    nm = np.array(spectrum.middles_nm)
    half = None if spectrum.edges_nm is None else 0.5 * np.diff(spectrum.edges_nm)
    emitted = np.array([part.value for part in result.ledger.emitted.by_wavelength])
    lit = emitted > 0.0
    for k, (name, row) in enumerate(shown):
        parts = row.by_wavelength
        value = np.array([part.value for part in parts])[lit] / emitted[lit]
        sigma = np.array([part.sigma or 0.0 for part in parts])[lit] / emitted[lit]
        axes.errorbar(
            nm[lit], value, yerr=sigma if result.batches > 1 else None,
            xerr=None if half is None else half[lit], color=_COLOURS[k], marker=_MARKS[k],
            markersize=5.0, linewidth=0.9 if half is None else 0.0, elinewidth=1.0, capsize=2.0,
            label=escaped(fitted(name, SMALL, 2.0)), zorder=3 + k,
        )  # fmt: skip
    if not shown:
        axes.text(
            0.5, 0.5, "no power", transform=axes.transAxes, ha="center", fontsize=LABEL,
            color=QUIET,
        )  # fmt: skip
    low, high = spectrum.ends_nm
    room = 0.04 * (high - low) or 0.01 * high
    axes.set_xlim(low - room, high + room)
    bottom, top = axes.get_ylim()
    axes.set_ylim(min(bottom, 0.0), max(top, math.nextafter(0.0, 1.0)))
    axes.set_xlabel("wavelength in nm", fontsize=LABEL)
    axes.set_ylabel(f"part of the {spectrum.word}'s emitted power", fontsize=LABEL)
    axes.tick_params(labelsize=SMALL)
    axes.grid(axis="y", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if shown:
        axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=SMALL, frameon=False,
            borderaxespad=0.2,
        )  # fmt: skip
