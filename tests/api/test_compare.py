"""Two runs compared: paired by batch where they share a stream, in quadrature where not."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main

ESCAPED = "ledger.escaped"
REFLECTANCE = "element.wall.surface.reflectance"


def sphere(reflectance, seed=1, batches=24, rays=256, **more):
    scene = pz.load("integrating-sphere").replace({REFLECTANCE: reflectance, **more})
    return pz.trace(scene, seed=seed, batches=batches, rays_per_batch=rays)


@pytest.fixture(scope="module")
def white():
    return sphere(0.97)


@pytest.fixture(scope="module")
def grey():
    return sphere(0.96)


def escapes(reflectance, port=0.05):
    """Part that leaves a diffuse sphere by its port; P = f Σ (ρ(1 − f))^k from the first hit on."""
    return port / (1.0 - reflectance * (1.0 - port))


def test_a_run_and_itself_do_not_differ(white):
    found = pz.compare(white, white)
    assert [row.name for row in found] == white.quantity_names
    assert found.batches == 24
    for row in found:
        assert (row.difference, row.sigma, row.paired) == (0.0, 0.0, True)
        assert row.ratio in (1.0, None)
        assert row.ratio_sigma in (0.0, None)


def test_batches_are_held_against_batches(white, grey):
    row = pz.compare(grey, white)[ESCAPED]
    x, y = grey.batch_values(ESCAPED), white.batch_values(ESCAPED)
    assert row.paired
    assert row.difference == pytest.approx(np.mean(y - x), rel=1e-12)
    assert row.sigma == pytest.approx(np.std(y - x, ddof=1) / math.sqrt(24), rel=1e-12)
    assert row.ratio == pytest.approx(y.mean() / x.mean(), rel=1e-12)
    rest = y - row.ratio * x
    wanted = np.std(rest, ddof=1) / math.sqrt(24) / x.mean()
    assert row.ratio_sigma == pytest.approx(wanted, rel=1e-12)
    assert (row.a, row.b) == (grey.ledger.escaped, white.ledger.escaped)


def test_pairing_tells_reflectances_apart_that_quadrature_does_not(white, grey):
    paired = pz.compare(grey, white)[ESCAPED]
    other = pz.compare(grey, sphere(0.97, seed=2))[ESCAPED]
    assert paired.ratio_sigma < other.ratio_sigma / 4.0
    truth = escapes(0.97) / escapes(0.96)
    assert abs(paired.ratio - truth) < 4.0 * paired.ratio_sigma


@pytest.mark.parametrize(
    ("other", "why"),
    [
        ({"seed": 2}, "the seeds differ (1 and 2)"),
        ({"rays": 128}, "the rays per batch differ (256 and 128)"),
        ({"batches": 1}, "a single batch has no scatter"),
    ],
)
def test_other_streams_add_in_quadrature(white, other, why):
    b = sphere(0.97, **other)
    found = pz.compare(white, b)
    assert (found.batches, found.why) == (0, why)
    row = found[ESCAPED]
    assert not row.paired
    assert row.difference == b.ledger.escaped.value - white.ledger.escaped.value
    if b.batches == 1:
        assert (row.sigma, row.ratio_sigma) == (None, None)
        return
    sigma = math.hypot(b.ledger.escaped.sigma, white.ledger.escaped.sigma)
    assert row.sigma == pytest.approx(sigma, rel=1e-14)
    parts = [e.sigma / e.value for e in (b.ledger.escaped, white.ledger.escaped)]
    assert row.ratio_sigma == pytest.approx(row.ratio * math.hypot(*parts), rel=1e-14)


def test_runs_of_other_lengths_pair_in_the_batches_that_both_have(white):
    longer = sphere(0.97, batches=30)
    found = pz.compare(longer, white)
    assert found.batches == 24
    assert "and the first 24 batches" in found.why
    # the same batches: nothing differs, and both are shown as these say
    assert (found[ESCAPED].difference, found[ESCAPED].sigma) == (0.0, 0.0)
    assert found[ESCAPED].a.value == pytest.approx(white.ledger.escaped.value, rel=1e-14)
    assert found[ESCAPED].a.sigma == pytest.approx(white.ledger.escaped.sigma, rel=1e-12)
    assert found[ESCAPED].b == white.ledger.escaped


def test_a_run_that_is_much_longer_is_compared_whole():
    """Else what its other batches tell would be thrown away; what both share is counted once."""
    short, long = sphere(0.96, batches=6), sphere(0.97, batches=300)
    found = pz.compare(short, long)
    assert found.batches == 6
    one, other = short.quantity(ESCAPED), long.quantity(ESCAPED)
    row = found[ESCAPED]
    x, y = short.batch_values(ESCAPED), long.batch_values(ESCAPED)
    shared = np.cov(x, y[:6])[0, 1] * 6 / (6 * 300)
    square = one.sigma**2 + other.sigma**2 - 2.0 * shared
    paired = np.std(y[:6] - x, ddof=1) / math.sqrt(6)
    assert row.sigma == pytest.approx(min(math.sqrt(square), paired), rel=1e-12)
    assert row.paired == (paired < math.sqrt(square))
    rows = [row for row in found if row.whole]
    assert all(not row.paired for row in rows)
    # of another scene, in which nothing is alike, all batches tell more
    empty = sphere(0.0, batches=6)
    row = pz.compare(empty, long)[ESCAPED]
    assert row.whole
    assert (row.a, row.b) == (empty.quantity(ESCAPED), other)
    assert row.difference == other.value - empty.quantity(ESCAPED).value
    assert row.ratio == pytest.approx(other.value / empty.quantity(ESCAPED).value, rel=1e-15)
    assert abs(row.difference - (escapes(0.97) - escapes(0.0))) < 4.0 * row.sigma


def test_lines_are_called_by_their_wavelengths(tmp_path, capsys):
    scene = pz.load("dispersing-prism")
    for seed, name in enumerate(("a", "b")):
        pz.trace(scene, seed=seed, batches=2, rays_per_batch=256).save(
            tmp_path / name, figures=False
        )
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    out = capsys.readouterr().out
    for line in scene.spectrum.names:
        assert f"screen, {line}" in " ".join(out.split())
    assert "by_wave" not in out


def test_what_one_run_alone_has_is_named(white):
    found = pz.compare(white, pz.trace("box-room", batches=24, rays_per_batch=256))
    assert "ledger.absorbed.wall" in found.only_a
    assert "detectors.floor.power" in found.only_b
    assert {row.name for row in found} >= {ESCAPED, "ledger.depth_capped"}
    with pytest.raises(pz.UnknownNameError, match="did you mean"):
        found["ledger.escapd"]
    assert found['"ledger".escaped'] is found[ESCAPED]


def test_batches_of_other_engines_are_no_pairs(white):
    info = dataclasses.replace(white.info, engine="other")
    found = pz.compare(white, pz.Result(white.compiled, white.tally, info))
    assert (found.batches, found.why) == (0, "other versions of the engine made them")


def test_files_and_the_command_say_the_same(white, grey, tmp_path, capsys):
    white.save(tmp_path / "white", figures=False)
    grey.save(tmp_path / "grey", figures=False)
    folders = [str(tmp_path / name) for name in ("grey", "white")]
    assert main(["compare", *folders, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary == pz.compare(grey, white).summary()
    assert pz.compare(folders[0], tmp_path / "white" / "result.nc").summary() == summary
    assert summary["schema"] == "photizon-comparison/1"
    assert main(["compare", *folders]) == 0
    out = capsys.readouterr().out
    assert "paired over 24 batches" in out
    row = next(line for line in out.splitlines() if line.startswith("escaped"))
    assert float(row.split()[4]) == pytest.approx(pz.compare(grey, white)[ESCAPED].ratio, rel=1e-2)
    assert "more are 0 in both" in out
    sphere(0.97, seed=3).save(tmp_path / "other", figures=False)
    assert main(["compare", folders[0], str(tmp_path / "other")]) == 0
    assert "in quadrature, since the seeds differ (1 and 3)" in capsys.readouterr().out
    assert main(["compare", folders[0], str(tmp_path / "absent")]) == 2
    assert "is not there" in capsys.readouterr().err
    assert main(["compare", "", folders[0]]) == 2


def test_directories_without_a_result_are_told_together(white, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    white.save("white", figures=False)
    (tmp_path / "empty").mkdir()
    assert main(["compare", "white", "empty"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert '"empty" holds no result.nc: give the directory that a run wrote' in line
    assert main(["compare", "absent", "empty"]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert '"absent" is not there: give' in first
    assert '"empty" holds no result.nc: give' in second
    assert main(["compare", "empty", "empty"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    # one that was killed has what its checkpoint holds
    again = {"seed": 1, "batches": 5, "rays_per_batch": 256, "checkpoint": "killed"}
    pz.trace(white.scene, **again)
    assert main(["compare", "white", "killed"]) == 0
    assert "paired over 5 batches" in capsys.readouterr().out


@pytest.mark.slow
def test_the_paired_difference_holds_the_truth_as_often_as_it_says():
    """240 seeds of 40 batches: within ±2σ in 0.948 of them (Student, 39 degrees of freedom).

    0.95 ± 0.03 is missed by chance once in 30 sets of seeds; these are fixed.
    """
    truth = escapes(0.97) - escapes(0.96)
    within = 0
    for seed in range(240):
        a, b = (sphere(rho, seed=seed, batches=40, rays=64) for rho in (0.96, 0.97))
        row = pz.compare(a, b)[ESCAPED]
        within += abs(row.difference - truth) <= 2.0 * row.sigma
    assert abs(within / 240 - 0.95) <= 0.03, within
