"""A scene drawn: three sections and a view in space, with traced rays.

Solid lines are where the plane through the scene's centre cuts an element; thin grey ones are its
edges seen through. Rays are those of the trace, projected onto the plane of each panel. Colours
are safe for colour-blind readers (M. Okabe and K. Ito, Color Universal Design, 2008).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, PowerNorm
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
    Line3DCollection,
    Poly3DCollection,
)

from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.result.paths import Paths
from photizon_cl.views.drawing.view import (
    FAINTEST,
    Box,
    ShownRays,
    bounding_box,
    no_rays,
    shown_rays,
)
from photizon_cl.views.shown import ShownFigure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene

__all__ = ["draw_scene", "draw_section", "legend_handles", "ray_colours"]

_INK: Final = "#222222"
_QUIET: Final = "#5f5f5f"
_FAINT: Final = "#b5b5b5"
_SOURCE: Final = "#e69f00"
_DETECTOR: Final = "#d55e00"
_RAYS: Final = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.86, 256)))
_MOST_SHADES: Final = 12
_MOST_FACETS: Final = 20000
_LONG: Final = 4.5
"""Proportions of a panel beyond which its two axes get scales of their own."""
_NAMES: Final = "xyz"


def draw_scene(found: Paths | Scene, by: str = "generation") -> Figure:
    """Draw a scene with paths through it.

    Parameters
    ----------
    found : Paths or Scene
        What `photizon_cl.paths` returned; a scene is drawn without rays.
    by : str
        What colours the rays: ``"generation"`` or ``"weight"``.
    """
    scene = found.scene if isinstance(found, Paths) else found
    box = bounding_box(scene)
    rays = shown_rays(found, box) if isinstance(found, Paths) else no_rays()
    colours, bar, label = ray_colours(rays, by)
    # A long scene lies on its side, as on an optical bench.
    lying = bool(box.extent[2] > 1.3 * max(box.extent[0], box.extent[1]))
    ratio = max(box.extent[0], box.extent[1]) / box.extent[2] if lying else 1.0
    height = float(np.clip(2.6 + 11.0 * ratio, 7.4, 9.6))
    figure = ShownFigure(figsize=(11.0, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    views = [(2, 0), (2, 1), (0, 1)] if lying else [(0, 2), (1, 2), (0, 1)]
    places = [(0, 0), (1, 0), (0, 1)]
    grid = figure.add_gridspec(2, 2, width_ratios=[1.25, 1.0] if lying else [1.0, 1.0])
    for (h, v), (row, column) in zip(views, places, strict=True):
        axes = figure.add_subplot(grid[row, column])
        draw_section(axes, scene, box, rays, colours, h, v)
    space = figure.add_subplot(grid[1, 1], projection="3d")
    _draw_space(space, scene, box, rays, colours, lying)
    if bar is not None:
        made = figure.colorbar(
            bar, ax=figure.axes, location="bottom", shrink=0.45, aspect=45, pad=0.02
        )
        made.set_label(label, fontsize=9)
        made.ax.tick_params(labelsize=8)
        if isinstance(bar.norm, BoundaryNorm):
            made.set_ticks(list(range(int(bar.norm.vmax or 0) + 1)))
        made.ax.minorticks_off()
    title = _plain(scene.heading)
    # Strips for title, legend and notes are set aside by hand, so that none is in another's way.
    figure.get_layout_engine().set(rect=(0.0, 0.32 / height, 1.0, 1.0 - 1.0 / height), h_pad=0.09)  # type: ignore[call-arg,union-attr]
    figure.text(0.01, 1.0 - 0.13 / height, title, fontsize=13, weight="bold", color=_INK, va="top")
    legend = figure.legend(
        handles=legend_handles(scene), loc="upper left",
        bbox_to_anchor=(0.005, 1.0 - 0.36 / height),
        ncols=7, fontsize=8.5, frameon=False, borderaxespad=0.0, handlelength=1.6,
        columnspacing=1.6,
    )  # fmt: skip
    legend.set_in_layout(False)
    notes = ["no rays drawn"]
    if isinstance(found, Paths):
        run = scene.run
        notes = [f"{run.rays_per_batch} rays, seed {run.seed}, projected on each panel"]
        notes += _cut_short(found)
    if not label and isinstance(found, Paths):
        notes.append("no ray meets more than one surface")
    if rays.faint:
        notes.append(f"{rays.faint} segments of weight below {FAINTEST:g} are not drawn")
    figure.text(0.01, 0.1 / height, _plain("  ·  ".join(notes)), fontsize=8, color=_QUIET)
    return figure


def _cut_short(found: Paths) -> list[str]:
    """Return what a reader must know: a capped part too small to be drawn is left out."""
    small = found.ledger["depth-capped"] < FAINTEST * found.unit_power
    return found.advisories[:-1] if small and found.ledger["depth-capped"] else found.advisories


def _plain(text: str) -> str:
    """Return text that matplotlib shows as it is, dollar signs included."""
    return text.replace("\\", "\\\\").replace("$", r"\$")


# -- colours -------------------------------------------------------------------------------------


def ray_colours(rays: ShownRays, by: str) -> tuple[NDArray[np.float64], ScalarMappable | None, str]:
    """Return a colour for each segment, what the colour bar shows, and its label."""
    norm: Any
    if not len(rays.weight):
        return np.empty((0, 4)), None, ""
    if by == "weight":
        low = max(float(rays.weight.min()), FAINTEST)
        norm, values = LogNorm(min(low, 0.5), 1.0), np.clip(rays.weight, low, None)
        label = "weight, relative to the heaviest launched ray"
    else:
        most = int(rays.generation.max())
        label = "generation: surface interactions so far"
        values = rays.generation.astype(np.float64)
        if most < _MOST_SHADES:
            norm = BoundaryNorm(np.arange(-0.5, most + 1.5), 256)
        else:
            norm = PowerNorm(0.5, 0.0, most)
    colours = np.array(_RAYS(norm(values)))
    # Less power is fainter; many rays together are fainter, so that they do not hide each other.
    share = 1.0 + np.log10(np.clip(rays.weight, FAINTEST, 1.0)) / 6.5
    crowd = min(1.0, (400.0 / len(rays.weight)) ** 0.35)
    colours[:, 3] = np.clip(0.9 * crowd * share, 0.06, 0.9)
    if np.ptp(values) == 0.0:  # one colour needs no scale
        colours[:, :3] = _RAYS(0.0)[:3]
        return colours, None, "weight" if by == "weight" else ""
    return colours, ScalarMappable(norm, _RAYS), label


def _colour(element: Element) -> str:
    return _DETECTOR if element.detector is not None else element.surface.colour


def legend_handles(scene: Scene) -> list[Line2D]:
    """Return what a legend of the scene shows, each kind of surface once."""
    seen: dict[str, Line2D] = {}
    for element in scene.element:
        label = "detector" if element.detector is not None else element.surface.label_text
        if label not in seen:
            seen[label] = Line2D([], [], color=_colour(element), linewidth=2.4, label=label)
    handles = list(seen.values())
    handles.append(
        Line2D(
            [], [], color=_SOURCE, marker="o", markersize=6, markeredgecolor=_INK,
            markeredgewidth=0.6, linewidth=2.4, label="source",
        )
    )  # fmt: skip
    if scene.element:
        handles.append(Line2D([], [], color=_FAINT, linewidth=0.9, label="edges, seen through"))
    return handles


# -- sections ------------------------------------------------------------------------------------


def draw_section(
    axes: Axes,
    scene: Scene,
    box: Box,
    rays: ShownRays,
    colours: NDArray[np.float64],
    h: int,
    v: int,
) -> None:
    """Draw the section whose panel has world axis h to the right and v up."""
    across, scale = 3 - h - v, box.scale
    pair = [h, v]
    rim = [line[:, pair] * scale for element in scene.element for line in edges(element)]
    axes.add_collection(LineCollection(rim, colors=_FAINT, linewidths=0.6, zorder=1.0))
    ends = np.stack([rays.start[:, pair], rays.end[:, pair]], axis=1) * scale
    axes.add_collection(LineCollection(list(ends), colors=colours, linewidths=0.8, zorder=2.0))
    for element in scene.element:
        colour = _colour(element)
        for line in cut(element, across, float(box.centre[across])):
            x, y = line[:, h] * scale, line[:, v] * scale
            if element.surface.refracts and len(line) > 2:
                axes.fill(x, y, color=colour, alpha=0.22, linewidth=0.0, zorder=1.5)
            axes.plot(x, y, color=colour, linewidth=2.2, solid_capstyle="butt", zorder=3.0)
        if element.detector is not None and element.flat:
            sign = 1.0 if element.detector_plus else -1.0
            du, dv, dw = (sign * d for d in element.frame[2])
            _arrow(axes, box, element.position, (du, dv, dw), h, v, _DETECTOR, 0.05)
    for source in scene.source:
        _draw_source(axes, box, source, h, v)
    axes.set_xlim(box.low[h] * scale, box.high[h] * scale)
    axes.set_ylim(box.low[v] * scale, box.high[v] * scale)
    axes.set_xlabel(f"{_NAMES[h]} in {box.unit}", fontsize=9)
    axes.set_ylabel(f"{_NAMES[v]} in {box.unit}", fontsize=9)
    axes.tick_params(labelsize=8)
    at = box.centre[across] * scale
    title = f"{_NAMES[min(h, v)]}{_NAMES[max(h, v)]} section at {_NAMES[across]} = {at:.4g}"
    title = title.replace("-", "−") + f" {box.unit}"
    ratio = float(box.extent[h] / box.extent[v])
    if max(ratio, 1.0 / ratio) <= _LONG:
        axes.set_aspect("equal", anchor="W")
    else:
        title += ", not to one scale"
    axes.set_title(title, fontsize=9.5, loc="left", color=_INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_source(axes: Axes, box: Box, source: Any, h: int, v: int) -> None:
    for outline in source.outline():
        style: dict[str, Any] = {"linewidth": 2.0}
        if len(outline) == 1:
            style = {"marker": "o", "markersize": 6, "markeredgecolor": _INK,
                     "markeredgewidth": 0.6}  # fmt: skip
        x, y = outline[:, h] * box.scale, outline[:, v] * box.scale
        axes.plot(x, y, color=_SOURCE, zorder=4.0, **style)
    if source.directed:
        _arrow(axes, box, source.position, source.frame[2], h, v, _SOURCE, 0.09)


def _arrow(
    axes: Axes,
    box: Box,
    position: Sequence[float],
    direction: tuple[float, float, float],
    h: int,
    v: int,
    colour: str,
    length: float,
) -> None:
    """Draw where a source shines or a detector looks, unless that is across the panel.

    It has the direction of a ray in the panel, and at most a part `length` of its width and height.
    """
    seen = np.array([direction[h], direction[v]])
    along = float(np.hypot(*seen))
    if along < 0.1:
        return
    largest = np.max(np.abs(seen) / np.array([box.extent[h], box.extent[v]]))
    reach = seen * (length * along / largest)
    start = np.array([position[h], position[v]]) * box.scale
    axes.annotate(
        "", xy=tuple(start + reach * box.scale), xytext=tuple(start), zorder=5.0,
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.4, "shrinkA": 0.0,
                    "shrinkB": 0.0, "mutation_scale": 11.0},
    )  # fmt: skip


# -- in space ------------------------------------------------------------------------------------


def _draw_space(
    axes: Any,
    scene: Scene,
    box: Box,
    rays: ShownRays,
    colours: NDArray[np.float64],
    lying: bool,
) -> None:
    scale = box.scale
    for element in scene.element:
        colour = _colour(element)
        polygons = facets(element) if len(scene.element) < _MOST_FACETS // 576 else []
        if polygons:
            axes.add_collection3d(
                Poly3DCollection(
                    [p * scale for p in polygons], facecolor=colour, alpha=0.07, linewidth=0.0
                ),
                autolim=False,  # the limits are set below; matplotlib's would read past polygons
            )
        lines = [line * scale for line in edges(element)]
        rims = Line3DCollection(lines, colors=colour, linewidths=0.7, alpha=0.55)
        axes.add_collection3d(rims, autolim=False)
    ends = np.stack([rays.start, rays.end], axis=1) * scale
    if len(ends):
        axes.add_collection3d(Line3DCollection(ends, colors=colours, linewidths=0.6), autolim=False)
    for source in scene.source:
        for outline in source.outline():
            style = "-" if len(outline) > 1 else "o"
            axes.plot(*(outline * scale).T, style, color=_SOURCE, linewidth=1.8, markersize=5)
    for axis, name in enumerate(_NAMES):
        limits = (box.low[axis] * scale, box.high[axis] * scale)
        getattr(axes, f"set_{name}lim")(*limits)
        getattr(axes, f"set_{name}label")(f"{name} in {box.unit}", fontsize=9, labelpad=3)
        getattr(axes, f"{name}axis").set_major_locator(_few_ticks())
        getattr(axes, f"{name}axis").set_pane_color((1.0, 1.0, 1.0, 0.0))
        getattr(axes, f"{name}axis")._axinfo["grid"].update(color="#e4e4e4", linewidth=0.5)
    axes.tick_params(labelsize=7.5, pad=0)
    aspect = np.maximum(box.extent / box.extent.max(), 1.0 / _LONG)
    if lying:
        axes.view_init(elev=20.0, azim=-62.0, vertical_axis="x")
    else:
        axes.view_init(elev=22.0, azim=-56.0)
    axes.set_box_aspect(aspect, zoom=1.12 if lying else 0.95)


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4, steps=[1, 2, 2.5, 5, 10])
