"""Figures of a result, drawn without a display and without matplotlib's global state.

Bins are drawn as they are, never smoothed or interpolated; a bin with fewer than 10 arrivals is
hatched instead of coloured. The colour map is safe for colour-blind readers and for print in grey.
"""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from photizon_cl.elements import Disk
from photizon_cl.figures_text import with_error

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from photizon_cl.maps import FarFieldResult, IrradianceMap, Rung
    from photizon_cl.result import Result

__all__ = ["draw_all", "draw_far_field", "draw_ladder", "draw_ledger", "draw_map", "figure_names"]

_COLOURS: Final = "viridis"
_INK: Final = "#222222"
_QUIET: Final = "#5f5f5f"
_WARNING: Final = "#b04a00"
_BAR: Final = "#3b6ea5"  # blue and ink: told apart by every kind of colour vision
_HATCHED: Final = "#e9e9e9"
_DPI: Final = 160
_LIT: Final = 0.5


def figure_names(result: Result) -> list[str]:
    """Return the file names of a result's figures."""
    return [name for name, _ in draw_all(result)]


def draw_all(result: Result) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """Give each figure's file name and a function that draws it into a PNG file."""
    used: set[str] = set()

    def name(kind: str, element: str = "") -> str:
        stem = re.sub(r"[^\w+.-]+", "_", f"{kind}-{element}" if element else kind).lower()
        unique, n = stem, 2
        while unique in used:
            unique, n = f"{stem}-{n}", n + 1
        used.add(unique)
        return f"{unique}.png"

    yield name("ledger"), partial(_write, draw_ledger, result)
    for element, detector in result.detectors.items():
        if detector.map is not None:
            yield name("map", element), partial(_write, draw_map, result, element)
        if detector.ladder is not None:
            yield name("ladder", element), partial(_write, draw_ladder, result, element)
    if result.far_field is not None:
        yield name("far-field"), partial(_write, draw_far_field, result)


def _write(draw: Callable[..., Figure], *arguments: Any) -> None:
    """Draw a figure of the arguments, the last of which is the file to write."""
    *what, path = arguments
    # A fixed Software entry: the same result gives the same file under one version of matplotlib.
    draw(*what).savefig(path, format="png", dpi=_DPI, metadata={"Software": "photizon_cl"})


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _plain(text: str) -> str:
    """Return text that matplotlib shows as it is, dollar signs included."""
    return text.replace("\\", "\\\\").replace("$", r"\$")


def _title(axes: Axes, result: Result, what: str) -> None:
    head = result.scene.title or result.scene.name
    axes.set_title(_plain(head), loc="left", fontsize=11, color=_INK, pad=20, weight="bold")
    axes.text(
        0.0, 1.015, _plain(what), transform=axes.transAxes, fontsize=9, color=_QUIET, va="bottom"
    )


def _footer(figure: Figure, result: Result, lit: float | None = None) -> None:
    achieved = result.achieved_sigma
    parts = [f"{result.rays:,} rays", f"{result.batches} batches"]
    parts.append("σ unknown" if achieved is None else f"median relative σ {achieved:.2%}")
    colour = _QUIET
    if lit is not None:
        parts.append(f"{lit:.0%} of bins carry at least 10 rays")
        if lit < _LIT:
            parts[-1] += " – less than half"
            colour = _WARNING
    figure.supxlabel(" · ".join(parts), fontsize=8, color=colour, x=0.01, ha="left")


# -- maps ----------------------------------------------------------------------------------------


def draw_map(result: Result, element: str) -> Figure:
    """Draw the irradiance map of a detector.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a map.
    """
    m = result.detectors[element].map
    if m is None:
        raise ValueError(f"the detector on {element!r} has no map")
    metric = m.x_units == "m"
    scale, unit = _length(m) if metric else (1.0, "")
    x_edges = m.x_edges * scale if metric else np.degrees(m.x_edges)
    y_edges = m.y_edges * scale
    width, height = 6.4, 5.6
    if metric:
        aspect = (y_edges[-1] - y_edges[0]) / (x_edges[-1] - x_edges[0])
        height = float(np.clip(1.3 + 4.6 * aspect, 2.8, 8.0))
    figure = _figure(width, height)
    axes = figure.add_subplot()
    _bins(figure, axes, x_edges, y_edges, m.irradiance, m.hatched, m.masked, "irradiance in W/m²")
    if metric:
        axes.set_aspect("equal")
        axes.set_xlabel(f"u in {unit}")
        axes.set_ylabel(f"v in {unit}")
        shape = next(e for e in result.scene.element if e.name == element)
        if isinstance(shape, Disk):
            turn = np.linspace(0.0, 2.0 * np.pi, 721)
            radius = shape.radius * scale
            axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=_INK, linewidth=0.8)
    else:
        axes.set_xlabel("φ in degrees")
        axes.set_ylabel("cos θ about the axis")
        axes.set_xticks(np.arange(0, 361, 45))
    _title(axes, result, f"irradiance on {element}")
    _footer(figure, result, m.lit_fraction)
    return figure


def _length(m: IrradianceMap) -> tuple[float, str]:
    """Return the scale and unit in which a map's size has one to three digits."""
    half = max(float(np.abs(m.x_edges).max()), float(np.abs(m.y_edges).max()))
    for scale, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm")):
        if half * scale >= 0.5:
            return scale, unit
    return 1e9, "nm"


def draw_far_field(result: Result) -> Figure:
    """Draw the intensity of what escaped over φ and cos θ."""
    far: FarFieldResult | None = result.far_field
    if far is None:
        raise ValueError("the scene has no far field")
    figure = _figure(6.8, 4.8)
    axes = figure.add_subplot()
    no = np.zeros(far.count.shape, bool)
    phi = np.degrees(far.phi_edges)
    _bins(figure, axes, phi, far.mu_edges, far.intensity, far.hatched, no, "intensity in W/sr")
    axes.set_xlabel("φ in degrees, from +x towards +y")
    axes.set_ylabel("cos θ, from world +z")
    axes.set_xticks(np.arange(0, 361, 45))
    _title(axes, result, "far field: intensity of what escaped")
    _footer(figure, result, float(np.mean(~far.hatched)))
    return figure


def _bins(
    figure: Figure,
    axes: Axes,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    values: NDArray[np.float64],
    hatched: NDArray[np.bool_],
    masked: NDArray[np.bool_],
    label: str,
) -> None:
    """Draw bins, hatched where few rays arrived, blank where there is nothing to arrive on."""
    shown = np.ma.masked_array(values, mask=hatched | masked)
    top = float(shown.max()) if shown.count() else 1.0
    # From zero: an irradiance is an amount, and a stretched scale makes noise look like structure.
    norm = Normalize(0.0, top or 1.0)
    mesh = axes.pcolormesh(x_edges, y_edges, shown, cmap=_COLOURS, norm=norm, rasterized=True)
    if hatched.any():
        axes.add_collection(_hatching(x_edges, y_edges, hatched), autolim=False)
        patch = Patch(
            facecolor=_HATCHED, edgecolor=_QUIET, hatch="////", linewidth=0.0, label="below 10 rays"
        )
        axes.legend(
            handles=[patch], loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8,
            frameon=False, borderaxespad=0.2, handlelength=1.6,
        )  # fmt: skip
    axes.set_xlim(x_edges[0], x_edges[-1])
    axes.set_ylim(y_edges[0], y_edges[-1])
    axes.tick_params(labelsize=8)
    bar = figure.colorbar(mesh, ax=axes, shrink=0.92, pad=0.02)
    bar.set_label(label, fontsize=9)
    bar.ax.tick_params(labelsize=8)


def _hatching(
    x: NDArray[np.float64], y: NDArray[np.float64], hatched: NDArray[np.bool_]
) -> PolyCollection:
    """Return hatched rectangles, one for each run of bins along a row."""
    corners = []
    for j, row in enumerate(hatched):
        steps = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
        for a, b in zip(steps[::2], steps[1::2], strict=True):
            corners.append([(x[a], y[j]), (x[b], y[j]), (x[b], y[j + 1]), (x[a], y[j + 1])])
    return PolyCollection(
        corners, facecolor=_HATCHED, edgecolor=_QUIET, hatch="////", linewidth=0.0, zorder=1.5
    )


# -- bars ----------------------------------------------------------------------------------------


def draw_ledger(result: Result) -> Figure:
    """Draw the ledger's rows as bars on a logarithmic axis, with their standard errors."""
    rows = result.ledger.rows()
    emitted = result.ledger.emitted.value
    names = [name for name, _ in rows]
    values = np.array([row.value for _, row in rows])
    sigmas = np.array([np.nan if row.sigma is None else row.sigma for _, row in rows])
    figure = _figure(7.2, 1.5 + 0.34 * len(rows))
    axes = figure.add_subplot()
    floor = max(1e-9 * emitted, 0.2 * min([v for v in values if v > 0.0], default=emitted))
    _log_bars(axes, names, values, sigmas, floor, emitted)
    axes.axvline(emitted, color=_INK, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_xlabel("power in W (dashed: emitted)", fontsize=9)
    closure = f"{result.ledger.closure:.1e}" if result.ledger.closure else "0"
    _title(axes, result, f"energy ledger; closure {closure} W")
    _footer(figure, result)
    return figure


def draw_ladder(result: Result, element: str) -> Figure:
    """Draw a detector's power by the number of surface interactions before the arrival."""
    rungs: tuple[Rung, ...] | None = result.detectors[element].ladder
    if rungs is None:
        raise ValueError(f"the detector on {element!r} has no ladder")
    lit = [rung for rung in rungs if rung.count]
    figure = _figure(7.2, 1.5 + 0.3 * max(len(lit), 1))
    axes = figure.add_subplot()
    names = [
        f"{rung.generation}" + (" or more" if rung.generation == len(rungs) - 1 else "")
        for rung in lit
    ]
    values = np.array([rung.value for rung in lit])
    sigmas = np.array([np.nan if rung.sigma is None else rung.sigma for rung in lit])
    top = float(values.max()) if len(lit) else 1.0
    floor = 0.2 * min((v for v in values if v > 0.0), default=top)
    _log_bars(axes, names, values, sigmas, floor, top)
    axes.set_ylabel("surface interactions", fontsize=9)
    axes.set_xlabel("power in W", fontsize=9)
    _title(axes, result, f"power by generation on {element}")
    _footer(figure, result)
    return figure


def _log_bars(
    axes: Axes,
    names: list[str],
    values: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    floor: float,
    top: float,
) -> None:
    """Draw horizontal bars from `floor`, with values written behind them."""
    places = np.arange(len(names))
    axes.set_xscale("log")
    axes.set_xlim(floor, top * (top / floor) ** 0.04)
    seen = values > floor
    axes.barh(places[seen], values[seen] - floor, left=floor, height=0.62, color=_BAR, zorder=2)
    known = seen & (sigmas > 0.0)
    if known.any():
        low = np.minimum(sigmas[known], values[known] - floor)  # a bar cannot reach below the axis
        axes.errorbar(
            values[known], places[known], xerr=[low, sigmas[known]], fmt="none", ecolor=_INK,
            elinewidth=1.2, capsize=3.0, zorder=3,
        )  # fmt: skip
    labels = []
    for value, sigma in zip(values, sigmas, strict=True):
        text, error = with_error(float(value), None if np.isnan(sigma) else float(sigma))
        labels.append("0" if value == 0.0 else f"{text} ± {error}")
    right: Any = axes.secondary_yaxis("right")
    right.set_yticks(places, labels, fontsize=8)
    right.tick_params(length=0)
    right.spines["right"].set_visible(False)
    axes.set_yticks(places, [_plain(name) for name in names], fontsize=9)
    axes.set_ylim(len(names) - 0.4, -0.6)
    locator: Any = LogLocator(numticks=9)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize=8)
    axes.tick_params(axis="y", length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.grid(axis="x", color="#dddddd", linewidth=0.6, zorder=0)
