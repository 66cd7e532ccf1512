"""Scenes that are good: defaults, both ways of building one, round trips, digest, immutability."""

import copy
import dataclasses
import json
import pickle
import random
import subprocess
import sys

import numpy as np
import pytest
from malformed import GOOD, edited

import photizon_cl as pz
from photizon_cl.errors import ArgumentError, PhotizonError, ResultError, RunError, SceneError
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.writing import to_json, to_toml

MINIMAL = {
    "schema": "photizon/1",
    "name": "minimal",
    "source": [{"name": "s", "kind": "isotropic-point", "flux": 1, "position": [0, 0, 0]}],
}


def built():
    return pz.Scene(
        "good",
        source=[
            pz.CosinePoint(name="lamp", flux=1, position=(0, 0, 1), axis="-z"),
            pz.LambertianSphere(name="ball", flux=2.0, position=[0, 1, 1], radius=0.1),
        ],
        element=(
            pz.Rectangle(
                name="target", position=(0, 0, 0), axis="+z", half_width=1, half_height=1,
                surface=pz.Absorber(), detector=pz.Detector(map=[4, 4], generations=3),
            ),
            pz.Disk(
                name="plate", position=(0, 0, 5), axis="-y", radius=0.5, tilt_deg=(10, -20.5),
                surface=pz.Lambertian(0.5),
            ),
            pz.Sphere(
                name="lens", position=(3, 0, 0), axis="+x", radius=1, surface=pz.Fresnel(1.5)
            ),
        ),
        run=pz.RunSettings(seed=7),
        far_field=pz.FarField(n_mu=10, n_phi=8),
    )  # fmt: skip


def test_defaults_of_the_contract():
    scene = load(MINIMAL)
    assert scene.run == pz.RunSettings(
        seed=1, rays_per_batch=65536, target_sigma=0.05, max_seconds=60.0, generation_cap=32,
        roulette_floor="auto",
    )  # fmt: skip
    assert scene.far_field is None
    assert scene.element == ()
    assert (scene.title, scene.notes) == ("", "")
    assert load({**MINIMAL, "far_field": {}}).far_field == pz.FarField(n_mu=40, n_phi=32)
    scene = load(GOOD)
    assert scene.element[0].tilt_deg == (0.0, 0.0)
    assert scene.element[2].port_fraction == 0.0
    assert scene.element[2].surface.index_outside == 1.0
    assert scene.source[0].share is None


def test_a_file_and_code_build_the_same_scene():
    assert load(GOOD) == built()
    assert hash(load(GOOD)) == hash(built())
    assert load(GOOD).digest() == built().digest()


def test_load_takes_what_it_is_given(tmp_path):
    scene = load(GOOD)
    assert load(scene) is scene
    path = tmp_path / "scene.TOML"
    path.write_text("\ufeff" + to_toml(scene).replace("\n", "\r\n"), encoding="utf-8", newline="")
    assert load(path) == scene
    assert load(str(path)) == scene
    assert load("box-room").name == "box-room"


def test_numbers_from_numpy():
    rectangle = pz.Rectangle(
        name=np.str_("r"), position=np.array([1, 2, 3]), axis="+z", half_width=np.float64(2.0),
        half_height=np.int32(3), surface=pz.Mirror(np.float32(0.5)),
    )  # fmt: skip
    assert rectangle.position == (1.0, 2.0, 3.0)
    for value in (*rectangle.position, rectangle.half_width, rectangle.half_height):
        assert type(value) is float
    assert type(rectangle.name) is str
    assert pz.RunSettings(seed=np.uint64(2**64 - 1)).seed == 2**64 - 1


def test_integers_and_negative_zeros_become_plain_floats():
    scene = load(edited([(("element", 0, "position"), [-0.0, 1, -0.0])]))
    assert repr(scene.element[0].position) == "(0.0, 1.0, 0.0)"


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("write", [to_toml, to_json])
def test_presets_round_trip(name, write, tmp_path):
    check_round_trip(load(name), write, tmp_path)


@pytest.mark.parametrize("write", [to_toml, to_json])
def test_awkward_values_round_trip(write, tmp_path):
    rng = random.Random(3)
    for _ in range(50):
        number = rng.uniform(0.5, 1) * 10.0 ** rng.randint(-149, 149)
        tables = edited(
            [
                (("element", 0, "half_width"), number),
                (("element", 0, "position"), [rng.uniform(-1, 1) * number for _ in range(3)]),
                (("source", 0, "share"), number),
                (("source", 1, "share"), rng.random()),
                (("run", "seed"), rng.getrandbits(64)),
                (("title",), 'quotes " and \\ and é 光 \t tab'),
                (("notes",), rng.choice(['three """ quotes\n', "a\r\nb\rc\n\n", "\n", "'''\n# x"])),
                (("element", 0, "name"), "é 光 #1 [a].b = 'c' \"d\""),
            ]
        )
        check_round_trip(load(tables), write, tmp_path)


def check_round_trip(scene, write, tmp_path):
    path = tmp_path / ("scene.toml" if write is to_toml else "scene.json")
    path.write_text(write(scene), encoding="utf-8", newline="")
    again = load(path)
    assert again == scene
    assert again.digest() == scene.digest()
    assert write(again) == write(scene)
    assert load(scene.to_dict()) == scene


def test_to_dict_is_plain_and_complete():
    tables = built().to_dict()
    assert json.loads(json.dumps(tables)) == tables
    assert tables["schema"] == "photizon/1"
    assert tables["source"][0] == {
        "name": "lamp", "kind": "cosine-point", "flux": 1.0, "position": [0.0, 0.0, 1.0],
        "axis": "-z",
    }  # fmt: skip
    assert tables["element"][1]["tilt_deg"] == [10.0, -20.5]
    assert tables["element"][0]["detector"] == {"map": [4, 4], "generations": 3}
    assert "detector" not in tables["element"][1]
    assert "far_field" not in load(MINIMAL).to_dict()
    # What is handed out is a copy.
    tables["element"][0]["detector"]["map"][0] = 99
    assert built().to_dict()["element"][0]["detector"]["map"] == [4, 4]


DIGEST_CHANGES = [
    (("source", 0, "flux"), 1.0000000000000002),
    (("source", 0, "name"), "other"),
    (("source", 0, "axis"), "+z"),
    (("element", 0, "position", 0), 5e-324),
    (("element", 0, "detector", "map"), [4, 5]),
    (("element", 1, "tilt_deg"), [10, -20.6]),
    (("element", 2, "surface", "index_outside"), 1.1),
    (("far_field", "n_phi"), 9),
    (("run", "seed"), 8),
    (("run", "rays_per_batch"), 1024),
    (("run", "generation_cap"), 33),
    (("run", "roulette_floor"), 0.5),
]


@pytest.mark.parametrize("change", DIGEST_CHANGES, ids=lambda change: ".".join(map(str, change[0])))
def test_digest_sees_what_decides_the_stream(change):
    assert load(edited([change])).digest() != load(GOOD).digest()


def test_digest_sees_the_order_and_nothing_else():
    tables = copy.deepcopy(GOOD)
    tables["element"].reverse()
    assert load(tables).digest() != load(GOOD).digest()
    same = edited(
        [
            (("name",), "other"),
            (("title",), "t"),
            (("notes",), "n"),
            (("run", "target_sigma"), 0.01),
            (("run", "max_seconds"), 5),
            (("element", 0, "tilt_deg"), [0, -0.0]),
            (("element", 2, "port_fraction"), 0),
            (("source", 0, "flux"), 1),
        ]
    )
    assert load(same).digest() == load(GOOD).digest()
    assert load(GOOD).digest().startswith("sha256:")


def test_digest_is_the_same_in_another_process():
    code = "import photizon_cl as pz; print(pz.load('ghost-ladder').digest())"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == load("ghost-ladder").digest()


def test_scenes_are_frozen_and_pickle():
    scene = built()
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.name = "x"
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.element[0].surface = pz.Mirror(1)
    assert pickle.loads(pickle.dumps(scene)) == scene
    run = dataclasses.replace(scene.run, seed=9)
    assert dataclasses.replace(scene, run=run).run.seed == 9


def messages(make):
    with pytest.raises(SceneError) as caught:
        make()
    return str(caught.value).splitlines()


def test_construction_reports_everything_at_once():
    lines = messages(
        lambda: pz.Rectangle(
            name="r", position=(0, float("nan")), axis="z", half_width=-1, half_height=True,
            surface=pz.Absorber,
        )
    )  # fmt: skip
    assert len(lines) == 5
    assert lines[0].startswith("element.position: found [0, nan], expected three coordinates")
    assert "call the class to make one" in lines[2]
    assert all('in Rectangle "r"' in line for line in lines)


def test_construction_checks_between_objects():
    lamp = pz.IsotropicPoint(name="a", flux=1, position=(0, 0, 0))
    shared = pz.IsotropicPoint(name="a", flux=1, position=(0, 0, 0), share=2)
    lines = messages(lambda: pz.Scene("s", source=(lamp, shared)))
    assert lines[0].startswith('source[1].name: found "a"')
    assert lines[1].startswith("source[0].share: found nothing")
    assert messages(lambda: pz.Scene("s", source=()))[0].startswith("source: found []")
    assert messages(lambda: pz.Scene("s", source=lamp))[0].startswith("source: found")
    assert messages(lambda: pz.Scene("s", source=[lamp, pz.Mirror(1)]))[0].startswith("source[1]")


def test_construction_checks_walls_and_detectors():
    common = {"name": "x", "position": (0, 0, 0), "axis": "+z", "radius": 1.0}
    (line,) = messages(lambda: pz.Sphere(**common, port_fraction=0.1, surface=pz.Fresnel(1.5)))
    assert line.startswith('element.surface.kind: found "fresnel"')
    (line,) = messages(lambda: pz.Disk(**common, surface=pz.Mirror(0.5), detector=pz.Detector()))
    assert line.startswith("element.detector: found {}, expected no detector on a mirror")
    (line,) = messages(
        lambda: pz.Disk(**common, surface=pz.Absorber(), detector=pz.Detector(side="inside"))
    )
    assert line.startswith('element.detector.side: found "inside", expected one of "front" "back"')


def test_settings_name_their_table():
    assert messages(lambda: pz.RunSettings(seed=-1))[0].startswith("run.seed: found -1")
    assert messages(lambda: pz.FarField(n_mu=0))[0].startswith("far_field.n_mu: found 0")


def test_limits_are_inside():
    assert pz.RunSettings(seed=0, rays_per_batch=2**24, target_sigma=1, generation_cap=2**20 - 1)
    assert pz.Mirror(0).reflectance == 0.0
    assert pz.Mirror(1).reflectance == 1.0
    assert pz.Fresnel(1e-3, 1e3).index_outside == 1e3
    assert pz.Detector(map=(8192, 1), generations=4096).map == (8192, 1)
    assert len(pz.Scene("n" * 64, source=load(MINIMAL).source).name) == 64


def test_names_are_compared_in_one_normal_form():
    tables = edited([(("element", 0, "name"), "é"), (("element", 1, "name"), "e\u0301")])
    with pytest.raises(SceneError, match="no other element"):
        load(tables)


def test_a_source_and_an_element_may_share_a_name():
    assert load(edited([(("source", 0, "name"), "target")])).source[0].name == "target"


def test_exit_codes():
    codes = {SceneError: 2, ArgumentError: 2, ResultError: 2, RunError: 1, PhotizonError: 1}
    for error, code in codes.items():
        assert issubclass(error, PhotizonError)
        assert error.exit_code == code
    assert issubclass(SceneError, ValueError)


def test_importing_scenes_touches_no_opencl():
    code = "import sys, photizon_cl as pz; pz.load('box-room'); print('pyopencl' in sys.modules)"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == "False"
