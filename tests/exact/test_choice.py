"""``splitting = false``: one of two children goes on, with the weight of both."""

from __future__ import annotations

import dataclasses
import math

import pytest
from oracles.branching import RAYS, chooses, mixed, pane, room, takes_its_share, takes_rounding
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled, with_tree
from oracles.scenes import beam, glass, matt, wall

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.compile.compiled import compile_scene

pytestmark = pytest.mark.usefixtures("built_quickly")


def test_each_ray_goes_one_way():
    chooses()


def test_what_is_absorbed_stays_exact():
    takes_its_share()


@pytest.mark.parametrize(("specular", "diffuse"), [(0.3, 0.7), (0.1, 0.9), (1 / 3, 2 / 3)])
def test_where_nothing_is_absorbed_rounding_takes_next_to_nothing(specular, diffuse):
    takes_rounding(specular, diffuse)


def test_a_border_of_glass_loses_nothing_in_thousands_of_meetings():
    found = trace(room(glass(1.5)), rays_per_batch=64, generation_cap=4000, splitting=False)
    assert found.closures() == [0]
    # whole rays to the last: each has escaped, or is under way at the cap
    assert found.escaped.denominator == found.depth_capped.denominator == 1
    assert found.escaped + found.depth_capped == 64


def test_expectations_are_those_of_both_children():
    scene = pz.load("ghost-ladder")
    runs = [
        pz.trace(scene.replace({"run.splitting": splitting}), batches=32, rays_per_batch=RAYS)
        for splitting in (True, False)
    ]
    want, found = (run.detectors["reflected"].ladder for run in runs)
    for g in (1, 3):
        # 5 sigma of a binomial number
        p = float(want[g])
        assert abs(float(found[g]) - p) < 5.0 * math.sqrt(p * (1.0 - p) / runs[1].rays), g
    assert runs[1].ledger.closure == 0.0


@pytest.mark.parametrize(
    "changes",
    [
        {"composition": "classical", "lanes": 8},
        pytest.param({"lanes": 8}, marks=pytest.mark.slow),
        pytest.param({"lanes": 1}, marks=pytest.mark.slow),
        pytest.param({"composition": "classical"}, marks=pytest.mark.slow),
    ],
)
def test_the_bits_are_the_same_however_it_runs(changes):
    scene = scene_of(
        [beam((0.1, 0.2, 2), "-z", 0.3)],
        [
            {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0, **glass(1.5)},
            {**wall((0, 0, -2), "+z", 3.0), **mixed(0.3, 0.4)},
            {**wall((0, 0, 3), "-z", 3.0), **matt(0.5)},
        ],
    )
    made = compiled(scene, rays_per_batch=2000, splitting=False)
    assert not made.tables.spec.splits
    runs = [trace_compiled(made, 2, plan=plan) for plan in (PLAN, PLAN.with_(**changes))]
    assert runs[0].digest == runs[1].digest
    assert runs[0].closures() == [0, 0]


def test_through_a_tree_and_with_splitting_forced_on_the_bits_are_the_same():
    scene = pane()
    run = dataclasses.replace(scene.run, splitting=False, rays_per_batch=1000)
    scan, tree = (compile_scene(scene, run, **with_tree(tree)) for tree in (False, True))
    forced = compile_scene(scene, run, frozenset({"splitting"}))
    assert forced.tables.spec.splits
    runs = [trace_compiled(made) for made in (scan, tree, forced)]
    assert len({one.digest for one in runs}) == 1


def test_where_nothing_splits_it_changes_neither_text_nor_digest():
    scene = pz.load("integrating-sphere")
    other = scene.replace({"run.splitting": False})
    assert other.digest() == scene.digest()
    texts = [
        program_source(compile_scene(s, s.run).tables.spec.for_device(4, ("wave",)))
        for s in (scene, other)
    ]
    assert texts[0] == texts[1]


def test_where_something_splits_it_is_another_stream():
    scene = pz.load("ghost-ladder")
    other = scene.replace({"run.splitting": False})
    assert other.digest() != scene.digest()
    assert scene.replace({"run.splitting": True}).digest() == scene.digest()
    assert pz.load(other.to_dict()) == other
    assert "splitting" not in scene.to_dict()["run"]
    # the floor that auto stands for is there for rays that split
    runs = [
        dataclasses.replace(scene.run, splitting=splitting, roulette_floor="auto")
        for splitting in (True, False)
    ]
    assert [scene.roulette_floor(run) for run in runs] == [1e-9, 0.0]


@pytest.mark.parametrize("value", [0, 1, "false", None, 0.0])
def test_it_is_true_or_false(value):
    with pytest.raises(pz.SceneError, match=r"splitting.*expected true or false"):
        pz.RunSettings(splitting=value)
