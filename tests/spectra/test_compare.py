"""Two runs of other lines or bands: what is held against what is of the same wavelength."""

from __future__ import annotations

import json

import pytest
from oracles.engine import scene_of
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from photizon_cl.cli.main import main

CURVE = {"wavelength_nm": [400.0, 700.0], "value": [0.0, 0.75]}
"""(λ − 400 nm) / 400 nm."""
POWER = "detectors.target.power"


def run(name="lines", **spectrum):
    """A beam on a mirror, and a target that gets what it reflects; 1 W a line."""
    lines = spectrum.get("wavelengths_nm") or spectrum["edges_nm"][1:]
    scene = scene_of(
        [{**beam((0, 0, 0.5), "-z", 0.01), "flux": float(len(lines))}],
        [
            {**wall((0, 0, 0), "+z", 1.0), "name": "by_wavelength[1]",
             "surface": {"kind": "mirror", "reflectance": CURVE}},
            {**wall((0, 0, 1.0), "-z", 1.0), "name": "target", **BLACK,
             "detector": {"wavelengths": True, "generations": 2}},
        ],
        spectrum=spectrum,
    )  # fmt: skip
    return pz.trace(scene, batches=2, rays_per_batch=24)


def of_lines(names):
    return [name for name in names if name.startswith(f"{POWER}.by_wavelength")]


def test_lines_are_matched_by_wavelength():
    a = run(wavelengths_nm=[450.0, 500.0, 600.0])
    b = run(wavelengths_nm=[500.0, 550.0, 600.0, 650.0])
    found = pz.compare(a, b)
    assert of_lines(row.name for row in found) == [f"{POWER}.by_wavelength[{k}]" for k in (1, 2)]
    for row in found:
        if "by_wavelength[" in row.name.rpartition('"')[2]:  # the same light, in both
            assert row.difference == pytest.approx(0.0, abs=1e-15)
            assert row.ratio is None or row.ratio == pytest.approx(1.0, rel=1e-14)
    assert found[f"{POWER}.by_wavelength[1]"].b.value == pytest.approx(0.25, rel=1e-14)
    assert of_lines(found.only_a) == [f"{POWER}.by_wavelength[0]"]
    assert of_lines(found.only_b) == [f"{POWER}.by_wavelength[{k}]" for k in (1, 3)]
    assert found[POWER].difference == pytest.approx(0.25 + 0.375 + 0.5 + 0.625 - 0.125 - 0.25 - 0.5)
    assert "matched by wavelength" in found.why
    n = len(a.quantity_names)
    assert len(found) + len(found.only_a) == n
    assert len(found) + len(found.only_b) == len(b.quantity_names)
    # an element of such a name is none of a line
    assert 'ledger.absorbed."by_wavelength[1]"' in [row.name for row in found]


def test_bands_are_matched_by_their_edges():
    a = run(edges_nm=[400.0, 500.0, 600.0, 700.0])
    b = run(edges_nm=[450.0, 500.0, 600.0, 650.0])
    found = pz.compare(a, b)
    assert of_lines(row.name for row in found) == [f"{POWER}.by_wavelength[1]"]
    assert of_lines(found.only_a) == of_lines(found.only_b)
    mixed = pz.compare(a, run(wavelengths_nm=[450.0, 550.0, 650.0]))
    assert of_lines(row.name for row in mixed) == []
    assert len(of_lines(mixed.only_a)) == len(of_lines(mixed.only_b)) == 3


def test_of_one_spectrum_everything_is_matched(tmp_path, capsys):
    a = run(wavelengths_nm=[450.0, 500.0, 600.0])
    found = pz.compare(a, a)
    assert [row.name for row in found] == a.quantity_names
    assert (found.only_a, found.only_b) == ((), ())
    assert "spectra" not in found.why
    a.save(tmp_path / "a", figures=False)
    run(wavelengths_nm=[500.0]).save(tmp_path / "b", figures=False)
    folders = [str(tmp_path / name) for name in "ab"]
    assert main(["compare", *folders, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert of_lines(told["only_a"]) == [f"{POWER}.by_wavelength[{k}]" for k in (0, 2)]
    assert of_lines(row["name"] for row in told["quantities"]) == [f"{POWER}.by_wavelength[1]"]
    assert main(["compare", *folders]) == 0
    assert "matched by wavelength" in " ".join(capsys.readouterr().out.split())
