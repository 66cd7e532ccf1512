"""Every malformed coating is refused in one line with path, value and reason."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.coatings import Coating
from photizon_cl.scene.registry import COATINGS

FIXED = {"kind": "fixed", "reflectance": 0.1, "transmittance": 0.8}
TABLE = {
    "kind": "table", "angle_deg": [0, 45, 90], "reflectance": [0.1, 0.2, 1.0],
    "transmittance": [0.8, 0.7, 0.0],
}  # fmt: skip
LAYER = {"index": 1.38, "thickness_nm": 99.6}
STACK = {"kind": "stack", "layers": [LAYER]}
GLASS = {"kind": "fresnel", "index": 1.5}
LINES = {"wavelengths_nm": [450.0, 550.0]}
CURVE = {"wavelength_nm": [400.0, 700.0], "value": [0.1, 0.3]}


def tables(surface, spectrum=None, **more):
    plate = {
        "name": "plate", "kind": "rectangle", "position": [0, 0, 0], "axis": "+z",
        "half_width": 1.0, "half_height": 1.0, "surface": surface, **more,
    }  # fmt: skip
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.5]}
    light = {} if spectrum is None else {"spectrum": spectrum}
    return {"schema": "photizon/1", "name": "t", **light, "source": [lamp], "element": [plate]}


def layers(*changes):
    return {"kind": "stack", "layers": [{**LAYER, **change} for change in changes]}


BAD = [
    ({**FIXED, "transmittance": 0.95}, ".transmittance: found 0.95, expected a number from 0 to 0"),
    ({**FIXED, "reflectance": -0.1}, ".reflectance: found -0.1, expected a number in [0, 1]"),
    ({**FIXED, "reflectance": math.nan}, ".reflectance: found nan, expected a number in [0, 1]"),
    ({**FIXED, "transmittance": "0.5"}, '.transmittance: found "0.5", expected a number in [0, 1]'),
    ({"kind": "fixed", "reflectance": 0.1}, ".transmittance: found nothing, expected a number"),
    ({**FIXED, "angle_deg": [0]}, ".angle_deg: found [0], expected no such key"),
    ({**FIXED, "reflectance": {**CURVE, "value": [0.1, 0.3, 0.2]}},
     ".reflectance.value: found 3 of them, expected 2 numbers, one for each wavelength"),
    ({**FIXED, "reflectance": {**CURVE, "wavelength_nm": [700.0, 400.0]}},
     ".reflectance.wavelength_nm[1]: found 400.0, expected a number above 700.0"),
    ({**FIXED, "reflectance": CURVE},
     ".transmittance: found 0.8, expected a number from 0 to 0.7 at 700 nm, as 0.3 is reflected"),
    ({**FIXED, "reflectance": {"angle_deg": [0, 90], "value": [0, 1]}},
     ".reflectance.angle_deg: found [0, 90], expected no such key"),
    ({**TABLE, "transmittance": [0.8, 0.85, 0.0]},
     ".transmittance[1]: found 0.85, expected a number from 0 to 0.8, as 0.2 is reflected"),
    ({**TABLE, "angle_deg": [0, 90, 45]}, ".angle_deg[2]: found 45.0, expected a number above 90."),
    ({**TABLE, "angle_deg": [0, 45, 45]}, ".angle_deg[2]: found 45.0, expected a number above 45."),
    ({**TABLE, "angle_deg": [0, 45, 95]}, ".angle_deg[2]: found 95, expected a number from 0 to 9"),
    ({**TABLE, "angle_deg": [-5, 45, 90]}, ".angle_deg[0]: found -5, expected a number from 0"),
    ({**TABLE, "angle_deg": [5, 45, 90]}, ".angle_deg[0]: found 5.0, expected 0 (in element"),
    ({**TABLE, "angle_deg": [0, 45, 80]}, ".angle_deg[2]: found 80.0, expected 90 (in element"),
    ({**TABLE, "angle_deg": [0, 90]}, ".reflectance: found 3 of them, expected 2 numbers, one"),
    ({**TABLE, "transmittance": [0.8, 0.7]}, ".transmittance: found 2 of them, expected 3 numbers"),
    ({**TABLE, "reflectance": [0.1, 1.2, 1.0]}, ".reflectance[1]: found 1.2, expected a number in"),
    ({**TABLE, "angle_deg": [0]}, ".angle_deg: found 1 number, expected 2 to 10000 ascending angl"),
    ({**TABLE, "angle_deg": 45.0}, ".angle_deg: found 45.0, expected 2 to 10000 ascending angles"),
    ({"kind": "stack", "layers": []}, ".layers: found 0 layers, expected a list of 1 to 1000 laye"),
    ({"kind": "stack", "layers": [LAYER] * 1001}, ".layers: found 1001 layers, expected a list of"),
    ({"kind": "stack"}, ".layers: found nothing, expected a list of 1 to 1000 layers"),
    ({"kind": "stack", "layers": LAYER}, ".layers: found {index = 1.38, thickness_nm = 99.6}"),
    ({"kind": "stack", "layers": [1.38]}, ".layers[0]: found 1.38, expected a layer: { index,"),
    (layers({}, {"thickness_nm": -1.0}), ".layers[1].thickness_nm: found -1.0, expected a thickne"),
    (layers({"thickness_nm": 2e6}), ".layers[0].thickness_nm: found 2000000.0, expected a thickne"),
    (layers({"extinction": -0.1}), ".layers[0].extinction: found -0.1, expected an extinction"),
    (layers({"index": 0.0}), ".layers[0].index: found 0.0, expected a refractive index, a number"),
    (layers({"index": -1.4}), ".layers[0].index: found -1.4, expected a refractive index, a numbe"),
    (layers({"medium": "MgF2"}), '.layers[0].medium: found "MgF2", expected no such key; a layer'),
    ({"kind": "stack", "layers": [{"index": 1.4}]}, ".layers[0].thickness_nm: found nothing, expe"),
    ({"kind": "stak", "layers": [LAYER]}, '.kind: found "stak", expected one of "fixed" "table" "'),
    ({}, '.kind: found nothing, expected one of "fixed" "table" "stack"'),
    (3, ": found 3, expected a table for the coating"),
]  # fmt: skip


@pytest.mark.parametrize(("coating", "message"), BAD)
def test_a_malformed_coating_is_refused_in_one_line(coating, message):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables({**GLASS, "coating": coating}, LINES))
    line, *more = str(caught.value).splitlines()  # a line for each problem
    assert line.startswith(f"element[0].surface.coating{message}")
    assert len(more) <= 1
    assert 'in element "plate"' in line


SURFACES = [
    ({"kind": "mirror", "reflectance": 0.9, "coating": FIXED}, ".coating: found {kind ="),
    ({"kind": "absorber", "coating": FIXED}, ".coating: found {kind ="),
    ({"kind": "mirror", "reflectance": {"angle_deg": [45, 0], "value": [0.5, 0.6]}},
     ".reflectance.angle_deg[1]: found 0.0, expected a number above 45.0"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [0, 45], "value": [0.5]}},
     ".reflectance.value: found 1 of them, expected 2 numbers, one for each angle"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [0, 95], "value": [0.5, 0.6]}},
     ".reflectance.angle_deg[1]: found 95, expected a number from 0 to 90"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [], "value": []}},
     ".reflectance.angle_deg: found 0 numbers, expected 1 to 10000 ascending angles"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [0], "value": [1.5]}},
     ".reflectance.value[0]: found 1.5, expected a number in [0, 1]"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [0], "value": [0.5], "wavelength_nm": [4]}},
     ".reflectance.wavelength_nm: found [4], expected no such key"),
    ({"kind": "lambertian", "reflectance": {"angle_deg": [0], "value": [0.5]}},
     ".reflectance.angle_deg: found [0], expected no such key"),
    ({"kind": "mirror", "reflectance": {"angle_deg": [0, 45, 90], "value": [0.9, 0.02, 0.9]},
      "scatter": {"kind": "lambertian", "tis": 0.05}},
     ".scatter: found a TIS of 0.05 at 45 deg, expected at most the reflectance there, 0.02"),
]  # fmt: skip


@pytest.mark.parametrize(("surface", "message"), SURFACES)
def test_a_surface_that_takes_none_or_another_is_refused(surface, message):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables(surface))
    first = str(caught.value).splitlines()[0]
    assert first.startswith(f"element[0].surface{message}")


def test_what_depends_on_wavelength_needs_a_spectrum():
    for coating, key in ((STACK, "layers"), ({**FIXED, "transmittance": CURVE}, "transmittance")):
        with pytest.raises(pz.SceneError) as caught:
            pz.load(tables({**GLASS, "coating": coating}))
        (line,) = str(caught.value).splitlines()
        assert line.startswith(f"element[0].surface.coating.{key}: found")
        assert "expected the table [spectrum] in the scene" in line
        assert pz.load(tables({**GLASS, "coating": coating}, LINES))


@pytest.mark.parametrize(
    "spectrum", [{"wavelengths_nm": [550.0, 750.0, 800.0]}, {"edges_nm": [390.0, 500.0]}]
)
def test_a_table_over_wavelength_is_refused_outside(spectrum):
    coating = {**FIXED, "reflectance": CURVE, "transmittance": 0.5}
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables({**GLASS, "coating": coating}, spectrum))
    (line,) = str(caught.value).splitlines()
    assert line.startswith("element[0].surface.coating.reflectance: found one from 400 to 700 nm, ")
    assert "expected a table that reaches" in line
    assert "not extrapolated" in line
    ends = {"edges_nm": [400.0, 700.0]}
    scene = pz.load(tables({**GLASS, "coating": coating}, ends))
    assert not [text for text in pz.advisories(scene) if "taken as at its end" in text]


def test_a_mirror_by_angle_is_constant_beyond_its_nodes_and_that_is_told():
    table = {"angle_deg": [10, 60], "value": [0.9, 0.8]}
    scene = pz.load(tables({"kind": "mirror", "reflectance": table}))
    (text,) = (a for a in pz.advisories(scene) if "has a reflectance" in a)
    assert "from 10 to 60 deg: below it is taken as at 10 deg and beyond it is taken" in text
    whole = {"angle_deg": [0, 90], "value": [0.9, 0.8]}
    scene = pz.load(tables({"kind": "mirror", "reflectance": whole}))
    assert not [a for a in pz.advisories(scene) if "has a reflectance" in a]


def test_a_coated_border_of_equal_indices_is_one():
    bare = pz.load(tables({"kind": "fresnel", "index": 1.0}))
    assert [a for a in pz.advisories(bare) if "same index on both sides" in a]
    coated = pz.load(tables({"kind": "fresnel", "index": 1.0, "coating": FIXED}))
    assert not [a for a in pz.advisories(coated) if "same index on both sides" in a]


@pytest.mark.parametrize(("thickness", "told"), [(99.64, False), (0.09964, True), (0.0, False)])
def test_a_film_in_another_unit_is_told(thickness, told):
    stack = {"kind": "stack", "layers": [
        {"index": 1.38, "thickness_nm": 100.0}, {"index": 1.38, "thickness_nm": thickness},
    ]}  # fmt: skip
    said = pz.advisories(pz.load(tables({**GLASS, "coating": stack}, LINES)))
    assert any("layers[1] of the coating is 0.09964 nm thick" in text for text in said) is told


@pytest.mark.parametrize(("nm", "told"), [([0.45, 0.65], True), ([450.0, 650.0], False)])
def test_wavelengths_in_another_unit_are_told(nm, told):
    said = pz.advisories(pz.load(tables(GLASS, {"wavelengths_nm": nm})))
    assert any("so that 0.65 µm is 650" in text for text in said) is told


def test_a_list_without_names_is_counted():
    scene = pz.load(tables({**GLASS, "coating": STACK}, LINES))
    name = scene.element[0].name
    with pytest.raises(pz.ArgumentError, match=r'found "index", expected a number in brackets'):
        scene.replace({f"element.{name}.surface.coating.layers.index": 1.4})


def test_who_cements_is_told_of_the_coating():
    glass = pz.Fresnel(1.5, coating=pz.FixedCoating(0.01, 0.99))
    lens = pz.Lens(
        name="a", position=(0, 0, 0), axis="+z", surface=glass, front_radius=0.1,
        back_radius=math.inf, thickness=0.01, aperture_radius=0.02,
    )  # fmt: skip
    flat = lens.derived()["back vertex at"][0]
    other = replace(lens, name="b", position=(0, 0, 2 * flat), axis="-z")
    lamp = pz.IsotropicPoint(name="s", flux=1.0, position=(0, 0, 1))
    said = pz.advisories(pz.Scene(name="t", source=[lamp], element=[lens, other]))
    (text,) = (text for text in said if "to cement them" in text)
    assert text.endswith("which loses its coating, the coating then stands in the cement")


def test_the_command_line_gives_no_traceback(tmp_path, capsys):
    path = tmp_path / "t.json"
    scene = pz.load(tables({**GLASS, "coating": STACK}, LINES))
    scene.save(path)
    assert main(["check", str(path), "--no-pilot"]) == 0
    said = capsys.readouterr().out
    assert "coating: stack, layers (99.6 nm of 1.38)" in said
    assert "at normal incidence" in said
    changed = ["--set", "element.plate.surface.coating.layers[0].thickness_nm=-3"]
    assert main(["run", str(path), "--batches", "1", *changed]) == 2
    said = capsys.readouterr().err
    assert "coating.layers[0].thickness_nm: found -3, expected a thickness" in said


@pytest.mark.parametrize("coating", [FIXED, TABLE, STACK, {**FIXED, "reflectance": CURVE,
                                                          "transmittance": 0.1}])  # fmt: skip
def test_a_scene_in_code_and_in_files_is_one(coating, tmp_path):
    scene = pz.load(tables({**GLASS, "coating": coating}, LINES))
    made = scene.element["plate"].surface.coating
    assert isinstance(made, Coating)
    cls = COATINGS[coating["kind"]]
    assert cls(**{k: v for k, v in coating.items() if k != "kind"}) == made
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert pz.load(tmp_path / name) == scene
    bare = scene.replace({"element.plate.surface.coating": None})
    assert bare.digest() != scene.digest()
    assert bare.replace({"element.plate.surface.coating": made}) == scene


def test_curves_that_people_give_are_taken():
    curve = pz.Curve([400.0, 700.0], [0.1, 0.3])
    read = pz.load(tables({**GLASS, "coating": {**FIXED, "reflectance": CURVE,
                                                 "transmittance": 0.5}}, LINES))  # fmt: skip
    assert read.element[0].surface.coating == pz.FixedCoating(curve, 0.5)
    mirror = pz.Mirror(pz.AngleCurve([0, 60], [0.9, 0.8]))
    table = {"kind": "mirror", "reflectance": {"angle_deg": [0, 60], "value": [0.9, 0.8]}}
    assert pz.load(tables(table)).element[0].surface == mirror
    assert mirror.absorptance is None


def test_films_that_a_precision_cannot_carry_are_told():
    thick = {"kind": "stack", "layers": [{**LAYER, "thickness_nm": 1e5}]}
    scene = pz.load(tables({**GLASS, "coating": thick}, LINES))
    said = [text for text in pz.advisories(scene, "mixed") if "wavelengths thick" in text]
    assert len(said) == 1
    assert "the coating is 307 wavelengths thick at 450 nm" in said[0]
    assert not [text for text in pz.advisories(scene) if "wavelengths thick" in text]
    thin = pz.load(tables({**GLASS, "coating": STACK}, LINES))
    assert not [text for text in pz.advisories(thin, "fp32") if "wavelengths thick" in text]
