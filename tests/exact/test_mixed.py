"""A surface that splits and absorbs: shares to the last bit, and both limits."""

from __future__ import annotations

from fractions import Fraction

import pytest
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, cube, matt, mirror, wall

import photizon_cl as pz


def mixed(specular, diffuse):
    return {"surface": {"kind": "mixed", "specular": specular, "diffuse": diffuse}}


def above(surface):
    """A beam straight down; what is specular comes back to a small target."""
    lamp = beam((0, 0, 1), "-z", 1e-9)
    return scene_of([lamp], [{**wall((0, 0, 0), "+z", 5.0), **surface}, {
        **wall((0, 0, 3), "-z", 1e-4), **BLACK, "detector": {"generations": 3},
    }])  # fmt: skip


def test_shares_of_a_single_hit_are_exact():
    found = trace(above(mixed(0.5, 0.25)), rays_per_batch=256)
    assert found.interactions == 256 + found.detector("element 1").count
    assert found.absorbed("element 0") == 64
    # the specular half of each ray arrives whole; what is diffuse misses so small a target
    assert found.detector("element 1").ladder[1] == 128
    assert found.escaped == 64
    assert found.closures() == [0]


@pytest.mark.parametrize(
    ("one", "other"), [(mixed(0.75, 0.0), mirror(0.75)), (mixed(0.0, 0.75), matt(0.75))]
)
def test_with_one_part_alone_it_is_a_mirror_or_a_matt_wall(one, other):
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    runs = [trace(scene_of([lamp], cube(s)), rays_per_batch=1024, batches=2) for s in (one, other)]
    assert runs[0].digest == runs[1].digest
    assert not runs[0].compiled.tables.spec.splits


def test_with_neither_part_it_is_black():
    found = trace(above(mixed(0.0, 0.0)), rays_per_batch=64)
    assert (found.absorbed("element 0"), found.escaped) == (64, 0)


def test_in_a_closed_room_every_bounce_takes_its_share():
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    scene = scene_of([lamp], cube(mixed(0.25, 0.5)))
    found = trace(scene, rays_per_batch=512, generation_cap=7)
    kept = Fraction(3, 4) ** 7
    assert found.escaped == 0
    assert found.depth_capped == 512 * kept
    assert sum(found.absorbed(e.name) for e in scene.element) == 512 * (1 - kept)
    assert found.interactions == 512 * (2**7 - 1)


def test_no_rounding_absorbs_less_than_nothing():
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    for specular, diffuse in ((0.1, 0.9), (0.7, 0.3), (1 / 3, 2 / 3), (0.9, 0.1)):
        scene = scene_of([lamp], cube(mixed(specular, diffuse)))
        found = trace(scene, rays_per_batch=256, generation_cap=6)
        for element in scene.element:
            assert 0 <= found.absorbed(element.name) < Fraction(1, 10**12)
        assert max(map(abs, found.closures())) <= Fraction(1, 10**15)


@pytest.mark.parametrize("choice", [
    {"composition": "classical"}, {"lanes": 1},
    pytest.param({"max_bounces": 1, "stack_rays": 1}, marks=pytest.mark.slow),
    pytest.param({"composition": "whole-path", "lanes": 1}, marks=pytest.mark.slow),
    pytest.param({"lanes": 16, "refill": 4}, marks=pytest.mark.slow),
])  # fmt: skip
def test_the_same_bits_however_it_is_run(choice):
    walls = cube(mixed(0.3, 0.45))
    walls[2].update(matt(0.6))
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    made = compiled(
        scene_of([lamp], walls), rays_per_batch=512, roulette_floor=1e-2, generation_cap=30
    )
    assert (
        trace_compiled(made, 2, plan=PLAN.with_(**choice)).digest == trace_compiled(made, 2).digest
    )


def test_more_than_everything_is_refused():
    with pytest.raises(pz.SceneError, match=r"diffuse.*at most 1 - 0.5"):
        pz.Mixed(0.5, 0.75)
    assert pz.Mixed(0.1, 0.9).absorptance == 0.0


@pytest.mark.parametrize(("specular", "diffuse"), [(0.5, 0.0), (0.0, 0.5)])
def test_beside_glass_it_leaves_the_glass_its_children(specular, diffuse):
    """With one part alone it splits nothing, and another surface of the same packet does."""
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.1]}
    glass = {**wall((0, 0, 0.5), "+z"), "surface": {"kind": "fresnel", "index": 1.5}}
    scene = scene_of([lamp], [glass, {**wall((0, 0, -0.5), "+z"), **mixed(specular, diffuse)}])
    made = compiled(scene, rays_per_batch=512)
    runs = [trace_compiled(made, plan=PLAN.with_(lanes=lanes)) for lanes in (1, 8)]
    assert len({run.digest for run in runs}) == 1
    for run in runs:
        assert max(map(abs, run.closures())) < Fraction(1, 10**15)
