"""Figures of a detector's map: its irradiance, and how well each bin is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.frames import direction_words
from photizon_cl.views.figures import bins
from photizon_cl.views.figures.scales import (
    PEAKED,
    colour_norm,
    extends,
    is_log,
    log_ticks,
    positive,
)
from photizon_cl.views.figures.style import INK, sheet, styled, whole
from photizon_cl.views.figures.words import percent, powered, prefixed, scaled

_ALONG = ("u", "v", "w")

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.maps import IrradianceMap
    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.filters.base import Axis

__all__ = ["draw_irradiance", "draw_relative_sigma", "length_unit"]


@styled
def draw_irradiance(
    result: Estimates,
    element: str,
    *,
    norm: str | Normalize | None = None,
    vmin: float | None = None,
    vmax: float | None = None,
    line: int | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw a detector's irradiance map.

    Every bin has the colour of its own value, or, where there are more bins than dots on paper,
    every dot that of the highest bin in it, which is said. Bins with fewer than 10 arrivals are
    hatched; bins without any area stay white. Bins that a rim leaves less than three quarters of
    the area of others do not set the scale; where they go beyond it, its bar ends in a point.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a map.
    norm : {"linear", "log"} or matplotlib.colors.Normalize, optional
        Scale of the colours; by default linear, or logarithmic where half of the bins are below 5 %
        of the highest, which is said.
    vmin, vmax : float, optional
        Limits of the scale in W/m²; by default from 0 to the highest bin, on a logarithmic scale
        from the lowest.
    line : int, optional
        Number of a line or band of the spectrum, of which alone the map is then.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into, with their colour bar; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Irradiance in W/m² over u and v, or over φ and cos θ; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no such map or line, or norm and limits do not go together.
    """
    m = _map(result, element)
    title = f"irradiance on {element}"
    if line is not None:
        m, name = _of_line(result, m, line)
        title += f", {name}"
    scale = colour_norm(m.irradiance[m.decisive], norm, vmin, vmax, peaked=True)
    shown = np.ma.masked_array(m.irradiance, mask=m.hatched | m.masked)
    notes = bins.said(m.count.shape) + chosen(scale, norm)
    if vmin is vmax is None:
        notes += _left_out(m, m.irradiance, scale, "W/m²")
    panel, x, y = _frame(result, element, m, title, notes, ax)
    amounts(panel, x, y, shown, m.hatched, "irradiance", "W/m²", scale)
    _rims(panel.axes, m, x[-1] / m.x_edges[-1])
    return whole(panel.axes)


@styled
def draw_relative_sigma(
    result: Estimates,
    element: str,
    *,
    norm: str | Normalize | None = None,
    vmin: float | None = None,
    vmax: float | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw the relative standard error of each bin of a detector's map.

    Bins without a value, and every bin after a single batch, are grey. Bins with fewer than 10
    arrivals are hatched: their σ is itself unreliable. Where there are more bins than dots on paper
    every dot has the highest σ of those in it with 10 arrivals, which is said.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a map.
    norm : {"linear", "log"} or matplotlib.colors.Normalize, optional
        Scale of the colours; by default linear.
    vmin, vmax : float, optional
        Limits of the scale, as parts of 1; by default from 0 to the highest bin among those that
        set an irradiance map's scale.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into, with their colour bar; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        σ over the irradiance in percent over u and v, or over φ and cos θ; that of `ax` where one
        is given.

    Raises
    ------
    ArgumentError
        Where the scene has no such map, or norm and limits do not go together.
    """
    m = _map(result, element)
    known = ~m.masked & (m.irradiance > 0.0) & np.isfinite(m.sigma)
    ratio = np.divide(m.sigma, m.irradiance, out=np.full(m.sigma.shape, np.nan), where=known)
    shown = np.ma.masked_array(ratio, mask=~known)
    # A bin with a single arrival has 100 %, which would leave the lit ones in one colour.
    decisive = known & m.decisive
    scale = colour_norm(ratio[decisive if decisive.any() else known], norm, vmin, vmax)
    target = result.info.goal.target
    marked = target is not None and _within(target, scale)
    notes = bins.said(m.count.shape, "highest σ")
    notes += ["mark on the scale: target of the median"] if marked else []
    if vmin is vmax is None:
        notes += _left_out(m, ratio, scale, "%", 100.0)
    what = f"relative σ of irradiance on {element}"
    panel, x, y = _frame(result, element, m, what, notes, ax)
    axes = panel.axes
    # viridis has no grey in it, which the bins without a value have
    well = np.ma.masked_array(ratio, mask=~known | m.hatched)
    values, lit = bins.dots(shown), bins.dots(well)
    none = np.ma.getmaskarray(lit)  # there others are shown, and hatched
    values = np.ma.masked_array(
        np.where(none, np.ma.getdata(values), np.ma.getdata(lit)), mask=np.ma.getmaskarray(values)
    )
    drawn = bins.paint(axes, x, y, positive(values, scale), colormaps["viridis"], scale)
    drawn.set_label("values")
    bar = bins.colour_bar(drawn, panel, "relative σ in %", extends(shown, scale))
    if is_log(scale):
        log_ticks(bar.ax.yaxis, *_limits(scale))
    bar.ax.yaxis.set_major_formatter(scaled(100.0))
    if target is not None and marked:
        bar.ax.axhline(target, color="#ffffff", linewidth=3.0)
        bar.ax.axhline(target, color=INK, linewidth=1.2, label="target of the median")
    if not shown.count():
        bar.set_ticks([])
    grey = bins.dots(~known & ~m.masked) & np.ma.getmaskarray(values)
    bins.flat(axes, x, y, grey, bins.GREY, "without a value")
    poor = none & ~np.ma.getmaskarray(values)
    bins.hatch(axes, x, y, poor)
    patches = [bins.plain_patch(bins.GREY, "no value")] if grey.any() else []
    hatched = [bins.plain_patch("#ffffff", "below 10 rays")] if poor.any() else []
    bins.key(panel, patches, hatched)
    _rims(axes, m, x[-1] / m.x_edges[-1])
    return whole(axes)


def amounts(
    panel: bins.Panel,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    shown: Any,
    hatched: NDArray[np.bool_],
    what: str,
    unit: str,
    scale: Normalize,
) -> None:
    """Draw amounts in the colours of a scale, and the bins with few rays hatched.

    Parameters
    ----------
    panel : Panel
        Where.
    x_edges, y_edges : ndarray
        Edges of the bins as drawn.
    shown : masked ndarray, shape (ny, nx)
        In `unit`; what is masked is not coloured.
    hatched : ndarray, shape (ny, nx), bool
        Bins with fewer than 10 rays.
    what, unit : str
        Name of the quantity and its SI unit.
    scale : Normalize
        Of the colours.
    """
    axes = panel.axes
    values = bins.dots(shown)
    # a dot is hatched where no bin in it has a colour
    hatched = bins.dots(hatched) & np.ma.getmaskarray(values)
    drawn = bins.paint(axes, x_edges, y_edges, positive(values, scale), colormaps["viridis"], scale)
    drawn.set_label("values")
    low, high = _limits(scale)
    factor, name = (1.0, unit) if is_log(scale) else powered(max(abs(low), abs(high)), unit)
    bar = bins.colour_bar(drawn, panel, f"{what} in {name}", extends(shown, scale))
    if is_log(scale):
        log_ticks(bar.ax.yaxis, low, high)
    else:
        bar.ax.yaxis.set_major_formatter(scaled(factor))
    if not shown.count():
        bar.set_ticks([])  # nothing is coloured: a scale would be made up
    bins.flat(axes, x_edges, y_edges, hatched, bins.HATCHED, "below 10 rays")
    bins.hatch(axes, x_edges, y_edges, hatched)
    if hatched.any():
        bins.key(panel, [], [bins.plain_patch(bins.HATCHED, "below 10 rays")])


def chosen(scale: Normalize, norm: str | Normalize | None) -> list[str]:
    """Return what is said where the values, not the reader, asked for a logarithmic scale."""
    if norm is not None or not is_log(scale):
        return []
    return [f"logarithmic scale: half of the bins are below {percent(PEAKED)} of the highest"]


def _limits(scale: Normalize) -> tuple[float, float]:
    return float(scale.vmin or 0.0), float(scale.vmax if scale.vmax is not None else 1.0)


def _within(value: float, scale: Normalize) -> bool:
    low, high = _limits(scale)
    return low <= value <= high


def _left_out(
    m: IrradianceMap, values: NDArray[np.float64], scale: Normalize, unit: str, factor: float = 1.0
) -> list[str]:
    """Return what is said of small bins that go beyond a scale which others set."""
    found = values[m.slivers & m.lit & np.isfinite(values)]
    low, high = _limits(scale)
    beyond = found[(found < low) | (found > high)]
    if not len(beyond):
        return []
    said = []
    if beyond.min() < low:
        said.append(f"down to {factor * float(beyond.min()):.3g}")
    if beyond.max() > high:
        said.append(f"up to {factor * float(beyond.max()):.3g}")
    n, rim = len(beyond), "that a rim leaves less than three quarters of the area of others"
    return [f"beyond the scale: {n:,} bin{'s' * (n != 1)} {rim}, {' and '.join(said)} {unit}"]


def _of_line(result: Estimates, m: IrradianceMap, line: int) -> tuple[IrradianceMap, str]:
    """Return the map of a line or band, and what that is called."""
    spectrum, there = result.scene.spectrum, m.by_wavelength
    if spectrum is None or not there:
        raise ArgumentError(
            f"line: found {show(line)}, expected none, as nothing is told by wavelength there "
            "(wavelengths = true does so)"
        )
    if isinstance(line, bool) or not isinstance(line, int) or not 0 <= line < len(there):
        raise ArgumentError(
            f"line: found {show(line)}, expected a number from 0 to {len(there) - 1}"
        )
    return there[line], spectrum.names[line]


def _map(result: Estimates, element: str) -> IrradianceMap:
    detector = result.detectors.get(element)
    if detector is None or detector.map is None:
        have = [name for name, d in result.detectors.items() if d.map is not None]
        raise ArgumentError(
            f"element: found {show(element)}, expected one whose detector has a map "
            f"({', '.join(map(show, have)) or 'this scene has none'})"
        )
    return detector.map


def _frame(
    result: Estimates,
    element: str,
    m: IrradianceMap,
    what: str,
    notes: list[str],
    ax: Axes | None,
) -> tuple[bins.Panel, NDArray[np.float64], NDArray[np.float64]]:
    """Return where to draw, and the edges as drawn."""
    across, up = m.bins.x.axis, m.bins.y.axis
    scale, unit = length_unit(m)
    x, y = (_as_drawn(axis, scale) for axis in (across, up))
    metric = across.units == up.units == "m"
    width, height = bins.size_of(x, y) if metric else (4.85, 3.6)
    if ax is not None:
        panel = bins.own_axes(ax, metric and bins.to_scale(x, y))
    else:
        if metric and not bins.to_scale(x, y):
            what += "; axes not to one scale"
        own = ("median relative σ of this map", m.median_sigma)
        page = sheet(result, what, bins.body(height), notes, m.count[~m.masked], own)
        panel = bins.bin_axes(page, width, height)
        if metric and width < 2.0:
            panel.axes.locator_params(axis="x", nbins=3)
        if metric and height < 2.0:
            panel.axes.locator_params(axis="y", nbins=3)
    owner = next(e for e in result.scene.element if e.name == element)
    panel.label(_label(across, unit, owner), _label(up, unit, owner))
    if across.units == "rad":
        panel.axes.set_xticks(np.arange(0, 361, 45 if ax is None else 90))
    return panel, x, y


def length_unit(m: IrradianceMap) -> tuple[float, str]:
    """Return the factor and the unit in which a map's lengths are written, here and in text."""
    lengths = [axis.edges for axis in (m.bins.x.axis, m.bins.y.axis) if axis.units == "m"]
    half = max((float(np.abs(edges).max()) for edges in lengths), default=0.0)
    return prefixed(2.0 * half, "m") if lengths else (1.0, "")


def _as_drawn(axis: Axis, scale: float) -> NDArray[np.float64]:
    """Return edges in a length's unit, in degrees, or as they are."""
    if axis.units == "m":
        return axis.edges * scale
    return np.degrees(axis.edges) if axis.units == "rad" else axis.edges


def _label(axis: Axis, unit: str, element: Element) -> str:
    """Return what stands at an axis: its symbol, where that points in the world, its unit."""
    unit = {"m": unit, "rad": "degrees"}.get(axis.units, "")
    symbol = axis.symbol
    if symbol in _ALONG:
        symbol += f" ({direction_words(element.frame[_ALONG.index(symbol)])})".replace("-", "−")
    if not unit:
        return f"{symbol} {axis.about}".strip()
    return f"{symbol} in {unit}" + (f", {axis.about}" if axis.about else "")


def _rims(axes: Axes, m: IrradianceMap, scale: float) -> None:
    """Draw the circles that bound what is mapped over its bins."""
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    for rim in m.bins.rims:
        radius = rim * scale
        axes.plot(
            radius * np.cos(turn), radius * np.sin(turn), color=INK, linewidth=0.8, clip_on=False
        )
