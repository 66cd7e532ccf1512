"""The page on the telescope is what the kept sweep prints; its scene is the preset's."""

from __future__ import annotations

import json
from dataclasses import replace

from benchmarks.pst import HERE, LOWEST, PAGE, RESULTS, SHOWN, TOP, WORST, page
from photizon_cl.scene.files import load
from photizon_cl.scene.sweep_reader import read_sweep

DATA = HERE / "data" / "pst"
AIMED = {"image", "field", "mouth"}


def kept():
    return json.loads((RESULTS / "pst.json").read_text(encoding="utf-8"))


def test_the_page_is_what_the_kept_sweep_prints():
    assert page(kept()) == PAGE.read_text(encoding="utf-8")


def test_every_angle_is_there_and_known_well_enough():
    points = kept()["points"]
    assert [p["theta_deg"] for p in points] == [
        0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0,
    ]  # fmt: skip
    assert all(p["sigma"] <= WORST * p["pst"] for p in points)
    assert min(p["pst"] for p in points) <= LOWEST
    assert {float(angle) for angle in kept()["paths"]} == set(SHOWN)
    assert all(len(rows) == TOP for rows in kept()["paths"].values())


def test_the_scene_is_the_preset_with_clear_disks_to_aim_at():
    own, preset = load(DATA / "telescope.toml"), load("baffled-telescope")
    elements = [e for e in own.element if e.name not in AIMED]
    assert {e.name for e in own.element} - {e.name for e in elements} == AIMED
    assert not any(own.element[name].surface.counts for name in AIMED)
    for mine, its in zip(elements, preset.element, strict=True):
        assert replace(mine, detector=None) == replace(its, detector=None)
    assert own.source == preset.source
    assert len(read_sweep(DATA / "pst.toml")) == 15
