"""Figure of a result's scene: three sections, with rays where some were traced for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from photizon_cl.views.drawing.panels import arrange
from photizon_cl.views.drawing.sections import (
    colour_key,
    draw_sections,
    legend_handles,
    ray_colours,
)
from photizon_cl.views.drawing.view import bounding_box, no_rays, shown_rays
from photizon_cl.views.figures.style import SMALL, WIDTH, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.paths import Paths
    from photizon_cl.views.drawing.panels import Place

__all__ = ["MOST_ELEMENTS", "draw_layout"]

MOST_ELEMENTS: Final = 500
"""Elements up to which a saved result has its scene drawn; more take long and hide each other."""

_TALLEST: Final = 6.6  # inches of the sections


@styled
def draw_layout(result: Estimates, paths: Paths | None = None) -> Figure:
    """Draw three sections through the scene's centre, to scale.

    Solid lines are where the plane of a section cuts an element; thin grey ones are its edges seen
    through.

    Parameters
    ----------
    result : Result
        The result; its scene is drawn.
    paths : Paths, optional
        What `photizon_cl.paths` returned for this scene; default no rays.

    Returns
    -------
    matplotlib.figure.Figure
        World coordinates in metres with an SI prefix.
    """
    scene = result.scene
    box = bounding_box(scene)
    if paths is None:
        rays = no_rays()
        said = "no rays drawn"
    else:
        rays = shown_rays(paths, box)
        run = paths.scene.run
        said = f"{run.rays_per_batch} rays of seed {run.seed}, projected on each section"
    colours, bar, label = ray_colours(rays, "generation")
    n, m = len(scene.element), len(scene.source)
    parts = f"{n} element{'s' * (n != 1)}, {m} source{'s' * (m != 1)}"
    panels = arrange(box, WIDTH, _TALLEST)
    handles = legend_handles(scene)
    strip = 0.0 if panels.lying else 0.2 + (0.5 if bar is not None else 0.0)
    notes = [f"sections through the scene's centre; {said}"]
    page = sheet(result, f"scene: {parts}", panels.height + strip + 0.05, notes)
    bottom = page.body - panels.height  # what rounding up leaves is below

    def inches(left: float, up: float, w: float, h: float) -> Place:
        return page.place(left, bottom + up, w, h)

    draw_sections(page.figure, inches, panels, scene, box, rays, colours)
    left, low, width, height = panels.rest
    if panels.lying:
        corner, columns = inches(left, low, width, height), 1
        bar_place = inches(left + 0.05, low + 0.46, min(width, 2.4) - 0.15, 0.12)
    else:
        corner, columns = inches(left - 0.4, 0.0, width, 0.0), 5
        bar_place = inches(left, -0.42, 3.0, 0.12)
    legend = page.figure.legend(
        handles=handles, loc="upper left", ncols=columns, fontsize=SMALL, frameon=False,
        bbox_to_anchor=(corner[0], corner[1] + corner[3]), borderaxespad=0.1, handlelength=1.6,
        columnspacing=1.4,
    )  # fmt: skip
    legend.set_in_layout(False)
    if bar is not None:
        said = label if not panels.lying else label.partition(":")[0]
        colour_key(page.figure, bar, said, page.figure.add_axes(bar_place))
    return page.figure
