"""Figure of a ghost ladder: a detector's power by the surface interactions before the arrival."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from matplotlib.ticker import MaxNLocator

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
from photizon_cl.views.figures.words import inches, parts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.maps import Rung

__all__ = ["draw_ladder"]

_MOST_NUMBERS: Final = 24
_DEEPEST: Final = 1e-18


@styled
def draw_ladder(result: Estimates, element: str, *, ax: Axes | None = None) -> Figure:
    """Draw a detector's power by the number of surface interactions before the arrival.

    Entries with fewer than 10 arrivals are open dots; entries without any have none. The last entry
    of a ladder collects all higher generations.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a ladder.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Power in W on a logarithmic axis, with ±σ, over the generation; that of `ax` where one is
        given.

    Raises
    ------
    ArgumentError
        Where the scene has no such ladder.
    """
    detector = result.detectors.get(element)
    if detector is None or detector.ladder is None:
        have = [name for name, d in result.detectors.items() if d.ladder is not None]
        raise ArgumentError(
            f"element: found {show(element)}, expected one whose detector has a ladder "
            f"({', '.join(map(show, have)) or 'this scene has none'})"
        )
    power, emitted = detector.power, result.ledger.emitted.value
    if ax is not None:
        _draw(ax, detector.ladder, emitted)
        return whole(ax)
    total = f"{power.value:.6g} W in all" if power.value else "0 W in all"
    notes = [f"{power.count:,} arrivals"]
    if result.batches > 1:
        notes[0] += " · dots with ±σ"
    relative = power.sigma / power.value if power.sigma is not None and power.value else None
    own = ("relative σ of the power in all", relative)
    page = sheet(result, f"power by generation on {element}; {total}", 3.4, notes, own=own)
    page.arrange()
    _draw(page.figure.add_subplot(), detector.ladder, emitted)
    return page.figure


def _draw(axes: Axes, ladder: tuple[Rung, ...], emitted: float) -> None:
    last = len(ladder) - 1
    lit = [rung for rung in ladder if rung.value > 0.0]
    top = max((rung.value for rung in lit), default=emitted)
    shown = [rung for rung in lit if rung.value >= _DEEPEST * top]
    # At least two decades, so that noise between like entries does not look like structure.
    least = min(min((rung.value for rung in shown), default=top), 0.02 * top)
    highest = max((rung.generation for rung in shown), default=last)
    across = min(max(highest, 5), last)
    width = axes.get_window_extent().width / whole(axes).dpi
    upright = _upright(shown, width / (across + 1.2))
    # Numbers stand over the dots, where they take room from no power that is possible; on end they
    # hang below them.
    room = 1.35 if upright else 1.12
    floor = 10.0 ** math.floor(math.log10(least * 0.7))
    floor = floor if not upright else top * (floor / top) ** room
    high = top * (top / floor) ** (0.05 if upright else 0.1)
    axes.set_yscale("log")
    axes.set_ylim(floor, high)
    known = [rung for rung in shown if rung.sigma is not None]
    if known:
        axes.errorbar(
            [rung.generation for rung in known], [rung.value for rung in known],
            yerr=[rung.sigma or 0.0 for rung in known], fmt="none", ecolor=INK, elinewidth=1.1,
            capsize=2.5 if len(known) < 100 else 0.0, zorder=3,
        )  # fmt: skip
    for few in (False, True):
        some = [rung for rung in shown if (rung.count < LIT_COUNT) is few]
        if some:
            axes.plot(
                [rung.generation for rung in some], [rung.value for rung in some],
                linestyle="none", marker="o", markersize=6.0 if last < 100 else 3.0, color=BLUE,
                markerfacecolor="white" if few else BLUE, markeredgewidth=1.2, zorder=4,
                label="below 10 rays" if few else "power",
            )  # fmt: skip
    step = width / (across + 1.2)
    margin = [0.6, 0.6]  # as much as the outer numbers need, where they are wider
    for rung, side in ((shown[0], 0), (shown[-1], 1)) if shown and not upright else ():
        spare = rung.generation if side == 0 else across - rung.generation
        margin[side] = max(0.6, 0.55 * inches(_number(rung), SMALL) / step - spare)
    axes.set_xlim(-margin[0], across + margin[1])
    if len(shown) <= _MOST_NUMBERS:
        _numbers(axes, shown, upright)
    if not shown:
        axes.text(
            0.5, 0.5, "nothing arrived", transform=axes.transAxes, ha="center", fontsize=LABEL,
            color=QUIET,
        )  # fmt: skip
    places = MaxNLocator(16, integer=True, min_n_ticks=1).tick_values(0, max(across, 1))
    ticks = [int(place) for place in places if 0 <= place <= across]
    if across == last:  # it collects, and is always named; its neighbour yields where it is close
        apart = 0.6 * (ticks[1] - ticks[0]) if len(ticks) > 1 else 0.0
        ticks = [*(tick for tick in ticks if tick < last - apart), last]
    axes.set_xticks(ticks, [f"≥ {tick}" if tick == last else f"{tick}" for tick in ticks])
    axes.set_xlabel("generation: surface interactions before the arrival", fontsize=LABEL)
    axes.set_ylabel("power in W", fontsize=LABEL)
    beside: Any = axes.secondary_yaxis("right", functions=parts_of(emitted))
    beside.set_ylabel("part of the emitted power", fontsize=LABEL, color=QUIET)
    beside.tick_params(labelsize=SMALL, colors=QUIET)
    log_ticks(axes.yaxis, floor, high, emitted)
    log_ticks(beside.yaxis, floor / emitted, high / emitted, 1.0)
    axes.tick_params(labelsize=SMALL)
    axes.grid(axis="y", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines["top"].set_visible(False)
    if any(rung.count < LIT_COUNT for rung in shown):
        open_dots = [line for line in axes.lines if line.get_label() == "below 10 rays"]
        axes.legend(
            handles=open_dots, loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=SMALL,
            frameon=False, borderaxespad=0.2,
        )  # fmt: skip


def _upright(shown: list[Rung], step: float) -> bool:
    """Say whether numbers have to stand on end to be clear of each other at a step in inches."""
    if len(shown) > _MOST_NUMBERS or len(shown) < 2:
        return False
    closest = min(b.generation - a.generation for a, b in pairwise(shown))
    widest = max(inches(_number(rung), SMALL) for rung in shown)
    return widest > 0.95 * closest * step


def _number(rung: Rung) -> str:
    return f"{rung.value:.3g}".replace("-", "−")


def _numbers(axes: Axes, shown: list[Rung], upright: bool) -> None:
    """Write each power over its dot and its error, or on end below them."""
    for rung in shown:
        sigma = rung.sigma or 0.0
        end = rung.value - sigma if upright else rung.value + sigma
        if end <= 0.1 * rung.value:  # off the axis
            end = rung.value
        axes.annotate(
            _number(rung), (rung.generation, end), (0.0, -6.0 if upright else 6.0),
            textcoords="offset points", ha="center", va="top" if upright else "bottom",
            fontsize=SMALL, color=INK, rotation=90.0 if upright else 0.0, annotation_clip=False,
        )  # fmt: skip
