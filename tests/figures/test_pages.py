"""What every figure has: title, footer, room for its text, and a file that can be made again."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from made_up import make, poisson, rectangle, tables
from matplotlib.text import Text

from photizon_cl.cli.outcome import print_result
from photizon_cl.cli.tables import console
from photizon_cl.errors import ArgumentError
from photizon_cl.result.stopping import Goal
from photizon_cl.views.figures import (
    FIGURES,
    draw_all,
    draw_far_field,
    draw_far_field_cuts,
    draw_irradiance,
    draw_ladder,
    draw_layout,
    figure_names,
    write_all,
)
from photizon_cl.views.figures.words import fitted, inches, prefixed
from photizon_cl.views.report.story import key_figures

HISTORY = ((2, 0.1, 0.3), (4, 0.2, 0.2))
LONG = "A title $x^2$ \\ that is much longer than a page is wide, " * 6


def all_figures(result):
    """Return every figure of a result by name."""
    return {
        "-".join([kind.stem, *subject]): kind.draw(result, *subject)
        for kind in FIGURES
        for subject in kind.subjects(result)
    }


def with_history(result):
    info = dataclasses.replace(result.info, history=HISTORY)
    return type(result)(result.compiled, result.tally, info)


@pytest.fixture(scope="module")
def full(result):
    return with_history(result)


def awkward(which):
    """Return results that strain a page."""
    name = "WWW $ an element whose name nobody would want to read in full"
    maps = {"map": [6, 5], "generations": 3}
    strip = rectangle(name=name, half_width=3.0, half_height=2e-4, detector=maps)
    post = rectangle(name="post", half_width=2e-7, half_height=1e-6, detector=maps)
    scenes = {
        "long names": (tables(strip, title=LONG, far_field={}), 12.0, 3),
        "tall": (tables(post, far_field={"n_mu": 1, "n_phi": 1}), 4.0, 3),
        "zero": (tables(post, far_field={}), 0.0, 2),
        "single batch": (tables(strip, far_field={}), 12.0, 1),
        "curves": (tables(far_field={"n_theta": 180, "n_phi": 6}), 9.0, 3),
        "no detector": (tables(rectangle()), 9.0, 3),
        "no element": (tables(), 9.0, 3),
        "many": (tables(*[rectangle(name=f"{n} {name}") for n in range(70)]), 9.0, 3),
    }
    scene, mean, batches = scenes[which]
    return with_history(make(scene, poisson(mean), batches))


def crowded(axes):
    """Return pairs of tick labels that are in each other's way."""
    found = []
    flat = [axes, *axes.child_axes] if axes.name == "rectilinear" else []
    for each in flat:
        for axis, low, high in (
            (each.xaxis, *sorted(each.get_xlim())), (each.yaxis, *sorted(each.get_ylim()))
        ):  # fmt: skip
            ticks = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
            for text in ("label1", "label2"):
                said = [t for t in (getattr(tick, text) for tick in ticks)
                        if t.get_visible() and t.get_text()]  # fmt: skip
                boxes = [t.get_window_extent() for t in said]
                found += [(a, b) for a, b in pairwise(boxes) if a.overlaps(b)]
    return found


CASES = [
    "long names",
    pytest.param("tall", marks=pytest.mark.slow),
    "zero",
    pytest.param("single batch", marks=pytest.mark.slow),
    "curves",
    "no detector",
    "no element",
    pytest.param("many", marks=pytest.mark.slow),
]


@pytest.fixture(scope="module")
def drawn(full):
    """Return every figure of a result, drawn, by name."""
    figures = all_figures(full)
    for figure in figures.values():
        figure.canvas.draw()
    return figures


@pytest.mark.parametrize("which", ["full", *CASES])
def test_nothing_is_cut_off_and_nothing_in_anothers_way(which, drawn):
    for name, figure in (drawn if which == "full" else all_figures(awkward(which))).items():
        if which != "full":
            figure.canvas.draw()
        renderer = figure.canvas.get_renderer()
        page = figure.bbox
        boxes = [axes.get_tightbbox(renderer) for axes in figure.axes]
        boxes += [legend.get_window_extent(renderer) for legend in figure.legends]
        lines = [text.get_window_extent(renderer) for text in figure.texts]
        for box in [*boxes, *lines]:
            assert box.x0 >= 0.0, name
            assert box.y0 >= 0.0, name
            assert box.x1 <= page.x1, name
            assert box.y1 <= page.y1, name
        head = min(box.y0 for box in lines if box.y0 > 0.5 * page.y1)
        size = figure.texts[0].get_text()
        assert size
        assert max(box.y1 for box in boxes) <= head, name
        # notes beside a plot stand above the footer, which begins at the page's edge
        foot = max(b.y1 for b in lines if b.y1 < 0.5 * page.y1 and b.x0 < 0.05 * page.x1)
        assert min(box.y0 for box in boxes) >= foot, name
        for axes in figure.axes:
            assert not crowded(axes), name
        for a, b in pairwise(sorted(lines, key=lambda box: -box.y1)):
            assert not (a.overlaps(b)), name


def test_letters_are_never_below_eight_points(drawn):
    for name, figure in drawn.items():
        sizes = [t.get_fontsize() for t in figure.findobj(Text) if t.get_text().strip()]
        assert min(sizes) >= 8.0, name
        assert figure.get_figwidth() == 7.0, name


def test_heights_are_whole_steps_of_pixels(drawn):
    for figure in drawn.values():
        assert figure.get_figheight() * 160 % 40 == 0.0


# -- footer --------------------------------------------------------------------------------------


def footer(figure):
    return " ".join(text.get_text() for text in figure.texts)


def test_the_footer_has_rays_sigma_and_lit_fraction(result):
    text = footer(draw_irradiance(result, "target"))
    assert f"N = {result.rays:,} rays" in text
    assert f"{result.batches} batches" in text
    assert f"median relative σ {100.0 * result.achieved_sigma:.3g} % over all maps" in text
    assert "(target 5 %)" in text
    known = result.detectors["target"].map.known_fraction
    assert 0.0 < known < 0.5
    assert f"only {int(1000.0 * known) / 10.0:.1f} % of the bins that rays reach carry" in text


@pytest.mark.parametrize("dark", [0, 40])
@pytest.mark.parametrize(("lit", "warns"), [(0, True), (29, True), (30, False), (60, False)])
def test_the_warning_comes_below_one_half_of_what_rays_reach(lit, dark, warns):
    def counts(_, layout):
        cells = np.zeros(layout.n_cells, np.int64)
        first = layout.detectors[0].map
        cells[first : first + lit] = 10
        cells[first + lit : first + 60] = 9
        return cells

    bins = [6, 10] if not dark else [10, 10]
    made = make(tables(rectangle(name="t", detector={"map": bins})), counts, 1)
    said = footer(draw_irradiance(made, "t"))
    if warns:
        share = int(1000.0 * lit / 60.0) / 10.0
        assert f"Warning: only {share:.1f} % of the bins that rays reach carry" in said
    else:
        assert "Warning" not in said
        assert f"{100.0 * lit / (60 + dark):.1f} % of bins carry at least 10 rays" in said
    assert "σ unknown from a single batch" in said


def test_a_map_that_no_ray_reaches_says_so():
    def nothing(_, layout):
        return np.zeros(layout.n_cells, np.int64)

    made = make(tables(rectangle(name="t", detector={"map": [4, 4]})), nothing, 2)
    assert "Warning: no ray reached any of these bins" in footer(draw_irradiance(made, "t"))


def test_the_lit_fraction_reads_alike_everywhere(capsys):
    def counts(_, layout):
        cells = np.full(layout.n_cells, 10, np.int64)
        cells[layout.detectors[0].map] = 9
        return cells

    made = make(tables(rectangle(name="t", detector={"map": [40, 40]})), counts, 1)
    assert made.lit_fraction == 1599 / 1600
    assert "99.9 % of bins carry at least 10 rays" in footer(draw_irradiance(made, "t"))
    print_result(made, console())
    assert "99.9 % of the bins lit" in capsys.readouterr().out


def test_the_warning_is_not_rounded_away():
    def counts(_, layout):
        cells = np.zeros(layout.n_cells, np.int64)
        first = layout.detectors[0].map
        cells[first : first + 10000] = 9
        cells[first : first + 4998] = 10
        return cells

    made = make(tables(rectangle(name="t", detector={"map": [100, 100]})), counts, 1)
    assert "Warning: only 49.9 %" in footer(draw_irradiance(made, "t"))


def test_every_figure_leads_with_its_own_sigma(result):
    run = f"median relative σ {100.0 * result.achieved_sigma:.3g} % over all maps"
    far = result.far_field
    lit = far.count >= 10
    own = 100.0 * float(np.median(far.sigma[lit] / far.intensity[lit]))
    for draw in (draw_far_field, draw_far_field_cuts):
        text = footer(draw(result))
        assert f"median relative σ of the far field's lit bins {own:.3g} %" in text
        assert text.index("far field's lit bins") < text.index(f"the run: {run}")
    for name in ("target", "rim"):
        m = result.detectors[name].map
        assert m.median_sigma == np.median(m.sigma[m.lit] / m.irradiance[m.lit])
        text = footer(draw_irradiance(result, name))
        own = f"median relative σ of this map {100.0 * m.median_sigma:.3g} %"
        assert text.index(own) < text.index(f"the run: {run}")
    power = result.detectors["target"].power
    own = f"relative σ of the power in all {100.0 * power.sigma / power.value:.3g} %"
    assert own in footer(draw_ladder(result, "target"))


def test_a_single_map_is_what_the_run_is_judged_by():
    made = make(
        tables(rectangle(name="t", detector={"map": [3, 3]})), poisson(50.0), goal=Goal(target=0.05)
    )
    text = footer(draw_irradiance(made, "t"))
    assert f"σ of this map {100.0 * made.achieved_sigma:.3g} % (target 5 %)" in text
    assert "the run" not in text


def test_the_lit_part_of_several_maps_is_not_mixed(capsys):
    """A fine map that is lit would hide a coarse one that is dark."""

    def counts(_, layout):
        cells = np.full(layout.n_cells, 10, np.int64)
        cells[layout.detectors[1].map : layout.detectors[1].map + 3] = 1
        return cells

    fine, coarse = ({"map": [40, 40]}, {"map": [2, 2]})
    made = make(tables(rectangle(name="f", detector=fine), rectangle(name="c", detector=coarse)),
                counts, 2)  # fmt: skip
    assert made.lit_fraction > 0.99
    assert made.least_lit == ("c", 0.25, 2)
    (advice,) = [text for text in made.advisories if "of the bins of" in text]
    assert 'only 25.0 % of the bins of "c" that any ray reaches carry at least 10' in advice
    print_result(made, console())
    said = " ".join(capsys.readouterr().out.split())
    assert "25.0 % of the bins lit on c, the least of 2 maps" in said
    assert ("lit map bins", "25.0 %", "on c, the least of 2 maps") in key_figures(made)


def test_what_stays_dark_is_not_scolded():
    """A spot that is smaller than its map, and known well."""

    def counts(_, layout):
        cells = np.zeros(layout.n_cells, np.int64)
        cells[layout.detectors[0].map + 7] = 100
        return cells

    made = make(tables(rectangle(name="m", detector={"map": [10, 10]})), counts, 8)
    assert made.lit_fraction == 0.01
    assert not [text for text in made.advisories if "carry at least 10" in text]
    assert "Warning" not in footer(draw_irradiance(made, "m"))


# -- files ---------------------------------------------------------------------------------------


def test_names_of_files(full):
    assert figure_names(full) == [
        "layout.png", "ledger.png", "convergence.png", "map-target.png", "map-rim.png",
        "sigma-target.png", "sigma-rim.png", "ladder-target.png", "far-field.png",
        "far-field-cuts.png",
    ]  # fmt: skip
    both = figure_names(full, ("png", "svg"))
    assert both[:2] == ["layout.png", "layout.svg"]
    assert len(both) == 20
    with pytest.raises(ArgumentError, match='formats: found "gif"'):
        figure_names(full, ("gif",))


def test_names_are_unique_whatever_elements_are_called():
    names = ["A b", "a_b", "a:b", "x" * 63, "x" * 64]
    made = make(tables(*[rectangle(name=n, detector={"map": [1, 1]}) for n in names]), poisson(9.0))
    found = figure_names(made)
    assert len(set(found)) == len(found) == 2 + 2 * len(names)
    assert all(len(name) < 120 and "/" not in name for name in found)


def test_scenes_of_very_many_elements_have_no_layout():
    made = make(tables(*[rectangle() for _ in range(501)]), poisson(1.0), 1)
    assert figure_names(made) == ["ledger.png"]


_SKIPPED = {
    f"{stem}.{kind}"  # the same code as what is drawn, in a format that is drawn elsewhere
    for kind, stems in {
        "png": "map-rim sigma-rim",
        "svg": "layout sigma-target map-rim sigma-rim far-field",
        "pdf": "layout sigma-target map-rim sigma-rim far-field ledger ladder-target convergence",
    }.items()
    for stem in stems.split()
}


def test_the_same_result_gives_the_same_bytes(full, tmp_path):
    files = {}
    for turn in ("a", "b"):
        # each figure in one of the formats, in turn
        every = [list(draw_all(full, form)) for form in ("png", "svg", "pdf")]
        turns = [every[n % 3][n] for n in range(len(every[0]))]
        chosen = [(name, draw) for name, draw in turns if name not in _SKIPPED]
        for name, draw in chosen:
            # settings of somebody else's must not show in a file
            other = {"font.size": 17.0, "axes.facecolor": "red"} if turn == "b" else {}
            with matplotlib.rc_context(other):
                draw(tmp_path / name)
            files[turn, name] = (tmp_path / name).read_bytes()
    names = [name for name, _ in chosen]
    assert [name for name in names if files["a", name] != files["b", name]] == []
    assert len(set(files.values())) == len(names)
    for name in names:
        kind = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[name[-3:]]
        assert files["a", name].startswith(kind)
        assert b"<dc:date>" not in files["a", name]
        assert b"/CreationDate" not in files["a", name]


def test_names_in_other_scripts_are_drawn_without_a_word(tmp_path):
    made = make(
        tables(rectangle(name="探测器", detector={"map": [2, 2]}), title="场景"), poisson(9.0)
    )
    written = write_all(made, tmp_path)  # warnings are errors here
    assert [path.name for path in written] == figure_names(made)
    assert sorted(tmp_path.iterdir()) == sorted(written)


# -- helpers -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [
        (1.0, 1.0, "W"), (0.9999, 1.0, "W"), (0.5, 1e3, "mW"), (999.0, 1.0, "W"), (1e3, 1e-3, "kW"),
        (2e-6, 1e6, "µW"), (0.0, 1.0, "W"), (1e40, 1.0, "W"), (float("nan"), 1.0, "W"),
    ],
)  # fmt: skip
def test_prefixes(largest, factor, unit):
    assert prefixed(largest, "W") == (pytest.approx(factor), unit)


def test_text_is_cut_to_its_room():
    assert fitted("short", 8.0, 1.0) == "short"
    cut = fitted("long " * 50, 8.0, 1.0)
    assert cut.endswith("…")
    assert 0.8 < inches(cut, 8.0) <= 1.0


def test_rays_are_drawn_where_they_are_given(result):
    import photizon_cl as pz

    paths = pz.paths(result.scene, 20, 1)
    figure = draw_layout(result, paths)
    assert "20 rays of seed 1" in footer(figure)
    lines = figure.axes[0].collections[1]
    assert len(lines.get_segments()) >= 20
    assert len(draw_layout(result).axes[0].collections[1].get_segments()) == 0
