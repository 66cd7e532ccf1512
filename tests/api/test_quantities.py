"""Quantities by name, what each batch gave of them, and targets on them."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.compile.quantities import quantity_of, scalars
from photizon_cl.result import batch_values as module

pytestmark = pytest.mark.usefixtures("built_quickly")

FEW = {"batches": 12, "rays_per_batch": 512}


@pytest.fixture(scope="module")
def room():
    return pz.trace("box-room", **FEW)


# -- names ---------------------------------------------------------------------------------------


def test_every_scalar_is_what_ledger_and_detectors_say(room):
    names = room.quantity_names
    assert len(set(names)) == len(names)
    for element in room.scene.element:
        name = f'ledger.absorbed."{element.name}"'
        assert room.quantity(name).value == room.ledger.absorbed[element.name].value
        assert room.quantity(name).sigma == room.ledger.absorbed[element.name].sigma
    for name, row in (
        ("escaped", room.ledger.escaped),
        ("depth_capped", room.ledger.depth_capped),
        ("roulette.killed", room.ledger.roulette.killed),
        ("roulette.boosted", room.ledger.roulette.boosted),
    ):
        assert f"ledger.{name}" in names
        assert room.quantity(f"ledger.{name}") == row
    floor = room.detectors["floor"]
    assert room.quantity("detectors.floor.power") == floor.power
    for g, rung in enumerate(floor.ladder):
        found = room.quantity(f"detectors.floor.ladder[{g}]")
        assert (found.value, found.sigma, found.count) == (rung.value, rung.sigma, rung.count)


def test_names_are_quoted_where_they_need_it_and_quotes_do_no_harm(room):
    scene = room.scene.replace({'element."wall -x".name': 'a.b "c" [2]'})
    layout = room.compiled.layout
    name = next(q.name for q in scalars(scene, layout) if "a.b" in q.name)
    assert name == 'ledger.absorbed."a.b \\"c\\" [2]"'
    assert quantity_of(name, scene, layout).first == list(scene.element.names).index('a.b "c" [2]')
    assert all(quantity_of(q.name, scene, layout) == q for q in scalars(scene, layout))
    plain = quantity_of("ledger.absorbed.floor", scene, layout)
    assert quantity_of('"ledger"."absorbed"."floor"', scene, layout) == plain


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("detectors.flor.power", 'did you mean "floor"?'),
        ("ledger.escape", 'did you mean "escaped"?'),
        ("detectors.floor.ladder[16]", "expected one below 16"),
        ("detectors.floor.mean", "expected detectors.floor.power, .ladder[g] or .map"),
        ("far_field", "found no far field in the scene"),
        ("ladger.escaped", "did you mean ledger.escaped?"),
        ("detectors.floor.map", "found 1024 bins, expected a scalar"),
        ("", "expected a quantity such as"),
        (7, "expected a quantity such as"),
        ("detectors[0].power", "expected a quantity such as"),
        ('detectors."floor.power', "expected a quantity such as"),
    ],
)
def test_what_is_no_quantity_is_told(room, name, said):
    for ask in (room.quantity, room.batch_values):
        with pytest.raises(pz.ArgumentError) as caught:
            ask(name)
        assert said in str(caught.value)


# -- batch by batch ------------------------------------------------------------------------------


def test_the_values_of_batches_have_the_mean_and_the_error(room):
    for name in room.quantity_names:
        found, quantity = room.batch_values(name), room.quantity(name)
        assert found.shape == (12,)
        assert found.mean() == pytest.approx(quantity.value, rel=1e-14, abs=1e-300)
        error = found.std(ddof=1) / np.sqrt(12)
        assert error == pytest.approx(quantity.sigma, rel=1e-9, abs=1e-17)
    with pytest.raises(ValueError, match="read-only"):
        found[0] = 1.0


def test_each_is_what_that_batch_alone_gives(room):
    for n in (1, 5):
        part, whole = (pz.trace("box-room", batches=m, rays_per_batch=512) for m in (n, n + 1))
        name = 'ledger.absorbed."wall +y"'
        last = whole.quantity(name).value * (n + 1) - part.quantity(name).value * n
        assert room.batch_values(name)[n] == pytest.approx(last, rel=1e-12)


def same(a, b):
    for name in a.quantity_names:
        assert a.batch_values(name).tobytes() == b.batch_values(name).tobytes()


def test_files_checkpoints_and_executors_keep_them(room, tmp_path):
    room.save(tmp_path / "whole", figures=False)
    same(pz.open_result(tmp_path / "whole"), room)
    pz.trace("box-room", batches=5, rays_per_batch=512, checkpoint=tmp_path / "part")
    same(pz.resume(tmp_path / "part", batches=12), room)
    with ThreadPoolExecutor(2) as executor:
        same(pz.trace("box-room", **FEW, executor=executor), room)
    same(pz.trace("box-room", batches=3, rays_per_batch=512).refine(batches=12), room)


def test_results_of_earlier_versions_have_none(room, tmp_path):
    room.save(tmp_path, figures=False)
    state = room.tally.state()
    older = type(state)(**{**vars(state), "batch_values": None})
    tally = type(room.tally).of(room.compiled.layout, older)
    old = pz.Result(room.compiled, tally, room.info)
    with pytest.raises(pz.ResultError, match="not by earlier versions"):
        old.batch_values("ledger.escaped")
    assert old.quantity("ledger.escaped") == room.quantity("ledger.escaped")
    old.save(tmp_path / "old", figures=False)
    longer = pz.open_result(tmp_path / "old").refine(batches=14)
    with pytest.raises(pz.ResultError, match="single batches were not kept"):
        longer.batch_values("ledger.escaped")


def test_very_long_runs_keep_none(monkeypatch):
    monkeypatch.setattr(module, "MOST_VALUES", 200)
    short = pz.trace("cosine-fourth", batches=2, rays_per_batch=64)
    n = len(short.tally.batch_values.cells)
    assert 0 < n < 100
    most = 200 // n
    assert len(short.refine(batches=most).batch_values("ledger.escaped")) == most
    with pytest.raises(pz.ResultError, match="not kept"):
        short.refine(batches=most + 1).batch_values("ledger.escaped")


def test_of_very_many_elements_rows_alone_are_kept(tmp_path):
    plate = pz.load("cosine-fourth").element[0]
    many = [
        pz.Disk(name=f"disk {n}", position=(0.01 * n, 9.0, 9.0), axis="+z", radius=0.001,
                surface=pz.Absorber())
        for n in range(1025)
    ]  # fmt: skip
    scene = pz.Scene("many", pz.load("cosine-fourth").source, [plate, *many])
    found = pz.trace(scene, batches=2, rays_per_batch=64)
    with pytest.raises(pz.ResultError, match="more than 1024 elements"):
        found.batch_values('ledger.absorbed."disk 7"')
    assert len(found.batch_values("ledger.escaped")) == 2
    found.save(tmp_path, figures=False)
    same_names = ("ledger.escaped", f"detectors.{plate.name}.power")
    opened = pz.open_result(tmp_path)
    for name in same_names:
        assert opened.batch_values(name).tobytes() == found.batch_values(name).tobytes()


# -- targets -------------------------------------------------------------------------------------


def test_each_quantity_must_meet_the_target():
    names = ("detectors.floor.ladder[3]", "ledger.absorbed.ceiling")
    found = pz.trace("box-room", target=0.05, target_on=names, rays_per_batch=512)
    errors = [found.quantity(n).sigma / found.quantity(n).value for n in names]
    assert found.converged
    assert found.achieved_sigma == pytest.approx(max(errors), rel=1e-12)
    assert max(errors) <= 0.05
    before = pz.trace("box-room", batches=found.batches - 1, target_on=names, rays_per_batch=512)
    assert before.achieved_sigma > 0.05 or before.batches < 8
    # they say when to stop, and nothing of the stream
    assert found.scene.digest() == pz.load("box-room").replace({"run.rays_per_batch": 512}).digest()
    same_stream = pz.trace("box-room", batches=found.batches, rays_per_batch=512)
    assert same_stream.tally_digest == found.tally_digest


def test_maps_and_far_fields_are_targets_by_their_lit_bins(room):
    found = pz.trace("box-room", target_on=["detectors.floor.map"], **FEW)
    assert found.achieved_sigma == room.achieved_sigma
    scene = pz.load("lambertian-sphere")
    run = {"batches": 9, "rays_per_batch": 512}
    found = pz.trace(scene, target_on=["far_field"], **run)
    assert found.achieved_sigma == pytest.approx(found.far_field.median_sigma, rel=1e-14)


def test_what_nothing_reaches_meets_no_target():
    found = pz.trace("box-room", target=0.9, target_on=["ledger.escaped"], **FEW)
    assert (found.batches, found.converged, found.achieved_sigma) == (12, False, None)
    (said,) = [text for text in found.advisories if "was not met" in text]
    assert "nothing came to ledger.escaped" in said


@pytest.mark.usefixtures("few_figures")
def test_what_is_said_is_said_of_the_quantities(tmp_path, capsys):
    asked = {"target": 1e-4, "target_on": ["detectors.floor.power"], "batches": 9}
    found = pz.trace("box-room", rays_per_batch=512, **asked)
    (said,) = [text for text in found.advisories if "was not met" in text]
    assert "the largest relative σ is" in said
    assert "median" not in " ".join(found.advisories)
    assert "largest relative σ" in found._repr_html_()
    found.save(tmp_path, figures=False)
    assert main(["report", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "The largest relative standard error (σ) over detectors.floor.power is" in page
    assert "edian relative σ as the run went on" not in page


def test_of_one_map_it_is_the_median_over_its_bins():
    asked = {"target": 0.9, "target_on": ["detectors.floor.map"]}
    found = pz.trace("box-room", rays_per_batch=512, batches=9, **asked)
    assert found.sigma_is == "median relative σ"
    more = [*asked["target_on"], "detectors.floor.power"]
    assert pz.trace("box-room", rays_per_batch=512, batches=2, target_on=more).sigma_is == (
        "largest relative σ"
    )


def test_targets_stand_in_files_and_go_on(room, tmp_path, capsys):
    scene = room.scene.replace({"run.target_on": ["detectors.floor.power"]})
    scene.save(tmp_path / "room.toml")
    assert pz.load(tmp_path / "room.toml").run.target_on == ("detectors.floor.power",)
    out = tmp_path / "out"
    asked = ["run", str(tmp_path / "room.toml"), "--target", "0.01", "--out", str(out)]
    assert main([*asked, "--no-figures"]) == 0
    assert "largest relative σ of detectors.floor.power" in capsys.readouterr().out
    found = pz.open_result(out)
    power = found.quantity("detectors.floor.power")
    assert found.achieved_sigma == pytest.approx(power.sigma / power.value, rel=1e-14)
    more = pz.resume(out, target=0.01, target_on=["ledger.absorbed.ceiling"])
    assert more.batches > found.batches
    assert more.scene.run.target_on == ("ledger.absorbed.ceiling",)
    assert found.refine(target=0.01).batches == found.batches


def test_the_command_line_takes_several(capsys):
    names = ["detectors.floor.power", 'ledger.absorbed."wall -x"']
    asked = ["run", "box-room", "--rays-per-batch", "512", "--json", "--target-on", *names]
    assert main(asked) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["converged"]
    assert main(["run", "box-room", "--target-on", "detectors.flor.power"]) == 2
    err = capsys.readouterr().err
    assert 'run.target_on: found "detectors.flor.power", expected one of "floor"' in err


def test_an_option_that_took_the_scene_says_so(capsys, tmp_path, monkeypatch):
    """It takes all that follows; given twice it takes both."""
    monkeypatch.chdir(tmp_path)
    asked = ["--target-on", "ledger.absorbed.ceiling", "--target-on", "detectors.floor.power"]
    run = ["run", *asked, "--rays-per-batch", "512", "--target", "0.5", "--out"]
    out = "out"
    assert main([*run, out, "--no-figures", "box-room"]) == 0
    found = pz.open_result(out).scene.run.target_on
    assert set(found) == {"ledger.absorbed.ceiling", "detectors.floor.power"}
    capsys.readouterr()
    for verb, what, last in (("run", "SCENE", "box-room"), ("resume", "DIR", out)):
        assert main([verb, *asked, last]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"{what}: found nothing, expected")
        assert f"--target-on takes all that follows, and took {json.dumps(last)}" in line
        assert f"put {what} before it, or two hyphens between" in line
        assert main([verb]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "--target-on" not in line
    assert main(["resume", "--no-figures", *asked, "--", out]) == 0


def test_a_detector_far_from_the_target_that_a_map_met_is_told():
    """A photodiode beside the map that the run looks at."""
    scene = pz.load("box-room").to_dict()
    diode = {
        "name": "photo diode", "kind": "disk", "position": [0.3, 0.2, 0.5], "axis": "+z",
        "radius": 0.002, "surface": {"kind": "absorber"}, "detector": {},
    }  # fmt: skip
    scene["element"].append(diode)
    found = pz.trace(scene, target=0.1, rays_per_batch=65536)
    assert found.converged
    (said,) = [text for text in found.advisories if "was met by the median" in text]
    assert """target_on = ['detectors."photo diode".power']""" in said
    name = 'detectors."photo diode".power'
    assert not [
        text
        for text in pz.trace(scene, target=0.5, target_on=[name], rays_per_batch=65536).advisories
        if "was met by the median" in text
    ]
