"""Figure of a ghost ladder: a detector's power by the surface interactions before the arrival."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.views.figures.style import BLUE, GRID, INK, LABEL, QUIET, SMALL, sheet, styled
from photizon_cl.views.figures.words import inches, parts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.maps import Rung

__all__ = ["draw_ladder"]

_MOST_NUMBERS: Final = 24
_ACROSS: Final = 5.3  # inches that the axes are wide, or a little more
_DEEPEST: Final = 1e-18


@styled
def draw_ladder(result: Estimates, element: str) -> Figure:
    """Draw a detector's power by the number of surface interactions before the arrival.

    Entries with fewer than 10 arrivals are open bars; entries without any have none. The last entry
    of a ladder collects all higher generations.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a ladder.

    Returns
    -------
    matplotlib.figure.Figure
        Power in W on a logarithmic axis, with ±σ, over the generation.

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
    power = detector.power
    total = f"{power.value:.6g} W in all" if power.value else "0 W in all"
    notes = [f"{power.count:,} arrivals"]
    if result.batches > 1:
        notes[0] += " · bars with ±σ"
    page = sheet(result, f"power by generation on {element}; {total}", 3.4, notes)
    page.arrange()
    axes = page.figure.add_subplot()
    _draw(axes, detector.ladder, result.ledger.emitted.value)
    return page.figure


def _draw(axes: Axes, ladder: tuple[Rung, ...], emitted: float) -> None:
    last = len(ladder) - 1
    lit = [rung for rung in ladder if rung.value > 0.0]
    top = max((rung.value for rung in lit), default=emitted)
    shown = [rung for rung in lit if rung.value >= _DEEPEST * top]
    least = min((rung.value for rung in shown), default=1e-2 * top)
    floor = 10.0 ** math.floor(math.log10(least * 0.5))
    axes.set_yscale("log")
    axes.set_ylim(floor, top * (top / floor) ** (0.34 if _upright(shown) else 0.09))
    for few in (False, True):
        some = [rung for rung in shown if (rung.count < LIT_COUNT) is few]
        if some:
            # One collection, not a patch for each: a ladder may have thousands of entries.
            bars = [
                [(g - 0.35, floor), (g - 0.35, top), (g + 0.35, top), (g + 0.35, floor)]
                for g, top in ((rung.generation, rung.value) for rung in some)
            ]
            axes.add_collection(
                PolyCollection(
                    bars, facecolor="white" if few else BLUE, edgecolor=BLUE, linewidth=0.9,
                    hatch="////" if few else None, zorder=2, label="few" if few else "enough",
                ),
                autolim=False,
            )  # fmt: skip
    known = [rung for rung in shown if rung.sigma is not None]
    if known:
        axes.errorbar(
            [rung.generation for rung in known], [rung.value for rung in known],
            yerr=[rung.sigma or 0.0 for rung in known], fmt="none", ecolor=INK, elinewidth=1.1,
            capsize=2.5 if len(known) < 100 else 0.0, zorder=3,
        )  # fmt: skip
    highest = max((rung.generation for rung in shown), default=last)
    axes.set_xlim(-0.6, max(highest, 5) + 0.6)
    if len(shown) <= _MOST_NUMBERS:
        _numbers(axes, shown)
    if not shown:
        axes.text(
            0.5, 0.5, "nothing arrived", transform=axes.transAxes, ha="center", fontsize=LABEL,
            color=QUIET,
        )  # fmt: skip
    axes.xaxis.set_major_locator(MaxNLocator(nbins=16, integer=True, min_n_ticks=1))
    axes.xaxis.set_major_formatter(
        FuncFormatter(
            lambda x, _: "" if x > last else f"≥ {last}" if round(x) == last else f"{x:.0f}"
        )
    )
    axes.set_xlabel("generation: surface interactions before the arrival", fontsize=LABEL)
    axes.set_ylabel("power in W", fontsize=LABEL)
    beside: Any = axes.secondary_yaxis("right", functions=parts_of(emitted))
    beside.set_ylabel("part of the emitted power", fontsize=LABEL, color=QUIET)
    beside.tick_params(labelsize=SMALL, colors=QUIET)
    for axis in (axes.yaxis, beside.yaxis):
        locator: Any = LogLocator(numticks=9)
        axis.set_major_locator(locator)
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=SMALL)
    axes.grid(axis="y", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines["top"].set_visible(False)
    if any(rung.count < LIT_COUNT for rung in shown):
        few_key = Patch(facecolor="white", edgecolor=BLUE, hatch="////", label="below 10 rays")
        axes.legend(
            handles=[few_key], loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=SMALL,
            frameon=False, borderaxespad=0.2,
        )  # fmt: skip


def _upright(shown: list[Rung]) -> bool:
    """Say whether numbers over the bars have to stand on end to be clear of each other."""
    if len(shown) > _MOST_NUMBERS or len(shown) < 2:
        return False
    places = [rung.generation for rung in shown]
    closest = min(b - a for a, b in pairwise(places))
    widest = max(inches(_number(rung), SMALL) for rung in shown)
    return widest > 0.95 * closest * _ACROSS / (max(*places, 5) + 1.2)


def _number(rung: Rung) -> str:
    return f"{rung.value:.3g}".replace("-", "−")


def _numbers(axes: Axes, shown: list[Rung]) -> None:
    """Write each power over its bar and its error."""
    upright = _upright(shown)
    for rung in shown:
        axes.annotate(
            _number(rung), (rung.generation, rung.value + (rung.sigma or 0.0)), (0.0, 3.0),
            textcoords="offset points", ha="center", va="bottom", fontsize=SMALL, color=INK,
            rotation=90.0 if upright else 0.0, annotation_clip=False,
        )  # fmt: skip
