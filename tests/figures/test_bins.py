"""Maps show the result's own numbers, bin by bin, and hatch what has fewer than 10 rays."""

from __future__ import annotations

import time

import numpy as np
import pytest
from made_up import make, poisson, rectangle, some_lit, tables
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

import photizon_cl.views.figures.bins as module
from photizon_cl.errors import ArgumentError
from photizon_cl.views.figures import draw_far_field, draw_irradiance, draw_relative_sigma
from photizon_cl.views.figures.bins import GREY, HATCHED, hatch_lines
from photizon_cl.views.figures.style import write


def labelled(figure, label):
    """Return what is drawn in the map's axes under a label, or None."""
    axes = figure.axes[0]
    found = [a for a in [*axes.collections, *axes.images] if a.get_label() == label]
    return found[0] if found else None


def drawn(figure):
    """Return the array of the coloured bins."""
    return labelled(figure, "values").get_array()


def where(figure, label, shape):
    """Return which bins are drawn under a label."""
    mesh = labelled(figure, label)
    return np.zeros(shape, bool) if mesh is None else ~np.ma.getmaskarray(mesh.get_array())


@pytest.fixture(
    scope="module",
    params=["rectangle", "disk", "sphere", "one bin", "zero", "single batch", "long", "all lit"],
)
def case(request):
    """Return a result whose element "t" has a map."""
    detector = {"name": "t", "detector": {"map": [9, 6]}}
    flat = rectangle(**detector)
    disk = {"kind": "disk", "axis": "+z", "radius": 0.02, **detector}
    ball = {"kind": "sphere", "axis": "+z", "radius": 0.1, "port_fraction": 0.4, **detector}
    scenes = {
        "rectangle": (flat, some_lit, 4),
        "disk": (disk, some_lit, 4),
        "sphere": (ball, some_lit, 4),
        "one bin": (rectangle(name="t", detector={"map": [1, 1]}), poisson(9.0), 4),
        "zero": (flat, poisson(0.0), 4),
        "single batch": (flat, poisson(9.0), 1),
        "long": ({**flat, "half_height": 1e-3}, some_lit, 4),
        "all lit": (flat, poisson(500.0), 3),
    }
    element, counts, batches = scenes[request.param]
    return make(tables(element), counts, batches)


def test_bins_have_the_values_of_the_result(case):
    m = case.detectors["t"].map
    array = drawn(draw_irradiance(case, "t"))
    np.testing.assert_array_equal(array.data, m.irradiance)
    np.testing.assert_array_equal(np.ma.getmaskarray(array), (m.count < 10) | (m.area == 0.0))


def test_exactly_the_bins_below_ten_are_hatched(case):
    m = case.detectors["t"].map
    figure = draw_irradiance(case, "t")
    expected = (m.count < 10) & (m.area > 0.0)
    np.testing.assert_array_equal(where(figure, "below 10 rays", m.count.shape), expected)
    mesh = labelled(figure, "below 10 rays")
    if expected.any():
        assert to_hex(mesh.get_cmap()(0.0)) == HATCHED
        assert "below 10 rays" in [t.get_text() for t in figure.legends[0].get_texts()]
    else:
        assert mesh is None
        assert not figure.legends or not figure.legends[0].get_texts()
    lines = labelled(figure, "hatching")
    assert (lines is not None) == expected.any()


def test_relative_sigma_is_that_of_the_result(case):
    m = case.detectors["t"].map
    figure = draw_relative_sigma(case, "t")
    array = drawn(figure)
    known = (m.area > 0.0) & (m.count > 0) & (case.batches > 1)
    np.testing.assert_array_equal(~np.ma.getmaskarray(array), known)
    np.testing.assert_array_equal(array.data[known], m.sigma[known] / m.irradiance[known])
    grey = (m.area > 0.0) & ~known
    np.testing.assert_array_equal(where(figure, "without a value", m.count.shape), grey)
    assert (labelled(figure, "hatching") is not None) == (known & (m.count < 10)).any()
    assert GREY != HATCHED


def test_the_far_field_has_the_values_of_the_result():
    made = make(tables(far_field={"n_mu": 12, "n_phi": 8}), some_lit)
    far = made.far_field
    figure = draw_far_field(made)
    np.testing.assert_array_equal(drawn(figure).data, far.intensity)
    np.testing.assert_array_equal(np.ma.getmaskarray(drawn(figure)), far.count < 10)
    few = where(figure, "below 10 rays", far.count.shape)
    np.testing.assert_array_equal(few, far.count < 10)
    assert few.any()
    assert not few.all()


def test_every_pixel_has_the_colour_of_its_own_bin():
    """A map that is smoothed, interpolated or shifted has other colours inside its bins."""
    made = make(tables(rectangle(name="t", detector={"map": [16, 12]})), some_lit)
    m = made.detectors["t"].map
    figure = draw_irradiance(made, "t")
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())
    axes, mesh = figure.axes[0], labelled(figure, "values")
    for part in (0.2, 0.5, 0.8):  # beside the edges too, where an interpolation shows most
        x = m.x_edges[:-1] + part * np.diff(m.x_edges)
        y = m.y_edges[:-1] + part * np.diff(m.y_edges)
        scale = axes.get_xlim()[1] / m.x_edges[-1]
        for j, i in zip(*np.nonzero(m.lit), strict=True):
            across, up = axes.transData.transform((x[i] * scale, y[j] * scale))
            found = pixels[pixels.shape[0] - 1 - int(up), int(across)]
            expected = mesh.to_rgba(m.irradiance[j, i], bytes=True)
            np.testing.assert_allclose(found, expected, atol=1.0, rtol=0.0)  # of 255


def test_the_colour_scale_is_from_zero_to_the_highest_coloured_bin(case):
    m = case.detectors["t"].map
    norm = labelled(draw_irradiance(case, "t"), "values").norm
    assert norm.vmin == 0.0
    assert norm.vmax == (m.irradiance[m.lit].max() if m.lit.any() else 1.0)


def test_ticks_of_the_colour_bar_have_a_prefix(result):
    # What is plotted stays in W/m²; what is written is scaled.
    for element, unit, factor in (("target", "mW/m²", 1e3), ("rim", "kW/m²", 1e-3)):
        figure = draw_irradiance(result, element)
        figure.canvas.draw()
        bar = figure.axes[1]
        assert bar.get_ylabel() == f"irradiance in {unit}"
        for tick, text in zip(bar.get_yticks(), bar.get_yticklabels(), strict=True):
            assert float(text.get_text()) == pytest.approx(factor * tick)


def test_lengths_have_a_prefix_too(result):
    figure = draw_irradiance(result, "rim")
    assert figure.axes[0].get_xlabel() == "u in mm"
    assert figure.axes[0].get_xlim() == (-20.0, 20.0)
    assert draw_irradiance(result, "target").axes[0].get_xlabel() == "u in m"


def test_hatching_stays_within_its_bins():
    random = np.random.default_rng(3)
    for shape in ((1, 1), (5, 8), (60, 31)):
        mask = random.random(shape) < 0.4
        x, y = np.linspace(-2.0, 1.0, shape[1] + 1), np.linspace(0.0, 0.5, shape[0] + 1)
        lines = hatch_lines(x, y, mask, 4.0, 3.0)
        seen = np.zeros(shape, bool)
        for part in np.linspace(0.001, 0.999, 25):
            at = lines[:, 0] + part * (lines[:, 1] - lines[:, 0])
            i = np.searchsorted(x, at[:, 0], "right") - 1
            j = np.searchsorted(y, at[:, 1], "right") - 1
            assert mask[j, i].all()
            seen[j, i] = True
        np.testing.assert_array_equal(seen, mask)  # none is left without a line
        slope = np.diff(lines, axis=1)[:, 0]
        np.testing.assert_allclose(slope[:, 1] / 0.5 * 3.0, slope[:, 0] / 3.0 * 4.0)


def test_hatching_is_vectors_on_small_maps_only(result):
    lines = labelled(draw_irradiance(result, "target"), "hatching")
    assert isinstance(lines, LineCollection)
    assert not lines.get_rasterized()
    assert labelled(draw_irradiance(result, "target"), "values").get_rasterized()


def test_the_target_stands_on_the_bar_of_sigma(result):
    figure = draw_relative_sigma(result, "target")
    assert "mark on the scale: target of the median" in [t.get_text() for t in figure.texts]
    bar = figure.axes[1]
    marks = [line for line in bar.lines if line.get_label() == "target of the median"]
    assert [line.get_ydata()[0] for line in marks] == [0.05]


def test_the_rim_of_a_disk_is_drawn(result):
    line = draw_irradiance(result, "rim").axes[0].lines[0]
    np.testing.assert_allclose(np.hypot(*line.get_data()), 20.0)


def test_maps_beyond_memory_are_pictures_of_the_same_bins(result, monkeypatch):
    m = result.detectors["target"].map
    monkeypatch.setattr(module, "_MOST_QUADS", 10)
    figure = draw_irradiance(result, "target")
    image = labelled(figure, "values")
    assert image is figure.axes[0].images[0]
    assert image.get_interpolation() == "nearest"
    np.testing.assert_array_equal(image.get_array().data, m.irradiance)
    assert image.get_extent() == [-1.0, 1.0, -0.5, 0.5]
    assert image.origin == "lower"


def test_large_maps_take_seconds(tmp_path):
    made = make(tables(rectangle(name="t", detector={"map": [2048, 2048]})), poisson(10.0), 1)
    started = time.process_time()
    write(lambda: draw_irradiance(made, "t"), tmp_path / "map.svg", "svg")
    assert time.process_time() - started < 20.0
    assert (tmp_path / "map.svg").stat().st_size < 8e6


@pytest.mark.parametrize("draw", [draw_irradiance, draw_relative_sigma])
def test_what_has_no_map_says_so(result, draw):
    with pytest.raises(ArgumentError, match=r'found "no", expected one .*"target", "rim"'):
        draw(result, "no")
