"""Figure of a cost study: error against seconds, a panel a knob."""

from __future__ import annotations

import math
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

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
    WIDTH,
    blank,
    styled,
)
from photizon_cl.views.figures.words import percent, scaled, wrapped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from photizon_cl.result.cost import CostSetting, CostStudy

__all__ = ["draw_cost"]

_COLOURS: Final = (BLUE, ORANGE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_MARKS: Final = ("o", "s", "^", "D", "v", "P")
_FURTHER: Final = 30.0
"""Times the seconds that were traced up to which curves are continued."""
_PANEL: Final = 2.3
"""Inches of a row of panels."""


@styled
def draw_cost(study: CostStudy) -> Figure:
    """Draw the error of each setting of a cost study against seconds of tracing.

    The error is √(σ² + bias²) over the value, with a bias that shows (beyond four of its standard
    errors) and none else. Marks are what was traced; the lines go on as the study predicts, with a
    slope of −1/2 until the bias stops them.

    Parameters
    ----------
    study : CostStudy
        The study.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each knob, both axes logarithmic; the scene as it stands is in each, in black.

    Raises
    ------
    ArgumentError
        Where nothing in the study scatters, so that there is no error to draw.
    """
    given = study[study.given]
    shown = [row for row in study if row.points and row.name != study.given]
    if not shown and not given.points:
        raise ArgumentError(
            f"cost: every batch gave the same {study.quantity}, so there is no error to draw"
        )
    key = [(knob, list(rows)) for knob, rows in groupby(shown, key=lambda row: row.knob)]
    panels = key or [(given.knob, [])]
    rows = math.ceil(len(panels) / 2)
    what = f"work and precision: {study.quantity} on {study.device}"
    text = (
        f"error: √(σ² + bias²) of {study.quantity} over its value; bias against {study.reference}, "
        f"where it shows; marks are measured, lines go on with slope −1/2; "
        f"{study.rays_per_batch:,} rays a batch"
    )
    lines = [(line, QUIET, "normal") for line in wrapped(text, SMALL, WIDTH - 0.28, "normal", 3)]
    page = blank(study.scene, what, _PANEL * rows, lines)
    page.arrange()
    across = 2 if len(panels) > 1 else 1
    axes: Any = page.figure.subplots(rows, across, sharex=True, sharey=True, squeeze=False)
    flat = list(axes.flat)
    for one, (knob, members) in zip(flat, panels, strict=False):
        _draw(one, given, INK, ".", f"{given.name}, as it stands")
        for number, row in enumerate(members):
            style = number % len(_COLOURS)
            _draw(one, row, _COLOURS[style], _MARKS[style], _label(row, knob))
        one.set_title(knob, fontsize=LABEL, color=INK, loc="left")
        one.legend(fontsize=SMALL, frameon=False, loc="upper right", handlelength=1.2)
    for one in flat[len(panels) :]:
        one.set_visible(False)
    _finish(flat[: len(panels)], flat, across)
    return page.figure


def _label(row: CostSetting, knob: str) -> str:
    text = row.name.removeprefix(knob).strip() or row.name
    return f"{text}, off by {percent(abs(row.relative_bias or 0.0))}" if row.is_biased else text


def _draw(axes: Any, row: CostSetting, colour: str, mark: str, label: str) -> None:
    if not row.points:
        return
    floor = abs(row.relative_bias or 0.0) if row.is_biased else 0.0
    t, s = (np.array(column) for column in zip(*row.points, strict=True))
    axes.plot(
        t, np.hypot(s, floor), color=colour, linewidth=0.0, marker=mark, markersize=3.0,
        label=label, zorder=2.5,
    )  # fmt: skip
    on = np.geomspace(t[0], t[-1] * _FURTHER, 60)
    axes.plot(on, np.hypot(s[-1] * np.sqrt(t[-1] / on), floor), color=colour, linewidth=0.9)


def _finish(used: list[Any], every: list[Any], across: int) -> None:
    for axes in used:
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.grid(color=GRID, linewidth=0.5)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=SMALL)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    low, high = used[0].get_xlim()
    log_ticks(used[0].xaxis, low, high)
    used[0].xaxis.set_major_formatter(scaled(1.0))
    low, high = used[0].get_ylim()
    used[0].set_ylim(low, high * 3.0)  # the legend's room
    log_ticks(used[0].yaxis, low, high * 3.0)
    used[0].yaxis.set_major_formatter(scaled(100.0))
    for number, axes in enumerate(every):
        if axes not in used:
            continue
        if number % across == 0:
            axes.set_ylabel("error in %", fontsize=LABEL)
        if number + across >= len(used):
            axes.set_xlabel("seconds of tracing", fontsize=LABEL)
            axes.xaxis.set_tick_params(labelbottom=True)
