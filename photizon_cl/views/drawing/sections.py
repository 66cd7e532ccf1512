"""The sections of a scene: what a plane cuts, edges seen through, rays, sources and arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, PowerNorm
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from photizon_cl.geometry.outlines import cut, edges
from photizon_cl.views.drawing.view import FAINTEST, Box, ShownRays

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.model import Scene
    from photizon_cl.views.drawing.panels import Arrangement, Place

__all__ = ["colour_key", "draw_section", "draw_sections", "legend_handles", "ray_colours"]

INK: Final = "#222222"
_FAINT: Final = "#b5b5b5"
SOURCE: Final = "#e69f00"
DETECTOR: Final = "#d55e00"
_RAYS: Final = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.86, 256)))
_MOST_SHADES: Final = 12
NAMES: Final = "xyz"
_TITLE: Final[dict[str, Any]] = {"fontsize": 9.0, "color": INK}


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


def colour_key(figure: Figure, bar: ScalarMappable, label: str, axes: Axes) -> None:
    """Draw the scale of rays' colours into axes that lie; generations are whole numbers."""
    made = figure.colorbar(bar, cax=axes, orientation="horizontal")
    made.set_label(label, fontsize=8)
    made.ax.tick_params(labelsize=8)
    if not isinstance(bar.norm, LogNorm):
        norm: Any = bar.norm
        most = int(norm.vmax or 0)
        # On a scale of roots the ticks of a straight one crowd at the end.
        room = max(int(axes.get_window_extent().width / figure.dpi / 0.4), 2)
        room = room if isinstance(bar.norm, BoundaryNorm) else min(room // 2 + 1, 6)
        ticks = MaxNLocator(room, integer=True).tick_values(0, most)
        made.set_ticks([float(tick) for tick in ticks if tick <= most])
    made.ax.minorticks_off()


def colour_of(element: Element, face: int = 0) -> str:
    """Return the colour of a face of an element."""
    return DETECTOR if element.detector is not None else element.surface_of(face).colour


def legend_handles(scene: Scene) -> list[Line2D]:
    """Return what a legend of the scene shows, each kind of surface once."""
    seen: dict[str, Line2D] = {}
    for element in scene.element:
        for surface in element.surfaces:
            label, colour = surface.label_text, surface.colour
            if element.detector is not None:
                label, colour = "detector", DETECTOR
            if label not in seen:
                seen[label] = Line2D([], [], color=colour, linewidth=2.4, label=label)
    handles = list(seen.values())
    handles.append(
        Line2D(
            [], [], color=SOURCE, marker="o", markersize=6, markeredgecolor=INK,
            markeredgewidth=0.6, linewidth=2.4, label="source",
        )
    )  # fmt: skip
    if scene.element:
        handles.append(Line2D([], [], color=_FAINT, linewidth=0.9, label="edges, seen through"))
    return handles


# -- sections ------------------------------------------------------------------------------------


def draw_sections(
    figure: Figure,
    inches: Callable[[float, float, float, float], Place],
    panels: Arrangement,
    scene: Scene,
    box: Box,
    rays: ShownRays,
    colours: NDArray[np.float64],
) -> None:
    """Draw the three sections of a scene where an arrangement has them.

    `inches` gives a place in parts of the figure from one in inches.
    """
    for (h, v), place in zip(panels.views, panels.places, strict=True):
        axes = figure.add_axes(inches(*place))
        draw_section(axes, scene, box, rays, colours, h, v)
        if panels.to_scale(h, v):
            axes.set_aspect("equal", anchor="NW")
        else:
            said = axes.get_title(loc="left").replace(" section", "") + ", not to scale"
            axes.set_title(said, loc="left", **_TITLE)
        for axis, length, room in ((axes.xaxis, place[2], 0.55), (axes.yaxis, place[3], 0.3)):
            most = min(max(int(length / room), 1), 8)
            steps = [1, 2, 2.5, 5, 10]
            axis.set_major_locator(MaxNLocator(most, steps=steps, min_n_ticks=min(most, 2)))


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
        at = float(box.centre[across])
        several = len(element.surfaces) > 1
        parts = [
            (colour_of(element, n or 0), [line[:, pair] for line in cut(element, across, at, n)])
            for n in (range(len(element.faces)) if several else [None])
        ]
        glass = [s.colour for s in element.surfaces if s.refracts]
        for loop in _loops([line for _, lines in parts for line in lines]) if glass else []:
            x, y = loop.T * scale
            colour = DETECTOR if element.detector is not None else glass[0]
            axes.fill(x, y, color=colour, alpha=0.22, linewidth=0.0, zorder=1.5)
        for colour, lines in parts:
            for line in lines:
                x, y = line.T * scale
                axes.plot(x, y, color=colour, linewidth=2.2, solid_capstyle="butt", zorder=3.0)
        if element.detector is not None and element.flat:
            sign = 1.0 if element.detector_plus else -1.0
            du, dv, dw = (sign * d for d in element.frame[2])
            _arrow(axes, box, element.position, (du, dv, dw), h, v, DETECTOR, 0.2)
    for source in scene.source:
        _draw_source(axes, box, source, h, v)
    axes.set_xlim(box.low[h] * scale, box.high[h] * scale)
    axes.set_ylim(box.low[v] * scale, box.high[v] * scale)
    axes.set_xlabel(f"{NAMES[h]} in {box.unit}", fontsize=9)
    axes.set_ylabel(f"{NAMES[v]} in {box.unit}", fontsize=9)
    axes.tick_params(labelsize=8)
    at = box.centre[across] * scale
    title = f"{NAMES[min(h, v)]}{NAMES[max(h, v)]} section, {NAMES[across]} = {at:.4g}"
    axes.set_title(title.replace("-", "−") + f" {box.unit}", loc="left", **_TITLE)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _loops(lines: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
    """Return the closed curves among polylines that are joined end to end: bodies that are cut."""
    left, found = list(lines), []
    while left:
        chain = left.pop()
        slack = 1e-6 * float(np.ptp(chain, axis=0).max())
        while np.hypot(*(chain[-1] - chain[0])) > slack:
            ends = [(k, line[::way]) for k, line in enumerate(left) for way in (1, -1)]
            nearest = min(ends, key=lambda end: np.hypot(*(end[1][0] - chain[-1])), default=None)
            if nearest is None or np.hypot(*(nearest[1][0] - chain[-1])) > slack:
                break  # a sheet, which has no inside
            chain = np.vstack([chain, nearest[1]])
            left.pop(nearest[0])
        else:
            if len(chain) > 2:
                found.append(chain)
    return found


def _draw_source(axes: Axes, box: Box, source: Any, h: int, v: int) -> None:
    for outline in source.outline():
        style: dict[str, Any] = {"linewidth": 2.0}
        if len(outline) == 1:
            style = {"marker": "o", "markersize": 6, "markeredgecolor": INK,
                     "markeredgewidth": 0.6}  # fmt: skip
        x, y = outline[:, h] * box.scale, outline[:, v] * box.scale
        axes.plot(x, y, color=SOURCE, zorder=4.0, **style)
    if source.directed:
        _arrow(axes, box, source.position, source.frame[2], h, v, SOURCE, 0.34)


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

    It has the direction of a ray in the panel, and is `length` inches long where it lies in it.
    """
    seen = np.array([direction[h], direction[v]])
    along = float(np.hypot(*seen))
    if along < 0.1:
        return
    figure: Any = axes.figure
    panel = axes.get_window_extent()
    paper = np.array([panel.width, panel.height]) / figure.dpi
    on_paper = seen * paper / np.array([box.extent[h], box.extent[v]])
    reach = seen * (length * along / float(np.hypot(*on_paper)))
    start = np.array([position[h], position[v]]) * box.scale
    axes.annotate(
        "", xy=tuple(start + reach * box.scale), xytext=tuple(start), zorder=5.0,
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.4, "shrinkA": 0.0,
                    "shrinkB": 0.0, "mutation_scale": 11.0},
    )  # fmt: skip
