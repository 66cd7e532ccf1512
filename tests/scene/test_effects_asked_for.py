"""`[run] effects`: a scene asks for what nothing else in it calls for."""

from __future__ import annotations

from dataclasses import replace

import pytest

import photizon_cl as pz
from hostcode.run import readout
from photizon_cl.compile.compiled import compile_scene


def asking(scene, *effects):
    return replace(scene, run=replace(scene.run, effects=effects))


def test_an_effect_that_is_asked_for_is_in_use_and_changes_no_number():
    plain = pz.load("box-room")
    scene = asking(plain, "tilt", "acceleration")
    assert compile_scene(scene, scene.run).reasons["tilt"] == "it was asked for"
    with_it, without = (pz.trace(s, batches=2, rays_per_batch=256) for s in (scene, plain))
    assert with_it.tally_digest == without.tally_digest
    assert scene.digest() != plain.digest()


def test_a_scene_that_asks_for_nothing_has_the_digest_that_it_had():
    preset = pz.load("integrating-sphere")
    assert preset.run.effects is None
    assert "effects" not in preset.to_dict()["run"]


def test_files_recipes_and_results_keep_it(tmp_path):
    scene = asking(pz.load("ghost-ladder"), "roulette", "contact")
    assert scene.run.effects == ("contact", "roulette")
    assert pz.load(scene.to_dict()) == scene
    result = pz.trace(scene, batches=1, rays_per_batch=64, seed=3)
    again = pz.Recipe.read(result.recipe).trace()
    assert again.scene.run.effects == scene.run.effects
    assert again.tally_digest == result.tally_digest
    result.save(tmp_path / "run", figures=False)
    assert pz.open_result(tmp_path / "run").scene.run.effects == scene.run.effects


@pytest.mark.parametrize(
    ("effects", "said"),
    [
        (("ghosts",), 'run.effects: found "ghosts", expected some of splitting'),
        (("far-field",), "expected effects that the scene can have (nothing in it has what"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(effects, said):
    with pytest.raises(pz.SceneError) as caught:
        pz.trace(asking(pz.load("box-room"), *effects), batches=1)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("value", "hint"),
    [
        ("tilt", "different words"),
        ([1], "in quotes"),
        (["tilt", "tilt"], "twice"),
        ([""], "in quotes"),
    ],
)
def test_what_is_no_list_of_words_is_refused(value, hint):
    tables = pz.load("box-room").to_dict()
    tables["run"]["effects"] = value
    with pytest.raises(pz.SceneError, match=r"run\.effects: found .* expected a list of different"):
        pz.load(tables)
    with pytest.raises(pz.SceneError, match=hint):
        pz.load(tables)


def test_a_full_tally_ends_the_run(monkeypatch):
    monkeypatch.setattr(readout, "_FULLEST", 2.0**38)  # 128 launched weights
    with pytest.raises(pz.RunError, match="holds more than 2\\^31 launched weights"):
        pz.trace("box-room", batches=1, rays_per_batch=1024)
