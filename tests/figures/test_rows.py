"""Ledger, ladder, convergence and polar cuts: dots, error bars and lines are the numbers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from made_up import make, poisson, rectangle, some_lit, tables
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from photizon_cl.errors import ArgumentError
from photizon_cl.result.stopping import Goal
from photizon_cl.views.figures import (
    draw_convergence,
    draw_far_field_cuts,
    draw_ladder,
    draw_ledger,
)


def errors(axes, across):
    """Return (middle, half length) of every error bar along x (0) or y (1)."""
    (container,) = axes.containers[-1:]
    (bars,) = container.lines[2]
    ends = np.array([segment[:, across] for segment in bars.get_segments()])
    return ends.mean(axis=1), 0.5 * (ends[:, 1] - ends[:, 0])


def texts(axis):
    return [label.get_text() for label in axis.get_ticklabels()]


# -- ledger --------------------------------------------------------------------------------------


RAYS = 2**24


def rows_of(random, layout):
    """Return a ledger of a batch with everything in it."""
    weights = np.zeros(layout.n_cells, np.int64)
    share = random.normal([0.6, 1e-4, 1e-9, 0.0, 3e-13], [1e-4, 1e-5, 1e-9, 0.0, 0.0])
    weights[:5] = np.abs(share) * RAYS * 2**31
    weights[layout.killed], weights[layout.boosted] = random.poisson(2**40), 2**50
    return np.sign(weights), weights


@pytest.fixture(scope="module")
def ledger():
    """Return a result with powers over twelve decades, a zero, and a negative balance."""
    scene = tables(*[rectangle() for _ in range(5)], run={"rays_per_batch": RAYS})
    scene["source"][0]["flux"] = 2.0
    return make(scene, rows_of)


def dots(axes, label="power"):
    """Return x and y of the dots drawn under a label, and the line that has them."""
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return *(np.asarray(values) for values in found.get_data()), found


def test_dots_and_errors_of_the_ledger(ledger):
    figure = draw_ledger(ledger)
    axes = figure.axes[0]
    rows = ledger.ledger.rows()
    assert axes.get_xscale() == "log"
    assert texts(axes.yaxis) == [name for name, _ in rows]
    seen = [(n, row) for n, (_, row) in enumerate(rows) if abs(row.value) >= 1e-12 * 2.0]
    power, places, line = dots(axes)
    np.testing.assert_array_equal(power, [row.value for _, row in seen if row.value > 0.0])
    np.testing.assert_array_equal(places, [n for n, row in seen if row.value > 0.0])
    assert line.get_linestyle() == "None"
    assert not axes.patches  # a bar on a logarithmic axis would begin anywhere
    middle, half = errors(axes, 0)
    np.testing.assert_allclose(middle, [abs(row.value) for _, row in seen], rtol=1e-9)
    np.testing.assert_allclose(half, [row.sigma for _, row in seen], rtol=1e-6, atol=1e-16)
    assert max(half) > 0.0


def test_zeros_are_said_and_negatives_marked(ledger):
    figure = draw_ledger(ledger)
    axes = figure.axes[0]
    rows = ledger.ledger.rows()
    zeros = sum(row.value == 0.0 for _, row in rows)
    assert zeros == 3
    assert [t.get_text() for t in axes.texts] == ["0", "◂", "0", "0"]  # e3, e4, escaped, capped
    assert 0.0 < ledger.ledger.absorbed["e4"].value < 2e-12
    balance = ledger.ledger.roulette.balance.value
    assert balance < 0.0
    size, _, line = dots(axes, "negative")
    np.testing.assert_array_equal(size, [-balance])
    assert (line.get_marker(), line.get_markerfacecolor()) == ("s", "white")
    numbers = texts(axes.child_axes[0].yaxis)
    assert numbers[-2].startswith("−")
    assert [text for text in numbers if text == "0"] == ["0"] * zeros
    assert any("open square: negative" in t.get_text() for t in figure.texts)


def test_the_axis_reaches_down_to_the_smallest_power():
    def faint(_, layout):
        weights = np.zeros(layout.n_cells, np.int64)
        weights[:2] = [2**54, 10**5]
        return np.sign(weights), weights

    scene = tables(rectangle(), rectangle(), run={"rays_per_batch": RAYS})
    made = make(scene, faint)
    axes = draw_ledger(made).axes[0]
    value = made.ledger.absorbed["e1"].value
    assert 1e-12 < value < 1e-11
    assert 0.0 < axes.get_xlim()[0] < value
    assert dots(axes)[0][1] == value


def test_powers_below_the_least_are_said_and_not_drawn(ledger):
    figure = draw_ledger(ledger)
    assert dots(figure.axes[0])[0].min() == ledger.ledger.absorbed["e2"].value
    assert any("◂ below 1e-12" in t.get_text() for t in figure.texts)


def test_many_elements_are_the_largest_24_and_the_rest():
    random = np.random.default_rng(2)
    order = random.permutation(60)
    scene = tables(*[rectangle() for _ in range(60)])
    made = make(scene, lambda r, layout: np.append(10 * order, np.zeros(layout.n_cells - 60, int)))
    axes = draw_ledger(made).axes[0]
    largest = [f"e{n}" for n in np.argsort(-order)[:24]]
    names = texts(axes.yaxis)
    assert names == [*largest, "36 more elements", "escaped", "roulette balance", "depth-capped"]
    rest = sum(row.value for name, row in made.ledger.absorbed.items() if name not in largest)
    power, places, _ = dots(axes)
    assert places[24] == 24
    assert power[24] == pytest.approx(rest)
    assert texts(axes.child_axes[0].yaxis)[24] == f"together {rest:.3g}"
    assert len(errors(axes, 0)[0]) == 24  # the sum of correlated rows has no error bar


def test_ledger_and_ladder_are_drawn_into_axes_of_ones_own(ladder):
    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    assert draw_ledger(ladder, ax=left) is draw_ladder(ladder, "t", ax=right) is figure
    assert texts(left.yaxis) == [name for name, _ in ladder.ledger.rows()]
    known = [rung for rung in ladder.detectors["t"].ladder if rung.count >= 10]
    np.testing.assert_array_equal(dots(right)[1], [rung.value for rung in known])
    assert not figure.texts
    figure.canvas.draw()


def test_a_single_batch_has_no_error_bars():
    axes = draw_ledger(make(tables(rectangle()), poisson(50.0), 1)).axes[0]
    assert all(not hasattr(c, "has_xerr") for c in axes.containers)
    assert not any("±" in text for text in texts(axes.child_axes[0].yaxis))


# -- ladder --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ladder():
    """Return a result with a ladder of 12 entries, some empty and some below 10 arrivals."""
    mean = np.array([0, 1e6, 1e5, 0, 1e4, 300, 40, 0, 0, 1, 0, 5])
    batch, odd = iter(range(4)), iter((1, 0))

    def counts(random, layout):
        cells = np.zeros(layout.n_cells, np.int64)
        d = layout.detectors[0]
        cells[d.ladder : d.ladder + 12] = random.poisson(mean)
        cells[d.ladder + 7] = cells[d.ladder + 8] = 2
        if next(batch) < 2:  # 9 and 10 arrivals in all: just open, just full
            cells[d.ladder + 8] += 1
            cells[d.ladder + 7] += next(odd)
        return cells

    return make(tables(rectangle(name="t", detector={"generations": 12})), counts)


def test_dots_of_the_ladder_and_which_are_open(ladder):
    axes = draw_ladder(ladder, "t").axes[0]
    rungs = [rung for rung in ladder.detectors["t"].ladder if rung.count]
    for label, few in (("below 10 rays", True), ("power", False)):
        places, power, line = dots(axes, label)
        chosen = [rung for rung in rungs if (rung.count < 10) is few]
        np.testing.assert_array_equal(places, [rung.generation for rung in chosen])
        np.testing.assert_array_equal(power, [rung.value for rung in chosen])
        assert (line.get_markerfacecolor() == "white") is few
        assert line.get_linestyle() == "None"
        assert (8 if few else 7) not in places
    assert (ladder.detectors["t"].ladder[7].count, ladder.detectors["t"].ladder[8].count) == (9, 10)
    assert axes.get_yscale() == "log"
    assert not axes.patches
    assert "below 10 rays" in [text.get_text() for text in axes.get_legend().get_texts()]


@pytest.mark.parametrize("mean", [(900.0,), (900.0, 90.0, 30.0, 11.0), tuple([900.0] * 16)])
def test_no_tick_of_the_ladder_is_above_what_was_emitted(mean):
    """However many numbers have to find room; and at least two ticks are labelled."""

    def counts(random, layout):
        cells = np.zeros(layout.n_cells, np.int64)
        first = layout.detectors[0].ladder
        cells[first : first + len(mean)] = random.poisson(np.array(mean) / len(mean))
        return cells

    made = make(tables(rectangle(name="t", detector={"generations": len(mean)})), counts)
    figure = draw_ladder(made, "t")
    figure.canvas.draw()
    axes = figure.axes[0]
    for axis, most in ((axes, made.ledger.emitted.value), (axes.child_axes[0], 1.0)):
        low, high = axis.get_ylim()
        said = [
            place
            for place, label in zip(axis.get_yticks(), axis.get_yticklabels(), strict=True)
            if label.get_text() and low <= place <= high
        ]
        assert len(said) >= 2
        assert max(said) <= most * 1.001
    labels = [text for text in texts(axes.xaxis) if text]
    assert labels[-1] == f"≥ {len(mean) - 1}"
    assert axes.get_xlim()[1] < len(mean)  # nothing stands right of the last entry


def test_errors_of_the_ladder(ladder):
    axes = draw_ladder(ladder, "t").axes[0]
    rungs = [rung for rung in ladder.detectors["t"].ladder if rung.count]
    middle, half = errors(axes, 1)
    np.testing.assert_allclose(middle, [rung.value for rung in rungs], rtol=1e-9)
    np.testing.assert_allclose(half, [rung.sigma for rung in rungs], rtol=1e-6, atol=1e-12)


def test_the_last_entry_collects(ladder):
    figure = draw_ladder(ladder, "t")
    figure.canvas.draw()
    assert [text for text in texts(figure.axes[0].xaxis) if text][-2:] == ["10", "≥ 11"]
    with pytest.raises(ArgumentError, match="expected one whose detector has a ladder"):
        draw_ladder(ladder, "e1")


# -- convergence ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run(result):
    """Return a result with a history of its own."""
    rows = [(1, 0.5, None), (4, 0.8, 0.21), (16, 1.6, 0.09), (64, 5.0, 0.052), (100, 8.0, 0.041)]
    info = dataclasses.replace(result.info, history=tuple(rows), goal=Goal(target=0.05))
    return type(result)(result.compiled, result.tally, info)


def line(axes, label):
    (found,) = [a for a in axes.lines if a.get_label().startswith(label)]
    return np.array(found.get_data(), float)


def test_points_are_those_of_the_run(run):
    figure = draw_convergence(run)
    known = run.history[1:]
    for axes, field in zip(figure.axes, ("rays", "seconds"), strict=True):
        x, y = line(axes, "this run")
        np.testing.assert_array_equal(x, known[field])
        np.testing.assert_array_equal(y, known["sigma"])
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_the_reference_has_slope_minus_one_half_through_the_last_point(run):
    for axes in draw_convergence(run).axes:
        x, y = line(axes, "slope")
        assert np.diff(np.log(y)) / np.diff(np.log(x)) == pytest.approx(-0.5, rel=1e-12)
        last = line(axes, "this run")[:, -1]
        assert y[-1] * np.sqrt(x[-1] / last[0]) == pytest.approx(last[1], rel=1e-12)
        assert x[0] <= last[0] <= x[-1]


def test_the_target_is_drawn_where_the_run_had_one(run):
    for axes in draw_convergence(run).axes:
        assert line(axes, "target 5 %")[1] == pytest.approx(0.05)
    info = dataclasses.replace(run.info, goal=Goal(batches=100))
    free = type(run)(run.compiled, run.tally, info)
    for axes in draw_convergence(free).axes:
        assert not [a for a in axes.lines if a.get_label().startswith("target")]


def test_a_result_without_history_says_so(result):
    with pytest.raises(ArgumentError, match="holds no history"):
        draw_convergence(result)


# -- polar cuts ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def far():
    """Return a result with a far field of 12 × 8 bins, a part of them poor."""
    return make(tables(far_field={"n_mu": 12, "n_phi": 8}), some_lit)


def halves(axes):
    """Return the thin outlines and the thick arcs, in the order in which they are drawn."""
    return axes.lines[::2], axes.lines[1::2]


def test_cuts_are_the_bins_around_their_planes(far):
    axes = draw_far_field_cuts(far, (0.0, 90.0)).axes[0]
    intensity, few = far.far_field.intensity, far.far_field.hatched
    theta = np.arccos(far.far_field.mu_edges)
    thin, thick = halves(axes)
    for n, k in enumerate((0, 4, 2, 6)):  # φ = 0°, 180°, 90°, 270° with bins of 45°
        left = n % 2 == 1
        angle, radius = (np.asarray(a) for a in thin[n].get_data())
        turned = 2.0 * np.pi - angle if left else angle
        for j in range(12):
            inside = (turned < theta[j] - 1e-9) & (turned > theta[j + 1] + 1e-9)
            assert inside.any()
            assert set(radius[inside]) == {intensity[j, k]}
            strong = np.asarray(thick[n].get_ydata())[inside]
            assert np.isnan(strong).all() if few[j, k] else set(strong) == {intensity[j, k]}
            # from edge to edge: a bin is an arc, not a point
            for edge in theta[j : j + 2]:
                assert intensity[j, k] in radius[np.isclose(turned, edge, rtol=0.0, atol=1e-9)]
    assert few.any()


def test_bands_of_cuts_are_one_sigma(far):
    axes = draw_far_field_cuts(far, (0.0,)).axes[0]
    right = axes.collections[0].get_paths()[0].vertices
    value, sigma = far.far_field.intensity[:, 0], far.far_field.sigma[:, 0]
    theta = np.arccos(far.far_field.mu_edges)
    for j in range(12):
        inside = (right[:, 0] < theta[j] - 1e-9) & (right[:, 0] > theta[j + 1] + 1e-9)
        found = right[inside, 1]
        assert found.min() == pytest.approx(max(value[j] - sigma[j], 0.0), abs=1e-12)
        assert found.max() == pytest.approx(value[j] + sigma[j])


def test_planes_are_checked(far):
    assert len(draw_far_field_cuts(far, (359.0, -10.0, 45.0)).axes[0].lines) == 12
    for planes in ((), (0.0,) * 7, (float("nan"),)):
        with pytest.raises(ArgumentError, match="planes: found"):
            draw_far_field_cuts(far, planes)
    with pytest.raises(ArgumentError, match="no far field"):
        draw_far_field_cuts(make(tables(rectangle()), poisson(5.0)))


def test_a_single_batch_has_no_band():
    axes = draw_far_field_cuts(make(tables(far_field={}), poisson(20.0), 1)).axes[0]
    assert len(axes.lines) == 8
    assert not axes.collections
