"""Bins drawn as they are: one flat colour each, hatched where fewer than 10 rays arrived."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.legend_handler import HandlerPatch
from matplotlib.patches import Patch

from photizon_cl.views.figures.style import INK, LABEL, QUIET, SMALL, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from numpy.typing import NDArray

    from photizon_cl.views.figures.style import Page

__all__ = [
    "GREY",
    "HATCHED",
    "Panel",
    "bin_axes",
    "colour_bar",
    "dots",
    "hatch",
    "key",
    "own_axes",
    "paint",
    "plain_patch",
    "said",
]

HATCHED: Final = "#e9e9e9"
GREY: Final = "#bdbdbd"
_LEFT: Final = 0.85
_ACROSS: Final = 4.85
_BAR: Final = 0.17
_BELOW: Final = 0.48
_ABOVE: Final = 0.28
_TALLEST: Final = 6.2
_LONG: Final = 5.0
_MOST_QUADS: Final = 1 << 20
_MOST_DOTS: Final = 1 << 10
_MOST_VECTORS: Final = 1 << 14


def size_of(x_edges: NDArray[np.float64], y_edges: NDArray[np.float64]) -> tuple[float, float]:
    """Return the inches at which a map in metres is drawn to scale, as far as that is possible."""
    ratio = float((y_edges[-1] - y_edges[0]) / (x_edges[-1] - x_edges[0]))
    ratio = min(max(ratio, 1.0 / _LONG), _LONG)
    width = min(_ACROSS, _TALLEST / ratio)
    return width, width * ratio


def to_scale(x_edges: NDArray[np.float64], y_edges: NDArray[np.float64]) -> bool:
    """Say whether a map is drawn with one scale along both axes."""
    ratio = float((y_edges[-1] - y_edges[0]) / (x_edges[-1] - x_edges[0]))
    return 1.0 / _LONG <= ratio <= _LONG


def body(height: float) -> float:
    """Return the inches that a map of a height needs with its labels."""
    return _ABOVE + height + _BELOW


@dataclass(frozen=True, eq=False)
class Panel:
    """Where bins are drawn.

    Parameters
    ----------
    axes : Axes
        For the bins.
    beside : Axes or None
        For the colour bar; None on axes of a reader's own, which give room to it themselves.
    """

    axes: Axes
    beside: Axes | None

    def label(self, x: str, y: str) -> None:
        """Label both axes."""
        self.axes.set_xlabel(x, **self.size(LABEL))
        self.axes.set_ylabel(y, **self.size(LABEL))

    def size(self, points: float) -> dict[str, Any]:
        """Return a text's size on a page; on a reader's own axes, sizes are those of matplotlib."""
        return {"fontsize": points} if self.beside is not None else {}


def bin_axes(page: Page, width: float, height: float) -> Panel:
    """Return axes for a map of so many inches, and beside it axes for its colour bar."""
    # Placed by hand: an automatic layout makes the bar as tall as the room, not as the map.
    spare = page.body - body(height)
    bottom = _BELOW + spare
    left = _LEFT + 0.5 * (_ACROSS - width)
    axes = page.figure.add_axes(page.place(left, bottom, width, height))
    beside = page.place(left + width + 0.13, bottom, _BAR, height)
    bar = page.figure.add_axes(beside)
    axes.tick_params(labelsize=SMALL)
    return Panel(axes, bar)


def own_axes(axes: Axes, to_one_scale: bool) -> Panel:
    """Return a reader's own axes, with the proportions of what is mapped where it has any."""
    if to_one_scale:
        axes.set_aspect("equal")
        axes.apply_aspect()
    return Panel(axes, None)


def paint(
    axes: Axes,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    values: Any,
    colours: Any,
    norm: Normalize,
) -> Any:
    """Draw bins of a masked array, each with the colour of its own value and no other's.

    Of more bins than there are dots on paper each dot has the highest of its block, see `dots`;
    `said` tells that to the reader.
    """
    if (len(x_edges) - 1) * (len(y_edges) - 1) > _MOST_QUADS:
        # As a picture: four numbers a corner would not fit into memory.
        values = dots(values)
        extent = (x_edges[0], x_edges[-1], y_edges[0], y_edges[-1])
        drawn: Any = axes.imshow(
            values, cmap=colours, norm=norm, extent=extent, origin="lower", aspect="auto",
            interpolation="nearest",
        )  # fmt: skip
    else:
        drawn = axes.pcolormesh(
            x_edges, y_edges, values, cmap=colours, norm=norm, rasterized=True, shading="flat"
        )
    axes.set_xlim(x_edges[0], x_edges[-1])
    axes.set_ylim(y_edges[0], y_edges[-1])
    return drawn


def _starts(n: int) -> NDArray[np.int64]:
    """Return where the blocks of n bins begin that are a dot each, and where the last one ends."""
    m = min(n, _MOST_DOTS)
    return np.arange(m + 1, dtype=np.int64) * n // m


def _many(shape: tuple[int, ...]) -> bool:
    """Say whether there are more bins than are drawn one by one."""
    return math.prod(shape) > _MOST_QUADS and max(shape) > _MOST_DOTS


def dots(values: Any) -> Any:
    """Return what is drawn of an array: of more bins than dots on paper, the highest of each block.

    Not one of them, nor their mean: a single bright bin is what a search for stray light is for. A
    block is masked where all of its bins are; of conditions, it has those that any bin has.

    Parameters
    ----------
    values : ndarray or masked ndarray, shape (ny, nx), float64 or bool
        A number, or a condition, of each bin.
    """
    if not _many(np.shape(values)):
        return values
    if np.asarray(values).dtype == bool:
        return _highest(np.asarray(values))
    mask = np.ma.getmaskarray(values)
    # in slabs, so that nothing of the whole map's size is made on the way
    found, none = _highest(np.ma.getdata(values), mask), ~_highest(~mask)
    return np.ma.masked_array(np.where(none, 0.0, found), mask=none)


def _highest(array: NDArray[Any], mask: NDArray[np.bool_] | None = None) -> NDArray[Any]:
    """Return the maxima of blocks of bins that are not masked, −inf where all are."""
    down, across = (_starts(n) for n in array.shape)
    rows = []
    for first, last in pairwise(down):
        slab = array[first:last]
        if mask is not None:
            slab = np.where(mask[first:last], -np.inf, slab)
        rows.append(np.maximum.reduceat(slab.max(axis=0), across[:-1]))
    return np.stack(rows)


def said(shape: tuple[int, ...], what: str = "highest") -> list[str]:
    """Return what the footer says of a map with more bins than dots on paper.

    Parameters
    ----------
    shape : tuple of int
        Of the map.
    what : str, optional
        Which of several bins is drawn.
    """
    if not _many(shape):
        return []
    ny, nx = (math.ceil(n / min(n, _MOST_DOTS)) for n in shape)
    text = (
        f"{shape[1]:,} × {shape[0]:,} bins are more than dots on paper: each dot is the {what} of "
        f"up to {nx} × {ny} of them with 10 rays"
    )
    return [text]


def flat(
    axes: Axes,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    where: NDArray[np.bool_],
    colour: str,
    label: str,
) -> None:
    """Draw some bins in one colour."""
    if where.any():
        only = np.ma.masked_array(np.broadcast_to(1.0, where.shape), mask=~where)
        one = ListedColormap([colour])
        paint(axes, x_edges, y_edges, only, one, Normalize(0.0, 2.0)).set_label(label)


def hatch(
    axes: Axes,
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    where: NDArray[np.bool_],
) -> None:
    """Draw slanted lines over some bins, or `dots` of them, and nowhere else."""
    if where.shape != (len(y_edges) - 1, len(x_edges) - 1):
        x_edges, y_edges = (e[_starts(len(e) - 1)] for e in (x_edges, y_edges))
    figure: Any = axes.figure
    box = axes.get_window_extent()
    dpi = figure.get_dpi() if hasattr(figure, "get_dpi") else figure.dpi
    width, height = box.width / dpi, box.height / dpi
    lines = hatch_lines(x_edges, y_edges, where, width, height)
    if len(lines):
        axes.add_collection(
            LineCollection(
                list(lines), colors=QUIET, linewidths=0.6, capstyle="butt", zorder=1.5,
                label="hatching", rasterized=where.size > _MOST_VECTORS,
            ),
            autolim=False,
        )  # fmt: skip


def hatch_lines(
    x_edges: NDArray[np.float64],
    y_edges: NDArray[np.float64],
    where: NDArray[np.bool_],
    width: float,
    height: float,
) -> NDArray[np.float64]:
    """Return slanted lines cut at the edges of the bins that they belong to.

    Parameters
    ----------
    x_edges, y_edges : ndarray, shapes (nx + 1,) and (ny + 1,)
        Edges of the bins.
    where : ndarray, shape (ny, nx), bool
        Bins to hatch.
    width, height : float
        Of the drawing in inches, on which the lines rise by 45°.

    Returns
    -------
    ndarray, shape (n, 2, 2), float64
        Ends, in the edges' coordinates.
    """
    ny, nx = where.shape
    # Far enough apart to be seen as lines, close enough that one crosses every bin of some size.
    apart = float(np.clip(min(width / nx, height / ny), 0.05, 0.09)) * math.sqrt(2.0)
    x = (x_edges - x_edges[0]) * (width / (x_edges[-1] - x_edges[0]))
    y = (y_edges - y_edges[0]) * (height / (y_edges[-1] - y_edges[0]))
    pieces = []
    for k in range(math.ceil(-width / apart), math.floor(height / apart) + 1):
        above = (k + 0.5) * apart  # half a step off, so that none runs along a corner
        first, last = max(0.0, -above), min(width, height - above)
        if last <= first:
            continue
        cuts = np.concatenate([[first, last], x, y - above])
        cuts = np.unique(cuts[(cuts >= first) & (cuts <= last)])
        middle = 0.5 * (cuts[1:] + cuts[:-1])
        i = np.clip(np.searchsorted(x, middle, "right") - 1, 0, nx - 1)
        j = np.clip(np.searchsorted(y, middle + above, "right") - 1, 0, ny - 1)
        inside = np.concatenate([[False], where[j, i], [False]])
        ends = np.flatnonzero(inside[1:] != inside[:-1])
        begin, end = cuts[ends[::2]], cuts[ends[1::2]]
        # Below half a point nothing can be seen; millions of them would only make files large.
        seen = end - begin > 0.005
        begin, end = begin[seen], end[seen]
        points = [np.stack([begin, begin + above], 1), np.stack([end, end + above], 1)]
        pieces.append(np.stack(points, 1))
    found = np.concatenate(pieces) if pieces else np.empty((0, 2, 2))
    size = np.array([x_edges[-1] - x_edges[0], y_edges[-1] - y_edges[0]])
    return np.asarray(np.array([x_edges[0], y_edges[0]]) + found / [width, height] * size)


def colour_bar(drawn: Any, panel: Panel, label: str, extend: str = "neither") -> Colorbar:
    """Draw a colour bar into its axes, or beside a reader's own."""
    figure: Any = panel.axes.figure
    place = {"ax": panel.axes} if panel.beside is None else {"cax": panel.beside}
    bar: Colorbar = figure.colorbar(drawn, extend=extend, **place)
    bar.set_label(label, **panel.size(LABEL))
    if panel.beside is not None:
        bar.ax.tick_params(labelsize=SMALL)
    return bar


class _HatchedKey(HandlerPatch):
    """A legend's patch with the slanted lines that the bins have."""

    def create_artists(self, legend: Any, orig_handle: Any, *where: Any) -> Any:
        """Return the patch and the lines over it."""
        from matplotlib.lines import Line2D

        x, y, width, height, _, transform = where
        patch = super().create_artists(legend, orig_handle, *where)
        lines = [
            Line2D(
                [start - x, start - x + height], [-y, height - y], color=QUIET, linewidth=0.6,
                transform=transform,
            )
            for start in np.linspace(0.0, width - height, 3)
        ]  # fmt: skip
        return [*patch, *lines]


def plain_patch(colour: str, label: str) -> Patch:
    """Return a legend's patch in one colour."""
    return Patch(facecolor=colour, edgecolor=QUIET, linewidth=0.4, label=label)


def key(panel: Panel, patches: list[Patch], hatched: list[Patch]) -> None:
    """Say above the upper right corner what bins without a colour of the scale mean."""
    if not patches and not hatched:
        return
    axes = panel.axes
    figure: Any = axes.figure
    how: dict[str, Any] = {
        "handles": [*hatched, *patches], "loc": "lower right", "frameon": False,
        "handler_map": {patch: _HatchedKey() for patch in hatched}, "ncols": 3,
        "borderaxespad": 0.2, "handlelength": 1.8, "columnspacing": 1.2,
    }  # fmt: skip
    if panel.beside is None:
        axes.legend(bbox_to_anchor=(1.0, 1.0), **how)
        return
    box = axes.get_position()
    corner = (min(box.x1, 1.0 - 0.1 / WIDTH), box.y1)
    legend = figure.legend(bbox_to_anchor=corner, fontsize=SMALL, labelcolor=INK, **how)
    legend.set_in_layout(False)
