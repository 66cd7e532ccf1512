"""Figure of a result's scene: three sections, with rays where some were traced for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from matplotlib.colors import BoundaryNorm

from photizon_cl.views.drawing.plot import draw_section, legend_handles, ray_colours
from photizon_cl.views.drawing.view import bounding_box, no_rays, shown_rays
from photizon_cl.views.figures.style import SMALL, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.paths import Paths

__all__ = ["MOST_ELEMENTS", "draw_layout"]

MOST_ELEMENTS: Final = 500
"""Elements up to which a saved result has its scene drawn; more take long and hide each other."""


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
    # A long scene lies on its side, as on an optical bench.
    lying = bool(box.extent[2] > 1.3 * max(box.extent[0], box.extent[1]))
    n, m = len(scene.element), len(scene.source)
    parts = f"{n} element{'s' * (n != 1)}, {m} source{'s' * (m != 1)}"
    page = sheet(result, f"scene: {parts}", 5.6, [f"sections through the scene's centre; {said}"])
    page.arrange()
    grid = page.figure.add_gridspec(2, 2)
    views = [(2, 0), (2, 1), (0, 1)] if lying else [(0, 2), (1, 2), (0, 1)]
    for (h, v), (row, column) in zip(views, [(0, 0), (1, 0), (0, 1)], strict=True):
        axes = page.figure.add_subplot(grid[row, column])
        draw_section(axes, scene, box, rays, colours, h, v)
    rest = page.figure.add_subplot(grid[1, 1])
    rest.set_axis_off()
    rest.legend(handles=legend_handles(scene), loc="upper left", fontsize=SMALL, frameon=False)
    if bar is not None:
        made = page.figure.colorbar(bar, ax=rest, location="bottom", shrink=0.9, aspect=30)
        made.set_label(label, fontsize=SMALL)
        made.ax.tick_params(labelsize=SMALL)
        if isinstance(bar.norm, BoundaryNorm):
            made.set_ticks(list(range(int(bar.norm.vmax or 0) + 1)))
        made.ax.minorticks_off()
    return page.figure
