"""Every malformed lobe is refused in one line with path, value and reason."""

from __future__ import annotations

import math

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.writing import to_json

ABG = {"kind": "abg", "A": 1e-3, "B": 1e-2, "g": 2.0}
SHACK = {"kind": "harvey-shack", "b0": 2.0, "L": 0.01, "S": -1.5}
GAUSS = {"kind": "gaussian", "sigma": 0.05, "tis": 0.2}
TABLE = {"kind": "table", "delta": [0.0, 0.1], "bsdf_per_sr": [1.0, 0.5]}
BLACK = {"kind": "absorber"}
MIRROR = {"kind": "mirror", "reflectance": 0.9}
GLASS = {"kind": "fresnel", "index": 1.5}


def tables(surface, scatter, **more):
    plate = {
        "name": "plate", "kind": "rectangle", "position": [0, 0, 0], "axis": "+z",
        "half_width": 1.0, "half_height": 1.0, "surface": {**surface, "scatter": scatter}, **more,
    }  # fmt: skip
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.5]}
    return {"schema": "photizon/1", "name": "t", "source": [lamp], "element": [plate]}


BAD = [
    (BLACK, {**ABG, "A": -1.0}, ".A: found -1.0, expected a number from 0"),
    (BLACK, {**ABG, "B": -1.0}, ".B: found -1.0, expected a positive number"),
    (BLACK, {**ABG, "B": 0.0}, ".B: found 0.0, expected a positive number"),
    (BLACK, {**ABG, "B": 1e-40}, ".B: found 1e-40, expected at least 1e-09^g"),
    (BLACK, {**ABG, "g": math.nan}, ".g: found nan, expected a number from 0.01 to 10"),
    (BLACK, {**ABG, "h": 1.0}, ".h: found 1.0, expected no such key"),
    (BLACK, {"kind": "abg", "A": 1.0, "B": 1.0}, ".g: found nothing, expected a number"),
    (BLACK, {**SHACK, "b0": -1.0}, ".b0: found -1.0, expected a number from 0"),
    (BLACK, {**SHACK, "L": -0.1}, ".L: found -0.1, expected a number from 1e-09"),
    (BLACK, {**SHACK, "S": 0.0}, ".S: found 0.0, expected a negative number"),
    (BLACK, {**GAUSS, "sigma": -0.1}, ".sigma: found -0.1, expected a number from 1e-09"),
    (BLACK, {**GAUSS, "sigma": math.inf}, ".sigma: found inf, expected a number"),
    (BLACK, {**GAUSS, "tis": 1.5}, ".tis: found 1.5, expected a number in [0, 1]"),
    (BLACK, {**TABLE, "delta": [0.1, 0.0]}, ".delta[1]: found 0.0, expected a number above 0.1"),
    (BLACK, {**TABLE, "delta": [0.0, 3.0]}, ".delta[1]: found 3.0, expected a number from 0 to 2"),
    (BLACK, {**TABLE, "delta": [0.0, 0.1, 0.2]}, ".bsdf_per_sr: found 2 of them, expected 3"),
    (BLACK, {**TABLE, "bsdf_per_sr": [1.0, math.nan]}, ".bsdf_per_sr[1]: found nan"),
    (BLACK, {**TABLE, "bsdf_per_sr": [1.0, -1.0]}, ".bsdf_per_sr[1]: found -1.0"),
    (BLACK, {"kind": "table", "delta": [0.0], "bsdf_per_sr": [1.0]}, ".delta: found [0.0]"),
    (MIRROR, {**GAUSS, "tis": 0.95}, ": found a TIS of 0.95 at 0 deg, expected at most the refl"),
    (MIRROR, {**ABG, "A": 1.0}, ": found a TIS of 14.4988 at 0 deg, expected at most the refl"),
    (BLACK, {**ABG, "A": 1.0}, ": found a TIS of 14.4988 at 0 deg, expected at most 1"),
    (GLASS, {**ABG, "A": 1.0}, ": found a TIS of 14.4988 at 0 deg, expected at most 1"),
    (
        BLACK,
        {**TABLE, "delta": [0.0, 1.9], "bsdf_per_sr": [0.3, 0.5]},
        ": found a TIS of 1.291 at 66.6 deg, expected at most 1",
    ),
    (
        BLACK,
        {"kind": "table", "delta": [0, 1.5, 1.501, 1.502], "bsdf_per_sr": [0, 0, 5, 0]},
        ': found {kind = "table", delta = [0.0, 1.5',
    ),
    (BLACK, {"kind": "abc"}, '.kind: found "abc", expected one of "abg" "harvey-shack"'),
    (BLACK, {}, ".kind: found nothing, expected one of"),
    (BLACK, 3, ": found 3, expected a table for the scatter"),
    ({"kind": "lambertian", "reflectance": 0.5}, ABG, ': found {kind = "abg"'),
]


@pytest.mark.parametrize(("surface", "scatter", "message"), BAD)
def test_a_malformed_lobe_is_refused_in_one_line(surface, scatter, message):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables(surface, scatter))
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"element[0].surface.scatter{message}")
    assert 'in element "plate"' in line


def test_a_detector_counts_what_ends():
    with pytest.raises(pz.SceneError, match=r"element\[0\]\.detector: found a detector"):
        pz.load(tables(BLACK, GAUSS, detector={}))


def test_a_detector_counts_what_ends_on_every_face():
    rim = pz.Absorber(pz.LambertianScatter(tis=0.1))
    lens = {"front_radius": 0.1, "back_radius": 0.1, "thickness": 0.02, "aperture_radius": 0.02}
    place = {"name": "lens", "position": (0, 0, 0), "axis": "+z", "surface": pz.Absorber()}
    with pytest.raises(pz.SceneError, match=r"edge\.scatter: found a scatter"):
        pz.Lens(**place, **lens, edge=rim, detector=pz.Detector())


def test_all_of_the_reflectance_may_scatter():
    scene = pz.load(tables({"kind": "mirror", "reflectance": 0.2}, GAUSS))
    assert scene.splits()


def test_the_command_line_gives_no_traceback(tmp_path, capsys):
    path = tmp_path / "t.toml"
    path.write_text(
        """
        schema = "photizon/1"
        name = "t"
        [[source]]
        name = "lamp"
        kind = "isotropic-point"
        flux = 1.0
        position = [0, 0, 1]
        [[element]]
        name = "plate"
        kind = "disk"
        position = [0, 0, 0]
        axis = "+z"
        radius = 1.0
        surface.kind = "mirror"
        surface.reflectance = 0.1
        surface.scatter = { kind = "gaussian", sigma = 1e-3, tis = 0.05 }
        """,
        encoding="utf-8",
    )
    assert main(["check", str(path)]) == 0
    assert "TIS at normal incidence" in capsys.readouterr().out
    changed = ["--set", "element.plate.surface.scatter.tis=0.2"]
    assert main(["run", str(path), "--batches", "1", *changed]) == 2
    said = capsys.readouterr().err
    assert "element[0].surface.scatter: found a TIS of 0.2 at 0 deg, expected at most the" in said


def test_a_scene_in_code_and_in_files_is_one(tmp_path):
    lobe = pz.TableScatter(delta=[0.0, 0.1], bsdf_per_sr=[1, 0.5])
    assert lobe == pz.load(tables(BLACK, TABLE)).element["plate"].surface.scatter
    scene = pz.load(tables(MIRROR, TABLE))
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert pz.load(tmp_path / name) == scene
    assert '"bsdf_per_sr"' in to_json(scene)
    other = scene.replace({"element.plate.surface.scatter": pz.LambertianScatter(tis=0.1)})
    assert other.element["plate"].surface.scatter == pz.LambertianScatter(tis=0.1)
    assert scene.replace({"element.plate.surface.scatter": None}).digest() != scene.digest()
