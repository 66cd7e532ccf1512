"""What a scene file may say of polarisation, and what the program says of it."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.brewster import pile
from oracles.polarised import CLOSE, ON

import photizon_cl as pz
from photizon_cl.checks.advisories import advisories
from photizon_cl.cli.main import main
from photizon_cl.result.recipe import RecipeText
from photizon_cl.scene.polarisation import Polarisation
from photizon_cl.scene.writing import to_json


def tables(run=None, **source):
    lamp = {"name": "lamp", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 1]}
    lamp |= {"axis": "-z", "radius": 0.1, **source}
    glass = {"kind": "fresnel", "index": 1.5}
    plate = {"name": "plate", "kind": "disk", "position": [0, 0, 0], "axis": "+z", "radius": 1.0}
    out = {"schema": "photizon/1", "name": "t", "source": [lamp]}
    out["element"] = [{**plate, "surface": glass}]
    return out | ({"run": run} if run is not None else {})


PATH = "source[0].polarisation"
BAD = [
    (ON, {"degree": 1.5}, f"{PATH}.degree: found 1.5, expected a number in [0, 1]"),
    (ON, {"degree": -0.1}, f"{PATH}.degree: found -0.1, expected a number in [0, 1]"),
    (ON, {"degree": "1"}, f'{PATH}.degree: found "1", expected a number in [0, 1]'),
    (ON, {"angle_deg": float("nan")}, f"{PATH}.angle_deg: found nan, expected an angle from"),
    (ON, {"angle_deg": float("inf")}, f"{PATH}.angle_deg: found inf, expected an angle from"),
    (ON, {"angle_deg": 1e9}, f"{PATH}.angle_deg: found 1000000000.0, expected an angle from"),
    (
        ON,
        {"angle": 3},
        f"{PATH}.angle: found 3, expected no such key; the polarisation table takes",
    ),
    (ON, 1.0, f"{PATH}: found 1.0, expected a table for the polarisation"),
    ({}, {"degree": 1.0}, f"{PATH}: found a table, expected none while run.polarisation is false"),
    (None, {}, f"{PATH}: found a table, expected none while run.polarisation is false"),
    ({"polarisation": False}, {}, f"{PATH}: found a table, expected none while run.polarisation"),
]


@pytest.mark.parametrize(("run", "told", "message"), BAD)
def test_what_is_malformed_is_refused_in_one_line(run, told, message):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables(run, polarisation=told))
    (line,) = str(caught.value).splitlines()
    assert line.startswith(message)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("yes", 'run.polarisation: found "yes", expected true or false'),
        (1, "run.polarisation: found 1, expected true or false"),
    ],
)
def test_the_run_takes_true_or_false(value, message):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables({"polarisation": value}, polarisation={}))
    (line,) = str(caught.value).splitlines()
    assert line.startswith(message)


def test_classes_refuse_what_files_may_not_say():
    with pytest.raises(pz.SceneError, match=r"polarisation\.degree: found 2\.0, expected"):
        pz.Polarisation(degree=2.0)
    lamp = pz.IsotropicPoint(name="a", flux=1.0, position=(0, 0, 0), polarisation=Polarisation())
    with pytest.raises(pz.SceneError, match=r"none while run\.polarisation is false"):
        pz.Scene(name="t", source=(lamp,))
    scene = pz.Scene(name="t", source=(lamp,), run=pz.RunSettings(polarisation=True))
    assert scene.source["a"].polarisation.stokes == (1.0, 0.0)
    assert pz.Polarisation(degree=0.5, angle_deg=45.0).stokes == (0.0, 0.5)
    assert pz.Polarisation(angle_deg=-90.0).stokes == (-1.0, 0.0)


def test_a_scene_in_code_and_in_files_is_one(tmp_path):
    scene = pz.load(tables(ON, polarisation={"degree": 0.5}))
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert pz.load(tmp_path / name) == scene
    assert '"polarisation": true' in to_json(scene)
    assert pz.load(scene.to_dict()) == scene
    other = scene.replace({"source.lamp.polarisation.angle_deg": 30.0})
    assert other.source["lamp"].polarisation == Polarisation(degree=0.5, angle_deg=30.0)
    without = scene.replace({"source.lamp.polarisation": None, "run.polarisation": False})
    assert without == pz.load(tables())
    assert len({s.digest() for s in (scene, other, without)}) == 3
    assert "polarisation" not in without.to_dict()["run"]
    assert without.digest() == pz.load(tables({"polarisation": False})).digest()


def test_recipes_say_it():
    scene = pz.load(tables(ON, polarisation={"angle_deg": 30.0}))
    recipe = RecipeText(scene, 2, "fp64", "sha256:" + "0" * 64)
    again = RecipeText.read(recipe.token)
    assert again.scene.run.polarisation
    assert again.scene.digest() == scene.digest()


def test_effects_name_it_and_say_why():
    on, off = pz.effects(tables(ON)), pz.effects(tables())
    assert on["polarisation"].in_use
    assert on["polarisation"].because == "run.polarisation is true"
    assert not on["polarisation"].optional
    assert "run.polarisation is false" in off["polarisation"].because
    assert not off["polarisation"].optional
    assert pz.effects("integrating-sphere")["polarisation"].optional


def test_advice_where_nothing_acts_by_it():
    mirror = tables(ON)
    mirror["element"][0]["surface"] = {"kind": "mirror", "reflectance": 0.9}
    (said,) = [text for text in advisories(pz.load(mirror)) if "polarisation" in text]
    assert said.startswith("run.polarisation is true, but how much the scene's surfaces send on")
    assert not [text for text in advisories(pz.load(tables(ON))) if "polarisation" in text]
    del mirror["run"]
    assert not [text for text in advisories(pz.load(mirror)) if "polarisation" in text]


def test_check_and_kinds_tell_it(tmp_path, capsys):
    path = tmp_path / "t.toml"
    pz.load(tables(ON, polarisation={"degree": 0.5, "angle_deg": 30.0})).save(path)
    assert main(["check", str(path), "--no-pilot"]) == 0
    said = capsys.readouterr().out
    assert "polarisation: degree 0.5, angle_deg 30 deg" in " ".join(said.split())
    assert "polarisation true" in said
    assert main(["kinds", "polarisation"]) == 0
    assert "angle_deg" in capsys.readouterr().out
    assert main(["check", str(path), "--no-pilot", "--set", "run.polarisation=false"]) == 2
    assert "source[0].polarisation: found a table" in capsys.readouterr().err
    assert main(["run", str(path), "--set", "source.lamp.polarisation.degree=3"]) == 2
    assert "found 3, expected a number in [0, 1]" in capsys.readouterr().err


def test_it_is_swept_in_one_program():
    """Malus's law by a sweep of the angle at a plate."""
    scene = pile(1, 1.52, 60.0, {"angle_deg": 0.0}, **ON)
    swept = pz.sweep(
        {
            "schema": "photizon-sweep/1",
            "scene": scene,
            "vary": [{"path": 'source."source 0".polarisation.angle_deg', "values": [0, 30, 90]}],
            "run": {"batches": 1},
            "measure": {"power": "detectors.end.power"},
        }
    )
    s, between, p = np.asarray(swept.to_dataframe()["power"])
    assert abs(0.75 * s + 0.25 * p - between) < CLOSE


def test_a_result_goes_on_as_it_was(tmp_path):
    """Kept and resumed, and run with other settings: the bits are those of one run."""
    scene = pz.load("polariscope").replace({"source.lamp.polarisation": {"angle_deg": 10.0}})
    whole = pz.trace(scene, batches=4, rays_per_batch=64)
    part = pz.trace(scene, batches=2, rays_per_batch=64)
    part.save(tmp_path / "run")
    assert pz.open_result(tmp_path / "run").refine(batches=4).tally_digest == whole.tally_digest
    assert pz.open_result(tmp_path / "run").scene == part.scene
