"""Scatter and nested media in scenes with a spectrum: all that reads a number reads the ray's."""

from __future__ import annotations

import math

import pytest
from oracles import media, spectra, spectra_scatter, watched
from oracles.engine import PLAN, TREE, compiled, trace_compiled

import photizon_cl as pz
from photizon_cl.cli.main import main

LOBE = {"kind": "lambertian", "tis": 0.25}
TABLE = {"wavelength_nm": [400.0, 500.0, 700.0], "value": [0.9, 0.2, 0.5]}


@pytest.mark.parametrize("by", ["lines", "bands"])
def test_glass_and_mirrors_scatter_a_part_of_what_their_wavelength_leaves(by):
    spectra_scatter.scattering(by)


@pytest.mark.parametrize("by", ["lines", "bands"])
def test_a_bubble_in_glass_in_water(by):
    spectra_scatter.nested(by)


def test_nested_media_book_by_line_and_are_the_right_ones():
    found = spectra_scatter.nested_rows()
    assert not any(media.mismatches(found))
    spectra.sums(found)
    assert all(abs(closure) < 1e-15 for closure in found.closures())
    layout = found.compiled.layout
    row = layout.row("absorbed_in.water")
    parts = [float(found.amount(layout.part(row, k))) for k in range(3)]
    # 0.21, 0.75 and 2.1 per metre at the three lines
    assert 0.0 < parts[0] < parts[1] < parts[2]


@pytest.mark.statistical
def test_importance_sampling_weighs_by_line():
    """|z| of six means in Student's limit of 31 degrees of freedom, false alarm 1e-6 in all."""
    spectra_scatter.aimed_by_line()


@pytest.mark.parametrize(
    ("by", "splitting"),
    [
        ("bands", True),
        pytest.param("lines", False, marks=pytest.mark.slow),
        pytest.param("lines", True, marks=pytest.mark.slow),
        pytest.param("bands", False, marks=pytest.mark.slow),
    ],
)
def test_lanes_and_compositions_change_no_bit(by, splitting):
    scene = spectra_scatter.everything(spectra_scatter.BY[by], splitting=splitting)
    made = compiled(scene, rays_per_batch=96)
    found = trace_compiled(made, batches=2)
    plans = [{"lanes": 1}, {"items": 2, "wave_rays": 32}]
    if splitting:
        plans.append({"composition": "classical"})
    for plan in plans:
        assert trace_compiled(made, batches=2, plan=PLAN.with_(**plan)).digest == found.digest
    spectra.sums(found)
    layout = found.compiled.layout
    assert all(abs(closure) < 1e-15 for closure in found.closures())
    for name in ("importance.balance", "absorbed_in.bk7"):
        row = layout.row(name)
        assert all(found.amount(layout.part(row, k)) for k in range(3)), name
    (detector,) = layout.detectors
    assert found.count(detector.power) > 20


@pytest.mark.slow
def test_a_narrow_band_is_its_line():
    tables = spectra_scatter.everything(spectra_scatter.BY["lines"]).to_dict()
    del tables["source"][0]["spectrum"]
    spectra_scatter.narrow_band(tables, 64)


@pytest.mark.slow  # large programs
@pytest.mark.parametrize("how", [{}, {"force": TREE}])
def test_a_narrow_band_is_its_line_for_every_kind(how):
    spectra_scatter.narrow_band(watched.every_kind("lines"), 70, **how)


@pytest.mark.slow
@pytest.mark.parametrize("by", ["lines", "bands"])
def test_a_tree_changes_no_bit(by):
    scene = spectra_scatter.everything(spectra_scatter.BY[by])
    plain, tree = (
        trace_compiled(compiled(scene, force, rays_per_batch=96)) for force in (frozenset(), TREE)
    )
    assert tree.compiled.tables.spec.one_by_one > plain.compiled.tables.spec.one_by_one
    assert plain.digest == tree.digest


def plate(reflectance, scatter, **more):
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.5]}
    mirror = {
        "name": "plate", "kind": "rectangle", "position": [0, 0, 0], "axis": "+z",
        "half_width": 1.0, "half_height": 1.0,
        "surface": {"kind": "mirror", "reflectance": reflectance, "scatter": scatter},
    }  # fmt: skip
    return {
        "schema": "photizon/1", "name": "t", "source": [lamp], "element": [mirror],
        "spectrum": {"wavelengths_nm": [450.0, 650.0]}, **more,
    }  # fmt: skip


def test_more_scatter_than_the_least_reflectance_is_refused(tmp_path, capsys):
    with pytest.raises(pz.SceneError) as caught:
        pz.load(plate(TABLE, LOBE))
    assert str(caught.value) == (
        "element[0].surface.scatter: found a TIS of 0.25 at 0 deg, expected at most the "
        'reflectance, 0.2 at 500 nm, where it is least (in element "plate"; the reflectance is '
        "all that leaves, and what scatters is a part of it)"
    )
    with pytest.raises(pz.SceneError, match=r"0\.2 at 500 nm"):
        pz.Mirror(pz.Curve(**TABLE), scatter=pz.LambertianScatter(tis=0.25))
    fits = {**LOBE, "tis": 0.2}
    scene = pz.load(plate(TABLE, fits))
    assert scene.element["plate"].surface.scatter.tis == 0.2
    scene.save(tmp_path / "t.toml")
    assert pz.load(tmp_path / "t.toml") == scene
    assert main(["check", str(tmp_path / "t.toml"), "--no-pilot"]) == 0
    text = capsys.readouterr().out
    assert "reflectance 0.2 … 0.9 over 400 … 700 nm" in text
    assert main(["check", str(tmp_path / "t.toml"), "--set",
                 "element.plate.surface.scatter.tis=0.3", "--no-pilot"]) == 2  # fmt: skip
    error = capsys.readouterr().err
    assert "0.2 at 500 nm" in error
    assert "Traceback" not in error


def test_a_table_with_scatter_needs_a_spectrum():
    found = plate(TABLE, {**LOBE, "tis": 0.1})
    del found["spectrum"]
    with pytest.raises(pz.SceneError, match=r"element\[0\].surface.reflectance: .*\[spectrum\]"):
        pz.load(found)


def test_all_that_a_lines_reflectance_leaves_is_scattered_where_both_are_equal():
    """ρ = TIS at one line: there nothing goes on specularly, at the other all but TIS."""
    scene = pz.load(
        plate({"wavelength_nm": [450.0, 650.0], "value": [0.2, 0.5]}, LOBE | {"tis": 0.2})
    )
    scene = scene.replace({"run.roulette_floor": 0.0})
    found = pz.paths(scene, rays=16, seed=2)
    left = found.generation == 1
    for line, wanted in ((0, {0.2}), (1, {0.2, 0.3})):
        of_line = left & (found.ray // 8 == line)
        assert of_line.any()
        weights = {round(w, 12) for w in found.weight[of_line].tolist() if w > 1e-15}
        assert weights == wanted
    assert math.isclose(sum(found.weight[found.generation == 0]), 16.0)
