"""Figures of the far field: intensity over all directions, and cuts through planes of φ."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.ticker import MaxNLocator

from photizon_cl.errors import ArgumentError
from photizon_cl.views.figures import bins
from photizon_cl.views.figures.map_plots import amounts, chosen
from photizon_cl.views.figures.scales import colour_norm
from photizon_cl.views.figures.style import (
    BLUE,
    GRID,
    LABEL,
    ORANGE,
    QUIET,
    SMALL,
    WIDTH,
    sheet,
    styled,
    whole,
)
from photizon_cl.views.figures.words import powered, scaled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.far_field import FarFieldResult

__all__ = ["STYLES", "column", "draw_far_field", "draw_far_field_cuts", "far_field_of", "own_sigma"]

STYLES: Final = (
    (BLUE, "-"), (ORANGE, (0, (5, 2))), ("#009e73", (0, (1, 1))), ("#cc79a7", (0, (5, 1, 1, 1))),
    ("#000000", (0, (8, 3))), ("#8c6d00", (0, (3, 1))),
)  # fmt: skip
_THICK: Final = 1.5
_THIN: Final = 0.5


@styled
def draw_far_field(
    result: Estimates,
    *,
    norm: str | Normalize | None = None,
    vmin: float | None = None,
    vmax: float | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw the intensity of what escaped over φ and cos θ, or over φ and θ.

    In cos θ all bins have the same solid angle, so that equal areas on paper are equal solid
    angles. Bins with fewer than 10 rays are hatched. Where there are more bins than dots on paper,
    every dot has the colour of the highest bin in it, which is said.

    Parameters
    ----------
    result : Result
        The result.
    norm : {"linear", "log"} or matplotlib.colors.Normalize, optional
        Scale of the colours; by default linear, or logarithmic where half of the bins are below 5 %
        of the highest, which is said.
    vmin, vmax : float, optional
        Limits of the scale in W/sr; by default from 0 to the highest bin, on a logarithmic scale
        from the lowest.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into, with their colour bar; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Intensity in W/sr; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no far field, or norm and limits do not go together.
    """
    far = far_field_of(result)
    scale = colour_norm(far.intensity[~far.hatched], norm, vmin, vmax, peaked=True)
    if ax is None:
        what = "far field: intensity of what escaped"
        notes = bins.said(far.count.shape) + chosen(scale, norm)
        page = sheet(result, what, bins.body(3.6), notes, far.count, own_sigma(far))
        panel = bins.bin_axes(page, 4.85, 3.6)
    else:
        panel = bins.own_axes(ax, False)
    shown = np.ma.masked_array(far.intensity, mask=far.hatched)
    phi = np.degrees(far.phi_edges)
    u, v, axis = far.axis_words
    u, v = u.removeprefix("world "), v.removeprefix("world ")
    rows = np.degrees(far.theta_edges) if far.by_theta else far.mu_edges
    said = f"θ in degrees, from {axis}" if far.by_theta else f"μ = cos θ, from {axis}"
    amounts(panel, phi, rows, shown, far.hatched, "intensity", "W/sr", scale)
    panel.label(f"φ in degrees, from {u} towards {v}", said)
    panel.axes.set_xticks(np.arange(0, 361, 45 if ax is None else 90))
    return whole(panel.axes)


def own_sigma(far: FarFieldResult) -> tuple[str, float | None]:
    """Return the far field's own σ: that of the run is about other quantities."""
    return "median relative σ of the far field's lit bins", far.median_sigma


@styled
def draw_far_field_cuts(result: Estimates, planes: Sequence[float] = (0.0, 90.0)) -> Figure:
    """Draw polar cuts through the far field, with bands of ±σ.

    A cut holds the bins around the half plane φ on its right and those around φ + 180° on its
    left; each bin is an arc from edge to edge in θ at its own value. Thin arcs are bins with fewer
    than 10 rays.

    Parameters
    ----------
    result : Result
        The result.
    planes : sequence of float
        φ of each cut's right half in degrees; one to six. A plane on an edge shows the bins above
        that edge.

    Returns
    -------
    matplotlib.figure.Figure
        Intensity in W/sr (ticks with an SI prefix) along the radius, θ from the axis around.

    Raises
    ------
    ArgumentError
        Where the scene has no far field, or `planes` are none, too many or not finite.
    """
    far = far_field_of(result)
    if not 1 <= len(planes) <= len(STYLES) or not all(math.isfinite(p) for p in planes):
        raise ArgumentError(
            f"planes: found {list(planes)}, expected one to {len(STYLES)} finite angles in degrees"
        )
    columns = [column(far, phi) for plane in planes for phi in (plane, plane + 180.0)]
    what = "far field: cuts through the intensity of what escaped"
    page = sheet(result, what, 4.7, None, far.count[:, columns], own_sigma(far))
    side = 4.2
    axes: Any = page.figure.add_axes(
        page.place(0.45, 0.5 * (page.body - side), side, side), projection="polar"
    )
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    top = 0.0
    for plane, (colour, line) in zip(planes, STYLES, strict=False):
        for half in (0, 1):
            k = column(far, plane + 180.0 * half)
            label = "" if half else _said(far, plane)
            top = max(top, _draw_half(axes, far, k, bool(half), colour, line, label))
    axes.set_ylim(0.0, 1.06 * top or 1.0)
    factor, unit = powered(top, "W/sr")
    axes.yaxis.set_major_formatter(scaled(factor))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    if top == 0.0:
        axes.set_yticks([])
    degrees = np.arange(0, 360, 30)
    axes.set_thetagrids(degrees, [f"{min(d, 360 - d)}°" for d in degrees])
    axes.set_rlabel_position(_free_angle(far, columns))
    axes.tick_params(labelsize=SMALL)
    axes.grid(color=GRID, linewidth=0.6)
    for text in axes.get_yticklabels():
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8})
    legend = page.figure.legend(
        loc="upper left", fontsize=SMALL, frameon=False, title=f"radius: intensity\nin {unit}",
        title_fontsize=LABEL, alignment="left", handlelength=2.0, labelspacing=0.9,
        bbox_to_anchor=((0.45 + side + 0.42) / WIDTH, axes.get_position().y1),
    )  # fmt: skip
    legend.set_in_layout(False)
    left = (0.45 + side + 0.46) / WIDTH
    says = "band: ±σ" if result.batches > 1 else "no band: σ unknown\nfrom a single batch"
    says += f"\nthin: below 10 rays\nangle: θ from {far.axis_words[2]}"
    page.figure.text(
        left, axes.get_position().y0, says, fontsize=SMALL, color=QUIET, linespacing=1.4
    )
    return page.figure


def far_field_of(result: Estimates) -> FarFieldResult:
    """Return the far field of a result that has one."""
    if result.far_field is None:
        raise ArgumentError("the scene has no far field: add a [far_field] table to it")
    return result.far_field


def column(far: FarFieldResult, phi: float) -> int:
    """Return the number of the bins in φ that hold an angle in degrees."""
    n: int = far.count.shape[1]
    return int(phi % 360.0 / 360.0 * n) % n


def _free_angle(far: FarFieldResult, columns: list[int]) -> float:
    """Return the θ in degrees at which the radius is labelled: where the cuts on the right end."""
    theta = np.degrees(far.theta_edges)
    low, high = np.minimum(theta[1:], theta[:-1]), np.maximum(theta[1:], theta[:-1])
    outermost = far.intensity[:, columns[::2]].max(axis=1)

    def reach(angle: float) -> float:
        near = (low <= angle + 12.0) & (high >= angle - 12.0)
        return float(outermost[near].max(initial=0.0))

    # between the spokes, and beside the horizontal where nothing speaks for another place
    return min((105.0, 75.0, 135.0, 45.0, 165.0, 15.0), key=reach)


def _said(far: FarFieldResult, plane: float) -> str:
    """Return what a cut's right and left halves show."""
    n = far.count.shape[1]
    sides = []
    for where, phi in (("right", plane), ("left", plane + 180.0)):
        k = column(far, phi)
        low, high = 360.0 * k / n, 360.0 * (k + 1) / n
        sides.append(f"{where}: φ = {low:.5g}°–{high:.5g}°")
    return "\n".join(sides)


def _draw_half(
    axes: Any, far: FarFieldResult, k: int, left: bool, colour: str, line: Any, label: str
) -> float:
    """Draw one column of bins as arcs, and return how far out it reaches in W/sr."""
    values, sigma, few = far.intensity[:, k], far.sigma[:, k], far.hatched[:, k]
    theta = far.theta_edges
    angle = 2.0 * np.pi - theta if left else theta
    arcs = [_arc(angle[j], angle[j + 1]) for j in range(len(values))]
    every = np.concatenate(arcs)
    each = [len(arc) for arc in arcs]
    radius = np.repeat(values, each)
    if np.isfinite(sigma).all():
        low, high = np.maximum(values - sigma, 0.0), values + sigma
        axes.fill_between(
            every, np.repeat(low, each), np.repeat(high, each), color=colour, alpha=0.22,
            linewidth=0.0, zorder=2.0,
        )  # fmt: skip
    else:
        high = values
    # The whole outline thin, and over it the bins that carry 10 rays in full strength.
    axes.plot(every, radius, color=colour, linewidth=_THIN, zorder=2.5)
    thick = np.where(np.repeat(few, each), np.nan, radius)
    axes.plot(
        every, thick, color=colour, linewidth=_THICK, linestyle=line, zorder=3.0,
        label=label or "_left",
    )  # fmt: skip
    return float(high.max())


def _arc(begin: float, end: float) -> NDArray[np.float64]:
    """Return angles from edge to edge, close enough to be round on paper."""
    return np.linspace(begin, end, 2 + int(abs(end - begin) / math.radians(1.0)))
