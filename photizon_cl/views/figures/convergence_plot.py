"""Figure of a run's convergence: σ against rays and against seconds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from photizon_cl.errors import ArgumentError
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
)
from photizon_cl.views.figures.words import percent, scaled

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates

__all__ = ["draw_convergence", "history"]


def history(result: Estimates) -> NDArray[Any]:
    """Return a result's waves: a structured array, empty where none are kept."""
    return result.history


@styled
def draw_convergence(result: Estimates) -> Figure:
    """Draw σ against rays and against seconds.

    Each point is what the run had after a wave of batches, as it was. The dashed line through the
    last one falls with the square root of rays (or seconds), as the error of independent rays does.
    The target of a run that had one is a horizontal line.

    Parameters
    ----------
    result : Result
        The result.

    Returns
    -------
    matplotlib.figure.Figure
        Median relative standard error in percent, both axes logarithmic.

    Raises
    ------
    ArgumentError
        Where the result holds no history.
    """
    waves = history(result)
    if not len(waves):
        raise ArgumentError(
            "the result holds no history of σ (it was saved by an earlier version): trace again"
        )
    known = np.isfinite(waves["sigma"]) & (waves["sigma"] > 0.0)
    what = f"convergence: {result.sigma_is} as the run went on"
    notes = [f"{len(waves):,} point{'s' * (len(waves) != 1)} over {waves['seconds'][-1]:.4g} s"]
    if len(waves) > known.sum():
        notes[0] += f", {len(waves) - int(known.sum())} of them without a σ to draw"
    page = sheet(result, what, 3.3, notes)
    page.arrange(above=0.26)
    both: Any = page.figure.subplots(1, 2, sharey=True)
    panels = (("rays", "rays"), ("seconds", "time in s"))
    for axes, (field, label) in zip(both, panels, strict=True):
        good = known & (waves[field] > 0)
        _draw(axes, waves[field][good].astype(np.float64), waves["sigma"][good])
        target = result.info.goal.target
        if target is not None and good.any():
            axes.axhline(
                target, color=ORANGE, linewidth=1.2, zorder=1.8, label=f"target {percent(target)}"
            )
        axes.set_xlabel(label, fontsize=LABEL)
        if not good.any():
            continue
        _finish(axes)
        if field == "seconds" and axes.get_xlim()[0] > 1e-4 and axes.get_xlim()[1] < 1e5:
            axes.xaxis.set_major_formatter(scaled(1.0))
    if not known.any():
        both[0].set_yscale("linear")
        both[0].set_yticks([])
    both[0].set_ylabel(f"{result.sigma_is} in %", fontsize=LABEL)
    handles, labels = both[0].get_legend_handles_labels()
    if handles:
        # Above both panels, where it hides no point.
        legend = page.figure.legend(
            handles, labels, loc="upper left", fontsize=SMALL, frameon=False, ncols=3,
            bbox_to_anchor=page.place(0.06, page.body, 0.0, 0.0)[:2], borderaxespad=0.0,
        )  # fmt: skip
        legend.set_in_layout(False)
    return page.figure


def _draw(axes: Any, x: NDArray[np.float64], sigma: NDArray[np.float64]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    if not len(x):
        axes.set_xscale("linear")
        axes.set_xticks([])  # they would be made up
        axes.text(
            0.5, 0.5, "no wave has a σ above zero", transform=axes.transAxes, ha="center",
            fontsize=LABEL, color=QUIET,
        )  # fmt: skip
        return
    low, high = float(x.min()), float(x.max())
    if low == high:
        low, high = low / 3.0, high * 3.0
    ends = np.array([low, high])
    axes.plot(
        ends, sigma[-1] * np.sqrt(x[-1] / ends), color=INK, linewidth=1.0, linestyle=(0, (5, 3)),
        zorder=2.0, label="slope −1/2 through the last point",
    )  # fmt: skip
    many = len(x) > 60
    axes.plot(
        x, sigma, color=BLUE, linewidth=1.0, marker="." if many else "o",
        markersize=2.5 if many else 4.0, zorder=2.5, label="this run",
    )  # fmt: skip
    axes.margins(x=0.06, y=0.12)


def _finish(axes: Any) -> None:
    """Give both axes enough of a decade for ticks that can be read, and set those."""
    for axis, least in ((axes.xaxis, 15.0), (axes.yaxis, 6.0)):
        low, high = axis.get_view_interval()
        more = max(1.0, math.sqrt(least * low / high))
        low, high = low / more, high * more
        set_limits = axes.set_xlim if axis is axes.xaxis else axes.set_ylim
        set_limits(low, high)
        log_ticks(axis, low, high)
    axes.yaxis.set_major_formatter(scaled(100.0))
    axes.tick_params(labelsize=SMALL)
    axes.grid(color=GRID, linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
