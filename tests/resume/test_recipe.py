"""Recipes: a token that makes the same bits again, or says why it cannot."""

from __future__ import annotations

import base64
import json
import shutil
import zlib
from dataclasses import replace
from pathlib import Path

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result import engine as module

pytestmark = pytest.mark.usefixtures("built_quickly")

ROOT = Path(__file__).resolve().parents[2]
RUN = {"batches": 3, "rays_per_batch": 1024, "seed": 7}


@pytest.fixture(scope="module")
def sphere():
    return pz.trace("integrating-sphere", **RUN)


def own_scene():
    tables = pz.load("integrating-sphere").to_dict()
    tables["element"][0]["name"] = "wall µ"
    tables["source"][0]["flux"] = 0.1 + 0.2
    tables["notes"] = "long " * 1000
    return pz.load(tables)


def unpacked(token):
    body = token.removeprefix("pz1-")
    return json.loads(zlib.decompress(base64.urlsafe_b64decode(body + "=" * (-len(body) % 4))))


def packed(content):
    data = zlib.compress(json.dumps(content).encode())
    return "pz1-" + base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def test_the_round_trip_on_both_pocls(pocl, sphere):
    made = pz.Recipe.read(sphere.recipe)
    again = made.trace(device=pocl)
    assert again.tally_digest == sphere.tally_digest
    assert made.differs(again) == ""
    assert again.recipe == sphere.recipe


def test_a_preset_makes_a_short_token(sphere):
    assert len(sphere.recipe) < 400
    assert sphere.recipe.isascii()
    assert unpacked(sphere.recipe)["scene"] == "integrating-sphere"


def test_a_scene_of_ones_own_is_in_the_token(sphere):
    result = pz.trace(own_scene(), **RUN)
    token = result.recipe
    assert len(token) < 1200  # notes are no part of it
    made = pz.Recipe.read(token)
    assert made.scene.digest() == result.scene.digest()
    again = made.trace()
    assert again.tally_digest == result.tally_digest
    assert list(again.ledger.absorbed) == ["wall µ"]


def test_settings_travel_with_it(sphere):
    scene = replace(
        sphere.scene, run=replace(sphere.scene.run, generation_cap=5, roulette_floor=0.25)
    )
    result = pz.trace(scene, batches=3)
    run = pz.Recipe.read(result.recipe).scene.run
    assert (run.seed, run.rays_per_batch) == (7, 1024)
    assert (run.generation_cap, run.roulette_floor) == (5, 0.25)
    assert pz.Recipe.read(result.recipe).trace().tally_digest == result.tally_digest


def test_white_space_does_no_harm(sphere):
    token = sphere.recipe
    folded = "\n  ".join(token[k : k + 40] for k in range(0, len(token), 40)) + "\n"
    assert pz.Recipe.read(folded) == pz.Recipe.read(token)


def test_every_damage_is_found(sphere):
    token = sphere.recipe
    alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"
    for k in range(4, len(token)):
        other = alphabet[(alphabet.index(token[k]) + 17) % 64]
        try:
            made = pz.Recipe.read(token[:k] + other + token[k + 1 :])
        except pz.RecipeError:
            continue
        assert made == pz.Recipe.read(token)  # the last character has bits that stand for nothing
    for k in range(len(token)):
        with pytest.raises(pz.RecipeError):
            pz.Recipe.read(token[:k])


@pytest.mark.parametrize("text", ["", "pz1-", "integrating-sphere", "pz2-abc", "pz1-ünicode", "é"])
def test_what_is_no_token(text):
    with pytest.raises(pz.RecipeError, match="recipe: found"):
        pz.Recipe.read(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scene": "no-such-preset", "version": "9.9"}, "which this version"),
        ({"scene_digest": "sha256:0"}, "is not the scene that it was"),
        ({"scene": {"schema": "photizon/1", "name": "x"}}, "its scene is not valid here"),
        ({"batches": None}, "another version of photizon_cl, or by hand"),
        ({"batches": float("inf")}, "another version of photizon_cl, or by hand"),
        ({"batches": 2.0}, "another version of photizon_cl, or by hand"),
        ({"tally": 5}, "another version of photizon_cl, or by hand"),
        ({"run": {}}, "another version of photizon_cl, or by hand"),
    ],
)
def test_why_it_cannot_be_made(sphere, change, message):
    with pytest.raises(pz.RecipeError, match=message):
        pz.Recipe.read(packed({**unpacked(sphere.recipe), **change}))


def test_a_changed_scene_is_told():
    token = pz.trace(own_scene(), **RUN).recipe
    content = unpacked(token)
    content["scene"]["source"][0]["flux"] = 2.0
    with pytest.raises(pz.RecipeError, match="the token was changed"):
        pz.Recipe.read(packed(content))


def test_why_the_bits_differ(sphere, monkeypatch):
    made = pz.Recipe.read(sphere.recipe)
    assert "ended after 3 of 4 batches" in replace(made, batches=4, tally_digest="x").differs(
        sphere
    )
    other = replace(made, tally_digest="sha256:0")
    assert "please report this" in other.differs(sphere)
    assert "engine is the same" in replace(other, version="0.0.9").differs(sphere)
    assert "with the engine 0123" in replace(other, engine="0123").differs(sphere)
    with pytest.raises(pz.RunError, match="not reproduced"):
        other.check(sphere)
    made.check(sphere)


def test_nothing_of_a_token_reaches_the_terminal_raw(sphere):
    evil = packed({**unpacked(sphere.recipe), "version": "\x1b[31m", "tally": "0" * 64})
    assert "\x1b" not in pz.Recipe.read(evil).differs(sphere)
    for change in ({"scene": "gone"}, {"scene_digest": "sha256:0"}):
        with pytest.raises(pz.RecipeError) as caught:
            pz.Recipe.read(packed({**unpacked(evil), **change}))
        assert "\x1b" not in str(caught.value)


def test_batches_of_two_engines_are_not_mixed(sphere, tmp_path, monkeypatch):
    sphere.save(tmp_path, figures=False)
    old = sphere.info.engine
    monkeypatch.setattr("photizon_cl.run.batches.engine_digest", lambda: "0123456789abcdef")
    with pytest.raises(pz.ResultError, match="are not mixed"):
        pz.resume(tmp_path, batches=5)
    # the recipe of a result names the engine that made it, whichever is installed
    monkeypatch.setattr("photizon_cl.result.recipe.engine_digest", lambda: "0123456789abcdef")
    assert pz.Recipe.of(pz.open_result(tmp_path)).engine == old


@pytest.fixture
def sources(tmp_path):
    """Return copies of the three folders that the engine digest looks into, and the digest."""
    for name in ("kernels", "hostcode", "photizon_cl"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))

    def digest():
        return module._digest(*(tmp_path / n for n in ("kernels", "hostcode", "photizon_cl")))

    assert digest() == module.engine_digest()
    return tmp_path, digest


BITS = (
    "kernels/lib", "kernels/surfaces", "hostcode", "hostcode/program", "hostcode/run",
    "photizon_cl/scene", "photizon_cl/scene/elements", "photizon_cl/geometry",
    "photizon_cl/compile", "photizon_cl/compile/effects", "photizon_cl/result",
)  # fmt: skip
"""Folders that decide bits."""


@pytest.mark.parametrize("folder", BITS)
def test_the_engine_digest_follows_every_file(folder, sources):
    root, digest = sources
    suffix = ".mako" if folder.startswith("kernels") else ".py"
    before = digest()
    added = root / folder / f"added{suffix}"
    added.write_text("")
    assert digest() != before
    added.unlink()
    assert digest() == before
    changed = min((root / folder).glob(f"*{suffix}"))
    changed.write_text(changed.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert digest() != before


@pytest.mark.parametrize("folder", ["hostcode/device", "photizon_cl/views", "photizon_cl/cli"])
def test_the_engine_digest_leaves_out_what_decides_no_bit(folder, sources):
    root, digest = sources
    before = digest()
    (root / folder / "added.py").write_text("")
    assert digest() == before


def test_command_line(sphere, tmp_path, capsys):
    sphere.save(tmp_path / "run", figures=False)
    assert main(["recipe", str(tmp_path / "run")]) == 0
    token = capsys.readouterr().out.strip()
    assert token == sphere.recipe == (tmp_path / "run" / "recipe.txt").read_text().strip()
    for given in (token, str(tmp_path / "run" / "recipe.txt")):
        again = ["--json", "--no-figures", "--out", str(tmp_path / "again")]
        assert main(["run", "--recipe", given, *again]) == 0
        printed = capsys.readouterr()
        assert json.loads(printed.out)["tally_digest"] == sphere.tally_digest
        assert printed.err == "reproduced: every bit is the recipe's\n"
    wrong = packed({**unpacked(token), "tally": "0" * 64})
    assert main(["run", "--recipe", wrong]) == 1
    assert "not reproduced: the tally digest is" in capsys.readouterr().err
    for more in (["integrating-sphere"], ["--seed", "3"], ["--batches", "2"], ["--target", "0.1"]):
        assert main(["run", *more, "--recipe", token]) == 2
        assert "the recipe says what is run" in capsys.readouterr().err
    assert main(["run", "--recipe", token[:-5]]) == 2
    assert main(["run"]) == 2
    assert "SCENE: found nothing" in capsys.readouterr().err
    assert main(["recipe", str(tmp_path)]) == 2


@pytest.mark.parametrize("precision", ["fp64", pytest.param("fp32", marks=pytest.mark.slow)])
def test_a_run_that_chooses_one_child_is_made_again_and_goes_on(tmp_path, precision):
    scene = pz.load("ghost-ladder").replace(
        {"run.splitting": False, "run.rays_per_batch": 512, "element.front.surface.index": 1.6}
    )
    result = pz.trace(scene, batches=2, precision=precision)
    result.save(tmp_path, figures=False)
    again = pz.Recipe.read((tmp_path / "recipe.txt").read_text())
    assert again.scene.run.splitting is False
    assert again.trace().tally_digest == result.tally_digest
    result.save(tmp_path, figures=False)  # its own recipe is known
    assert pz.resume(tmp_path, batches=3).batches == 3
