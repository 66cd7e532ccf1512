"""Figures of a result, drawn without a display and without matplotlib's global state.

Each function draws one figure and returns it as a `matplotlib.figure.Figure`, to be changed or
saved as one likes. `write_all` writes every figure of a result, as PNG, SVG or PDF. Bins are drawn
as they are, never smoothed or interpolated, and are hatched where fewer than 10 rays arrived.

===========================  =====================================================
``draw_irradiance``          map of a detector's irradiance
``draw_relative_sigma``      σ over irradiance of each bin of that map
``draw_far_field``           intensity over φ and cos θ
``draw_far_field_cuts``      polar cuts through planes of φ
``draw_far_field_theta``     intensity over θ on a logarithmic axis
``draw_ledger``              where the power went
``draw_ladder``              a detector's power by generation
``draw_paths``               strongest paths to a detector, ranked
``draw_ghosts``              two-reflection ghosts by pair of faces
``draw_by_wavelength``       what each line of the spectrum brings to the largest rows
``draw_convergence``         σ against rays and against seconds
``draw_layout``              sections through the scene, with or without rays
``draw_sweep``               what a sweep measured, with error bars
===========================  =====================================================

Each is there without ``draw_`` as well: ``figures.ledger(result)``.

>>> from photizon_cl import figures
>>> figures.draw_irradiance(result, "target").savefig("target.pdf")  # doctest: +SKIP
"""

from __future__ import annotations

from photizon_cl.views.figures.convergence_plot import draw_convergence
from photizon_cl.views.figures.far_field_plots import draw_far_field, draw_far_field_cuts
from photizon_cl.views.figures.far_field_theta import draw_far_field_theta
from photizon_cl.views.figures.ladder_plot import draw_ladder
from photizon_cl.views.figures.layout_plot import draw_layout
from photizon_cl.views.figures.ledger_plot import draw_ledger
from photizon_cl.views.figures.map_plots import draw_irradiance, draw_relative_sigma
from photizon_cl.views.figures.path_plots import draw_ghosts, draw_paths
from photizon_cl.views.figures.spectrum_plot import draw_by_wavelength
from photizon_cl.views.figures.style import FORMATS
from photizon_cl.views.figures.sweep_plot import draw_sweep
from photizon_cl.views.figures.table import FIGURES, draw_all, figure_names, write_all

irradiance, relative_sigma = draw_irradiance, draw_relative_sigma
far_field, far_field_cuts = draw_far_field, draw_far_field_cuts
far_field_theta = draw_far_field_theta
ledger, ladder, convergence, layout = draw_ledger, draw_ladder, draw_convergence, draw_layout
paths, ghosts = draw_paths, draw_ghosts
by_wavelength = draw_by_wavelength
sweep = draw_sweep

__all__ = [
    "FIGURES",
    "FORMATS",
    "by_wavelength",
    "convergence",
    "draw_all",
    "draw_by_wavelength",
    "draw_convergence",
    "draw_far_field",
    "draw_far_field_cuts",
    "draw_far_field_theta",
    "draw_ghosts",
    "draw_irradiance",
    "draw_ladder",
    "draw_layout",
    "draw_ledger",
    "draw_paths",
    "draw_relative_sigma",
    "draw_sweep",
    "far_field",
    "far_field_cuts",
    "far_field_theta",
    "figure_names",
    "ghosts",
    "irradiance",
    "ladder",
    "layout",
    "ledger",
    "paths",
    "relative_sigma",
    "sweep",
    "write_all",
]
