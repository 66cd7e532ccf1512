"""Media in scenes: what is read, kept and refused."""

from __future__ import annotations

import dataclasses
import json
import re

import pytest
from oracles.media import Layer, stack

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.compile import compiled
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.scene.writing import to_json, to_toml

LAYERS = [Layer("vacuum", 1.0), Layer("bk7", 1.5168, 2.0), Layer("water", 1.333)]


def tables(**changes):
    """A plate with bk7 in it, and water behind that, as a file has it."""
    parts = stack(LAYERS, [0.0, 0.01], -0.1)
    named = lambda rows, stem: [{"name": f"{stem} {n}", **row} for n, row in enumerate(rows)]  # noqa: E731
    return {
        "schema": "photizon/1", "name": "plate", "source": named(parts["sources"], "lamp"),
        "element": named(parts["elements"], "face"), "medium": parts["medium"], **changes,
    }  # fmt: skip


def refused(found, *wanted):
    """Assert that a scene is refused with one line, which says all that is wanted."""
    with pytest.raises(pz.SceneError) as caught:
        pz.load(found)
    text = str(caught.value)
    assert len(text.splitlines()) == 1, text
    for part in wanted:
        assert part in text


def test_it_is_found_by_name_and_number():
    scene = pz.load(tables())
    assert scene.medium["bk7"] == scene.medium[0] == pz.Medium("bk7", 1.5168, 2.0)
    assert scene.medium.names == ("bk7", "water")
    assert scene.element["face 0"].surface == pz.Fresnel(medium="vacuum", medium_outside="bk7")
    assert [s.indices for s in scene.optics.values()] == [(1.0, 1.5168), (1.333, 1.5168)]
    assert pz.Medium("air", 1.0003).absorption_per_m == 0.0
    assert pz.load("box-room").medium == ()


def test_it_comes_back_from_files(tmp_path):
    scene = pz.load(tables())
    for name in ("plate.toml", "plate.json"):
        scene.save(tmp_path / name)
        again = pz.load(tmp_path / name)
        assert again == scene
        assert again.digest() == scene.digest()
    assert "index_outside" not in to_toml(scene)
    assert json.loads(to_json(scene))["source"][0].get("medium") is None  # the vacuum, by default
    inside = dataclasses.replace(scene.source[0], medium="water")
    assert 'medium = "water"' in to_toml(dataclasses.replace(scene, source=(inside,)))


def test_a_scene_without_media_is_written_and_hashed_as_ever():
    scene = pz.load("ghost-ladder")
    assert "medium" not in to_toml(scene)
    # as of the version before there were media
    assert scene.digest() == (
        "sha256:47824e6f515105219f9921d7ae983ab91f6514704c91d75e0b6c883ca972110a"
    )


def test_values_are_replaced_by_path():
    scene = pz.load(tables())
    assert scene.replace({"medium.bk7.index": 1.6}).medium["bk7"].index == 1.6
    assert scene.replace({"medium[1].absorption_per_m": 3}).medium["water"].absorption_per_m == 3.0
    plain = scene.replace({"element.face 0.surface.index": 1.2}).element[0].surface
    assert plain == pz.Fresnel(1.2)
    back = scene.replace({"element.face 1.surface.medium": "bk7"}).element[1].surface
    assert back == pz.Fresnel(medium="bk7", medium_outside="bk7")
    outside = scene.replace({"element.face 1.surface": pz.Fresnel(medium="bk7")})
    assert outside.element[1].surface.media == ("bk7", "vacuum")
    glass = {"medium": [pz.Medium("f2", 1.62)], "element.front.surface": pz.Fresnel(medium="f2")}
    made = pz.load("ghost-ladder").replace(glass)
    assert made.optics[made.element[0].surface].indices == (1.62, 1.0)
    with pytest.raises(pz.SceneError, match="the name of a medium: "):
        made.replace({"medium": None})
    with pytest.raises(pz.UnknownNameError, match='found "bk8", expected one of "bk7", "water"'):
        scene.replace({"medium.bk8.index": 1.0})


@pytest.mark.parametrize(("key", "value", "wanted"), [
    ("index", 0, ("medium[0].index", "0", "a refractive index, a number from 0.001 to 1000")),
    ("index", [1.5], ("medium[0].index", "a refractive index")),
    ("absorption_per_m", -1.0, ("medium[0].absorption_per_m", "-1.0", "a number from 0 to 1e150")),
    ("absorption_per_m", float("nan"), ("medium[0].absorption_per_m", "it must be finite")),
    ("absorption_per_m", {"wavelength_nm": [400.0], "per_m": [1.0]},
     ("medium[0].absorption_per_m.wavelength_nm", "1 number", "2 to 10000 ascending")),
    ("dispersion", {"kind": "cauchy"},
     ("medium[0].dispersion.A", "nothing", "requires the key A")),
    ("glass", "N-BK7", ("medium[0].glass", "N-BK7", "nothing beside index")),
    ("absorption", 1.0, ("medium[0].absorption", "did you mean absorption_per_m?")),
    ("name", "vacuum", ("medium[0].name", "another name than", "always there")),
    ("name", "water", ("medium[1].name", "a name that no other medium has", "medium[0]")),
])  # fmt: skip
def test_a_medium_that_is_refused(key, value, wanted):
    found = tables()
    found["medium"][0][key] = value
    if key == "name" and value == "vacuum":  # else bk7 is missed as well
        found = tables(element=[], medium=[{"name": "vacuum", "index": 1.0}])
    elif key == "name":
        found["element"] = []
    refused(found, *wanted)


def test_an_index_is_required():
    refused(tables(medium=[{"name": "bk7"}, {"name": "water", "index": 1.3}]), "medium[0].index")


@pytest.mark.parametrize(("surface", "wanted"), [
    ({"medium": "bk8"}, ("element[0].surface.medium", '"bk8"', '"vacuum", "bk7", "water"',
                         'did you mean "bk7"?')),
    ({"medium": "bk7", "medium_outside": "oil"},
     ("element[0].surface.medium_outside", '"oil"', "a [[medium]] table adds one")),
    ({"medium": "bk7", "index": 1.5}, ("element[0].surface.medium", "nothing beside index",
                                       "and not index beside medium")),
    ({"medium": "bk7", "index_outside": 1.0},
     ("element[0].surface.medium", "nothing beside index_outside")),
    ({"index": 1.5, "medium_outside": "bk7"},
     ("element[0].surface.medium_outside", "nothing beside index")),
    ({"medium_outside": "bk7"}, ("element[0].surface.medium", "requires the key medium")),
    ({}, ("element[0].surface.index", "requires the key index, or medium")),
    ({"index_outside": 1.5}, ("element[0].surface.index", "requires the key index, or medium")),
    ({"medium": 3}, ("element[0].surface.medium", "3", "the name of a medium")),
])  # fmt: skip
def test_a_surface_that_is_refused(surface, wanted):
    found = tables()
    found["element"][0]["surface"] = {"kind": "fresnel", **surface}
    refused(found, *wanted)


def test_a_source_in_a_medium_that_is_not_there():
    found = tables()
    found["source"][0]["medium"] = "Water"
    refused(found, "source[0].medium", '"Water"', 'did you mean "water"?')
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0, 0, 0), medium="oil")
    with pytest.raises(pz.SceneError, match=r'source\[0\].medium: found "oil"'):
        pz.Scene(name="x", source=[lamp])


def program_of(scene):
    return compile_scene(scene, scene.run).tables.spec


@pytest.mark.parametrize("changes", [
    {"medium.bk7.index": 1.7}, {"medium.bk7.absorption_per_m": 0.0}, {"medium.water.index": 1.4},
    {"medium.water.absorption_per_m": 9.0}, {"source.lamp 0.medium": "water"},
    {"element.face 0.surface.medium": "bk7"}, {"element.face 1.surface.medium_outside": "vacuum"},
])  # fmt: skip
def test_other_values_and_names_are_the_same_program(changes):
    scene = pz.load(tables())
    other = scene.replace(changes)
    assert program_of(other) == program_of(scene)


@pytest.mark.parametrize("name", ["ghost-ladder", "box-room", "baffled-telescope"])
def test_a_scene_without_media_knows_nothing_of_them(name, monkeypatch):
    """The same program as if there were no such effect, and none of its words in the text."""
    scene = pz.load(name)
    spec = program_of(scene)
    text = program_source(spec.for_device(8, ("wave",)))
    assert "medium" not in text.replace("thinner medium", "")
    assert "twofold_exp" not in text
    assert "lost" not in re.findall(r"\w+", re.sub("//.*", "", text))
    without = tuple(effect for effect in EFFECTS if effect.name != "media")
    assert len(without) == len(EFFECTS) - 1
    monkeypatch.setattr(compiled, "EFFECTS", without)
    assert program_of(scene) == spec


def test_it_is_told_what_it_is(capsys):
    from photizon_cl.cli.main import main

    assert main(["kinds", "medium"]) == 0
    text = capsys.readouterr().out
    assert "absorption_per_m" in text
    assert "1/m" in text
    assert main(["kinds"]) == 0
    text = " ".join(capsys.readouterr().out.replace("\N{NO-BREAK SPACE}", " ").split())
    assert "name, index, absorption_per_m (1/m) = 0.0" in text
