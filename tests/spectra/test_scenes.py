"""Spectra in scenes: what is read, kept, refused and advised."""

from __future__ import annotations

import math
import re

import pytest
from oracles import spectra

import photizon_cl as pz
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.grid import Indices, numbers_of
from photizon_cl.scene.writing import to_json, to_toml

CURVE = {"wavelength_nm": [400.0, 700.0], "value": [0.5, 0.8]}


def tables(**changes):
    """A mirror, a lens of dispersing glass and a target, as a file has them."""
    found = {
        "schema": "photizon/1", "name": "lines", "spectrum": {"wavelengths_nm": spectra.LINES},
        "medium": [{"name": "bk7", "dispersion": dict(spectra.N_BK7)}],
        "source": [
            {"name": "lamp", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, 1.0],
             "axis": "-z", "radius": 0.01, "spectrum": [1.0, 2.0, 0.0]},
        ],
        "element": [
            {"name": "lens", "kind": "plano-convex", "position": [0, 0, 0.1], "axis": "+z",
             "curvature_radius": 0.05, "aperture_radius": 0.02,
             "surface": {"kind": "fresnel", "medium": "bk7"}},
            {"name": "mirror", "kind": "rectangle", "position": [0, 0, 2.0], "axis": "-z",
             "half_width": 1.0, "half_height": 1.0,
             "surface": {"kind": "mirror", "reflectance": dict(CURVE)}},
            {"name": "target", "kind": "rectangle", "position": [0, 0, 0.0], "axis": "+z",
             "half_width": 1.0, "half_height": 1.0, "surface": {"kind": "absorber"},
             "detector": {"wavelengths": True}},
        ],
    }  # fmt: skip
    for path, value in changes.items():
        at = found
        *way, last = path.split("__")
        for key in way:
            at = at[int(key) if key.isdigit() else key]
        last = int(last) if last.isdigit() else last
        if value is None:
            del at[last]
        else:
            at[last] = value
    return found


def refused(found, *wanted):
    """Assert that a scene is refused with one line, which says all that is wanted."""
    with pytest.raises(pz.SceneError) as caught:
        pz.load(found)
    text = str(caught.value)
    assert len(text.splitlines()) == 1, text
    for part in wanted:
        assert part in text, text


def test_it_comes_back_from_files(tmp_path):
    scene = pz.load(tables())
    assert scene.spectrum == pz.Spectrum(spectra.LINES)
    assert scene.source["lamp"].spectrum == (1.0, 2.0, 0.0)
    assert scene.element["mirror"].surface == pz.Mirror(pz.Curve([400, 700], [0.5, 0.8]))
    for name in ("lines.toml", "lines.json"):
        scene.save(tmp_path / name)
        again = pz.load(tmp_path / name)
        assert again == scene
        assert again.digest() == scene.digest()
    assert "wavelengths = true" in to_toml(scene)
    assert '"kind": "sellmeier"' in to_json(scene)
    other = scene.replace({"spectrum.wavelengths_nm": [500.0, 600.0, 700.0]})
    assert other.digest() != scene.digest()
    assert other.spectrum.n == 3


def test_absent_it_leaves_no_trace():
    text = to_toml(pz.load("plano-convex-condenser"))
    assert "spectrum" not in text
    assert "wavelength" not in text


@pytest.mark.parametrize(
    ("dispersion", "wanted"),
    [
        (spectra.N_BK7, float(spectra.index_of_bk7(587.6))),
        ({"kind": "cauchy", "A": 1.5, "B_um2": 0.004, "C_um4": 1e-5},
         1.5 + 0.004 / 0.5876**2 + 1e-5 / 0.5876**4),
        ({"kind": "table", "wavelength_nm": [400, 587.6, 700], "index": [1.6, 1.5, 1.4]}, 1.5),
        ({"kind": "table", "wavelength_nm": [487.6, 687.6], "index": [1.6, 1.5]}, 1.55),
    ],
)  # fmt: skip
def test_forms_of_dispersion(dispersion, wanted):
    low = {"spectrum__wavelengths_nm": [500.0, 587.6, 650.0], "medium__0__dispersion": dispersion}
    scene = pz.load(tables(**low))
    assert scene.medium["bk7"].index_at(587.6) == pytest.approx(wanted, rel=1e-15)
    assert scene.reference_nm == 587.6
    assert scene.optics[scene.element["lens"].surface].indices[0] == pytest.approx(wanted)


TABLE = {"kind": "table", "wavelength_nm": [500.0, 700.0], "index": [1.6, 1.5]}
REFUSED = [
    ({"spectrum": None, "source__0__spectrum": None, "medium__0": {"name": "bk7", "index": 1.5},
      "element__2__detector": {}},
     ["element[1].surface.reflectance", "0.8", "[spectrum]"]),
    ({"spectrum": None, "source__0__spectrum": None, "element__1__surface__reflectance": 0.5,
      "element__2__detector": {}}, ["medium[0].dispersion", "sellmeier", "[spectrum]"]),
    ({"spectrum": None, "source__0__spectrum": None, "element__1__surface__reflectance": 0.5,
      "medium__0": {"name": "bk7", "index": 1.5}},
     ["element[2].detector.wavelengths", "true", "[spectrum]"]),
    ({"spectrum": {}}, ["spectrum.wavelengths_nm", "nothing", "requires the key"]),
    ({"spectrum__wavelengths_nm": []}, ["spectrum.wavelengths_nm", "0 numbers", "1 to 1024"]),
    ({"spectrum__wavelengths_nm": [500.0, 486.1, 656.3]},
     ["spectrum.wavelengths_nm[1]", "486.1", "above 500.0", "ascend"]),
    ({"spectrum__wavelengths_nm": [500.0, 500.0, 656.3]}, ["spectrum.wavelengths_nm[1]", "twice"]),
    ({"spectrum__wavelengths_nm": [-1.0, 500.0, 656.3]}, ["spectrum.wavelengths_nm[0]", "-1.0"]),
    ({"spectrum__wavelengths_nm": [500.0, math.nan, 656.3]}, ["spectrum.wavelengths_nm[1]", "nan"]),
    ({"spectrum__edges_nm": [400.0, 500.0]},
     ["spectrum.edges_nm", "[400.0, 500.0]", "nothing beside wavelengths_nm"]),
    ({"spectrum": {"edges_nm": [400.0]}}, ["spectrum.edges_nm", "1 number", "2 to 1025"]),
    ({"spectrum": {"edges_nm": [500.0, 400.0]}}, ["spectrum.edges_nm[1]", "400.0", "above 500.0"]),
    ({"spectrum": {"edges_nm": [400.0, 500.0, 600.0]}},
     ["source[0].spectrum", "3 of them", "2 numbers, one for each band"]),
    ({"spectrum": {"edges_nm": [400.0, 500.0, 600.0, 650.0]}, "medium__0__dispersion":
      {"kind": "table", "wavelength_nm": [450.0, 700.0], "index": [1.6, 1.5]}},
     ["spectrum.edges_nm[0]", "400.0", "from 450 to 700 nm"]),
    ({"spectrum": {"edges_nm": [400.0, 500.0, 600.0, 650.0]}, "medium__0__dispersion":
      {"kind": "sellmeier", "B": [1.0, 0.01], "C_um2": [0.01, 0.25]}},
     ["spectrum.edges_nm[1]", "500", "medium[0].dispersion", "none there"]),
    ({"spectrum": {"edges_nm": [400.0, 490.0, 600.0, 650.0]}, "medium__0__dispersion":
      {"kind": "sellmeier", "B": [1.0, 0.01], "C_um2": [0.01, 0.25]}},
     ["spectrum.edges_nm[1]", "490 to 600 nm", "everywhere", "it has none at 500 nm"]),
    ({"source__0__spectrum": [1.0, 2.0]}, ["source[0].spectrum", "2 of them", "3 numbers"]),
    ({"source__0__spectrum": [1.0, 2.0], "spectrum__wavelengths_nm": [550.0]},
     ["source[0].spectrum", "2 of them", "expected one number, one for each line"]),
    ({"medium__0__dispersion": {"kind": "sellmeier", "B": [1.0], "C_um2": [0.1, 0.2]}},
     ["medium[0].dispersion.C_um2", "2 of them", "expected one number, one for each of B"]),
    ({"medium__0__dispersion": {"kind": "sellmeier", "B": [1.0], "C_um2": [0.1], "range_nm": [1]}},
     ["medium[0].dispersion.range_nm", "1 number", "expected 2 ascending wavelengths"]),
    ({"source__0__spectrum": [1.0, -2.0, 1.0]}, ["source[0].spectrum[1]", "-2.0", "from 0"]),
    ({"source__0__spectrum": [0.0, 0.0, 0.0]}, ["source[0].spectrum", "no power"]),
    ({"source__0__spectrum": [0.0, math.nan, 0.0]}, ["source[0].spectrum[1]", "nan"]),
    ({"source__0__spectrum": []}, ["source[0].spectrum", "[]"]),
    ({"medium__0__dispersion": TABLE},
     ["spectrum.wavelengths_nm[0]", "486.1", "from 500 to 700 nm", '"bk7"']),
    ({"medium__0__dispersion": {**TABLE, "index": [1.6]}},
     ["medium[0].dispersion.index", "1 of them", "2 numbers"]),
    ({"medium__0__dispersion": {**TABLE, "wavelength_nm": [700.0, 500.0]}},
     ["medium[0].dispersion.wavelength_nm[1]", "500.0", "ascend"]),
    ({"medium__0__dispersion": {**TABLE, "index": [1.6, math.inf]}},
     ["medium[0].dispersion.index[1]", "inf"]),
    ({"medium__0__dispersion": {"kind": "selmeier"}},
     ["medium[0].dispersion.kind", "selmeier", "did you mean sellmeier"]),
    ({"medium__0__dispersion": {"kind": "xyzzy"}},
     ["medium[0].dispersion.kind", '"xyzzy"', "expected one of"]),
    ({"medium__0__dispersion": {"kind": "cauchy", "a": 1.5, "A": 1.5}},
     ["medium[0].dispersion.a", "no such key", "did you mean A"]),
    ({"medium__0__dispersion": {**spectra.N_BK7, "C_um2": [0.1]}},
     ["medium[0].dispersion.C_um2", "1 of them", "3 numbers"]),
    ({"medium__0__dispersion": {"kind": "cauchy", "B_um2": 1.0}},
     ["medium[0].dispersion.A", "nothing", "requires the key A"]),
    ({"medium__0__dispersion": 1.5}, ["medium[0].dispersion", "1.5", "sellmeier",
      'kind = "polynomial", coefficients = [..], powers = [..], range_nm = [..] }']),
    ({"medium__0__index": 1.5}, ["medium[0].dispersion", "sellmeier", "nothing beside index"]),
    ({"medium__0__dispersion": None}, ["medium[0].index", "nothing", "or dispersion or glass"]),
    ({"medium__0__dispersion": {"kind": "sellmeier", "B": [-5.0], "C_um2": [0.0]}},
     ["spectrum.wavelengths_nm[0]", "486.1", "medium[0].dispersion",
      "gives none there, and none at 2 more"]),
    ({"medium__0__absorption_per_m": {"wavelength_nm": [400, 500], "per_m": [1.0, -1.0]}},
     ["medium[0].absorption_per_m.per_m[1]", "-1.0"]),
    ({"element__1__surface__reflectance": {**CURVE, "value": [0.5, 1.5]}},
     ["element[1].surface.reflectance.value[1]", "1.5", "[0, 1]"]),
    ({"element__1__surface__reflectance": {**CURVE, "values": [0.5, 0.5]}},
     ["element[1].surface.reflectance.values", "no such key", "did you mean value"]),
    ({"element__1__surface__reflectance": {"wavelength_nm": [400.0, 700.0]}},
     ["element[1].surface.reflectance.value", "nothing", "requires the key value"]),
    ({"element__1__surface__reflectance": {"wavelength_nm": [700.0, 400.0], "value": [0.1, 0.2]}},
     ["element[1].surface.reflectance.wavelength_nm[1]", "400.0"]),
    ({"element__1__surface": {"kind": "mixed", "specular": CURVE, "diffuse": 0.3}},
     ["element[1].surface.diffuse", "0.3 at 700 nm", "at most 1 - 0.8"]),
    ({"element__1__surface__reflectance": "high"},
     ["element[1].surface.reflectance", '"high"', "wavelength_nm"]),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "wanted"), REFUSED)
def test_what_is_wrong_is_refused_in_one_line(changes, wanted):
    found = tables(**changes)
    if "spectrum" in changes and changes["spectrum"] is None:
        assert "spectrum" not in found
    if "medium__0__dispersion" in changes and "spectrum__wavelengths_nm" not in changes:
        low = changes["medium__0__dispersion"] in (TABLE, {**TABLE, "index": [1.6]})
        if low and "486.1" not in wanted:
            found["spectrum"]["wavelengths_nm"] = [500.0, 587.6, 656.3]
    refused(found, *wanted)


def test_a_gap_in_a_band_is_told_beside_what_else_is_wrong():
    resonant = {"kind": "sellmeier", "B": [1.0, 0.01], "C_um2": [0.01, 0.25]}
    found = tables(
        spectrum={"edges_nm": [400.0, 490.0, 600.0, 650.0]},
        source__0__spectrum=[1.0, 2.0],
        medium__0__dispersion=resonant,
    )
    with pytest.raises(pz.SceneError) as caught:
        pz.load(found)
    both = str(caught.value).splitlines()
    assert len(both) == 2
    assert "source[0].spectrum" in both[0]
    assert "it has none at 500 nm" in both[1]


def test_a_hint_names_no_key_that_was_given():
    with pytest.raises(pz.SceneError) as caught:
        pz.load(tables(medium__0__dispersion={"kind": "xyzzy"}))
    assert "requires the key kind" not in str(caught.value)


def test_indices_that_meet_at_one_wavelength_are_no_face_without_effect():
    table = {"kind": "table", "wavelength_nm": [480.0, 587.6, 660.0]}
    for index, told in (([1.7, 1.5, 1.4], False), ([1.5, 1.5, 1.5], True)):
        found = tables(
            medium=[{"name": "bk7", "dispersion": {**table, "index": index}},
                    {"name": "oil", "index": 1.5}],
            element__0__surface={"kind": "fresnel", "medium": "bk7", "medium_outside": "oil"},
        )  # fmt: skip
        said = pz.advisories(pz.load(found))
        assert any("same index on both sides" in text for text in said) == told


def test_python_refuses_the_same():
    with pytest.raises(pz.SceneError, match="ascend"):
        pz.Spectrum([500.0, 400.0])
    with pytest.raises(pz.SceneError, match=r"surface.reflectance.value"):
        pz.Mirror(reflectance={"wavelength_nm": [400.0, 500.0], "value": [0.5, 2.0]})
    with pytest.raises(pz.SceneError, match="nothing beside index"):
        pz.Medium("glass", 1.5, dispersion=pz.Cauchy(A=1.5))
    with pytest.raises(ValueError, match="depends on wavelength"):
        pz.Medium("glass", dispersion=pz.Cauchy(A=1.5)).index_at(None)


SLOPE = pz.IndexTable([500.0, 700.0], [1.6, 1.5])
RANGED = pz.Sellmeier([1.0], [0.01], range_nm=[400.0, 700.0])


@pytest.mark.parametrize(
    ("dispersion", "nm", "wanted"),
    [
        (SLOPE, 499.9, "from 500 to 700 nm"),
        (SLOPE, 700.1, "from 500 to 700 nm"),
        (RANGED, 399.0, "from 400 to 700 nm"),
        (pz.Sellmeier([1.0], [0.25]), 500.0, "gives none there"),
        (pz.Sellmeier([1.0], [0.25]), 499.0, "gives none there"),
        (pz.Cauchy(A=2000.0), 500.0, "gives 2000 there"),
        (pz.Polynomial([1e-8], [0]), 500.0, "gives 0.0001 there"),
        *(
            (dispersion, nm, "a number of nanometres, from 0.001 to 1e+09")
            for dispersion in (SLOPE, RANGED, pz.Cauchy(A=1.5))
            for nm in (math.nan, math.inf, 0.0, -500.0, 1e-300, "550", True, 10**400)
        ),
    ],
)
def test_where_there_is_no_index_none_is_told(dispersion, nm, wanted):
    medium = pz.Medium("x", dispersion=dispersion)
    for owner, ask in (("the dispersion", dispersion.at), ('medium "x"', medium.index_at)):
        with pytest.raises(pz.ArgumentError) as caught:
            ask(nm)
        text = str(caught.value)
        assert text.startswith(f"{owner}")
        assert wanted in text
        assert len(text.splitlines()) == 1


def test_what_is_no_wavelength_is_refused_whatever_is_asked():
    dyed = pz.Medium("x", 1.5, pz.AbsorptionCurve([400.0, 700.0], [1.0, 2.0]))
    coating = pz.FixedCoating(CURVE, 0.2)
    asked = [
        pz.Medium("x", 1.5).index_at, dyed.absorption_at, pz.Curve(**CURVE).at,
        lambda nm: dyed.transmittance(0.1, nm),
        lambda nm: pz.Medium("x", 1.5, 2.0).transmittance(0.1, nm),
        lambda nm: pz.Medium("x", 1.5).transmittance(0.1, nm),
        lambda nm: coating.powers(0.0, 1.5, nm=nm),
    ]  # fmt: skip
    for ask in asked:
        ask(550.0)
        ask(550)
        for nm in (math.nan, math.inf, 0.0, -1.0, "550", True):
            with pytest.raises(pz.ArgumentError, match="found the wavelength"):
                ask(nm)
    for ask in (dyed.absorption_at, lambda nm: dyed.transmittance(0.1, nm),
                lambda nm: coating.powers(0.0, 1.5, nm=nm)):  # fmt: skip
        with pytest.raises(pz.ArgumentError, match="found no wavelength"):
            ask(None)
    for nm in (399.0, 701.0):  # what a coating does is not extrapolated
        with pytest.raises(pz.ArgumentError, match="from 400 to 700 nm"):
            coating.powers(0.0, 1.5, nm=nm)
        assert pz.Curve(**CURVE).at(nm) in CURVE["value"]
        assert dyed.absorption_at(nm) in (1.0, 2.0)


def test_indices_are_asked_of_the_media_of_a_surface_alone():
    """A scene of many glasses costs no more for a surface that has none, or has two."""
    scene = pz.load(tables())
    asked = []
    known = Indices(scene)
    whole = known.of
    known.of = lambda names, nm: asked.append(tuple(names)) or whole(names, nm)
    for element in scene.element:
        numbers_of(scene, element.surface, indices=known)(550.0)
    assert asked == [("bk7", "vacuum"), (), ()]


def test_a_table_that_ends_is_advised_of():
    scene = pz.load(tables(element__1__surface__reflectance__wavelength_nm=[500.0, 600.0]))
    (text,) = (text for text in pz.advisories(scene) if "is given from" in text)
    assert text == (
        'element "mirror": surface.reflectance is given from 500 to 600 nm; at 486.1 nm and 1 more '
        "it is taken as at its end: 0.5 as at 500 nm"
    )
    assert not [text for text in pz.advisories(pz.load(tables())) if "is given from" in text]


def test_a_path_table_over_all_lines_is_advised_of():
    scene = pz.load(tables(element__2__detector={"wavelengths": True, "paths": 5}))
    (text,) = (text for text in pz.advisories(scene) if "path table" in text)
    assert text.startswith(
        'element "target": the path table of its detector is over all wavelengths'
    )
    for other in ({"wavelengths": True}, {"paths": 5}):
        scene = pz.load(tables(element__2__detector=other))
        assert not [text for text in pz.advisories(scene) if "path table" in text]


def test_too_few_rays_and_lines_too_weak():
    scene = pz.load(tables())
    with pytest.raises(pz.ArgumentError, match=r"expected at least 2, one for each line"):
        pz.trace(scene, batches=1, rays_per_batch=1)
    weak = pz.load(tables(source__0__spectrum=[1.0, 1e-30, 0.0]))
    with pytest.raises(pz.ArgumentError, match=r"its rays of 587.6 nm carry") as caught:
        pz.trace(weak, batches=1, rays_per_batch=64)
    assert "a 0 in spectrum[1] of the source" in str(caught.value)
    assert "rays_per_batch" not in str(caught.value)  # none would do
    assert "shares" not in str(caught.value)


def test_more_rays_help_a_weak_line_where_the_message_says_so():
    weak = pz.load(tables(source__0__spectrum=[1.0, 0.0, 1e-17]))
    with pytest.raises(pz.ArgumentError, match=r"its rays of 656.3 nm carry 6.3e-16") as caught:
        compile_scene(weak, pz.RunSettings(rays_per_batch=64))
    (needed,) = re.findall(r"run.rays_per_batch = (\d+) is enough", str(caught.value))
    assert compile_scene(weak, pz.RunSettings(rays_per_batch=int(needed)))
    # of sources, each weak in all its lines, shares are what helps
    rows = tables()["source"]
    other = {**rows[0], "name": "other", "flux": 1e-20}
    with pytest.raises(pz.ArgumentError, match=r"'other': its rays of 486.1 nm .* sources shares"):
        compile_scene(pz.load(tables(source=[*rows, other])), pz.RunSettings(rays_per_batch=64))


def test_the_effect_says_why():
    told = pz.effects(pz.load(tables()))
    assert "[spectrum] has 3 lines, 486.1 … 656.3 nm" in str(told)
