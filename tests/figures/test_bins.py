"""Maps show the result's own numbers, bin by bin, and hatch what has fewer than 10 rays."""

from __future__ import annotations

import time

import matplotlib
import numpy as np
import pytest
from made_up import make, poisson, rectangle, some_lit, tables
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize, PowerNorm, to_hex
from matplotlib.figure import Figure

import photizon_cl.views.figures.bins as module
from photizon_cl.errors import ArgumentError
from photizon_cl.scene.files import load
from photizon_cl.views.figures import draw_far_field, draw_irradiance, draw_relative_sigma
from photizon_cl.views.figures.bins import GREY, HATCHED, hatch_lines
from photizon_cl.views.figures.style import write
from photizon_cl.views.report import tables as report_tables
from photizon_cl.views.report.words import describe


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


def whole(m):
    """Return the lit bins that no rim or port cuts to less than three quarters."""
    return (m.count >= 10) & (m.area >= 0.75 * m.area.max())


def test_the_colour_scale_is_from_zero_to_the_highest_whole_bin(case):
    m = case.detectors["t"].map
    norm = labelled(draw_irradiance(case, "t"), "values").norm
    assert norm.vmin == 0.0
    assert norm.vmax == (m.irradiance[whole(m)].max() if m.lit.any() else 1.0)


def test_the_unit_is_one_on_every_page(result):
    # What is plotted stays in W/m²; a power of ten stands before the unit, never a prefix.
    disk = {"kind": "disk", "axis": "+z", "radius": 1e-3, "name": "t", "detector": {"map": [8, 8]}}
    spot = make(tables(disk), poisson(100.0))
    for made, element, unit, factor in (
        (result, "target", "W/m²", 1.0), (result, "rim", "W/m²", 1.0), (spot, "t", "10⁶ W/m²", 1e-6)
    ):  # fmt: skip
        figure = draw_irradiance(made, element)
        figure.canvas.draw()
        bar = figure.axes[1]
        assert bar.get_ylabel() == f"irradiance in {unit}"
        for tick, text in zip(bar.get_yticks(), bar.get_yticklabels(), strict=True):
            assert float(text.get_text()) == pytest.approx(factor * tick)


# -- bins that a rim cuts ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rimmed():
    """Return a disk's map of 8 × 8 bins whose smallest bins are the brightest and the worst."""

    def counts(random, layout):
        d = layout.detectors[0]
        cells = np.zeros(layout.n_cells, np.int64)
        cells[d.map : d.map + 64] = random.poisson(200.0, 64)
        area = load(scene).element[0].map_bins(8, 8).areas.ravel()
        small = (area > 0.0) & (area < 0.3 * area.max())
        cells[d.map : d.map + 64][small] *= random.integers(1, 9)
        cells[d.map : d.map + 64][area == 0.0] = 0
        return cells

    disk = {"kind": "disk", "axis": "+z", "radius": 0.02, "name": "t", "detector": {"map": [8, 8]}}
    scene = tables(disk)
    return make(scene, counts)


def footer(figure):
    return " ".join(text.get_text() for text in figure.texts)


def test_slivers_do_not_set_the_scale_and_that_is_said(rimmed):
    m = rimmed.detectors["t"].map
    small = (m.area > 0.0) & (m.area < 0.75 * m.area.max())
    np.testing.assert_array_equal(m.slivers, small)
    top, least = m.irradiance[whole(m)].max(), m.irradiance[whole(m)].min()
    assert m.irradiance[small].max() > 3.0 * top
    figure = draw_irradiance(rimmed, "t")
    assert labelled(figure, "values").norm.vmax == top
    assert labelled(figure, "values").colorbar.extend == "max"
    beyond = int((m.irradiance[small] > top).sum())
    assert f"beyond the scale: {beyond} bins that a rim" in footer(figure)
    assert f"up to {m.irradiance[small].max():.3g} W/m²" in footer(figure)
    ratio = m.sigma / m.irradiance
    sigma = draw_relative_sigma(rimmed, "t")
    assert labelled(sigma, "values").norm.vmax == ratio[whole(m)].max()
    # The same in words: extremes are those of whole bins, and what is left out is said.
    table = report_tables.map_table("x", "t", m, rimmed.detectors["t"].power)
    rows = {row[0]: str(row[1]) for row in table.rows}
    assert rows["highest of these bins"].startswith(f"{top:.0f} ± ")
    assert f"{int(small.sum())} bins" in table.note
    assert f"range from {least:.4g} to" in describe(rimmed, "map", "t")[0]


def test_slivers_set_the_scale_where_nothing_else_is_lit(rimmed):
    def counts(random, layout):
        d = layout.detectors[0]
        cells = np.zeros(layout.n_cells, np.int64)
        cells[d.map + 1] = 50 * random.integers(1, 3)
        return cells

    disk = {"kind": "disk", "axis": "+z", "radius": 0.02, "name": "t", "detector": {"map": [4, 4]}}
    made = make(tables({**disk, "detector": {"map": [7, 7]}}), counts)
    m = made.detectors["t"].map
    assert m.slivers[0, 1]
    assert labelled(draw_irradiance(made, "t"), "values").norm.vmax == m.irradiance[0, 1]


# -- scales that a reader asks for ---------------------------------------------------------------


def test_a_logarithmic_scale_runs_from_the_lowest_to_the_highest_bin(case):
    m = case.detectors["t"].map
    figure = draw_irradiance(case, "t", norm="log")
    norm = labelled(figure, "values").norm
    assert isinstance(norm, LogNorm)
    known = m.irradiance[whole(m)]
    if m.lit.any():
        assert norm.vmax == known.max()
        assert norm.vmin == (known.min() if len(known) > 1 else 0.1 * known.min())
    figure.canvas.draw()
    bar = figure.axes[1]
    shown = [t.get_text() for t in bar.get_yticklabels() if t.get_text()]
    places = [t for t in bar.get_yticks() if norm.vmin <= t <= norm.vmax]
    assert (len(places) >= 2) == m.lit.any()
    assert len(shown) >= len(places)


def test_limits_are_the_readers(result):
    m = result.detectors["target"].map
    for norm, kind in ((None, Normalize), ("linear", Normalize), ("log", LogNorm)):
        figure = draw_irradiance(result, "target", norm=norm, vmin=0.1, vmax=0.2)
        mesh = labelled(figure, "values")
        assert type(mesh.norm) is kind
        assert (mesh.norm.vmin, mesh.norm.vmax) == (0.1, 0.2)
        np.testing.assert_array_equal(mesh.get_array().data, m.irradiance)
        lit = m.irradiance[m.lit]
        ends = {(True, True): "both", (True, False): "min", (False, True): "max"}
        expected = ends.get(((lit < 0.1).any(), (lit > 0.2).any()), "neither")
        assert mesh.colorbar.extend == expected
    own = PowerNorm(0.5, 0.0, 1.0)
    assert labelled(draw_irradiance(result, "target", norm=own), "values").norm is own
    sigma = draw_relative_sigma(result, "target", norm="log", vmin=0.01, vmax=1.0)
    assert labelled(sigma, "values").norm.vmin == 0.01
    assert draw_far_field(result, vmax=7.0).axes[0].collections[0].norm.vmax == 7.0


def test_a_peak_gets_a_logarithmic_scale_unless_one_is_asked_for():
    def counts(random, layout):
        cells = random.poisson(20.0, layout.n_cells)
        cells[layout.detectors[0].map + 12] = 5000
        return cells

    made = make(tables(rectangle(name="t", detector={"map": [5, 5]})), counts)
    figure = draw_irradiance(made, "t")
    assert isinstance(labelled(figure, "values").norm, LogNorm)
    assert "logarithmic scale: half of the bins are below 5 %" in footer(figure)
    for asked in ({"norm": "linear"}, {"vmax": 1.0}, {"norm": "log"}):
        figure = draw_irradiance(made, "t", **asked)
        assert isinstance(labelled(figure, "values").norm, LogNorm) is (asked == {"norm": "log"})
        assert "logarithmic scale" not in footer(figure)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"norm": "lgo"}, 'norm: found "lgo", expected "linear", "log"'),
        ({"norm": "log", "vmin": 0.0}, "vmin: found 0.0, expected a number above 0"),
        ({"vmax": float("nan")}, "vmax: found nan, expected a finite number"),
        ({"vmin": 2.0, "vmax": 1.0}, "scale would run from 2 to 1"),
        ({"vmin": 1e9}, "scale would run from 1e[+]09 to"),
        ({"norm": LogNorm(), "vmin": 1.0}, "found a matplotlib norm beside vmin"),
    ],
)
def test_a_scale_that_cannot_be_is_refused(result, asked, message):
    for draw in (draw_irradiance, draw_relative_sigma):
        with pytest.raises(ArgumentError, match=message):
            draw(result, "target", **asked)
    with pytest.raises(ArgumentError, match=message):
        draw_far_field(result, **asked)


def test_zero_on_a_logarithmic_scale_is_below_it():
    """Equal batches have σ 0, which a logarithm has no place for."""

    def counts(random, layout):
        cells = np.full(layout.n_cells, 20, np.int64)
        cells[layout.detectors[0].map : layout.detectors[0].map + 3] = random.poisson(20.0, 3)
        return cells

    made = make(tables(rectangle(name="t", detector={"map": [3, 3]})), counts)
    mesh = labelled(draw_relative_sigma(made, "t", norm="log"), "values")
    assert not np.ma.getmaskarray(mesh.get_array()).any()
    assert mesh.colorbar.extend == "min"


# -- a reader's own axes -------------------------------------------------------------------------


def test_axes_of_ones_own_at_the_width_of_a_column(result):
    """85 mm, two in a row on a figure of one's own: nothing in the way, and the reader's sizes."""
    with matplotlib.rc_context({"font.size": 7.0}):
        figure = Figure(figsize=(85.0 / 25.4, 3.0), layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.add_subplot()
        assert draw_irradiance(result, "target", norm="log", ax=ax) is figure
        figure.canvas.draw()
        assert {text.get_fontsize() for text in ax.get_xticklabels()} == {7.0}
    assert len(figure.axes) == 2
    assert ax.get_xlabel() == "u (+x) in m"
    assert ax.get_aspect() == 1.0
    assert not figure.texts  # no title and no footer of ours
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box.x0 >= 0.0
        assert box.x1 <= figure.bbox.x1
    for draw in (draw_relative_sigma, lambda r, _, ax: draw_far_field(r, ax=ax)):
        other = Figure(figsize=(85.0 / 25.4, 2.6))
        row = other.subfigures(1, 1).subplots()
        assert draw(result, "rim", ax=row) is other
        assert len(other.subfigs[0].axes) == 2


def test_lengths_have_a_prefix_too(result):
    figure = draw_irradiance(result, "rim")
    assert figure.axes[0].get_xlabel() == "u (+x) in mm"
    assert figure.axes[0].get_xlim() == (-20.0, 20.0)
    assert draw_irradiance(result, "target").axes[0].get_xlabel() == "u (+x) in m"


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


@pytest.mark.slow
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
