"""The table [importance]: what is refused and why, files, names of what it brings."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.errors import SceneError
from photizon_cl.scene.importance import MOST_TARGETS

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

ROOM = pz.load("box-room")


def aimed(**values):
    tables = ROOM.to_dict()
    tables["importance"] = {"toward": ["floor"], **values}
    return tables


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (
            {"toward": ["flor"]},
            (
                'importance.toward[0]: found "flor", expected the name of an element: "floor", '
                '"ceiling", "wall -x", "wall +x", "wall -y", "wall +y" (did you mean "floor"?)'
            ),
        ),
        (
            {"toward": []},
            (
                "importance.toward: found [], expected a list of one or more different names "
                "(it is empty)"
            ),
        ),
        ({"toward": ["floor", "floor"]}, "one stands in it twice"),
        ({"toward": [1]}, "write each in quotes"),
        (
            {"fraction": 1.0},
            "importance.fraction: found 1.0, expected a number from 0 up to but not including 1",
        ),
        ({"fraction": -0.1}, "importance.fraction: found -0.1"),
        (
            {"weights": [1.0, 2.0]},
            "importance.weights: found 2 of them, expected one number",
        ),
        ({"weights": [-1.0]}, "importance.weights[0]: found -1.0, expected a positive number"),
        ({"weights": [0.0]}, "importance.weights[0]: found 0.0, expected a positive number"),
        ({"weights": 1.0}, "importance.weights: found 1.0, expected a list of positive numbers"),
        ({"towards": ["floor"]}, "did you mean toward?"),
        (
            {"toward": [f"e {n}" for n in range(MOST_TARGETS + 1)]},
            f"expected at most {MOST_TARGETS} names",
        ),
    ],
)
def test_what_is_refused(values, said):
    with pytest.raises(SceneError) as caught:
        pz.load(aimed(**values))
    assert said in str(caught.value)
    assert "Traceback" not in str(caught.value)


def test_toward_is_required():
    tables = aimed()
    tables["importance"] = {}
    with pytest.raises(SceneError, match="the importance table requires the key toward"):
        pz.load(tables)


def test_in_python_the_same_is_refused():
    with pytest.raises(SceneError, match='found "flor"'):
        dataclasses.replace(ROOM, importance=pz.Importance(toward=["flor"]))
    with pytest.raises(SceneError, match="2 numbers, one for each name"):
        pz.Importance(toward=["floor", "ceiling"], weights=[1.0])


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_files_give_it_back_in_its_order(suffix, tmp_path):
    asked = pz.Importance(toward=["wall -x", "floor"], fraction=0.25, weights=[3.0, 1.0])
    scene = dataclasses.replace(ROOM, importance=asked)
    scene.save(tmp_path / f"room.{suffix}")
    again = pz.load(tmp_path / f"room.{suffix}")
    assert again == scene
    assert again.importance.toward == ("wall -x", "floor")
    assert again.importance.shares == {"wall -x": 0.75, "floor": 0.25}
    assert again.digest() == scene.digest() != ROOM.digest()
    assert "importance" not in ROOM.to_dict()


def test_paths_lead_to_its_keys():
    scene = ROOM.replace({"importance.toward": ["floor"], "importance.fraction": 0.2})
    assert scene.importance == pz.Importance(toward=["floor"], fraction=0.2)
    assert scene.replace({"importance": None}) == ROOM


def test_its_row_has_a_name_everywhere(tmp_path, capsys):
    words = ["run", "box-room", "--batches", "2", "--rays-per-batch", "256", "--no-figures"]
    words += ["--set", 'importance.toward=["floor"]', "--out", str(tmp_path / "run"), "--json"]
    assert main(words) == 0
    summary = json.loads(capsys.readouterr().out)
    row = summary["ledger"]["importance"]["balance"]
    result = pz.open_result(tmp_path / "run")
    found = result.quantity("ledger.importance.balance")
    assert (found.value, found.sigma) == (row["value"], row["sigma"])
    assert found.value != 0.0
    assert "ledger.importance.balance" in result.quantity_names
    assert result.ledger.others["importance balance"].value == found.value
    assert result.ledger.importance.balance.value == found.value
    assert list(result.ledger.importance) == ["balance"]
    assert {"importance", "absorbed"} <= set(dir(result.ledger))
    assert "balance" in dir(result.ledger.importance)
    again = pickle.loads(pickle.dumps(result.ledger))
    assert again.importance["balance"] == copy.copy(result.ledger).importance.balance == found
    for missing in (lambda: result.ledger.important, lambda: result.ledger.importance.killed):
        with pytest.raises(AttributeError, match="has no attribute"):
            missing()
    assert "importance balance" in (tmp_path / "run" / "ledger.csv").read_text("utf-8")
    assert result.ledger.closure == 0.0
    assert result.summary()["ledger"] == summary["ledger"]
    aimed_at = ROOM.replace({"importance.toward": ["floor"]})
    effects = pz.effects(aimed_at)
    assert "importance" in str(effects)


def test_a_result_whose_weights_gained_is_read_again(tmp_path):
    """The row is negative then, as no power is; of eight seeds some gain and some lose."""
    signs = set()
    for seed in range(1, 9):
        aimed = ROOM.replace({"importance.toward": ["floor"]})
        result = pz.trace(aimed, seed=seed, batches=2, rays_per_batch=256)
        value = result.quantity("ledger.importance.balance").value
        signs.add(value < 0.0)
        result.save(tmp_path / str(seed), figures=False)
        again = pz.open_result(tmp_path / str(seed))
        assert again.quantity("ledger.importance.balance").value == value
        further = pz.resume(tmp_path / str(seed), batches=3)
        assert (
            further.tally_digest
            == pz.trace(aimed, seed=seed, batches=3, rays_per_batch=256).tally_digest
        )
    assert signs == {True, False}


def test_advice_where_it_can_do_nothing():
    black = ROOM.replace({f'element."{e.name}".surface': pz.Absorber() for e in ROOM.element})
    asked = pz.Importance(toward=["floor"])
    assert not [a for a in pz.advisories(dataclasses.replace(ROOM, importance=asked))
                if a.startswith("importance")]  # fmt: skip
    (said,) = [
        a for a in pz.advisories(dataclasses.replace(black, importance=asked))
        if a.startswith("importance")
    ]  # fmt: skip
    assert "no surface of the scene scatters" in said
    around = pz.Sphere(name="dome", position=(0, 0, 0), axis="+z", radius=50.0,
                       surface=pz.Absorber())  # fmt: skip
    held = dataclasses.replace(
        ROOM, element=(*ROOM.element, around), importance=pz.Importance(toward=["dome"])
    )
    assert any('the ball around "dome" holds all that scatters' in a for a in pz.advisories(held))
