"""``pz.cost`` and ``photizon cost``: what its rows say is what a trace says."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result.cost import TARGETS, CostSetting, CostStudy, TargetTime
from photizon_cl.result.cost_advice import advice
from photizon_cl.result.cost_file import is_study, read_study, study_text
from photizon_cl.result.stopping import achieved_sigma
from photizon_cl.studies.cost_files import check_folder, save
from photizon_cl.studies.costing import Study
from photizon_cl.studies.knobs import KNOBS, Option, as_it_stands
from photizon_cl.studies.trial import Bins, Trial, _curve, firm
from photizon_cl.views.report.writing import beside

pytestmark = pytest.mark.usefixtures("built_quickly")

SPHERE = "integrating-sphere"
RAYS = 1024


def small(name=SPHERE, **run):
    scene = pz.load(name)
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, rays_per_batch=RAYS, **run)
    )


def traced(option, batches, quantity="ledger.escaped"):
    trial = Trial(option, quantity, None)
    trial.advance(batches // 2, lambda: False)
    trial.advance(batches - batches // 2, lambda: False)
    return trial


@pytest.fixture(scope="module")
def pair():
    """A scene as it stands, and the same with a cap that cuts some."""
    scene = small()
    capped = Option("cap 20", "generation_cap", 20, "", small(generation_cap=20))
    return traced(as_it_stands(scene), 40), traced(capped, 30)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study of some seconds, its directory, and what the verb printed of it."""
    folder = tmp_path_factory.mktemp("cost")
    scene = dataclasses.replace(small().run, max_seconds=4.0)
    some = Study(dataclasses.replace(small(), run=scene), None, None, lambda _: None, KNOBS[1:4])
    return some.run(), folder


def test_a_row_says_what_a_trace_says(pair):
    reference, capped = pair
    row, other = (trial.row(reference) for trial in pair)
    result = pz.trace(small(), batches=40)
    again = pz.trace(small(generation_cap=20), batches=40)
    quantity = result.quantity("ledger.escaped")
    assert row.estimate == quantity.value
    assert row.sigma == pytest.approx(quantity.sigma, rel=1e-12)
    assert np.array_equal(reference.values(), result.batch_values("ledger.escaped"))
    assert np.array_equal(capped.values(), again.batch_values("ledger.escaped")[:30])
    assert (row.bias, row.bias_sigma, row.paired) == (0.0, 0.0, True)
    assert row.rays == 40 * RAYS
    assert row.closure == other.closure == 0.0
    # the same streams: what the cap cuts, and no more, as `compare` has it of as many batches
    found = pz.compare(
        pz.trace(small(), batches=30), pz.trace(small(generation_cap=20), batches=30)
    )
    assert other.bias == pytest.approx(found["ledger.escaped"].difference, rel=1e-9)
    assert other.bias_sigma == pytest.approx(found["ledger.escaped"].sigma, rel=1e-9)
    assert other.is_biased
    assert not row.is_biased


def test_other_batches_are_held_against_it_in_quadrature(pair):
    reference, _ = pair
    trial = traced(Option("few", "rays_per_batch", 512, "", small()), 2)
    assert trial.row(reference).paired
    scene = dataclasses.replace(small().run, rays_per_batch=512)
    other = Option("few", "rays_per_batch", 512, "", dataclasses.replace(small(), run=scene))
    row = traced(other, 12).row(reference)
    assert not row.paired
    assert row.bias == pytest.approx(row.estimate - reference.row(reference).estimate)
    assert row.bias_sigma == pytest.approx(
        math.hypot(row.sigma, reference.row(reference).sigma), rel=1e-12
    )


def test_of_a_map_it_is_the_median_that_a_run_is_judged_by():
    scene = small("box-room")
    trial = traced(as_it_stands(scene), 24, "detectors.floor.map")
    result = pz.trace(scene, batches=24, target_on=["detectors.floor.map"], target=1e-9)
    row = trial.row(trial)
    want = achieved_sigma(result.compiled.layout, result.tally)
    assert row.relative_sigma == pytest.approx(want, rel=1e-6)  # kept as floats
    assert row.estimate == result.quantity("detectors.floor.power").value


def made(trial, seconds_of_a_batch):
    """Give a trial made-up times."""
    trial.times = [seconds_of_a_batch * (n + 1) for n in range(trial.batches)]
    return trial


def test_bins_that_do_not_scatter_have_no_sigma():
    # random values of all bits, whose squares are rounded
    r = np.random.default_rng(5)
    bins = Bins(0, 64)
    cells = np.zeros((64, 4), np.int64)
    cells[:, 0] = r.integers(1 << 29, 1 << 31, 64)
    cells[:, 1] = r.integers(0, 1 << 32, 64)
    cells[:, 3] = 100
    for _ in range(40):
        bins.add(cells)
    assert bins.curve()[-1] == (40, 0.0)


@pytest.mark.parametrize("batches", [2, 3, 8, 15, 16, 30, 200])
def test_of_few_batches_a_bias_is_not_claimed_by_chance(batches):
    """400 groups of normal numbers without a bias: 1 in 16 000 each, 1 in 40 for all of them."""
    r = np.random.default_rng(7)
    for _ in range(400):
        x = r.normal(size=batches)
        row = dataclasses.replace(
            row_of("a"), bias=float(x.mean()), bias_batches=batches,
            bias_sigma=float(x.std(ddof=1) / math.sqrt(batches)),
        )  # fmt: skip
        assert not row.is_biased
    # and a large one is, of enough
    row = dataclasses.replace(row_of("a"), bias=0.1, bias_sigma=0.01, bias_batches=batches)
    assert row.is_biased == (batches >= 16)


def test_settings_are_tried_beside_a_cap_that_cuts_nothing():
    scene = small(generation_cap=20, max_seconds=3.0)
    study = Study(scene, None, None, lambda _: None, KNOBS[2:4]).run()
    assert study[study.given].is_biased
    assert study.reference != study.given
    reference = study[study.reference]
    assert reference.knob == "generation_cap"
    rows = [row for row in study if row.knob == "roulette_floor"]
    # what the cap cuts is no fault of theirs
    assert not any(row.is_biased for row in rows)
    assert f"write {reference.written}" in study.advice[0]


def test_sigma_of_bins_is_of_the_same_bins_everywhere():
    """Half of the bins dark so far: alone they would not count, and σ would look small."""
    few, many = Bins(0, 4), Bins(0, 4)
    r = np.random.default_rng(3)
    for _ in range(20):
        cells = np.zeros((4, 4), np.int64)
        cells[:2, 1], cells[:2, 3] = r.integers(900, 1100, 2), 100
        dark = cells.copy()
        cells[2:, 1], cells[2:, 3] = r.integers(1, 100, 2), 3
        few.add(dark)
        many.add(cells)
    assert few.curve()[-1][1] < 0.2 * many.curve()[-1][1]
    few.judge(many.lit)
    # two of four bins never lit: no median
    assert few.curve()[-1][1] == math.inf


def closed_sphere():
    lamp = pz.IsotropicPoint(name="lamp", position=[0, 0, 0], flux=1.0)
    ball = pz.Sphere(
        name="ball", position=[0, 0, 0], axis="+z", radius=1.0, surface=pz.Lambertian(0.5)
    )
    run = pz.RunSettings(rays_per_batch=RAYS, max_seconds=1.0)
    return pz.Scene(name="closed", source=[lamp], element=[ball], run=run)


def test_a_quantity_that_is_0_is_not_studied_unless_it_is_asked_for():
    study = Study(closed_sphere(), None, None, lambda _: None, ()).run()
    assert study.quantity == "ledger.absorbed.ball"
    assert study["fp64"].estimate == pytest.approx(1.0, abs=1e-9)
    study = Study(closed_sphere(), "ledger.escaped", None, lambda _: None, ()).run()
    assert study.quantity == "ledger.escaped"
    assert study["fp64"].estimate == 0.0
    assert study.advice[0].startswith("nothing arrives at ledger.escaped: name another quantity")


def test_seconds_to_a_target_are_those_of_its_batches(pair):
    trial = made(traced(as_it_stands(small()), 40), 0.5)
    row = trial.row(trial)
    values = trial.values()
    final = values.mean()
    for target in row.targets:
        sigmas = [values[:n].std(ddof=1) / math.sqrt(n) / final for n in range(8, 41)]
        reached = next((n for n, s in enumerate(sigmas, 8) if s <= target.target), None)
        if reached is None:
            assert target.measured_seconds is None
            # all batches tell: the square of what is missing, times what it took
            assert target.predicted_seconds == pytest.approx(
                20.0 * (sigmas[-1] / target.target) ** 2, rel=1e-9
            )
        else:
            assert target.measured_seconds == 0.5 * reached
    assert row.figure_of_merit == pytest.approx(1.0 / (row.relative_sigma**2 * 20.0))


def row_of(name, knob="roulette_floor", *, merit=1.0, bias=0.0, sigma=0.0, closure=0.0):
    """A row of a value of 1 W whose σ is 1 % at a figure of merit of `merit` in 10⁴/s."""
    none = tuple(TargetTime(target, 1.0, None) for target in TARGETS)
    return CostSetting(
        name, knob, name, f"set {name}", 401, 401, 1.0 / merit, 0.0, 0.0, 1.0, 1.0, 0.01, bias,
        sigma, True, 401, closure, none, ((1.0, 0.01),),
    )  # fmt: skip


def study_of(*rows, given=None, reference="fp64"):
    first = given or row_of("fp64", "precision")
    return CostStudy("scene", "", "device", "q", "fp64", reference, 1, 1, 1.0, (first, *rows), ())


def test_advice_says_what_is_worth_it():
    found = study_of(row_of("a", merit=6.0, sigma=1e-4), row_of("b", merit=2.0))
    (text,) = advice(found)
    assert text.startswith("set a gives the same σ in 0.17 of the time (6 ± 0.6 times as soon)")
    assert "no bias shows, to 0.01 %" in text
    assert found.gain(found["a"])[0] == pytest.approx(6.0)


def test_advice_never_recommends_what_is_biased():
    (text,) = advice(study_of(row_of("a", merit=6.0, bias=-0.002, sigma=1e-4)))
    assert text == "set a is off by -0.2 % ± 0.01 %, though 6 times as soon to the same σ"
    # 3.9 standard errors are chance, for one of many rows
    assert "is off by" not in advice(study_of(row_of("a", bias=3.9e-4, sigma=1e-4)))[0]


def test_advice_does_not_make_much_of_a_small_bias():
    found = study_of(row_of("a", merit=6.0, bias=-3e-4, sigma=1e-6), row_of("b", bias=1e-8))
    small, sooner = advice(found)
    assert small == (
        "off by less than 0.05 %, which is no matter where σ is 0.5 %: set a (-0.03 %), "
        "set b (1e-06 %)"
    )
    assert sooner.startswith("set a gives the same σ in 0.17 of the time")
    assert sooner.endswith("its bias is -0.03 % ± 0.0001 %")


def test_advice_says_where_the_scene_itself_is_off():
    given = dataclasses.replace(row_of("fp64", "precision"), bias=-0.1, bias_sigma=1e-3)
    text = advice(study_of(row_of("cap 99", "generation_cap"), given=given, reference="cap 99"))[0]
    assert text.startswith("the scene as it stands is off by -9.09 % ± 0.09 % against cap 99")
    assert text.endswith("write set cap 99")


def test_a_pace_that_is_not_known_is_no_gain(pair):
    steady, _ = pair
    steady.turns = [(1, 9.0), (4, 2.0), (8, 4.0), (4, 2.0)]
    assert steady.row(steady).pace_error == 0.0
    steady.turns = [(1, 9.0), (4, 2.0), (4, 4.0)]
    assert steady.row(steady).pace_error == pytest.approx(1.0 / 3.0)
    unsteady = dataclasses.replace(row_of("a", merit=2.0), pace_error=0.3)
    (text,) = advice(study_of(unsteady))
    assert (
        text == "roulette_floor: no value that was tried is surely sooner to a σ by a fifth or more"
    )


def test_advice_names_what_does_not_close_and_what_takes_longer():
    texts = advice(study_of(row_of("a", closure=1e-9), row_of("b", "splitting", merit=0.1)))
    assert texts == (
        "set a leaves 1.0e-09 of the power unaccounted for",
        "roulette_floor: no value that was tried is surely sooner to a σ by a fifth or more",
        "set b takes 10 times as long to the same σ",
    )


def test_where_nothing_scatters_there_is_no_merit_and_it_is_said():
    given = dataclasses.replace(row_of("fp64", "precision"), sigma=1e-16)
    found = study_of(row_of("a"), given=given)
    assert found.is_certain
    assert found.gain(found["a"]) is None
    assert "every batch gave the same q" in advice(found)[0]


@pytest.mark.parametrize("name", ["integrating-sphere", "ghost-ladder", "box-room"])
def test_knobs_change_one_thing_each_and_never_to_what_it_is(name):
    scene = pz.load(name)
    options = [option for knob in KNOBS for option in knob(scene, 1000)]
    assert len({option.name for option in options}) == len(options)
    for option in options:
        if option.plain or option.precision != "fp64":
            assert option.scene == scene
        else:
            want = dataclasses.replace(scene.run, **{option.knob: option.value})
            assert option.scene == dataclasses.replace(scene, run=want)
            assert option.scene != scene
            key, value = option.written.split(" = ")
            assert {key: json.loads(value)} == {option.knob: option.value}
    assert any(o.knob == "splitting" for o in options) == (name == "ghost-ladder")


def test_a_study_has_a_row_for_each_setting_and_its_json_is_finite(study):
    found, _ = study
    summary = json.loads(json.dumps(found.summary(), allow_nan=False))
    assert summary["schema"] == "photizon-cost/1"
    assert found.quantity == "ledger.escaped"
    assert found.scene_digest == small().digest()
    names = [row["name"] for row in summary["settings"]]
    assert len(set(names)) == len(names)
    assert {"fp64", "mixed", "roulette 0.1", "cap 1000"} <= {
        *names, *(item["name"] for item in summary["left_out"])
    }  # fmt: skip
    reference = found[found.reference]
    assert (reference.bias, reference.bias_sigma) == (0.0, 0.0)
    assert found.gain(found[found.given])[0] == 1.0
    for row in found:
        assert row.batches * row.rays > 0 < row.seconds
        assert len(row.targets) == len(TARGETS)


def test_the_same_setting_twice_is_told(study):
    found, _ = study
    with pytest.raises(pz.UnknownNameError, match="cost study"):
        found["roulette 7"]


def test_the_verb_writes_and_says_the_same(capsys, tmp_path, monkeypatch, study):
    found, _ = study
    monkeypatch.setattr("photizon_cl.studies.costing.cost", lambda *_, **__: found)
    out = tmp_path / "study"
    assert main(["cost", SPHERE, "--out", str(out), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == found.summary() == json.loads((out / "cost.json").read_text())
    assert (out / "cost.png").read_bytes().startswith(b"\x89PNG")
    check_folder(out)  # its own may be replaced
    assert main(["cost", SPHERE]) == 0
    text = capsys.readouterr().out
    assert all(len(line) <= 80 for line in text.splitlines())
    assert all(row.name in text for row in found)
    for line in found.advice:
        assert line.split()[0] in text


def test_what_is_not_ours_is_kept(capsys, tmp_path):
    (tmp_path / "cost.json").write_text('{"mine": 1}')
    assert main(["cost", SPHERE, "--out", str(tmp_path)]) == 2
    assert "is no cost study" in capsys.readouterr().err
    assert (tmp_path / "cost.json").read_text() == '{"mine": 1}'
    (tmp_path / "cost.json").unlink()
    (tmp_path / "cost.png").write_text("mine")
    with pytest.raises(pz.ResultError, match="no photizon figure"):
        check_folder(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--quantity", "detectors.nothing.power"], "nothing"),
        (["--quantity", "sigma"], "expected a quantity"),
        (["--max-seconds", "0"], "max_seconds"),
        (["--out", ""], "--out: found nothing"),
        (["--set", "run.splitting=7"], "expected true or false"),
    ],
)
def test_bad_input_is_one_line(capsys, arguments, message):
    assert main(["cost", SPHERE, *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error


def test_a_study_is_read_as_it_was_written(tmp_path, study):
    found, _ = study
    path = tmp_path / "cost.json"
    path.write_text(study_text(found))
    assert read_study(path) == found
    assert is_study(path)


@pytest.mark.parametrize(
    "damage",
    [
        lambda d: d.pop("settings"),
        lambda d: d.update(schema="photizon-result/1"),
        lambda d: d.update(reference="none of them"),
        lambda d: d.update(seconds="long"),
        lambda d: d["settings"][0].update(estimate=None),
        lambda d: d["settings"][0].update(points=[[-1.0, 1.0]]),
        lambda d: d["settings"][0].update(targets=[]),
        lambda d: d["settings"].append(7),
        lambda d: d.update(left_out=[["a", "b"]]),
    ],
)
def test_what_is_no_study_is_refused(tmp_path, study, damage):
    tables = json.loads(study_text(study[0]))
    damage(tables)
    path = tmp_path / "cost.json"
    path.write_text(json.dumps(tables))
    with pytest.raises(ValueError, match=r"lack|schema"):
        read_study(path)


def test_the_report_of_a_result_has_the_study_beside_it(tmp_path, study):
    found, _ = study
    # a result with few figures; the study is of another scene, and it is said
    scene = dataclasses.replace(small(), far_field=None)
    result = pz.trace(scene, batches=8)
    save(found, tmp_path)
    result.save(tmp_path, figures=False)  # a study there is no reason to refuse
    assert main(["report", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text()
    assert '<h2 id="cost">' in page
    assert "It is of other settings than" in page
    assert all(row.name in page for row in found)


def test_a_damaged_study_is_told_and_left_out(tmp_path):
    (tmp_path / "cost.json").write_text("{")
    study, remarks = beside(tmp_path)
    assert study is None
    assert "is left out of the report" in remarks[0]
    assert beside(tmp_path / "nothing") == (None, [])


@pytest.mark.slow
def test_all_knobs_of_a_scene_that_splits():
    found = pz.cost("plano-convex-condenser", max_seconds=90.0, quantity="detectors.focus.map")
    assert {row.knob for row in found} == {
        "precision", "roulette_floor", "generation_cap", "splitting", "rays_per_batch", "geometry",
        "tally",
    }  # fmt: skip
    # one child has the same expectation; what the cap cuts shows, with a sign
    assert not found["one child"].is_biased
    assert found["cap 4"].is_biased
    assert found["cap 4"].bias < 0.0
    assert found["one child"].interactions_per_s > 0.0
    assert found["mixed"].closure <= 1e-15


def test_before_anything_came_no_target_is_met():
    """One arrival in the first 16 batches, then some in each: σ began far below what it is."""
    values = np.zeros(400)
    values[7] = 1e-3
    values[16:] = np.random.default_rng(1).poisson(0.2, 384)
    curve = _curve(values, float(values.mean()))
    assert min(sigma for n, sigma in curve if n >= 8) < 0.01  # as if 1 % were known at once
    kept = dict(firm(curve))
    last = math.sqrt(400) * kept[400]
    assert kept[400] == dict(curve)[400]
    assert all(sigma * math.sqrt(n) >= 0.5 * last for n, sigma in kept.items())
    assert 8 not in kept
    assert len(kept) > 350
    # of what comes all the time nothing is left out from the eighth batch on
    steady = _curve(np.random.default_rng(2).normal(1.0, 0.1, 400), 1.0)
    assert {n for n, _ in steady if n >= 8} <= set(dict(firm(steady)))


def test_a_rare_arrival_does_not_make_a_target_cheap():
    trial = traced(as_it_stands(small()), 16)
    unit = trial.totals[0] // 10**5
    # nothing but one weak ray in the first half of 160 batches
    later = 100 * np.random.default_rng(3).poisson(0.4, 80)
    counts = [0] * 7 + [1] + [0] * 72 + later.tolist()
    trial.totals, trial.times = [unit * n for n in counts], np.linspace(0.1, 16.0, 160).tolist()
    row = trial.row(trial)
    last = row.sigma / row.estimate
    assert 0.1 < last < 0.3
    for target in row.targets:
        assert target.measured_seconds is None
        wanted = row.seconds * (last / target.target) ** 2
        assert target.predicted_seconds == pytest.approx(wanted, rel=1e-9)
    assert all(sigma > 0.1 for _, sigma in row.points)
