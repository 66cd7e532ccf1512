"""A scene drawn: three sections and a view in space, with traced rays.

Solid lines are where the plane through the scene's centre cuts an element; thin grey ones are its
edges seen through. Rays are those of the trace, projected onto the plane of each panel. Colours
are safe for colour-blind readers (M. Okabe and K. Ito, Color Universal Design, 2008).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
    Line3DCollection,
    Poly3DCollection,
)

from photizon_cl.errors import counted
from photizon_cl.geometry.outlines import edges, facets
from photizon_cl.result.paths import Paths
from photizon_cl.views.drawing.panels import arrange
from photizon_cl.views.drawing.sections import (
    INK,
    NAMES,
    SOURCE,
    colour_key,
    colour_of,
    draw_sections,
    legend_handles,
    ray_colours,
)
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
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from photizon_cl.scene.model import Scene
    from photizon_cl.views.drawing.panels import Place

__all__ = ["draw_scene"]

_QUIET: Final = "#5f5f5f"
_MOST_FACETS: Final = 20000
_LONG: Final = 4.5
"""Proportions beyond which a view in space shortens a scene."""
_WIDEST: Final = 11.0
_LEAST: Final = 9.0
_TALLEST: Final = 8.2
_SPACE: Final = 3.0
_HEAD: Final = 0.72
_FOOT: Final = 0.36
_BAR: Final = 0.62


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
    below = _FOOT + (_BAR if bar is not None else 0.0)
    panels = arrange(box, _WIDEST, _TALLEST, space=_SPACE)
    width = max(_LEAST, panels.width)
    height = _HEAD + panels.height + below
    figure = ShownFigure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)

    def inches(left: float, bottom: float, w: float, h: float) -> Place:
        return left / width, (below + bottom) / height, w / width, h / height

    draw_sections(figure, inches, panels, scene, box, rays, colours)
    left, low, across, up = panels.rest
    # its labels stand outside of it, on the right
    space = figure.add_axes(inches(left - 0.5, low, across + 0.1, up), projection="3d")
    _draw_space(space, scene, box, rays, colours, panels.lying)
    if bar is not None:
        place = (0.3, (_FOOT + 0.4) / height, 0.4, 0.13 / height)
        colour_key(figure, bar, label, figure.add_axes(place))
    title = _plain(scene.heading)
    figure.text(0.01, 1.0 - 0.13 / height, title, fontsize=13, weight="bold", color=INK, va="top")
    figure.legend(
        handles=legend_handles(scene), loc="upper left",
        bbox_to_anchor=(0.005, 1.0 - 0.36 / height),
        ncols=7, fontsize=8.5, frameon=False, borderaxespad=0.0, handlelength=1.6,
        columnspacing=1.6,
    )  # fmt: skip
    notes = ["no rays drawn"]
    if isinstance(found, Paths):
        rays_drawn = counted(found.launched, "ray")
        notes = [f"{rays_drawn}, seed {scene.run.seed}, projected on each panel"]
        notes += _cut_short(found)
    if not label and isinstance(found, Paths):
        notes.append("no ray meets more than one surface")
    if rays.faint:
        notes.append(f"{rays.faint} segments of weight below {FAINTEST:g} are not drawn")
    figure.text(0.01, 0.1 / height, _plain("  ·  ".join(notes)), fontsize=8, color=_QUIET)
    return figure


def _cut_short(found: Paths) -> list[str]:
    """Return what a reader must know: a capped part too small to be drawn is left out."""
    capped = found.ledger.get("depth-capped", 0.0)
    small = 0.0 < capped < FAINTEST * found.unit_power
    return found.advisories[:-1] if small else found.advisories


def _plain(text: str) -> str:
    """Return text that matplotlib shows as it is, dollar signs included."""
    return text.replace("\\", "\\\\").replace("$", r"\$")


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
        colour = colour_of(element)
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
            axes.plot(*(outline * scale).T, style, color=SOURCE, linewidth=1.8, markersize=5)
    for axis, name in enumerate(NAMES):
        limits = (box.low[axis] * scale, box.high[axis] * scale)
        getattr(axes, f"set_{name}lim")(*limits)
        getattr(axes, f"set_{name}label")(f"{name} in {box.unit}", fontsize=9, labelpad=3)
        few = 4 if box.extent[axis] > 0.4 * box.extent.max() else 2
        getattr(axes, f"{name}axis").set_major_locator(_few_ticks(few))
        getattr(axes, f"{name}axis").set_pane_color((1.0, 1.0, 1.0, 0.0))
        getattr(axes, f"{name}axis")._axinfo["grid"].update(color="#e4e4e4", linewidth=0.5)
    axes.tick_params(labelsize=7.5, pad=0)
    aspect = np.maximum(box.extent / box.extent.max(), 1.0 / _LONG)
    if lying:
        axes.view_init(elev=20.0, azim=-62.0, vertical_axis="x")
    else:
        axes.view_init(elev=22.0, azim=-56.0)
    axes.set_box_aspect(aspect, zoom=1.12 if lying else 0.95)


def _few_ticks(most: int) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(most, steps=[1, 2, 2.5, 5, 10])
