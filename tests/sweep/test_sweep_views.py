"""A sweep as a figure and as a page."""

from __future__ import annotations

import html

import numpy as np
import pytest
from tubes import MEASURE, WALL, a_sweep

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.views.figures.style import is_figure
from photizon_cl.views.figures.sweep_plot import draw_sweep

pytestmark = pytest.mark.usefixtures("built_quickly")


@pytest.fixture(scope="module")
def grid():
    logs = {"path": "source.sun.tilt_deg[0]", "name": "angle", "logspace": [0.5, 8, 4]}
    return pz.sweep(a_sweep(logs, WALL))


def bars(axes):
    """Return the curves of a panel: x, y and the ends of the bars."""
    found = []
    for container in axes.containers:
        line, _, (ends,) = container.lines
        spans = np.array([segment[:, 1] for segment in ends.get_segments()])
        found.append((line.get_xdata(), line.get_ydata(), spans))
    return found


def test_curves_have_the_numbers_and_bars_of_one_sigma(grid):
    figure = draw_sweep(grid)
    assert [axes.get_ylabel() for axes in figure.axes] == ["power, W", "share", "PST"]
    assert figure.axes[-1].get_xlabel() == "angle, deg"  # the longer axis lies along
    assert figure.axes[0].get_xscale() == "log"
    for axes, name in zip(figure.axes, MEASURE, strict=True):
        curves = bars(axes)
        assert len(curves) == 2
        for n, (x, y, ends) in enumerate(curves):
            points = [grid[2 * k + n] for k in range(4)]
            assert list(x) == [point.values["angle"] for point in points]
            assert list(y) == [point[name].value for point in points]
            sigma = np.array([point[name].sigma for point in points])
            np.testing.assert_allclose(ends[:, 1] - ends[:, 0], 2.0 * sigma, rtol=1e-6)
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert texts == [
        "element.tube.surface.reflectance = 0.1", "element.tube.surface.reflectance = 0.5",
    ]  # fmt: skip
    footer = " ".join(text.get_text() for text in figure.texts)
    assert "8 points; bars ± 1 σ" in footer
    assert "PST: (P/A)/(Φ/S): mean irradiance" in footer


def test_equal_factors_are_on_a_logarithmic_axis_and_no_others():
    for values, scale in (([1, 10, 100], "log"), ([1, 2, 3], "linear"), ([4, 1], "linear")):
        vary = {"path": "source.sun.flux", "values": values}
        found = pz.sweep(a_sweep(vary, run={"batches": 2}))
        assert draw_sweep(found, ["PST"]).axes[0].get_xscale() == scale


def test_one_measure(grid):
    figure = draw_sweep(grid, ["PST"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["PST"]
    with pytest.raises(pz.ArgumentError, match='found "pst", expected some of'):
        draw_sweep(grid, ["pst"])


def test_a_wide_measure_is_on_a_logarithmic_axis(grid):
    values = [point["power"].value for point in grid]
    assert max(values) < 30.0 * min(values)
    assert draw_sweep(grid, ["power"]).axes[0].get_yscale() == "linear"
    flux = {"path": "source.sun.flux", "values": [1, 100]}
    wide = pz.sweep(a_sweep(flux))
    assert draw_sweep(wide, ["power"]).axes[0].get_yscale() == "log"


def test_words_along_the_axis():
    kinds = [{"kind": "absorber"}, {"kind": "lambertian", "reflectance": 0.1}]
    walls = {"path": "element.tube.surface", "name": "wall", "values": kinds}
    axes = draw_sweep(pz.sweep(a_sweep(walls))).axes[-1]
    texts = [text.get_text() for text in axes.get_xticklabels()]
    assert texts[0].startswith('{"kind": "absorb')
    assert list(bars(axes)[0][0]) == [0.0, 1.0]


def test_many_curves_are_thinned_evenly():
    many = {"path": "element.tube.surface.reflectance", "linspace": [0.0, 1.0, 10]}
    rays = {"path": "source.sun.radius", "linspace": [0.01, 0.05, 11]}
    tables = a_sweep(many, rays, run={"batches": 1, "rays_per_batch": 64})
    found = pz.sweep(tables, max_seconds=0.5)  # the figure does without most points
    figure = draw_sweep(found, ["power"])
    assert len(figure.axes[0].containers) == 8
    assert "2 more curves are in the table" in " ".join(t.get_text() for t in figure.texts)


def test_nothing_to_draw(swept):
    import dataclasses

    from photizon_cl.result.sweep import empty_point

    points = tuple(empty_point(n, swept.plan) for n in range(len(swept)))
    with pytest.raises(pz.ArgumentError, match="no point that has been run"):
        draw_sweep(dataclasses.replace(swept, points=points))


# -- the page --------------------------------------------------------------------------------------


def test_the_report(kept, capsys):
    assert main(["report", str(kept)]) == 0
    assert capsys.readouterr().out == f"{kept / 'report.html'}\n"
    page = (kept / "report.html").read_text("utf-8")
    assert "<title>tube – report of a sweep</title>" in page
    found = pz.open_sweep(kept)
    for point in found:
        assert point.digest in page
    assert "(P/A)/(Φ/S): mean irradiance" in html.unescape(page)
    assert page.count('<img src="data:image/png') == 1
    # the same again, and the directory is still that of a sweep
    assert main(["report", str(kept)]) == 0
    assert (kept / "report.html").read_text("utf-8") == page
    assert main(["resume", str(kept)]) == 0
    assert main(["report", str(kept), "--out", str(kept / "sweep.csv")]) == 2
    assert "no photizon report, and is not replaced" in capsys.readouterr().err
    # a point has a report of its own
    assert main(["report", str(kept / "points" / "0001")]) == 0


def test_names_are_no_markup(tmp_path):
    name = "<b>&angle"
    vary = {"path": "source.sun.tilt_deg[0]", "name": name, "values": [0, 4]}
    pz.sweep(a_sweep(vary, title="<i>", measure={"<u>": "ledger.escaped"}), out=tmp_path / "out")
    assert is_figure(tmp_path / "out" / "sweep.png")
    assert main(["report", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    for bad in ("<b>", "<i>", "<u>"):
        assert bad not in page
    assert html.escape(name) in page


def test_in_a_browser(kept):
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "report"))
    from pagecheck import executable, faults

    if executable() is None:
        pytest.skip("no Chromium on this machine")
    from playwright.sync_api import sync_playwright

    assert main(["report", str(kept)]) == 0
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=executable())
        assert faults(browser, kept / "report.html") == []
        browser.close()
