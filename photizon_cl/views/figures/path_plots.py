"""Figures of a path table: the strongest paths ranked, and ghosts by pair of faces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import LogNorm

from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.views.figures.scales import log_ticks
from photizon_cl.views.figures.style import (
    BLUE,
    GRID,
    INK,
    LABEL,
    QUIET,
    SMALL,
    sheet,
    styled,
    whole,
)
from photizon_cl.views.figures.words import escaped, fitted, inches, parts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.ghosts import Ghosts
    from photizon_cl.result.path_rows import PathRow
    from photizon_cl.result.path_table import PathTable

__all__ = ["MOST_FACES", "draw_ghosts", "draw_paths"]

_MOST_ROWS: Final = 24
_ROW: Final = 0.34
MOST_FACES: Final = 48
"""Faces up to which a matrix of ghosts is drawn."""
_DEEPEST: Final = 1e-15


def _table(result: Estimates, element: str) -> PathTable:
    detector = result.detectors.get(element)
    if detector is None or detector.paths is None:
        having = [name for name, d in result.detectors.items() if d.paths is not None]
        raise ArgumentError(
            f"element: found {show(element)}, expected one whose detector has a path table "
            f"({', '.join(map(show, having)) or 'this scene has none'})"
        )
    return detector.paths


@styled
def draw_paths(result: Estimates, element: str, *, ax: Axes | None = None) -> Figure:
    """Draw the strongest paths to a detector, ranked by power, with their sequences.

    Up to 24 of them. Paths with fewer than 10 arrivals are open dots.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a path table.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Power in W on a logarithmic axis, with ±σ, a row a path; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no such path table.
    """
    table = _table(result, element)
    emitted = result.ledger.emitted.value
    shown = [row for row in table if row.power > 0.0][:_MOST_ROWS]
    if ax is not None:
        _ranked(ax, shown, emitted)
        return whole(ax)
    detector = result.detectors[element].power
    rest = table.rest
    left = math.fsum(row.power for row in table[len(shown) :]) + rest.power
    notes = [
        "dots with ±σ; r reflected, i totally reflected, s scattered; in brackets the transmissions"
    ]
    if left > 0.0:
        notes.append(f"{left:.3g} W come by other paths")
    relative = detector.sigma / detector.value if detector.sigma and detector.value else None
    page = sheet(
        result, f"strongest paths to {element}; {detector.value:.6g} W in all",
        1.0 + _ROW * max(len(shown), 2), notes, own=("relative σ of the power in all", relative),
    )  # fmt: skip
    page.arrange()
    _ranked(page.figure.add_subplot(), shown, emitted)
    return page.figure


def _ranked(axes: Axes, shown: list[PathRow], emitted: float) -> None:
    top = max((row.power for row in shown), default=emitted)
    shown = [row for row in shown if row.power >= _DEEPEST * top]
    least = min(min((row.power for row in shown), default=top), 0.02 * top)
    floor = 10.0 ** math.floor(math.log10(least * 0.7))
    high = top * (top / floor) ** 0.05
    places = np.arange(len(shown))
    axes.set_xscale("log")
    axes.set_xlim(floor, high)
    known = [n for n, row in enumerate(shown) if row.sigma is not None]
    if known:
        axes.errorbar(
            [shown[n].power for n in known], known, xerr=[shown[n].sigma or 0.0 for n in known],
            fmt="none", ecolor=INK, elinewidth=1.1, capsize=2.5, zorder=3,
        )  # fmt: skip
    for few in (False, True):
        some = [n for n, row in enumerate(shown) if (row.count < LIT_COUNT) is few]
        if some:
            axes.plot(
                [shown[n].power for n in some], some, linestyle="none", marker="o", markersize=5.5,
                color=BLUE, markerfacecolor="white" if few else BLUE, markeredgewidth=1.2, zorder=4,
            )  # fmt: skip
    faces: dict[str, set[str]] = {}
    for row in shown:
        for step in row.steps:
            faces.setdefault(step.element, set()).add(step.face)
    # the sequence stands over its line: it is longer than any margin
    width = axes.get_window_extent().width / whole(axes).dpi
    for n, row in enumerate(shown):
        axes.annotate(
            escaped(_middle(_said(row, faces), width - 0.15)), (0.0, n), (2.0, 4.0),
            xycoords=("axes fraction", "data"), textcoords="offset points", fontsize=SMALL,
            color=INK, va="bottom", zorder=5,
        )  # fmt: skip
    axes.set_yticks(places, [f"{n + 1}" for n in places], fontsize=SMALL)
    axes.set_ylim(max(len(shown), 1) - 0.5, -0.9)
    axes.set_xlabel("power in W", fontsize=LABEL)
    right: Any = axes.secondary_yaxis("right")
    right.set_yticks(
        places, [f"{row.power:.3g}".replace("-", "−") for row in shown], fontsize=SMALL
    )
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
    axes.grid(axis="x", color=GRID, linewidth=0.6, zorder=0)
    axes.grid(axis="y", color=GRID, linewidth=0.8, linestyle=(0, (1, 2)), zorder=0)
    axes.set_axisbelow(True)
    if not shown:
        axes.text(
            0.5, 0.5, "nothing arrived", transform=axes.transAxes, ha="center", fontsize=LABEL,
            color=QUIET,
        )  # fmt: skip


def _said(row: PathRow, faces: dict[str, set[str]]) -> str:
    """Return a path in short: what turned it, and how often it was transmitted on the way."""
    if not row.steps:
        return row.sequence if row.interactions else "direct"
    turns = [
        f"{step.element}.{step.face} {step.event}"
        if len(faces[step.element]) > 1
        else f"{step.element} {step.event}"
        for step in row.steps
        if step.event != "t"
    ]
    passed = row.events.count("t")
    if not turns:
        return "direct, transmitted" + (f" {passed} times" if passed > 1 else "")
    return " > ".join(turns) + (f"   ({passed} t)" if passed else "")


def _middle(text: str, room: float) -> str:
    """Return a sequence without steps in its middle where it is too long."""
    if inches(text, SMALL) <= room:
        return text
    steps = text.split(" > ")
    for left in range(len(steps) - 1, 1, -1):
        front = (left + 1) // 2
        cut = [*steps[:front], f"… {len(steps) - left} more …", *steps[len(steps) - left + front :]]
        if inches(" > ".join(cut), SMALL) <= room:
            return " > ".join(cut)
    return fitted(text, SMALL, room)


@styled
def draw_ghosts(result: Estimates, element: str, *, ax: Axes | None = None) -> Figure:
    """Draw the two-reflection ghosts on a detector as a matrix over pairs of refracting faces.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a path table.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Power in W in colour; rows are the faces of the first reflection, columns those of the
        second; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no such path table, or more faces than can be drawn.
    """
    ghosts = _table(result, element).ghosts()
    if len(ghosts.faces) > MOST_FACES:
        raise ArgumentError(
            f"element: {show(element)} has ghosts of {len(ghosts.faces)} faces, and a matrix shows "
            f"up to {MOST_FACES}: `ghosts().pairs()` lists them"
        )
    if ax is not None:
        _matrix(ax, ghosts)
        return whole(ax)
    pairs = ghosts.pairs()
    notes = ["rows: first reflection, columns: second; grey: no such path in the table"]
    page = sheet(
        result,
        f"ghosts of two reflections on {element}; {len(pairs)} pairs, {ghosts.power.sum():.4g} W",
        max(3.0, 1.6 + 0.3 * len(ghosts.faces)), notes,
    )  # fmt: skip
    page.arrange()
    _matrix(page.figure.add_subplot(), ghosts)
    return page.figure


def _matrix(axes: Axes, ghosts: Ghosts) -> None:
    n = len(ghosts.faces)
    lit = ghosts.power > 0.0
    top = float(ghosts.power.max(initial=0.0)) or 1.0
    least = float(ghosts.power[lit].min(initial=top))
    norm = LogNorm(min(least, 0.1 * top) * 0.999, top)
    shown = np.ma.masked_array(ghosts.power, ~lit)
    axes.set_facecolor("#ececec")
    image = axes.imshow(shown, norm=norm, cmap="cividis", aspect="auto")
    names = [escaped(fitted(face, SMALL, 1.8)) for face in ghosts.faces]
    axes.set_xticks(
        range(n), names, fontsize=SMALL, rotation=40, ha="right", rotation_mode="anchor"
    )
    axes.set_yticks(range(n), names, fontsize=SMALL)
    axes.set_xlabel("second reflection", fontsize=LABEL)
    axes.set_ylabel("first reflection", fontsize=LABEL)
    if n <= 12:
        for a, b in zip(*(at.tolist() for at in np.nonzero(lit)), strict=True):
            value = float(ghosts.power[a, b])
            dark = norm(value) < 0.55
            axes.text(
                b, a, f"{value:.2g}".replace("-", "−"), ha="center", va="center", fontsize=SMALL,
                color="white" if dark else INK,
            )  # fmt: skip
    axes.tick_params(length=0)
    bar = whole(axes).colorbar(image, ax=axes, shrink=0.9, pad=0.02)
    bar.set_label("power in W", fontsize=LABEL)
    bar.ax.tick_params(labelsize=SMALL)
    bar.ax.minorticks_off()
