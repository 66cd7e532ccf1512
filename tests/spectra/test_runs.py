"""Spectra in runs: what comes out by wavelength, in Python, files, figures and on the terminal."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
from oracles import spectra

import photizon_cl as pz
from photizon_cl.cli.main import main


@pytest.fixture(scope="module")
def result():
    return pz.trace(spectra.tables_scene(), batches=3, rays_per_batch=64)


def test_every_row_gives_what_each_line_brings(result):
    rows = [row for _, row in result.ledger.labelled_rows()]
    (detector,) = result.detectors.values()
    for row in (*rows, detector.power, *detector.ladder):
        assert len(row.by_wavelength) == 4
        assert sum(row.by_wavelength) == pytest.approx(row.value, rel=1e-15, abs=1e-30)
        assert all(part.sigma is not None for part in row.by_wavelength)
    assert len(detector.map.by_wavelength) == 4
    total = sum(m.irradiance for m in detector.map.by_wavelength)
    assert total == pytest.approx(detector.map.irradiance, rel=1e-15)
    assert sum(m.count for m in detector.map.by_wavelength).tolist() == detector.map.count.tolist()
    assert pickle.loads(pickle.dumps(detector.power)) == detector.power
    assert result.ledger.emitted.by_wavelength[0] == 0.75


def test_quantities_go_by_line(result):
    name = 'detectors."element 3".power'
    assert f"{name}.by_wavelength[2]" in result.quantity_names
    power = result.detectors["element 3"].power
    assert result.detectors["element 3"].by_wavelength == power.by_wavelength
    assert f"{len(power.by_wavelength)} wavelengths" in repr(result.detectors["element 3"])
    found = result.quantity(f"{name}.by_wavelength[2]")
    assert found == power.by_wavelength[2].value
    assert found.count == power.by_wavelength[2].count
    assert result.batch_values(f"{name}.by_wavelength[2]").mean() == pytest.approx(found, rel=1e-14)
    escaped = result.quantity("ledger.absorbed_in.dye.by_wavelength[0]")
    assert (escaped.value, escaped.count) == (0.0, None)
    for wrong in (
        f"{name}.by_wavelength[4]", "ledger.escaped.by_wavelength[9]", "far_field.by_wavelength[0]"
    ):  # fmt: skip
        with pytest.raises(pz.ArgumentError):
            result.quantity(wrong)
    with pytest.raises(pz.ArgumentError, match="over all wavelengths together"):
        result.quantity("far_field.by_wavelength[0]")
    on = f"{name}.by_wavelength[1]"
    met = pz.trace(result.scene, target=0.5, target_on=[on], rays_per_batch=64, max_seconds=60)
    assert met.converged
    assert len(pz.compare(result, met)) == len(result.quantity_names)


@pytest.mark.parametrize("light", ["wavelengths_nm", "edges_nm"])
def test_paths_tell_what_a_batch_does_and_of_which_line_each_ray_is(result, light):
    scene = result.scene
    if light == "edges_nm":
        scene = scene.replace({"spectrum": {"edges_nm": [420.0, 450.0, 520.0, 600.0, 660.0]}})
    found = pz.paths(scene, rays=32)
    ledger = pz.trace(scene, batches=1, rays_per_batch=32).ledger
    assert found.ledger["escaped"] == ledger.escaped.value
    for name, row in ledger.absorbed.items():
        assert found.ledger[f"absorbed by {name}"] == row.value
    assert found.ledger["absorbed in dye"] == ledger.absorbed_in["dye"].value > 0.0
    rays = [line for line in found if line.parent < 0]
    assert len(rays) == 32
    watts = [0.0] * 4
    for ray in rays:
        watts[ray.line] += ray.weight[0] * found.unit_power
        single = None if light == "edges_nm" else scene.spectrum.wavelengths_nm[ray.line]
        assert ray.wavelength_nm == single
    assert watts == pytest.approx(ledger.emitted.by_wavelength, rel=1e-14)
    # by number, of a later batch of the scene's own
    own = scene.replace({"run.rays_per_batch": 32})
    again = pz.paths(own, ray_numbers=[32 + ray.ray for ray in rays[::5]])
    assert [r.line for r in again if r.parent < 0] == [r.line for r in rays[::5]]
    plain = pz.paths("cosine-fourth", rays=4)
    assert plain.line is None
    assert {(ray.line, ray.wavelength_nm) for ray in plain} == {(None, None)}


def test_the_summary_says_which_wavelengths_its_lists_are_of(result):
    summary = result.summary()
    assert summary["spectrum"] == {"wavelengths_nm": [425.0, 500.0, 550.0, 650.0]}
    assert len(summary["ledger"]["escaped"]["by_wavelength"]) == 4
    bands = result.scene.replace({"spectrum": {"edges_nm": [420.0, 450.0, 520.0, 600.0, 660.0]}})
    summary = pz.trace(bands, batches=1, rays_per_batch=16).summary()
    assert summary["spectrum"] == {"edges_nm": [420.0, 450.0, 520.0, 600.0, 660.0]}
    assert json.loads(json.dumps(summary))["spectrum"] == summary["spectrum"]
    assert "spectrum" not in pz.trace("cosine-fourth", batches=1, rays_per_batch=16).summary()


def test_a_quantity_of_no_line_says_how_one_is_named(result):
    name = 'detectors."element 3".power'
    for asked, whole in (
        (f"{name}.by_wavelength", name), ("ledger.escaped.by_wavelength", "ledger.escaped"),
        (f"{name[:-6]}.map.by_wavelength", f"{name[:-6]}.map"),
        ("ledger.absorbed_in.dye.by_wavelength", "ledger.absorbed_in.dye"),
    ):  # fmt: skip
        with pytest.raises(pz.ArgumentError) as caught:
            result.quantity(asked)
        assert f"{whole}.by_wavelength[i]" in str(caught.value)
    with pytest.raises(pz.ArgumentError, match=r"or one line or band of one: .by_wavelength\[i\]"):
        result.quantity('detectors."element 3".by_wavelength')
    with pytest.raises(pz.SceneError, match=r"run.target_on.*by_wavelength\[i\]"):
        pz.trace(result.scene, batches=1, target_on=["ledger.escaped.by_wavelength"])


def test_the_report_counts_no_spectrum_that_is_there_among_what_is_not(result):
    from photizon_cl.views.report.claims import _physics

    text = " ".join(map(str, _physics(result)))
    assert "<strong>No polarisation.</strong> Light is of 4 lines, 425 … 650 nm, and of " in text
    assert "What lies in dye absorbs by Beer and Lambert's law" in text
    plain = pz.trace("cosine-fourth", batches=1, rays_per_batch=16)
    assert "<strong>No spectrum, no polarisation, no bulk absorption.</strong> One set" in " ".join(
        map(str, _physics(plain))
    )


def test_the_report_says_of_scatter_and_films_what_the_scene_has():
    from photizon_cl.views.report.claims import _physics

    said = {
        name: " ".join(map(str, _physics(pz.trace(name, batches=1, rays_per_batch=16))))
        for name in ("scattering-mirror", "coated-window", "cosine-fourth")
    }
    assert "but for their scatter without roughness or dust" in said["scattering-mirror"]
    assert "without measured scatter, roughness or dust" in said["cosine-fourth"]
    assert "as their coatings say, within which alone films interfere" in said["coated-window"]
    plain = pz.FixedCoating(reflectance=0.1, transmittance=0.9)
    window = pz.load("ghost-ladder").replace({"element.front.surface.coating": plain})
    text = " ".join(map(str, _physics(pz.trace(window, batches=1, rays_per_batch=16))))
    assert "as their coatings say" in text
    assert "films interfere" not in text


def test_files_have_it_and_a_run_goes_on(result, tmp_path):
    result.save(tmp_path / "out")
    again = pz.open_result(tmp_path / "out")
    assert again.summary() == result.summary()
    written = json.loads((tmp_path / "out" / "summary.json").read_text())
    parts = written["ledger"]["absorbed"]["element 2"]["by_wavelength"]
    assert [part["value"] for part in parts] == [
        part.value for part in result.ledger.absorbed["element 2"].by_wavelength
    ]
    table = (tmp_path / "out" / "spectrum.csv").read_text().splitlines()
    assert table[0] == "what,name,generation,wavelength_nm,value_W,sigma_W,count"
    assert len(table) == 1 + 4 * (len(result.ledger.labelled_rows()) + 1 + 6)
    found = result.to_dataset()
    assert found["ledger/power_by_wavelength"].dims == ("wavelength", "row")
    assert found["element 3/irradiance_by_wavelength"].shape == (4, 3, 2)
    assert found["element 3"]["wavelength"].values.tolist() == [425.0, 500.0, 550.0, 650.0]
    resumed = pz.resume(tmp_path / "out", batches=5)
    whole = pz.trace(result.scene, batches=5, rays_per_batch=64)
    assert resumed.tally_digest == whole.tally_digest
    assert resumed.ledger.escaped == whole.ledger.escaped


def test_it_is_shown(result, tmp_path, capsys):
    result.save(tmp_path / "out")
    assert main(["report", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "By wavelength" in page
    assert "650 nm" in page
    axes = pz.figures.by_wavelength(result).axes[0]
    assert axes.get_xlabel() == "wavelength in nm"
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels[0] == "detector element 3"
    drawn = axes.containers[0].lines[0]
    power, emitted = result.detectors["element 3"].power, result.ledger.emitted
    wanted = np.divide(power.by_wavelength, emitted.by_wavelength)
    assert drawn.get_ydata() == pytest.approx(wanted)
    figure = pz.figures.irradiance(result, "element 3", line=1)
    mesh = next(c for c in figure.axes[0].collections if c.get_label() == "values")
    one = result.detectors["element 3"].map.by_wavelength[1]
    assert np.ma.compressed(mesh.get_array()).tolist() == one.irradiance[~one.hatched].tolist()
    for wrong in (4, -1, "red"):
        with pytest.raises(pz.ArgumentError, match="a number from 0 to 3"):
            pz.figures.irradiance(result, "element 3", line=wrong)
    result.scene.save(tmp_path / "lines.toml")
    capsys.readouterr()
    assert main(["check", str(tmp_path / "lines.toml"), "--no-pilot"]) == 0
    text = capsys.readouterr().out
    assert "spectrum: 4 lines, 425 … 650 nm" in text
    assert "absorption_per_m 0 … 40 over 450 … 650 nm 1/m" in text
    with pytest.raises(pz.ArgumentError, match=r"\[spectrum\] adds it"):
        pz.figures.by_wavelength(pz.trace("cosine-fourth", batches=1, rays_per_batch=16))
