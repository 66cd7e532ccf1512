"""A scene by name and by path, written and drawn."""

from __future__ import annotations

import dataclasses
import os
import pickle

import numpy as np
import pytest

import photizon_cl as pz

ROOM = pz.load("box-room")
MISSING = pytest.mark.parametrize(
    ("path", "said"),
    [
        (
            "element.flor.half_width",
            'element.flor.half_width: found "flor", expected one of "floor"',
        ),
        ("elemnt.floor.half_width", 'elemnt.floor.half_width: found "elemnt"'),
        ("element[9].name", "element[9].name: found [9], expected a number below 6"),
        ("element.floor.half_width.x", "found half_width = 1.0, expected the path to end there"),
        ("element.floor.position.x", 'found "x", expected a number in brackets, [0] to [2]'),
        ("element.floor.position[3]", "found [3], expected a number below 3"),
        ("run[0]", "found [0], expected a key here"),
        ("", "expected a path such as"),
        ("element..half_width", "expected a path such as"),
        ('element."floor.half_width', "expected a path such as"),
        ("[0].x", "expected a path such as"),
        ("a." * 100_000, "expected a path such as"),
    ],
)


def test_objects_are_found_by_name_and_by_number():
    assert ROOM.element["wall -x"] is ROOM.element[2]
    assert ROOM.element[-1].name == "wall +y"
    assert ROOM.source[ROOM.source[0].name] is ROOM.source[0]
    assert "floor" in ROOM.element
    assert "flor" not in ROOM.element
    assert ROOM.element[0] in ROOM.element
    assert [e.name for e in ROOM.element[1:3]] == ["ceiling", "wall -x"]
    assert isinstance(ROOM.element[1:3], tuple)
    assert pickle.loads(pickle.dumps(ROOM)).element["floor"] == ROOM.element["floor"]


def test_a_name_that_is_not_there_says_what_is(room):
    for look_up, said in [
        (lambda: ROOM.element["flor"], 'element: found "flor", expected one of "floor", "ceiling"'),
        (lambda: ROOM.source["lmp"], 'source: found "lmp", expected one of'),
        (lambda: room.detectors["flor"], 'expected one of "floor" (did you mean "floor"?)'),
        (lambda: room.detectors["ceiling"], "that element has none; detector = {} in the scene"),
        (lambda: room.ledger.absorbed["wall x"], 'did you mean "wall -x"?'),
        (lambda: room.ledger.others["x"], "expected nothing: there are none"),
        (lambda: room.tallies["x"], "expected nothing: there are none"),
    ]:
        with pytest.raises(KeyError) as caught:
            look_up()
        assert isinstance(caught.value, pz.UnknownNameError)
        assert said in str(caught.value)
    assert room.detectors.get("ceiling") is None


def test_many_names_are_not_all_listed():
    lamp = ROOM.source[0]
    plate = ROOM.element[1]
    many = [dataclasses.replace(plate, name=f"e{n}") for n in range(300)]
    scene = pz.Scene("many", [lamp], many)
    with pytest.raises(KeyError, match='"e11" and 288 more'):
        scene.element["x"]
    assert len(repr(scene.element)) < 200
    assert repr(scene) == "<photizon_cl.Scene 'many': 1 source, 300 elements>"


def test_replace_by_paths():
    changed = ROOM.replace(
        {
            'element."wall -x".surface.reflectance': 0.25,
            "element.wall +x.surface.reflectance": np.float64(0.5),
            "element[1].name": "top",
            "element.ceiling.position[2]": 3,
            "element.floor.tilt_deg[1]": 2.0,
            "element.floor.detector.map": (4, 5),
            f"source.{ROOM.source[0].name}.flux": 2.0,
            "run.seed": 7,
            "far_field.n_mu": 8,
            "title": "changed",
        }
    )
    assert changed.element["wall -x"].surface == pz.Lambertian(0.25)
    assert changed.element["wall +x"].surface == pz.Lambertian(0.5)
    assert changed.element["top"].position == (*ROOM.element["ceiling"].position[:2], 3.0)
    assert changed.element["floor"].tilt_deg == (0.0, 2.0)
    assert changed.element["floor"].detector == pz.Detector(map=[4, 5], generations=16)
    assert (changed.source[0].flux, changed.run.seed, changed.title) == (2.0, 7, "changed")
    assert changed.far_field == pz.FarField(n_mu=8)
    # what is not named is what it was, and so is the scene itself
    assert changed.element["wall +y"] == ROOM.element["wall +y"]
    assert pz.load("box-room") == ROOM
    assert ROOM.replace({}) == ROOM
    # a kind with its parameters, by object or as a table, and what may be absent taken away
    for mirror in (pz.Mirror(0.9), {"kind": "mirror", "reflectance": 0.9}):
        assert ROOM.replace({"element.ceiling.surface": mirror}).element[1].surface == pz.Mirror(
            0.9
        )
    bare = changed.replace({"far_field": None, "element.floor.detector": None})
    assert (bare.far_field, bare.element["floor"].detector) == (None, None)


def test_a_whole_table_and_then_a_key_of_it():
    floor = {"element.floor.detector": {}, "element.floor.detector.map": [2, 3]}
    assert ROOM.replace(floor).element["floor"].detector == pz.Detector(map=(2, 3))


@MISSING
def test_a_path_that_leads_nowhere_is_told(path, said):
    with pytest.raises(pz.ArgumentError) as caught:
        ROOM.replace({path: 1})
    assert said in str(caught.value)
    assert len(str(caught.value)) < 400


def test_values_are_checked_as_in_a_file():
    with pytest.raises(pz.SceneError) as caught:
        ROOM.replace({"element.wall -x.surface.reflectance": 2, "element.floor.half_widht": 1})
    wanted = "element[2].surface.reflectance: found 2, expected a number in [0, 1] (in element"
    assert wanted in str(caught.value)
    assert "did you mean half_width?" in str(caught.value)


@pytest.mark.parametrize("name", ["room.toml", "room.JSON"])
def test_a_scene_is_saved(name, tmp_path):
    (tmp_path / name).write_text("older")
    ROOM.save(tmp_path / name)
    ROOM.save(str(tmp_path / name))
    assert pz.load(tmp_path / name) == ROOM
    assert os.listdir(tmp_path) == [name]


def test_what_cannot_be_saved(tmp_path):
    (tmp_path / "folder.toml").mkdir()
    for path, said in [
        (tmp_path / "room.txt", "expected a file that ends in .toml or .json"),
        (tmp_path / "nowhere" / "room.toml", "cannot be written (No such file or directory)"),
        (tmp_path / "folder.toml", "it is a directory"),
        (3, "expected the path of a file"),
    ]:
        with pytest.raises(pz.ArgumentError, match="path: ") as caught:
            ROOM.save(path)
        assert said in str(caught.value)
    assert os.listdir(tmp_path) == ["folder.toml"]


def test_a_link_keeps_leading_to_its_file(tmp_path):
    (tmp_path / "real.toml").write_text("older")
    (tmp_path / "link.toml").symlink_to("real.toml")
    ROOM.save(tmp_path / "link.toml")
    assert (tmp_path / "link.toml").is_symlink()
    assert pz.load(tmp_path / "real.toml") == ROOM


# -- a port by its rim ----------------------------------------------------------------------------

SPHERE = pz.load("integrating-sphere")


def test_a_port_by_its_rim_is_the_port_by_its_area():
    # 0.6 of the radius: cos θ = 0.8, so that a tenth of the sphere is open
    by_rim = SPHERE.replace({"element.wall.radius": 0.125, "element.wall.port_radius": 0.075})
    wall = by_rim.element["wall"]
    assert (wall.port_radius, wall.rim_radius) == (0.075, 0.075)
    assert wall.port == pytest.approx(0.1, rel=4e-16)
    part = {"element.wall.radius": 0.125, "element.wall.port_fraction": wall.port}
    by_area = SPHERE.replace(part)
    assert "port_fraction" not in by_rim.to_dict()["element"][0]
    assert "port_radius" not in by_area.to_dict()["element"][0]
    assert pz.load(by_rim.to_dict()) == by_rim
    a, b = (pz.trace(scene, batches=2, rays_per_batch=1024) for scene in (by_rim, by_area))
    assert a.tally_digest == b.tally_digest
    # the rim stays where it is when the sphere grows, and either may follow the other
    assert by_rim.replace({"element.wall.radius": 0.2}).element["wall"].rim_radius == 0.075
    assert by_rim.replace(part) == by_area


@pytest.mark.parametrize("part", [1e-7, 1e-4, 0.3, 0.99, 1 - 2**-40])
def test_the_area_of_a_port_by_its_rim(part):
    from mpmath import mp, mpf, sqrt

    rim = {"port_fraction": 0.0, "radius": 1.0, "port_radius": part}
    wall = dataclasses.replace(SPHERE.element["wall"], **rim)
    with mp.workdps(60):
        exact = (1 - sqrt(1 - mpf(part) ** 2)) / 2
        assert abs(mpf(wall.port) / exact - 1) < 1e-15


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"port_radius": 0.1}, "expected a length below the radius of 0.1 m"),
        ({"port_radius": 0.2}, "a port of half the sphere or more takes port_fraction"),
        ({"port_radius": 1e-10}, "would round to 1, a sphere without a port"),
        ({"port_radius": 0.0}, "expected a positive length in metres"),
        ({"port_radius": 0.01, "surface": {"kind": "fresnel", "index": 1.5}}, "close the port"),
    ],
)
def test_ports_that_cannot_be(changes, said):
    with pytest.raises(pz.SceneError) as caught:
        SPHERE.replace({f"element.wall.{key}": value for key, value in changes.items()})
    assert said in str(caught.value)


def test_a_port_is_given_once():
    with pytest.raises(pz.SceneError, match="expected nothing beside port_fraction"):
        dataclasses.replace(SPHERE.element["wall"], port_radius=0.01)


# -- presets and drawings -------------------------------------------------------------------------


def test_presets_are_there_by_name():
    found = pz.presets()
    assert "box-room" in found
    assert found["box-room"].title == ROOM.title
    assert [pz.load(name).name for name in found] == list(found)


def test_a_scene_is_drawn_before_any_run(tmp_path):
    figure = pz.draw(ROOM, rays=6)
    assert len(figure.axes) == 5  # three sections, a view in space, a colour bar
    assert any("6 rays, seed 1" in text.get_text() for text in figure.texts)
    figure.savefig(tmp_path / "room.png")
    bare = pz.draw("box-room", rays=0)
    assert any("no rays drawn" in text.get_text() for text in bare.texts)
    with pytest.raises(pz.ArgumentError, match='by: found "colour", expected one of "generation"'):
        pz.draw(ROOM, by="colour")
    with pytest.raises(pz.ArgumentError, match="rays: found false"):
        pz.draw(ROOM, rays=False)


def test_a_scene_without_rays_is_drawn_without_a_device(run_python):
    code = "import photizon_cl as pz; pz.draw('cosine-fourth', rays=0)"
    run_python(code, {"PHOTIZON_DEVICE": "there is none of this name"})


# -- for type checkers ----------------------------------------------------------------------------

TYPED = """
import photizon_cl as pz

lamp = pz.CosinePoint(name="lamp", flux=1, position=[0, 0, 1], axis="-z", tilt_deg=[0, 10])
target = pz.Rectangle(
    name="target", position=[0, 0, 0], axis="+z", half_width=1, half_height=1,
    surface=pz.Absorber(), detector=pz.Detector(map=[8, 8], generations=4),
)
more = pz.Disk(name="d", position=(0.0, 0, 2), axis="-z", radius=1, surface=pz.Mirror(0.9))
scene = pz.Scene(name="s", source=[lamp], element=[target, more], run=pz.RunSettings(seed=3))
same = pz.Scene("s", (lamp,), (target, more))
brighter = scene.replace({"source.lamp.flux": 2.0})
x: float = scene.element["target"].position[2] + scene.source[0].flux
brighter.save("s.toml")
result = pz.trace(scene, batches=2)
power = result.detectors["target"].power
total: float = power + result.ledger.absorbed["target"] + sum(result.ledger.absorbed.values())
print(f"{power:.3f}", float(power), result.to_dataset()["target"])
pz.draw(scene).savefig("s.png")
pz.figures.ledger(result).savefig("l.pdf")
for name, preset in pz.presets().items():
    print(name, preset.anchor)
"""
WRONG = """
pz.Disk(name="d", position="here", axis="-z", radius=1, surface=pz.Mirror(0.9))
pz.Detector(map=["a", "b"])
scene.element = []
pz.Scene(name="s", source=[target])
scene.element["target"].nothing
"""


UNREAD = "".join(
    f"[mypy-{name}.*]\nfollow_imports = skip\nfollow_imports_for_stubs = True\n"
    for name in ("h5netcdf", "h5py", "mako", "matplotlib", "numpy", "pyopencl", "rich", "xarray")
)


def test_lists_pass_the_type_checker(tmp_path):
    mypy = pytest.importorskip("mypy.api")
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    # what is not ours is not read: its stubs are nine tenths of the work
    config = tmp_path / "mypy.ini"
    config.write_text(UNREAD)
    right.write_text(TYPED)
    wrong.write_text(TYPED + WRONG)
    said, _, _ = mypy.run(
        [
            "--strict",
            "--config-file",
            *map(str, (config, "--cache-dir", tmp_path / "c", right, wrong)),
        ]
    )
    errors = [line for line in said.splitlines() if "error:" in line and str(tmp_path) in line]
    assert not [line for line in errors if "right.py" in line]
    first = TYPED.count("\n") + 2
    lines = {int(line.partition("wrong.py:")[2].partition(":")[0]) for line in errors}
    assert lines == set(range(first, first + 5))
