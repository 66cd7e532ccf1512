"""Figure of the energy ledger: where the power went, over twelve decades, with errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.result.text import with_error
from photizon_cl.views.figures.scales import log_ticks
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
from photizon_cl.views.figures.words import escaped, fitted, parts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates

__all__ = ["draw_ledger"]

MOST_ROWS: Final = 24
"""Elements that get a row of their own."""
LEAST: Final = 1e-12
"""Part of the emitted power below which a row is said and not drawn."""
_ROW: Final = 0.27


@dataclass(frozen=True)
class Row:
    """A row as it is drawn; power and its standard error in watts."""

    name: str
    value: float
    sigma: float | None
    text: str


@styled
def draw_ledger(result: Estimates, *, ax: Axes | None = None) -> Figure:
    """Draw the ledger's rows as dots on a logarithmic axis, with their standard errors.

    The 24 elements that absorb most have rows of their own where a scene has more; the others stand
    together in one. A negative balance of the roulette is an open square at its magnitude. Zeros
    are said, as are powers below 1e-12 of what was emitted, which get no dot.

    Parameters
    ----------
    result : Result
        The result.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Power in W below, and as a part of the emitted power above; that of `ax` where one is given.
    """
    ledger = result.ledger
    emitted = ledger.emitted.value
    shown = rows(result)
    if ax is not None:
        _dots(ax, shown, emitted)
        return whole(ax)
    closure = f"closure {ledger.closure:.1e} W" if ledger.closure else "closure 0 W"
    notes = ["dots with ±σ; dashed: emitted power"] if result.batches > 1 else []
    if any(row.value < 0.0 for row in shown):
        notes.append("open square: negative, drawn by its magnitude")
    if any(0.0 < abs(row.value) < LEAST * emitted for row in shown):
        notes.append("◂ below 1e-12 of the emitted power")
    page = sheet(
        result, f"energy ledger of {emitted:.6g} W emitted; {closure}",
        0.95 + _ROW * len(shown), [" · ".join(notes)] if notes else None,
    )  # fmt: skip
    page.arrange()
    _dots(page.figure.add_subplot(), shown, emitted)
    return page.figure


def rows(result: Estimates) -> list[Row]:
    """Return the rows to draw, at most 24 of elements and one for the rest."""
    absorbed = list(result.ledger.absorbed.items())
    others = result.ledger.rows()[len(absorbed) :]
    rest = []
    if len(absorbed) > MOST_ROWS:
        absorbed.sort(key=lambda item: -item[1].value)  # stable: equal ones stay in scene order
        absorbed, rest = absorbed[:MOST_ROWS], absorbed[MOST_ROWS:]
    out = [Row(name, row.value, row.sigma, _text(row.value, row.sigma)) for name, row in absorbed]
    if rest:
        together = math.fsum(row.value for _, row in rest)
        # Rows are correlated, so that the error of their sum does not follow from theirs.
        text = f"together {together:.3g}" if together else "together 0"
        out.append(Row(f"{len(rest):,} more elements", together, None, text))
    return out + [Row(name, row.value, row.sigma, _text(row.value, row.sigma))
                  for name, row in others]  # fmt: skip


def _text(value: float, sigma: float | None) -> str:
    if value == 0.0 and not sigma:
        return "0"
    text, error = with_error(value, sigma)
    return (text if sigma is None else f"{text} ± {error}").replace("-", "−")


def _dots(axes: Axes, shown: list[Row], emitted: float) -> None:
    """Draw rows as dots, with their numbers behind them."""
    places = np.arange(len(shown))
    values = np.array([row.value for row in shown])
    size = np.abs(values)
    sigma = np.array([np.nan if row.sigma is None else row.sigma for row in shown])
    seen = size >= LEAST * emitted
    # At least two decades, so that noise between like rows does not look like structure.
    least = min(float(size[seen].min(initial=emitted)), 0.02 * emitted)
    floor = 10.0 ** math.floor(math.log10(least * 0.7))
    high = emitted * (emitted / floor) ** 0.03
    axes.set_xscale("log")
    axes.set_xlim(floor, high)
    known = seen & np.isfinite(sigma)
    if known.any():
        # Where an error reaches below the axis it is cut there.
        axes.errorbar(
            size[known], places[known], xerr=sigma[known], fmt="none", ecolor=INK,
            elinewidth=1.2, capsize=3.0, zorder=3,
        )  # fmt: skip
    for sign, colour, marker, name in ((1.0, BLUE, "o", "power"), (-1.0, ORANGE, "s", "negative")):
        at = seen & (np.sign(values) == sign)
        if at.any():
            axes.plot(
                size[at], places[at], linestyle="none", marker=marker, markersize=6.5, zorder=4,
                color=colour, markerfacecolor=colour if sign > 0.0 else "white",
                markeredgewidth=1.4, label=name,
            )  # fmt: skip
    for place, value, drawn in zip(places, values, seen, strict=True):
        if not drawn:
            axes.annotate(
                "0" if value == 0.0 else "◂", (floor, place), (3.0, 0.0),
                textcoords="offset points", fontsize=SMALL, color=QUIET, va="center",
            )  # fmt: skip
    axes.axvline(emitted, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
    names = [escaped(fitted(row.name, LABEL, 1.7)) for row in shown]
    axes.set_yticks(places, names, fontsize=LABEL)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlabel("power in W", fontsize=LABEL)
    right: Any = axes.secondary_yaxis("right")
    right.set_yticks(places, [row.text for row in shown], fontsize=SMALL)
    right.tick_params(length=0)
    right.spines["right"].set_visible(False)
    above: Any = axes.secondary_xaxis("top", functions=parts_of(emitted))
    above.set_xlabel("part of the emitted power", fontsize=LABEL, color=QUIET)
    above.tick_params(labelsize=SMALL, colors=QUIET)
    log_ticks(axes.xaxis, floor, high)
    log_ticks(above.xaxis, floor / emitted, high / emitted, 1.0)
    axes.tick_params(axis="x", labelsize=SMALL)
    axes.tick_params(axis="y", length=0)
    for side in ("right", "left"):
        axes.spines[side].set_visible(False)
    # A line from each name to its dot and number: there is no foot to start from.
    axes.grid(axis="x", color=GRID, linewidth=0.6, zorder=0)
    axes.grid(axis="y", color=GRID, linewidth=0.8, linestyle=(0, (1, 2)), zorder=0)
    axes.set_axisbelow(True)
