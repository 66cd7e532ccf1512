"""Maps of more bins than there are dots on paper: no bright bin is lost, and the reader is told."""

from __future__ import annotations

import numpy as np
import pytest
from made_up import make, poisson, rectangle, tables
from test_bins import labelled

import photizon_cl.views.figures.bins as module
from photizon_cl.views.figures import draw_far_field, draw_irradiance, draw_relative_sigma


@pytest.fixture
def few_dots(monkeypatch):
    """Have paper with two dots along each axis."""
    monkeypatch.setattr(module, "_MOST_QUADS", 4)
    monkeypatch.setattr(module, "_MOST_DOTS", 2)


def blocks(array):
    """Return the four parts of an array that are a dot each."""
    ny, nx = (n // 2 for n in array.shape)
    return [[array[:ny, :nx], array[:ny, nx:]], [array[ny:, :nx], array[ny:, nx:]]]


def texts(figure):
    return " ".join(t.get_text() for t in figure.texts)


def test_of_more_bins_than_dots_on_paper_the_highest_is_drawn(result, few_dots):
    m = result.detectors["target"].map
    figure = draw_irradiance(result, "target")
    image = labelled(figure, "values")
    shown = np.ma.masked_array(m.irradiance, mask=m.hatched | m.masked)
    best = [[part.max() for part in row] for row in blocks(shown)]
    assert image.get_array().tolist() == [
        [None if v is np.ma.masked else v for v in r] for r in best
    ]
    assert image.get_array().max() == shown.max()
    assert image.get_extent() == [-1.0, 1.0, -0.5, 0.5]
    ny, nx = (n - n // 2 for n in m.irradiance.shape)
    assert f"each dot is the highest of up to {nx} × {ny} of them with 10 rays" in texts(figure)


def test_a_single_bright_bin_is_seen_among_many(few_dots):
    made = make(tables(rectangle(name="t", detector={"map": [7, 5]})), poisson(0.0), 4)
    m = made.detectors["t"].map
    for array in (m.irradiance, m.sigma, m.count):
        array.flags.writeable = True  # what they say is made up here
    m.irradiance[...], m.sigma[...], m.count[...] = 0.0, np.nan, 0
    m.irradiance[1, 1], m.sigma[1, 1], m.count[1, 1] = 9.0, 1.0, 99  # no dot's middle
    figure = draw_irradiance(made, "t")
    values = labelled(figure, "values").get_array()
    assert values[0, 0] == 9.0
    assert values.count() == 1
    few = ~np.ma.getmaskarray(labelled(figure, "below 10 rays").get_array())
    assert few.tolist() == [[False, True], [True, True]]  # over no bin that has a value
    figure = draw_relative_sigma(made, "t")
    values = labelled(figure, "values").get_array()
    assert values[0, 0] == pytest.approx(1.0 / 9.0)
    grey = ~np.ma.getmaskarray(labelled(figure, "without a value").get_array())
    assert grey.tolist() == [[False, True], [True, True]]
    assert "each dot is the highest σ of up to 4 × 3 of them" in texts(figure)


def test_the_sigma_of_a_dot_is_that_of_bins_with_enough_rays(few_dots):
    made = make(tables(rectangle(name="t", detector={"map": [4, 4]})), poisson(0.0), 4)
    m = made.detectors["t"].map
    for array in (m.irradiance, m.sigma, m.count):
        array.flags.writeable = True  # what they say is made up here
    m.irradiance[...], m.sigma[...], m.count[...] = 1.0, 0.5, 5
    m.sigma[0, 1], m.count[0, 1] = 0.1, 50
    figure = draw_relative_sigma(made, "t")
    assert labelled(figure, "values").get_array().tolist() == [[0.1, 0.5], [0.5, 0.5]]
    lines = np.concatenate(labelled(figure, "hatching").get_segments())
    left, low = (0.5 * (lines[::2] + lines[1::2]) < 0.0).T  # of their middles
    assert (left & ~low).any()
    assert (low & ~left).any()
    assert not (left & low).any()


def test_nothing_is_said_where_every_bin_is_drawn(result):
    assert "dots on paper" not in texts(draw_irradiance(result, "target"))


@pytest.mark.parametrize("shape", [(5, 7), (4, 4), (2, 9), (1, 3), (6, 2)])
def test_blocks_hold_every_bin_once(shape, few_dots):
    values = np.ma.masked_array(np.arange(1.0, 1.0 + np.prod(shape)).reshape(shape))
    for at in np.ndindex(shape):
        alone = np.ma.masked_array(values.data, mask=True)
        alone[at] = values[at]
        found = module.dots(alone)
        assert found.compressed().tolist() == [values[at]]
        condition = np.zeros(shape, bool)
        condition[at] = True
        assert module.dots(condition).sum() == 1
        assert (module.dots(condition) == ~np.ma.getmaskarray(found)).all()


def test_the_far_field_says_so_too(few_dots):
    made = make({**tables(), "far_field": {"n_mu": 6, "n_phi": 8}}, poisson(30.0), 4)
    figure = draw_far_field(made)
    image = labelled(figure, "values").get_array()
    assert image.shape == (2, 2)
    assert image.max() == made.far_field.intensity.max()
    assert "each dot is the highest of up to 4 × 3 of them with 10 rays" in texts(figure)
