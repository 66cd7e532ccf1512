"""Figures of a detector's map: its irradiance, and how well each bin is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Normalize

from photizon_cl.errors import ArgumentError, show
from photizon_cl.views.figures import bins
from photizon_cl.views.figures.style import INK, LABEL, Page, sheet, styled
from photizon_cl.views.figures.words import prefixed, scaled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.maps import IrradianceMap
    from photizon_cl.scene.filters.base import Axis

__all__ = ["draw_irradiance", "draw_relative_sigma"]


@styled
def draw_irradiance(result: Estimates, element: str) -> Figure:
    """Draw a detector's irradiance map.

    Every bin has the colour of its own value. Bins with fewer than 10 arrivals are hatched instead;
    bins without any area stay white.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a map.

    Returns
    -------
    matplotlib.figure.Figure
        Irradiance in W/m² (ticks with an SI prefix) over u and v, or over φ and cos θ.

    Raises
    ------
    ArgumentError
        Where the scene has no such map.
    """
    m = _map(result, element)
    page, axes, beside, x, y = _frame(result, element, m, f"irradiance on {element}")
    shown = np.ma.masked_array(m.irradiance, mask=m.hatched | m.masked)
    amounts(axes, beside, x, y, shown, m.hatched, "irradiance", "W/m²")
    _rims(axes, m, x[-1] / m.x_edges[-1])
    return page.figure


@styled
def draw_relative_sigma(result: Estimates, element: str) -> Figure:
    """Draw the relative standard error of each bin of a detector's map.

    Bins without a value, and every bin after a single batch, are grey. Bins with fewer than 10
    arrivals are hatched: their σ is itself unreliable.

    Parameters
    ----------
    result : Result
        The result.
    element : str
        Name of the element whose detector has a map.

    Returns
    -------
    matplotlib.figure.Figure
        σ over the irradiance in percent over u and v, or over φ and cos θ.

    Raises
    ------
    ArgumentError
        Where the scene has no such map.
    """
    m = _map(result, element)
    known = ~m.masked & (m.irradiance > 0.0) & np.isfinite(m.sigma)
    ratio = np.divide(m.sigma, m.irradiance, out=np.full(m.sigma.shape, np.nan), where=known)
    shown = np.ma.masked_array(ratio, mask=~known)
    # A bin with a single arrival has 100 %, which would leave the lit ones in one colour.
    decisive = ratio[known & m.lit] if (known & m.lit).any() else ratio[known]
    top = float(decisive.max(initial=0.0)) or 1.0
    norm = Normalize(0.0, top)
    target = result.info.goal.target
    marked = target is not None and target <= top
    notes = ["mark on the scale: target of the median"] if marked else []
    what = f"relative σ of irradiance on {element}"
    page, axes, beside, x, y = _frame(result, element, m, what, notes)
    # viridis has no grey in it, which the bins without a value have
    drawn = bins.paint(axes, x, y, shown, colormaps["viridis"], norm)
    drawn.set_label("values")
    grey = ~known & ~m.masked
    bins.flat(axes, x, y, grey, bins.GREY, "without a value")
    poor = m.hatched & known
    bins.hatch(axes, x, y, poor)
    patches = [bins.plain_patch(bins.GREY, "no value")] if grey.any() else []
    hatched = [bins.plain_patch("#ffffff", "below 10 rays")] if poor.any() else []
    bins.key(axes, patches, hatched)
    beyond = bool(shown.count()) and float(shown.max()) > top
    bar = bins.colour_bar(drawn, beside, "relative σ in %", "max" if beyond else "neither")
    bar.formatter = scaled(100.0)
    if target is not None and marked:
        bar.ax.axhline(target, color="#ffffff", linewidth=3.0)
        bar.ax.axhline(target, color=INK, linewidth=1.2, label="target of the median")
    if not shown.count():
        bar.set_ticks([])
    _rims(axes, m, x[-1] / m.x_edges[-1])
    return page.figure


def amounts(
    axes: Axes,
    beside: Axes,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    shown: Any,
    hatched: NDArray[np.bool_],
    what: str,
    unit: str,
) -> None:
    """Draw amounts on a colour scale from zero, and the bins with few rays hatched.

    Parameters
    ----------
    axes, beside : Axes
        For the bins and for the colour bar.
    x_edges, y_edges : ndarray
        Edges of the bins as drawn.
    shown : masked ndarray, shape (ny, nx)
        In `unit`; what is masked is not coloured.
    hatched : ndarray, shape (ny, nx), bool
        Bins with fewer than 10 rays.
    what, unit : str
        Name of the quantity and its SI unit.
    """
    top = float(shown.max()) if shown.count() else 0.0
    # From zero: an irradiance is an amount, and a stretched scale makes noise look like structure.
    norm = Normalize(0.0, top or 1.0)
    drawn = bins.paint(axes, x_edges, y_edges, shown, colormaps["viridis"], norm)
    drawn.set_label("values")
    bins.flat(axes, x_edges, y_edges, hatched, bins.HATCHED, "below 10 rays")
    bins.hatch(axes, x_edges, y_edges, hatched)
    if hatched.any():
        bins.key(axes, [], [bins.plain_patch(bins.HATCHED, "below 10 rays")])
    factor, name = prefixed(top, unit)
    bar = bins.colour_bar(drawn, beside, f"{what} in {name}")
    bar.formatter = scaled(factor)
    if top == 0.0:
        bar.set_ticks([])  # nothing is coloured: a scale would be made up


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
    result: Estimates, element: str, m: IrradianceMap, what: str, notes: list[str] | None = None
) -> tuple[Page, Axes, Axes, NDArray[np.float64], NDArray[np.float64]]:
    """Return the page, axes for map and colour bar, and the edges as drawn."""
    across, up = m.bins.x.axis, m.bins.y.axis
    lengths = [axis.edges for axis in (across, up) if axis.units == "m"]
    half = max((float(np.abs(edges).max()) for edges in lengths), default=0.0)
    scale, unit = prefixed(2.0 * half, "m") if lengths else (1.0, "")
    x, y = (_as_drawn(axis, scale) for axis in (across, up))
    metric = len(lengths) == 2
    if metric:
        width, height = bins.size_of(x, y)
        if not bins.to_scale(x, y):
            what += "; axes not to one scale"
    else:
        width, height = 4.85, 3.6
    page = sheet(result, what, bins.body(height), notes, m.lit_fraction)
    axes, beside = bins.bin_axes(page, width, height)
    axes.set_xlabel(_label(across, unit), fontsize=LABEL)
    axes.set_ylabel(_label(up, unit), fontsize=LABEL)
    if metric and width < 2.0:
        axes.locator_params(axis="x", nbins=3)
    if metric and height < 2.0:
        axes.locator_params(axis="y", nbins=3)
        beside.locator_params(axis="y", nbins=4)
    if across.units == "rad":
        axes.set_xticks(np.arange(0, 361, 45))
    return page, axes, beside, x, y


def _as_drawn(axis: Axis, scale: float) -> NDArray[np.float64]:
    """Return edges in a length's unit, in degrees, or as they are."""
    if axis.units == "m":
        return axis.edges * scale
    return np.degrees(axis.edges) if axis.units == "rad" else axis.edges


def _label(axis: Axis, unit: str) -> str:
    unit = {"m": unit, "rad": "degrees"}.get(axis.units, "")
    if not unit:
        return f"{axis.symbol} {axis.about}".strip()
    return f"{axis.symbol} in {unit}" + (f", {axis.about}" if axis.about else "")


def _rims(axes: Axes, m: IrradianceMap, scale: float) -> None:
    """Draw the circles that bound what is mapped over its bins."""
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    for rim in m.bins.rims:
        radius = rim * scale
        axes.plot(
            radius * np.cos(turn), radius * np.sin(turn), color=INK, linewidth=0.8, clip_on=False
        )
