"""Figure of a sweep: what was measured over what was varied, with error bars."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.sweep_values import value_text
from photizon_cl.views.figures.scales import log_ticks
from photizon_cl.views.figures.style import (
    BLUE,
    GRID,
    LABEL,
    ORANGE,
    QUIET,
    SMALL,
    WIDTH,
    blank,
    styled,
)
from photizon_cl.views.figures.words import fitted, wrapped

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.sweep import SweepTable
    from photizon_cl.scene.sweeps import Axis

__all__ = ["draw_sweep"]

_COLOURS: Final = (BLUE, ORANGE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#222222")
_MARKS: Final = ("o", "s", "^", "D", "v", "P", "X", "*")
_PANEL: Final = 2.6
"""Inches of a panel."""
_MOST_PANELS: Final = 6
_WIDE: Final = 30.0
"""Values that are so many times as large as others are drawn on a logarithmic axis."""


@styled
def draw_sweep(sweep: SweepTable, measures: Sequence[str] | None = None) -> Figure:
    """Draw what a sweep measured over the axis of most values, with error bars of ± 1 σ.

    That is one of numbers, where there is any. A curve for each set of values of the other axes, up
    to eight, evenly chosen where there are more. An axis in equal factors is logarithmic, and so is
    a measure whose values are all above 0 and span a factor of more than 30.

    Parameters
    ----------
    sweep : Sweep
        The sweep; points that have not been run are left out.
    measures : sequence of str, optional
        Names of what is drawn, a panel each; by default the sweep's measures or, where it names
        none, the powers of its detectors, up to six that are not 0 everywhere.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ArgumentError
        Where there is no such measure, or nothing to draw.
    """
    names = _chosen(sweep, measures)
    along = _along(sweep)
    curves, left_out = _curves(sweep, along)
    group = sweep.plan.groups[along]
    axis = next((one for one in group if one.numeric), group[0])
    notes = _notes(sweep, left_out, [n for n in sweep.names if n not in names])
    text = [(line, QUIET, "normal") for note in notes
            for line in wrapped(note, SMALL, WIDTH - 0.28, "normal", 3)]  # fmt: skip
    page = blank(sweep.plan.heading, f"sweep over {_over(sweep)}", _PANEL * len(names), text)
    page.arrange()
    panels: Any = page.figure.subplots(len(names), 1, sharex=True, squeeze=False)
    at = np.array(axis.values, float) if axis.numeric else np.arange(len(axis.values), dtype=float)
    for one, name in zip(panels.flat, names, strict=True):
        _draw(one, sweep, name, at, curves)
        if axis.numeric and _in_factors(at):
            one.set_xscale("log")
            log_ticks(one.xaxis, float(at.min()), float(at.max()))
        elif not axis.numeric:
            texts = [fitted(value_text(value), SMALL, 1.2) for value in axis.values]
            one.set_xticks(at, texts, parse_math=False)
    panels.flat[-1].set_xlabel(axis.label, fontsize=LABEL, parse_math=False)
    if len(curves) > 1:
        panels.flat[0].legend(
            fontsize=SMALL, frameon=False, handlelength=1.2, loc="upper left",
            bbox_to_anchor=(1.0, 1.0),
        )  # fmt: skip
    return page.figure


def _chosen(sweep: SweepTable, asked: Sequence[str] | None) -> list[str]:
    """Return the names of what is drawn."""
    unknown = [name for name in asked or () if name not in sweep.names]
    if unknown:
        raise ArgumentError(f"measures: found {show(unknown[0])}, expected some of {sweep.names}")
    names = list(asked or sweep.names)
    if asked is None and not sweep.plan.measures:
        powers = [name for name in names if name.startswith("detectors.")]
        names = powers or names
    if asked is None:
        lit = [n for n in names if any(p.done and p.measures[n].value for p in sweep.points)]
        names = (lit or names)[:_MOST_PANELS]
    if not names or not sweep.n_done:
        raise ArgumentError("sweep: found no point that has been run, expected one to draw")
    return names


def _along(sweep: SweepTable) -> int:
    """Return which dimension lies along the axis: of those of numbers the longest, or the last."""
    sizes = [
        (any(axis.numeric for axis in group), len(group[0].values), place)
        for place, group in enumerate(sweep.plan.groups)
    ]
    return max(sizes)[2]


def _curves(sweep: SweepTable, along: int) -> tuple[list[tuple[str, list[int]]], int]:
    """Return the label and the points of each curve, and how many are left out."""
    shape = sweep.plan.shape
    lines = np.moveaxis(np.arange(len(sweep)).reshape(shape), along, -1).reshape(-1, shape[along])
    found = []
    for points in lines.tolist():
        place = sweep.plan.index(points[0])
        label = ", ".join(
            f"{group[0].name} = {_short(group[0], at)}"
            for n, (group, at) in enumerate(zip(sweep.plan.groups, place, strict=True))
            if n != along
        )
        found.append((label, points))
    most = len(_COLOURS)
    if len(found) <= most:
        return found, 0
    kept = sorted({round(k * (len(found) - 1) / (most - 1)) for k in range(most)})
    return [found[k] for k in kept], len(found) - len(kept)


def _in_factors(at: NDArray[np.float64]) -> bool:
    """Say whether values are apart by equal factors, and not by equal steps."""
    if len(at) < 3 or at.min() <= 0.0:
        return False
    logs = np.diff(np.log(at))
    return bool(np.ptp(logs) < 1e-9 * abs(logs).max())


def _short(axis: Axis, at: int) -> str:
    """Return a value of an axis as it stands in a legend."""
    value = axis.values[at]
    return f"{value:.4g}" if axis.numeric else value_text(value)


def _draw(
    axes: Any, sweep: SweepTable, name: str, at: Any, curves: list[tuple[str, list[int]]]
) -> None:
    """Draw one measure."""
    seen: list[float] = []
    for number, (label, points) in enumerate(curves):
        kept = [n for n, k in enumerate(points) if sweep[k].done]
        done = [sweep[points[k]] for k in kept]
        values = np.array([point.measures[name].value for point in done])
        sigmas = np.array([point.measures[name].sigma or 0.0 for point in done])
        style = number % len(_COLOURS)
        axes.errorbar(
            at[kept], values, yerr=sigmas, color=_COLOURS[style], marker=_MARKS[style],
            markersize=3.5, linewidth=0.9, elinewidth=0.9, capsize=2.0,
            label=fitted(label, SMALL, 3.0) or None,
        )  # fmt: skip
        seen += [value for value in values.tolist() if math.isfinite(value)]
    if seen and min(seen) > 0.0 and max(seen) > _WIDE * min(seen):
        axes.set_yscale("log")
        log_ticks(axes.yaxis, *axes.get_ylim())
    unit = next(m.unit for m in sweep.measured if m.name == name)
    text = name if unit == "1" else f"{name}, {unit}"
    axes.set_ylabel(fitted(text, LABEL, _PANEL - 0.3), fontsize=LABEL, parse_math=False)
    axes.grid(color=GRID, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _over(sweep: SweepTable) -> str:
    return ", ".join(axis.name for axis in sweep.plan.axes)


def _notes(sweep: SweepTable, left_out: int, other: list[str]) -> list[str]:
    """Return what stands below the panels."""
    points = f"{len(sweep)} points"
    if not sweep.finished:
        points = f"{sweep.n_done} of {len(sweep)} points"
    sigma = "bars ± 1 σ, smaller than the marks where none are seen"
    seeds = {point.seed for point in sweep.points if point.done}
    stream = "; one random stream for all points: differences are paired" if len(seeds) == 1 else ""
    out = [f"{points}; {sigma}{stream}"]
    for measure in sweep.measured:
        if measure.name not in other and measure.meaning != measure.name:
            out.append(f"{measure.name}: {measure.meaning}")
    if left_out:
        out.append(f"{left_out} more curves are in the table")
    if other:
        out.append(f"{len(other)} more measures are in the table")
    return out
