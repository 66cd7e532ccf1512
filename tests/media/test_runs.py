"""Runs with media from beginning to end: kept, gone on with, shared out, printed."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor

import pytest
from oracles import media
from oracles.engine import scene_of, trace

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.files import load

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

CUVETTE = "absorbing-cuvette"
RUN = {"rays_per_batch": 128}
ROW = 'ledger.absorbed_in."dyed water"'


@pytest.fixture(scope="module")
def whole():
    return pz.trace(CUVETTE, batches=4, **RUN)


def test_its_rows_have_names(whole):
    assert ROW in whole.quantity_names
    assert "ledger.absorbed_in.glass" in whole.quantity_names
    row = whole.ledger.absorbed_in["dyed water"]
    assert whole.quantity(ROW).value == row.value
    assert whole.quantity("ledger.absorbed_in.dyed water").value == row.value
    assert math.fsum(whole.batch_values(ROW)) / 4 == pytest.approx(row.value, rel=1e-15)
    with pytest.raises(pz.UnknownNameError, match='did you mean "glass"'):
        whole.ledger.absorbed_in["glas"]
    with pytest.raises(pz.UnknownNameError, match=r"absorbed_in\.glas"):
        whole.quantity("ledger.absorbed_in.glas")


def test_a_name_of_any_letters():
    """Rows of the kernels are numbered: a name is not their business."""
    tables = json.loads(json.dumps(pz.load(CUVETTE).to_dict()).replace("dyed water", "H₂O. 5 %"))
    result = pz.trace(tables, batches=1, rays_per_batch=64)
    row = result.ledger.absorbed_in["H₂O. 5 %"]
    assert result.quantity('ledger.absorbed_in."H₂O. 5 %"').value == row.value > 0.4
    assert result.quantity_names[-3:-2] == ['ledger.absorbed_in."H₂O. 5 %"']


@pytest.mark.slow
def test_a_target_may_be_what_a_medium_absorbs():
    result = pz.trace(CUVETTE, target=0.2, target_on=[ROW], max_seconds=3600, **RUN)
    assert result.converged
    with pytest.raises(pz.SceneError, match=r"absorbed_in\.oil"):
        pz.trace(CUVETTE, target_on=["ledger.absorbed_in.oil"], **RUN)


def test_the_summary(whole):
    summary = json.loads(json.dumps(whole.summary()))
    ledger = summary["ledger"]
    assert set(ledger["absorbed_in"]) == {"glass", "dyed water"}
    assert ledger["absorbed_in"]["dyed water"]["value"] == whole.quantity(ROW).value
    assert summary["media_mismatches"] == 0
    assert "media_mismatches" not in pz.trace("box-room", batches=1, rays_per_batch=64).summary()
    rows = [ledger[name]["value"] for name in ("escaped", "depth_capped")]
    rows += [row["value"] for part in ("absorbed", "absorbed_in") for row in ledger[part].values()]
    rows.append(ledger["roulette"]["balance"]["value"])
    assert math.fsum(rows) == pytest.approx(1.0, abs=1e-14)
    assert abs(ledger["closure"]) < 1e-15


def test_it_is_kept_and_gone_on_with(whole, tmp_path):
    pz.trace(CUVETTE, batches=2, **RUN).save(tmp_path / "run", figures=False)
    kept = pz.open_result(tmp_path / "run")
    assert set(kept.ledger.absorbed_in) == {"glass", "dyed water"}
    more = pz.resume(tmp_path / "run", batches=4)
    assert more.tally_digest == whole.tally_digest
    assert more.ledger == whole.ledger
    assert more.counts == whole.counts
    text = (tmp_path / "run" / "ledger.csv").read_text("utf-8")
    assert "absorbed in dyed water" in text
    found = kept.to_dataset()["ledger"]
    assert "absorbed in dyed water" in found["row"].values.tolist()
    row = pz.compare(kept, whole)[ROW]
    assert row.paired
    assert row.a.value == row.b.value == kept.quantity(ROW).value


def test_its_recipe_makes_it_again():
    changed = pz.load(CUVETTE).replace({"medium.glass.absorption_per_m": 1.5})
    result = pz.trace(changed, batches=2, **RUN)
    recipe = pz.Recipe.read(result.recipe)
    assert recipe.scene.medium["glass"].absorption_per_m == 1.5
    again = recipe.trace()
    assert recipe.differs(again) == ""
    assert again.tally_digest == result.tally_digest


def test_it_is_shared_out(whole):
    with ThreadPoolExecutor(2) as pool:
        assert pz.trace(CUVETTE, batches=4, executor=pool, **RUN).tally_digest == whole.tally_digest


def test_on_the_command_line(capsys, tmp_path):
    words = ["run", CUVETTE, "--batches", "2", "--rays-per-batch", "64"]
    words += ["--set", 'medium."dyed water".absorption_per_m=0', "--out", str(tmp_path / "run")]
    assert main([*words, "--no-figures"]) == 0
    text = capsys.readouterr().out
    assert "absorbed in dyed water" in text
    assert main(["report", str(tmp_path / "run")]) == 0
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert "absorbed in dyed water" in page
    capsys.readouterr()
    assert main(["run", CUVETTE, "--set", "medium.glass.absorption_per_m=-1"]) == 2
    text = capsys.readouterr().err
    assert "medium[0].absorption_per_m" in text
    assert "Traceback" not in text
    assert main(["check", CUVETTE, "--no-pilot"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "dyed water: index 1.33333333, absorption_per_m 69.3147181 1/m" in text
    assert "internal transmittance of 10 mm 0.5" in text
    assert main(["effects", CUVETTE]) == 0
    assert 'the scene has the medium "glass"' in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    "number", [0, *(pytest.param(number, marks=pytest.mark.slow) for number in range(1, 6))]
)
def test_every_batch_closes_in_random_scenes_with_media(number):
    """To the rounding of the splits, which is none where both sides are of one medium."""
    tables = media.random_scene(number, 256)
    found = trace(load(tables), batches=3)
    assert all(abs(closure) <= 1e-15 for closure in found.closures())
    for element in tables["element"]:
        if element["surface"]["kind"] == "fresnel":
            element["surface"]["medium_outside"] = element["surface"]["medium"]
    found = trace(load(tables), batches=3)
    assert found.amount(found.compiled.layout.row("absorbed_in.m1")) > 0
    assert found.closures() == [0, 0, 0]


def test_media_that_nothing_names_are_told():
    scene = pz.load(CUVETTE)
    more = [*scene.to_dict()["medium"], {"name": "oil", "index": 1.4}]
    said = pz.advisories(load({**scene.to_dict(), "medium": more}))
    assert any('medium "oil"' in text and "nothing is made of it" in text for text in said)
    assert pz.advisories(scene) == []


def test_bodies_in_contact_are_told_what_to_name():
    """Cement is said by names where surfaces have names."""
    wall = lambda z, axis, **s: {  # noqa: E731
        "kind": "rectangle", "position": [0, 0, z], "axis": axis, "half_width": 1.0,
        "half_height": 1.0, "surface": {"kind": "fresnel", **s},
    }  # fmt: skip
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, -1.0]}
    glasses = [{"name": "crown", "index": 1.5}, {"name": "flint", "index": 1.6}]
    elements = [
        wall(0.0, "-z", medium="crown"), wall(0.1, "+z", medium="crown"),
        wall(0.1, "-z", medium="flint"), wall(0.2, "+z", medium="flint"),
    ]  # fmt: skip
    said = pz.advisories(scene_of([lamp], elements, medium=glasses))
    assert any('give "element 1" medium_outside = "flint" and make' in text for text in said)
