"""The far field over θ: the values of the result on a logarithmic axis."""

from __future__ import annotations

import numpy as np
import pytest
from made_up import make, poisson, rectangle, some_lit, tables

from photizon_cl.errors import ArgumentError
from photizon_cl.views.figures import draw_far_field, draw_far_field_theta, figure_names

EDGES = [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 90.0]


def curve(counts=some_lit, batches=4, **more):
    far_field = {"axis": "-z", "theta_edges_deg": EDGES, "n_phi": 1, **more}
    return make(tables(far_field=far_field), counts, batches)


def dots(axes):
    """Return the dots' places, and whether each series is open, in the order drawn."""
    lines = [c.lines[0] for c in axes.containers]
    return [(np.array(line.get_data()), line.get_markerfacecolor() == "white") for line in lines]


def test_dots_are_the_bins():
    result = curve()
    far = result.far_field
    axes = draw_far_field_theta(result).axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    drawn = np.full(8, np.nan)
    for (theta, values), few in dots(axes):
        for at, value in zip(theta, values, strict=True):
            row = int(np.searchsorted(EDGES, at)) - 1
            assert bool(far.hatched[row, 0]) == few
            drawn[row] = value
    lit = far.intensity[:, 0] > 0.0
    assert lit.any()
    assert (drawn[lit] == far.intensity[lit, 0]).all()
    assert np.isnan(drawn[~lit]).all()


def test_bars_are_one_sigma_and_the_width_of_the_bin():
    result = curve(poisson(40.0))
    far = result.far_field
    (container,) = draw_far_field_theta(result).axes[0].containers
    across, up = (np.array(bars.get_segments()) for bars in container.lines[2])
    assert across[1:, :, 0] == pytest.approx(np.stack([EDGES[1:-1], EDGES[2:]], 1))
    assert across[0, :, 0] == pytest.approx([0.25, 0.5])  # no 0 on a logarithmic axis
    half = 0.5 * (up[:, 1, 1] - up[:, 0, 1])
    assert half == pytest.approx(far.sigma[:, 0])


def test_even_bins_have_an_even_axis_and_columns_their_colours():
    result = make(tables(far_field={"n_theta": 18, "n_phi": 4}), poisson(40.0))
    axes = draw_far_field_theta(result).axes[0]
    assert axes.get_xscale() == "linear"
    assert len({line.get_color() for line in (c.lines[0] for c in axes.containers)}) == 4
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert said == ["φ = 0°–90°", "φ = 90°–180°", "φ = 180°–270°", "φ = 270°–360°"]


def test_of_many_columns_four_are_drawn_or_those_asked_for():
    result = make(tables(far_field={"n_theta": 4, "n_phi": 36}), poisson(40.0))
    assert len(draw_far_field_theta(result).axes[0].containers) == 4
    assert len(draw_far_field_theta(result, (10.0,)).axes[0].containers) == 1
    for planes in ((), (0.0,) * 7, (float("nan"),)):
        with pytest.raises(ArgumentError, match="planes: found"):
            draw_far_field_theta(result, planes)


def test_a_scene_without_a_far_field_says_so():
    with pytest.raises(ArgumentError, match="no far field"):
        draw_far_field_theta(make(tables(rectangle()), poisson(5.0)))


@pytest.mark.parametrize(("counts", "batches"), [(poisson(0.0), 2), (poisson(9.0), 1)])
def test_without_rays_or_a_sigma_it_is_drawn_all_the_same(counts, batches):
    result = curve(counts, batches)
    axes = draw_far_field_theta(result).axes[0]
    text = " ".join(text.get_text() for text in axes.texts)
    assert ("no ray" in text) == (not result.far_field.count.any())
    assert all(len(c.lines[2]) == 1 for c in axes.containers)  # bars across and no others


def test_which_figures_there_are():
    one = {"theta_edges_deg": EDGES, "n_phi": 1}
    stems = [
        [n for n in figure_names(make(tables(far_field=far), poisson(5.0))) if "far" in n]
        for far in (one, {"n_theta": 4, "n_phi": 2}, {"n_mu": 4, "n_phi": 1, "axis": "+x"})
    ]
    assert stems == [
        ["far-field-theta.png"],
        ["far-field-theta.png", "far-field.png", "far-field-cuts.png"],
        ["far-field.png", "far-field-cuts.png"],
    ]


def test_axes_name_the_axis():
    result = make(tables(far_field={"axis": "-x", "n_theta": 4, "n_phi": 2}), poisson(40.0))
    axes = draw_far_field(result).axes[0]
    assert axes.get_xlabel() == "φ in degrees, from +z towards +y"
    assert axes.get_ylabel() == "θ in degrees, from world -x"
    assert draw_far_field_theta(result).axes[0].get_xlabel() == "θ in degrees, from world -x"
