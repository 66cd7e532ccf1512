"""The far field over θ in everything that a run leaves and shows."""

from __future__ import annotations

import json
from html import unescape

import numpy as np
import pytest
import xarray as xr

import photizon_cl as pz
from photizon_cl.cli.main import main

pytestmark = pytest.mark.usefixtures("built_quickly")

EDGES = [1.0, 2.0, 5.0, 20.0, 60.0, 85.0]
TABLES = {
    "schema": "photizon/1",
    "name": "lamp",
    "run": {"rays_per_batch": 4096},
    "far_field": {"axis": "-x", "theta_edges_deg": EDGES, "n_phi": 1},
    "source": [
        {"name": "disk", "kind": "lambertian-disk", "flux": 2.0, "position": [0, 0, 0],
         "axis": "-x", "radius": 0.01},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A directory that the command line wrote: 4 batches of 8, and the others resumed."""
    where = tmp_path_factory.mktemp("far")
    scene = where / "lamp.json"
    scene.write_text(json.dumps(TABLES), encoding="utf-8")
    out = where / "out"
    command = ["run", str(scene), "--batches", "4", "--out", str(out), "--no-figures"]
    assert main(command) == 0
    assert main(["resume", str(out), "--batches", "8"]) == 0
    return out


@pytest.fixture(scope="module")
def whole():
    return pz.trace(TABLES, batches=8)


def test_resumed_and_opened_it_is_the_same(folder, whole):
    for path in (folder, folder / "result.nc"):
        opened = pz.open_result(path)
        assert opened.tally_digest == whole.tally_digest
        far = opened.far_field
        for name in ("intensity", "sigma", "count", "solid_angle", "theta_edges", "mu_edges"):
            assert np.array_equal(getattr(far, name), getattr(whole.far_field, name)), name
        assert far.bins == whole.far_field.bins == pz.FarField(**TABLES["far_field"])


def test_the_file_has_angles_with_units(folder, whole):
    with xr.open_dataset(folder / "result.nc") as ds:
        intensity = ds["far_field.intensity"]
        assert intensity.dims == ("far_field.theta", "far_field.phi")
        assert intensity.attrs["units"] == "W sr-1"
        assert ds["far_field.theta"].attrs["units"] == "rad"
        assert ds["far_field.theta"].attrs["comment"] == "angle from world -x"
        assert ds["far_field.phi"].attrs["comment"] == "azimuth from world +z towards +y"
        assert np.degrees(ds["far_field.theta_edges"].values) == pytest.approx(EDGES)
        solid = ds["far_field.solid_angle"]
        assert (solid.dims, solid.attrs["units"]) == (("far_field.theta",), "sr")
        power = float((intensity * solid).sum())
        assert power == pytest.approx(whole.far_field.power, rel=1e-15)
    tree = whole.to_dataset()["far_field"]
    assert tree["intensity"].dims == ("theta", "phi")
    assert (tree["intensity"].values == whole.far_field.intensity).all()


def test_the_summary_has_the_curve(folder, whole):
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    far = summary["far_field"]
    assert (far["n_theta"], far["n_phi"], far["hatched_below"]) == (5, 1, 10)
    for j, row in enumerate(far["intensity"]):
        assert row == {
            "theta_deg": [EDGES[j], EDGES[j + 1]],
            "value": whole.far_field.intensity[j, 0],
            "sigma": whole.far_field.sigma[j, 0],
            "count": whole.far_field.count[j, 0],
        }
    single = pz.trace(TABLES, batches=1).summary()["far_field"]
    assert single["intensity"][0]["sigma"] is None


def test_other_far_fields_say_how_many_bins_they_have(sphere):
    assert sphere.summary()["far_field"] == {"n_mu": 40, "n_phi": 32, "hatched_below": 10}


def test_the_report_shows_the_curve(folder, whole):
    assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    text = " ".join(unescape(page).split())
    assert "Intensity over the angle from world -x" in text
    assert "20 – 60" in text
    assert "of it in the bins, θ from 1° to 85°" in text
    assert (folder / "figures" / "far-field-theta.png").is_file()
    assert not (folder / "figures" / "far-field.png").exists()


def test_a_run_prints_the_curve_where_it_is_not_long(folder, whole, tmp_path, capsys):
    command = ["run", str(folder / "scene.toml"), "--batches", "2"]
    assert main(command) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    (row,) = [line for line in lines if line[:4] == ["θ", "20°", "–", "60°"]]
    half = pz.trace(TABLES, batches=2).far_field
    assert row[-1] == str(half.count[3, 0])
    assert float(row[4]) == pytest.approx(half.intensity[3, 0], rel=0.05)
    assert main([*command, "--set", "far_field.n_theta=60"]) == 0
    assert "far field  " not in capsys.readouterr().out


def test_check_says_where_the_bins_are(folder, capsys):
    assert main(["check", str(folder / "scene.toml"), "--no-pilot"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "far field: axis -x" in said
    assert "theta_edges_deg (1, 2, 5, 20, 60, 85) deg" in said
    assert "θ is from -x, φ from +z towards +y" in said
    assert "what leaves outside θ = 1 … 85 deg escapes unbinned" in said


def test_check_shortens_long_lists(tmp_path, capsys):
    scene = tmp_path / "long.json"
    far_field = {"theta_edges_deg": [0.5 * k for k in range(101)], "n_phi": 1}
    scene.write_text(json.dumps({**TABLES, "far_field": far_field}), encoding="utf-8")
    assert main(["check", str(scene), "--no-pilot"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "theta_edges_deg (0, 0.5, …, 50: 101 numbers) deg" in said


def test_it_can_be_the_target():
    found = pz.trace(
        TABLES, target=0.02, target_on=["far_field"], max_seconds=120.0, rays_per_batch=1 << 15
    )
    assert found.converged
    far = found.far_field
    lit = far.count[:, 0] >= 10
    error = np.median((far.sigma / far.intensity)[lit, 0])
    assert found.achieved_sigma == pytest.approx(error, rel=1e-14)
    assert found.achieved_sigma <= 0.02


def test_edges_can_be_set_by_their_path():
    scene = pz.load(TABLES).replace({"far_field.theta_edges_deg[1]": 3.5, "far_field.axis": "+y"})
    assert scene.far_field == pz.FarField(
        axis="+y", theta_edges_deg=[1.0, 3.5, 5.0, 20.0, 60.0, 85.0], n_phi=1
    )
    # one way of giving rows stands for the others
    even = scene.replace({"far_field.n_theta": 9})
    assert even.far_field == pz.FarField(axis="+y", n_theta=9, n_phi=1)
    assert even.replace({"far_field.n_mu": 8}).far_field.n_theta is None


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({"n_theta": 8192}, "lower far_field.n_theta and far_field.n_phi"),
        (
            {"theta_edges_deg": [0.02 * k for k in range(8193)]},
            "lower the number of far_field.theta_edges_deg and far_field.n_phi",
        ),
    ],
)
def test_bins_that_take_too_much_memory_are_told_by_their_name(rows, words, limited):
    limited(2 << 30)
    with pytest.raises(pz.RunError, match=words):
        pz.trace({**TABLES, "far_field": {**rows, "n_phi": 8192}})
