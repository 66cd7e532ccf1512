"""Rays on their way through media: where they end, what is counted, and what is said of it."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest
from oracles import media
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.views.drawing import view

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

FOG = {"name": "fog", "index": 1.0, "absorption_per_m": 2.0}
CLEAR = {"surface": {"kind": "clear"}}


def in_fog(*elements, alpha=2.0, **parts):
    """A beam along +z in fog of index 1, from the origin."""
    lamp = {**beam((0, 0, 0), "+z", 1e-9), "medium": "fog"}
    fog = {**FOG, "absorption_per_m": alpha}
    return scene_of([lamp], list(elements), medium=[fog], **parts)


def in_medium(found, name="fog"):
    return found.amount(found.compiled.layout.row(f"absorbed_in.{name}"))


def plate(z, **more):
    return {**wall((0, 0, z), "-z"), **BLACK, **more}


@pytest.mark.parametrize("precision", ["fp64", "mixed", "fp32"])
def test_nothing_escapes_from_what_absorbs(precision):
    """Neither to the ledger's row nor to the far field, whose bins count nothing."""
    scene = in_fog(far_field={"n_mu": 2, "n_phi": 2})
    found = trace(scene, rays_per_batch=100, batches=2, precision=precision)
    assert in_medium(found) == found.emitted
    assert found.escaped == 0
    assert found.far_field_counts.sum() == 0
    assert found.closures() == [0, 0]
    clear = trace(in_fog(alpha=0.0, far_field={"n_mu": 2, "n_phi": 2}), rays_per_batch=100)
    assert clear.escaped == clear.emitted
    assert clear.far_field_counts.sum() == 100


def test_a_ray_of_which_nothing_is_left_ends_on_its_way():
    """It is no arrival and no interaction, and neither is its end an escape."""
    scene = in_fog(plate(1.0, detector={"paths": 4}), alpha=800.0)
    found = trace(scene, rays_per_batch=64)
    assert in_medium(found) == found.emitted
    assert found.interactions == found.detector("element 0").count == 0
    rows = pz.paths(scene, rays=3)
    assert [line.ending for line in rows] == ["absorbed"] * 3
    assert rows.element.tolist() == [-1] * 3
    # drawn no further than to the face that was on its way, and out of the picture without one
    np.testing.assert_allclose(rows.end, [[0.0, 0.0, 1.0]] * 3, atol=2e-9)
    box = view.Box(np.full(3, -3.0), np.full(3, 3.0), np.zeros(3), 1.0, "m")
    np.testing.assert_array_equal(view.shown_rays(rows, box).end, rows.end)
    away = pz.paths(in_fog(alpha=800.0), rays=1)
    assert away.end[0, 2] == away.escape_length
    assert view.shown_rays(away, box).end[0, 2] == 3.0


@pytest.mark.parametrize(("alpha", "z"), [(2.0, 0.75), (51.7, 0.3)])
def test_a_detector_gets_what_is_left(alpha, z):
    """To the last bit; of the second pair's product a double holds only a part."""
    found = trace(in_fog(plate(z, detector={}), alpha=alpha), rays_per_batch=64)
    kept = Fraction(pz.Medium("fog", 1.0, alpha).transmittance(z))
    assert found.detector("element 0").power == found.absorbed("element 0") == 64 * kept
    assert in_medium(found) == 64 * (1 - kept)


def test_a_way_in_two_parts_is_a_way():
    """A clear plane halves it, sees what half of it leaves, and changes nothing else."""
    planes = [{**wall((0, 0, z), "+z"), **CLEAR, "detector": {"side": "back"}} for z in (0.25, 0.5)]
    whole = trace(in_fog(plate(0.75, detector={})), rays_per_batch=64)
    parted = trace(in_fog(plate(0.75, detector={}), *planes), rays_per_batch=64)
    ends = [float(t.detector("element 0").power) for t in (whole, parted)]
    assert ends[1] == pytest.approx(ends[0], rel=4e-16)
    for n, z in ((1, 0.25), (2, 0.5)):
        power = float(parted.detector(f"element {n}").power)
        assert power == pytest.approx(64 * math.exp(-2.0 * z), rel=4e-16)
    assert parted.interactions == whole.interactions
    assert media.mismatches(parted) == [0, 0, 0]
    assert parted.closures() == [0]


def test_what_meets_the_cap_travels_no_further():
    layers = media.plate(1.5, 5.0)
    parts = media.stack(layers, [0.0, 1.0], -1.0, generation_cap=1, rays_per_batch=32)
    found = trace(scene_of(**parts))
    assert in_medium(found, "glass") == 0
    assert abs(found.depth_capped - found.emitted) <= 32 * Fraction(1, 2**52)  # of the split


def test_roulette_sees_what_absorption_left():
    """0.37 of 1 is below a floor of 0.4, 1 is not: every ray is played for once."""
    matt = {**wall((0, 0, 0.5), "-z"), "surface": {"kind": "mirror", "reflectance": 1.0}}
    run = {"roulette_floor": 0.4, "generation_cap": 1}
    found = trace(in_fog(matt, run=run), rays_per_batch=4096)
    left = Fraction(pz.Medium("fog", 1.0, 2.0).transmittance(0.5))
    assert found.killed + found.boosted == 0  # capped before it is played for
    run["generation_cap"] = 2
    found = trace(in_fog(matt, run=run), rays_per_batch=4096)
    assert found.killed + found.boosted == 4096 * left
    assert 1800 < found.killed / left < 2300  # of 4096: 8 standard deviations
    higher = trace(in_fog(matt, run={**run, "roulette_floor": 0.3}), rays_per_batch=4096)
    assert higher.killed == higher.boosted == 0


def test_a_source_in_glass_that_is_not_told_so(tmp_path):
    """Each face that a ray meets from within is met in the wrong medium."""
    ball = {
        "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.1,
        "surface": {"kind": "fresnel", "medium": "glass"},
    }  # fmt: skip
    glass = {"name": "glass", "index": 1.5, "absorption_per_m": 1.0}
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 0.0]}
    run = {"generation_cap": 4, "rays_per_batch": 256}
    for medium, part in (("vacuum", 1), ("glass", 0)):
        scene = scene_of([{**lamp, "medium": medium}], [ball], medium=[glass], run=run)
        found = trace(scene, batches=2)
        assert media.mismatches(found) == [part * found.interactions]
        result = pz.trace(scene, batches=2)
        summary = result.summary()
        assert summary["media_mismatches"] == part * summary["interactions"]
        assert result.counts["media_mismatches"] == summary["media_mismatches"]
        said = [text for text in result.advisories if "names another medium" in text]
        assert len(said) == part
        if part:
            assert said[0].startswith(f"{summary['interactions']} times a ray met a surface")
            assert f'{summary["interactions"]} at "element 0"' in said[0]
            result.save(tmp_path / "run", figures=False)
            again = pz.open_result(tmp_path / "run")
            assert again.counts == result.counts
            assert said[0] in again.advisories
            with ThreadPoolExecutor(2) as pool:
                shared = pz.trace(scene, batches=2, executor=pool)
            assert shared.tally_digest == result.tally_digest


def test_borders_by_index_say_nothing_of_media_and_lead_out_of_them():
    """Behind an index of 1 lies the vacuum, behind another one what has no name."""
    surface = lambda **sides: {"surface": {"kind": "fresnel", **sides}}  # noqa: E731
    elements = [
        {**wall((0, 0, 0.1), "-z"), **surface(index=1.2, index_outside=1.2)},  # fog, then no name
        {**wall((0, 0, 0.2), "-z"), **surface(medium="fog")},  # wrong: no name beside vacuum
        {**wall((0, 0, 0.3), "+z"), **surface(index=1.0, index_outside=1.0)},  # fog, then vacuum
        {**wall((0, 0, 0.4), "-z"), **surface(medium="fog")},  # right
        plate(0.5),
    ]
    found = trace(in_fog(*elements), rays_per_batch=32)
    assert media.mismatches(found) == [0, 32, 0, 0, 0]
    left = math.exp(-2.0 * 0.3)
    assert float(in_medium(found)) == pytest.approx(32 * (1.0 - left), rel=1e-14)


def test_without_absorption_it_is_a_scene_of_indices():
    """Bit by bit, in every row and detector."""
    plain = pz.load("ghost-ladder")
    tables = plain.to_dict()
    indices = sorted(
        {s["index"] for s in (e["surface"] for e in tables["element"]) if "index" in s}
    )
    tables["medium"] = [{"name": f"n = {index}", "index": index} for index in indices]
    for element in tables["element"]:
        surface = element["surface"]
        if "index" in surface:
            assert surface.pop("index_outside") == 1.0
            surface["medium"] = f"n = {surface.pop('index')}"
    found, by_index = (trace(s, rays_per_batch=512, batches=2) for s in (pz.load(tables), plain))
    assert found.interactions == by_index.interactions
    assert any(e.surface.media for e in found.compiled.scene.element)
    mine, others = found.compiled.layout.pieces, by_index.compiled.layout.pieces
    assert set(mine) - set(others) == {f"row absorbed_in.n = {i}" for i in indices} | {
        "effect media"
    }
    for piece, (first, n) in others.items():
        at = mine[piece][0]
        assert found.cells[at : at + n].tobytes() == by_index.cells[first : first + n].tobytes()
    new = [found.cells[first : first + n] for p, (first, n) in mine.items() if p not in others]
    assert not np.concatenate(new).any()


def test_paths_tell_the_weight_that_is_left():
    layers = media.plate(1.5, 30.0)
    parts = media.stack(layers, [0.0, 0.01], -0.05, 0.05, generation_cap=8)
    rows = pz.paths(scene_of(**parts), rays=1)
    kept = math.exp(-0.3)
    weights = sorted(rows.weight.tolist(), reverse=True)
    # launched, into the glass as it starts there, and out of it
    assert weights[0] == 1.0
    assert weights[1] == pytest.approx(0.96, rel=1e-15)
    assert weights[2] == pytest.approx(0.96 * 0.96 * kept, rel=1e-15)


def test_a_path_table_adds_up_in_what_absorbs():
    layers = media.plate(1.5, 30.0)
    parts = media.stack(layers, [0.0, 0.01], -0.05, 0.05, generation_cap=9, rays_per_batch=64)
    parts["elements"][-1]["detector"] = {"paths": 16}
    plate_of = pz.trace(scene_of(**parts), batches=2).detectors["plate"]
    part, kept = 0.04, math.exp(-0.3)
    powers = [row.power for row in plate_of.paths]
    expected = [0.96**2 * kept * (part * kept) ** (2 * k) for k in range(len(powers))]
    assert powers == pytest.approx(expected, rel=1e-13)
    assert math.fsum(powers) == pytest.approx(plate_of.power.value, rel=1e-15)


def test_a_check_tells_wrong_media_before_a_run(tmp_path, capsys):
    """By a pilot, which counts them as the run will."""
    ball = {
        "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.1,
        "surface": {"kind": "fresnel", "medium": "glass"},
    }  # fmt: skip
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 0.0]}
    glass = {"name": "glass", "index": 1.5, "absorption_per_m": 1.0}
    for medium in ("vacuum", "glass"):
        scene = scene_of([{**lamp, "medium": medium}], [ball], medium=[glass])
        scene.save(tmp_path / "ball.toml")
        assert main(["check", str(tmp_path / "ball.toml")]) == 0
        told = " ".join(capsys.readouterr().out.split())
        assert ("by a pilot of 512 rays: " in told) == (medium == "vacuum")
        assert ("names another medium than the ray was in" in told) == (medium == "vacuum")
