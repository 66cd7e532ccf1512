"""Results on disk and back."""

from __future__ import annotations

import csv
import json
import pickle

import numpy as np
import pytest
import xarray as xr

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.run import directory as result_directory
from photizon_cl.scene.files import load
from photizon_cl.views.figures import figure_names

pytestmark = pytest.mark.usefixtures("built_quickly")

FILES = ["ledger.csv", "recipe.txt", "result.nc", "scene.toml", "summary.json"]


def arrays(result):
    """Return every array and number of a result."""
    found = {"far": result.far_field and vars(result.far_field)}
    for name, detector in result.detectors.items():
        found[name] = None
        if detector.map is not None:
            rest = {k: v for k, v in vars(detector.map).items() if k != "bins"}
            edges = {"x_edges": detector.map.x_edges, "y_edges": detector.map.y_edges}
            found[name] = rest | edges
    return found


def identical(a, b):
    assert a.summary() == b.summary()
    assert a.ledger == b.ledger
    assert a.info == b.info
    assert a.scene == b.scene
    for name, expected in arrays(a).items():
        if expected is None:
            assert arrays(b)[name] is None
            continue
        for key, value in expected.items():
            np.testing.assert_array_equal(arrays(b)[name][key], value)


@pytest.mark.parametrize("which", ["room", "sphere"])
def test_round_trip_to_the_bit(which, request, tmp_path):
    result = request.getfixturevalue(which)
    folder = tmp_path / "new" / "result"
    result.save(folder, figures=False)
    identical(pz.open_result(folder), result)
    identical(pz.open_result(str(folder / "result.nc")), result)
    assert json.loads((folder / "summary.json").read_text("utf-8")) == result.summary()
    assert load(folder / "scene.toml") == result.scene
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        [*FILES, *["detectors.csv"][: len(result.detectors)]]
    )


def test_an_opened_result_goes_on(room, tmp_path):
    pz.trace("box-room", batches=4, rays_per_batch=2048).save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).refine(batches=10).tally_digest == room.tally_digest


def test_arrays_are_labelled(room, sphere, tmp_path):
    room.save(tmp_path / "room", figures=False)
    with xr.open_dataset(tmp_path / "room" / "result.nc", engine="h5netcdf") as ds:
        irradiance = ds["floor.irradiance"]
        assert irradiance.dims == ("floor.v", "floor.u")
        assert irradiance.attrs["units"] == "W m-2"
        np.testing.assert_array_equal(irradiance.values, room.detectors["floor"].map.irradiance)
        assert ds["floor.u"].attrs["units"] == "m"
        assert ds["floor.u"].values[0] == -1.0 + 1.0 / 32
        assert ds["floor.u_edges"].values[[0, -1]].tolist() == [-1.0, 1.0]
        for name in ("sigma", "count", "area"):
            assert ds[f"floor.{name}"].dims == irradiance.dims
        assert ds["floor.ladder"].dims == ("floor.generation",)
        assert float(ds["ledger.power"].sel({"ledger.row": "emitted"})) == 1.0
        for name, array in ds.variables.items():
            if name not in ("ledger.row",):
                assert "units" in array.attrs, name
    sphere.save(tmp_path / "sphere", figures=False)
    with xr.open_dataset(tmp_path / "sphere" / "result.nc", engine="h5netcdf") as ds:
        assert ds["far_field.intensity"].attrs["units"] == "W sr-1"
        assert ds["far_field.intensity"].dims == ("far_field.mu", "far_field.phi")


def test_tables_are_read_back_to_the_bit(room, tmp_path):
    room.save(tmp_path, figures=False)
    with open(tmp_path / "ledger.csv", encoding="utf-8", newline="") as file:
        rows = {row["row"]: row for row in csv.DictReader(file)}
    assert float(rows["absorbed: wall -x"]["value_W"]) == room.ledger.absorbed["wall -x"].value
    assert float(rows["absorbed: wall -x"]["sigma_W"]) == room.ledger.absorbed["wall -x"].sigma
    assert float(rows["emitted"]["share"]) == 1.0
    with open(tmp_path / "detectors.csv", encoding="utf-8", newline="") as file:
        total, *ladder = list(csv.DictReader(file))
    floor = room.detectors["floor"]
    assert (total["detector"], total["generation"]) == ("floor", "")
    assert float(total["value_W"]) == floor.power.value
    assert [float(r["value_W"]) for r in ladder] == [rung.value for rung in floor.ladder]
    assert [int(r["count"]) for r in ladder] == [rung.count for rung in floor.ladder]
    single = pz.trace("integrating-sphere", batches=1, rays_per_batch=512)
    single.save(tmp_path / "single", figures=False)
    assert ",," in (tmp_path / "single" / "ledger.csv").read_text("utf-8")  # no σ
    assert not (tmp_path / "single" / "detectors.csv").exists()


def test_awkward_names(tmp_path):
    tables = pz.load("cosine-fourth").to_dict()
    names = ["far_field", "ledger", "a [bold] $x^2$ {µ} %", "e.irradiance"]
    target = tables["element"][0]
    tables["element"] = [
        {**target, "name": name, "position": [0.0, 0.0, -float(n)]} for n, name in enumerate(names)
    ]
    result = pz.trace(tables, batches=2, rays_per_batch=512)
    result.save(tmp_path)
    identical(pz.open_result(tmp_path), result)
    assert len(list((tmp_path / "figures").iterdir())) == 13


def test_figures_are_drawn_and_old_ones_go(room, sphere, tmp_path):
    room.save(tmp_path)
    mine = tmp_path / "figures" / "mine.png"
    mine.write_text("kept")
    drawn = {p.name for p in (tmp_path / "figures").iterdir()}
    both = {"layout.png", "ledger.png", "convergence.png"}
    floor = {"map-floor.png", "sigma-floor.png", "ladder-floor.png"}
    assert drawn == both | floor | {"mine.png"}
    assert (tmp_path / "figures" / "map-floor.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "notes.txt").write_text("kept")
    sphere.save(tmp_path, replace=True)
    drawn = {p.name for p in (tmp_path / "figures").iterdir()}
    assert drawn == both | {"far-field.png", "far-field-cuts.png", "mine.png"}
    assert (tmp_path / "notes.txt").exists()
    identical(pz.open_result(tmp_path), sphere)


@pytest.mark.slow
def test_figures_come_in_the_formats_asked_for(tmp_path):
    few = pz.trace("lambertian-sphere", batches=2, rays_per_batch=256)

    def suffixes():
        return sorted({p.suffix for p in (tmp_path / "figures").iterdir()})

    few.save(tmp_path, formats=("svg", "png"))
    assert suffixes() == [".png", ".svg"]
    assert main(["report", str(tmp_path)]) == 0
    assert (tmp_path / "report.html").exists()
    few.save(tmp_path, formats="svg")
    assert suffixes() == [".svg"]
    assert not (tmp_path / "report.html").exists()
    few.save(tmp_path)
    assert suffixes() == [".png"]
    assert figure_names(few, "svg") == figure_names(few, ["svg"])  # one needs no brackets
    for wrong in (("bmp",), "bmp"):
        with pytest.raises(pz.ArgumentError, match='formats: found "bmp"'):
            few.save(tmp_path / "no", formats=wrong)
    assert not (tmp_path / "no").exists()


def test_other_peoples_files_are_left_alone(room, tmp_path):
    file = tmp_path / "file"
    file.write_text("data")
    with pytest.raises(pz.ResultError, match="is a file"):
        room.save(file)
    (tmp_path / "thesis.tex").write_text("text")
    with pytest.raises(pz.ResultError, match="holds files and no photizon result"):
        room.save(tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    (other / "result.nc").write_text("somebody's measurement")
    with pytest.raises(pz.ResultError, match="damaged or not a photizon result"):
        room.save(other)
    assert (other / "result.nc").read_text() == "somebody's measurement"
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    xr.Dataset({"x": ("t", [1.0])}).to_netcdf(foreign / "result.nc", engine="h5netcdf")
    with pytest.raises(pz.ResultError, match='expected "photizon-result/1"'):
        room.save(foreign)


def test_what_cannot_be_opened(room, tmp_path):
    with pytest.raises(pz.ResultError, match="is not there"):
        pz.open_result(tmp_path / "absent")
    with pytest.raises(pz.ResultError, match=r"holds no result\.nc"):
        pz.open_result(tmp_path)
    (tmp_path / "text.nc").write_text("text")
    with pytest.raises(pz.ResultError, match="not a photizon result"):
        pz.open_result(tmp_path / "text.nc")
    room.save(tmp_path / "cut", figures=False)
    data = (tmp_path / "cut" / "result.nc").read_bytes()
    (tmp_path / "cut" / "result.nc").write_bytes(data[: len(data) // 2])
    with pytest.raises(pz.ResultError):
        pz.open_result(tmp_path / "cut")


def test_a_result_that_is_there_is_read_once(room, sphere, tmp_path, monkeypatch):
    room.save(tmp_path, figures=False)
    read, seen = result_directory.read_file, []
    monkeypatch.setattr(result_directory, "read_file", lambda f: (seen.append(f.name), read(f))[1])
    sphere.save(tmp_path, figures=False, replace=True)
    assert seen == ["result.nc"]


def test_a_failed_write_leaves_the_old_result(room, sphere, tmp_path, monkeypatch):
    room.save(tmp_path, figures=False)

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("photizon_cl.run.directory.write_arrays", fail)
    with pytest.raises(pz.ResultError, match="No space left on device"):
        sphere.save(tmp_path, figures=False, replace=True)
    assert pz.open_result(tmp_path).tally_digest == room.tally_digest
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


@pytest.mark.parametrize("which", ["room", "sphere"])
def test_results_are_pickled(which, request):
    result = request.getfixturevalue(which)
    again = pickle.loads(pickle.dumps(result))
    identical(again, result)
    assert again.refine(batches=result.batches + 1).batches == result.batches + 1


def test_nobody_writes_into_what_a_result_says(room, sphere):
    far = sphere.far_field
    shown = room.detectors["floor"].map
    for array in (shown.irradiance, shown.sigma, shown.count, far.intensity, far.sigma, far.count):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 7
