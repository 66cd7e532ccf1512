"""Figure of the far field over θ, whose intensity spans decades: on a logarithmic axis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.errors import ArgumentError
from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.views.figures.far_field_plots import STYLES, column, far_field_of, own_sigma
from photizon_cl.views.figures.scales import log_ticks
from photizon_cl.views.figures.style import GRID, LABEL, QUIET, SMALL, sheet, styled, whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.far_field import FarFieldResult

__all__ = ["draw_far_field_theta"]

_PLANES: Final = (0.0, 90.0, 180.0, 270.0)
_UNEVEN: Final = 8.0
"""From so many times the narrowest bin on, the widest one calls for a logarithmic θ."""
_DEEPEST: Final = 1e-18
"""Below this part of the highest value nothing is shown: it would flatten the rest."""
_MOST_BARS: Final = 200


@styled
def draw_far_field_theta(
    result: Estimates, planes: Sequence[float] | None = None, *, ax: Axes | None = None
) -> Figure:
    """Draw the intensity of what escaped over θ on a logarithmic axis, with ±σ.

    Each bin is a dot in its middle with a bar across its width, open where it has fewer than 10
    rays; bins without rays have none. Where widths differ much, θ is logarithmic as well, and a bin
    that begins at 0 is drawn from half of its other edge.

    Parameters
    ----------
    result : Result
        The result.
    planes : sequence of float, optional
        φ in degrees of the columns to draw, one to six; by default all where they are six at most,
        else those around 0°, 90°, 180° and 270°.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; by default a page with title and footer.

    Returns
    -------
    matplotlib.figure.Figure
        Intensity in W/sr over θ in degrees; that of `ax` where one is given.

    Raises
    ------
    ArgumentError
        Where the scene has no far field, or `planes` are none, too many or not finite.
    """
    far = far_field_of(result)
    columns = _columns(far, planes)
    if ax is not None:
        _draw(ax, far, columns)
        return whole(ax)
    counts = far.count[:, columns]
    notes = ["dots with ±σ" if result.batches > 1 else "no σ from a single batch"]
    notes[0] += " · bars across: from edge to edge in θ"
    dark = int(np.count_nonzero(counts == 0))
    if dark:
        bins = "1 bin" if dark == 1 else f"{dark:,} bins"
        notes[0] += f" · {bins} without rays not shown"
    what = "far field: intensity of what escaped over the angle from the axis"
    page = sheet(result, what, 3.6, notes, counts, own_sigma(far))
    page.arrange()
    _draw(page.figure.add_subplot(), far, columns)
    return page.figure


def _columns(far: FarFieldResult, planes: Sequence[float] | None) -> list[int]:
    most = len(STYLES)
    if planes is None:
        n = far.count.shape[1]
        if n <= most:
            return list(range(n))
        planes = _PLANES
    if not 1 <= len(planes) <= most or not all(np.isfinite(phi) for phi in planes):
        raise ArgumentError(
            f"planes: found {list(planes)}, expected one to {most} finite angles in degrees"
        )
    return list(dict.fromkeys(column(far, phi) for phi in planes))


def _edges(far: FarFieldResult) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Return where rows begin and end in degrees as drawn, and whether θ is logarithmic."""
    edges = np.degrees(far.theta_edges)
    low, high = np.minimum(edges[:-1], edges[1:]), np.maximum(edges[:-1], edges[1:])
    uneven = far.by_theta and (high - low).max() >= _UNEVEN * (high - low).min()
    return (np.where(low == 0.0, 0.5 * high, low) if uneven else low), high, bool(uneven)


def _draw(axes: Axes, far: FarFieldResult, columns: list[int]) -> None:
    low, high, log = _edges(far)
    middle = np.sqrt(low * high) if log else 0.5 * (low + high)
    across = np.stack([middle - low, high - middle])
    values = far.intensity[:, columns]
    top = float(values.max())
    shown = values[(values > 0.0) & (values >= _DEEPEST * top)]
    known = bool(np.isfinite(far.sigma).all())
    axes.set_yscale("log")
    if log:
        axes.set_xscale("log")
        axes.set_xlim(0.93 * low.min(), 1.07 * high.max())
    else:
        spare = 0.02 * (high.max() - low.min())
        axes.set_xlim(low.min() - spare, high.max() + spare)
    # at least half a decade, so that noise between like values does not look like structure
    floor = 0.7 * min(float(shown.min()), 0.4 * top) if shown.size else 0.1
    roof = 1.5 * top if shown.size else 1.0
    axes.set_ylim(floor, roof)
    marked = bool((far.count[:, columns] < LIT_COUNT).any() and shown.size)
    size = 4.5 if len(middle) <= _MOST_BARS else 2.0
    for k, (colour, _) in zip(columns, STYLES, strict=False):
        label = _said(far, k) if far.count.shape[1] > 1 else ""
        for few in (False, True):
            some = (far.intensity[:, k] > 0.0) & (far.hatched[:, k] == few)
            if not some.any():
                continue
            axes.errorbar(
                middle[some], far.intensity[some, k],
                xerr=across[:, some] if len(middle) <= _MOST_BARS else None,
                yerr=far.sigma[some, k] if known else None,
                fmt="o", markersize=size, color=colour, elinewidth=1.0, capsize=0.0,
                markerfacecolor="white" if few else colour, markeredgewidth=1.1, zorder=3.0,
                label="_few" if few else label or "_bins",
            )  # fmt: skip
    if not shown.size:
        axes.text(
            0.5, 0.5, "no ray reached any bin", transform=axes.transAxes, ha="center",
            fontsize=LABEL, color=QUIET,
        )  # fmt: skip
    axes.set_xlabel(f"θ in degrees, from {far.axis_words[2]}", fontsize=LABEL)
    axes.set_ylabel("intensity in W/sr", fontsize=LABEL)
    log_ticks(axes.yaxis, floor, roof)
    if log:
        log_ticks(axes.xaxis, *axes.get_xlim())
    axes.tick_params(labelsize=SMALL)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    _key(axes, marked)


def _key(axes: Axes, marked: bool) -> None:
    """Say what colours and open dots mean, above the plot."""
    handles, labels = axes.get_legend_handles_labels()
    if marked:
        (mark,) = axes.plot(
            [], [], linestyle="none", marker="o", markersize=4.5, color=QUIET,
            markerfacecolor="white", markeredgewidth=1.1,
        )  # fmt: skip
        handles, labels = [*handles, mark], [*labels, "below 10 rays"]
    if handles:
        axes.legend(
            handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=SMALL,
            frameon=False, borderaxespad=0.2, ncols=4, columnspacing=1.2, handletextpad=0.4,
        )  # fmt: skip


def _said(far: FarFieldResult, k: int) -> str:
    low, high = np.degrees(far.phi_edges[k : k + 2])
    return f"φ = {low:.5g}°–{high:.5g}°"
