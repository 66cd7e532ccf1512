"""Runs in ``mixed`` and ``fp32``: kept, gone on with, made again, compared, and refused."""

from __future__ import annotations

import dataclasses
import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import photizon_cl as pz
from hostcode.device import capability
from photizon_cl.cli.main import main
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.run import distribution

pytestmark = pytest.mark.usefixtures("built_quickly")

RUN = {"batches": 3, "rays_per_batch": 1024, "seed": 7}
SINGLE = 2.0**-24


@pytest.fixture(scope="module")
def doubles():
    return pz.trace("ghost-ladder", **RUN)


@pytest.fixture(scope="module")
def floats():
    return pz.trace("ghost-ladder", precision="fp32", **RUN)


def test_the_mode_is_told(doubles, floats):
    assert floats.info.precision == floats.summary()["precision"] == "fp32"
    assert floats.compiled.precision.name == "fp32"
    assert doubles.summary()["precision"] == "fp64"
    assert floats.tally_digest != doubles.tally_digest


def test_a_result_keeps_its_mode_and_goes_on_in_it(floats, tmp_path):
    pz.trace("ghost-ladder", precision="fp32", **{**RUN, "batches": 2}).save(tmp_path / "a")
    back = pz.open_result(tmp_path / "a")
    assert back.info.precision == back.compiled.precision.name == "fp32"
    whole = back.refine(batches=3)
    assert whole.tally_digest == floats.tally_digest
    again = pz.resume(tmp_path / "a", batches=3)
    assert again.tally_digest == floats.tally_digest
    assert again.ledger.absorbed == floats.ledger.absorbed


def test_another_modes_result_is_not_lost_unsaid(doubles, floats, tmp_path, capsys):
    doubles.save(tmp_path / "a", figures=False)
    with pytest.raises(pz.ResultError, match="'ghost-ladder' in fp64"):
        floats.save(tmp_path / "a", figures=False)
    arguments = ["run", "ghost-ladder", "--batches", "2", "--rays-per-batch", "512", "--seed", "7"]
    out = ["--out", str(tmp_path / "b"), "--no-figures"]
    assert main([*arguments, *out]) == 0
    assert main([*arguments, *out, "--precision", "mixed"]) == 0
    assert "in fp64, which this run's will replace" in capsys.readouterr().err
    assert json.loads((tmp_path / "b" / "summary.json").read_text())["precision"] == "mixed"


def test_a_recipe_makes_the_bits_of_its_mode(floats):
    made = pz.Recipe.read(floats.recipe)
    assert made.precision == "fp32"
    again = made.trace()
    assert made.differs(again) == ""
    assert again.tally_digest == floats.tally_digest


def test_workers_compute_in_the_mode(floats):
    with ThreadPoolExecutor(1) as pool:
        found = pz.trace("ghost-ladder", precision="fp32", executor=pool, **RUN)
        # the same tables in another mode are another task
        mixed = pz.trace("ghost-ladder", precision="mixed", executor=pool, **RUN)
    assert found.tally_digest == floats.tally_digest
    assert mixed.tally_digest == pz.trace("ghost-ladder", precision="mixed", **RUN).tally_digest


def test_modes_are_paired_and_that_is_said(doubles, floats):
    found = pz.compare(doubles, floats)
    assert found.batches == 3
    assert "they are in fp64 and fp32" in found.why
    for row in found:
        assert row.paired
        assert abs(row.difference) < 64 * SINGLE  # of 1 W, by the same draws


def test_a_scene_far_away_is_brought_near(floats):
    scene = pz.load("ghost-ladder")
    far = 2.0**20
    moved = {f"source.{s.name}.position[2]": s.position[2] + far for s in scene.source}
    moved |= {f"element.{e.name}.position[2]": e.position[2] + far for e in scene.element}
    there = compile_scene(scene.replace(moved), scene.run, precision="fp32")
    here = floats.compiled
    # 0.01 + 2^20 is a double that is off by 10^-10: bounds follow that, not floats' rounding there
    assert np.abs(there.tables.geometry - here.tables.geometry).max() < 2.0**-30


def test_probes_and_paths_are_in_the_mode(floats):
    hits = {
        mode: pz.probe("ghost-ladder", [[1e-3, 2e-3, -0.05]], [[0.1, 0.2, 1.0]], precision=mode)
        for mode in ("fp64", "fp32")
    }
    assert hits["fp32"].element.tolist() == hits["fp64"].element.tolist()
    off = abs(hits["fp32"].distance[0] - hits["fp64"].distance[0])
    assert 0.0 < off < 8 * SINGLE * 0.1
    found = pz.paths("ghost-ladder", 4, seed=7, precision="fp32")
    doubles = pz.paths("ghost-ladder", 4, seed=7)
    assert len(found.start) == len(doubles.start)
    assert np.array_equal(found.start, found.start.astype(np.float32))
    assert not np.array_equal(doubles.start, doubles.start.astype(np.float32))


def small(position):
    """Return a scene of a small plate, some way off the others."""
    return pz.Scene(
        name="small",
        source=(pz.IsotropicPoint(name="lamp", flux=1.0, position=(0.0, 0.0, 0.0)),),
        element=(
            pz.Rectangle(
                name="chip", position=position, axis="+z", half_width=1e-5, half_height=1e-5,
                surface=pz.Absorber(),
            ),
            pz.Rectangle(
                name="wall", position=(0.0, 0.0, -10.0), axis="+z", half_width=5.0,
                half_height=5.0, surface=pz.Absorber(),
            ),
        ),
    )  # fmt: skip


def test_what_is_below_the_rounding_is_refused_with_numbers(tmp_path, capsys):
    scene = small((4.0, 0.0, 10.0))
    for call in (
        lambda: pz.trace(scene, precision="fp32", batches=1),
        lambda: pz.probe(scene, [[0, 0, 0]], [[0, 0, 1]], precision="mixed"),
        lambda: pz.paths(scene, 1, precision="fp32"),
    ):
        with pytest.raises(pz.ArgumentError) as caught:
            call()
        text = str(caught.value)
        assert 'element "chip" is lost in it: 2e-05 m across at 10 m' in text
        assert "single-precision numbers are 9.5e-07 m apart" in text
        assert 'expected "fp64"' in text
    scene.save(tmp_path / "small.toml")
    for verb in (["check", "--no-pilot"], ["run", "--batches", "1"]):
        asked = [verb[0], str(tmp_path / "small.toml"), *verb[1:], "--precision", "fp32"]
        assert main(asked) == 2
        assert 'element "chip" is lost in it' in capsys.readouterr().err
    assert main(["check", str(tmp_path / "small.toml"), "--no-pilot"]) == 0


def test_what_is_coarse_is_advised_with_numbers(capsys):
    scene = small((0.2, 0.0, 0.1)).replace(
        {"element.chip.half_width": 1e-3, "element.chip.half_height": 1e-3}
    )
    (text,) = (t for t in pz.advisories(scene, "fp32") if "single precision" in t)
    assert text.startswith(
        'element "chip" is small beside its length or its distance from the middle'
    )
    assert "run it in fp64" in text
    assert not [t for t in pz.advisories(scene) if "chip" in t]
    assert [t for t in pz.trace(scene, precision="mixed", batches=1).advisories if t == text]


@pytest.mark.parametrize(("gap", "told"), [(1e-7, True), (1e-3, False), (0.0, False)])
def test_a_gap_below_the_rounding_is_told(gap, told):
    plate = {"axis": "+z", "half_width": 0.5, "half_height": 0.5, "surface": pz.Mirror(0.9)}
    scene = pz.Scene(
        name="gap",
        source=(pz.IsotropicPoint(name="lamp", flux=1.0, position=(0.0, 0.0, 1.0)),),
        element=(
            pz.Rectangle(name="one", position=(0.0, 0.0, 0.0), **plate),
            pz.Rectangle(name="other", position=(0.0, 0.0, gap), **plate),
        ),
    )
    found = [t for t in pz.advisories(scene, "fp32") if "does not tell from none" in t]
    assert bool(found) == told
    if told:
        assert (
            'elements "one" and "other" have faces that stand apart by less than 9.5e-07 m'
            in found[0]
        )
    assert not [t for t in pz.advisories(scene) if "does not tell from none" in t]


@pytest.mark.parametrize("precision", ["fp16", "FP32", "", None, 32, ["fp32"]])
def test_an_unknown_mode_is_refused(precision):
    for call in (
        lambda: pz.trace("ghost-ladder", precision=precision),
        lambda: pz.probe("ghost-ladder", [[0, 0, 0]], [[0, 0, 1]], precision=precision),
        lambda: pz.paths("ghost-ladder", precision=precision),
    ):
        with pytest.raises(pz.ArgumentError, match='expected one of "fp64", "mixed", "fp32"'):
            call()


def test_a_device_that_promises_no_bits_says_so(monkeypatch, tmp_path):
    record = capability.survey().records[0]
    flags = tuple(flag for flag in record.fp32_flags if flag != "denorm")
    flushing = dataclasses.replace(record, fp32_flags=flags)
    assert record.fp32_exact
    assert not flushing.fp32_exact
    assert flushing.promises("double")
    assert not flushing.promises("float")
    opened = distribution.open_chosen(record)
    other = dataclasses.replace(opened, record=flushing)
    monkeypatch.setattr(distribution, "open_chosen", lambda device: other)
    found = pz.trace("ghost-ladder", precision="fp32", **RUN)
    assert not found.info.portable
    (text,) = (t for t in found.advisories if "does not promise the bits" in t)
    found.save(tmp_path / "a", figures=False)
    back = pz.open_result(tmp_path / "a")
    assert text in back.advisories
    assert pz.trace("ghost-ladder", **RUN).info.portable
