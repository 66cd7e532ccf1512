"""Surfaces that light passes: what they count, and that nothing else changes."""

from __future__ import annotations

from fractions import Fraction

import pytest
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, glass, mirror, wall

from photizon_cl.scene.files import load

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

CLEAR = {"surface": {"kind": "clear"}}


def plane(position, axis="+z", half=0.4, **detector):
    return {**wall(position, axis, half), **CLEAR, "detector": detector}


def test_a_plane_before_the_port_counts_exactly_what_escapes():
    tables = load("integrating-sphere").to_dict()
    plain = trace(load(tables), rays_per_batch=4096, batches=3)
    sphere = tables["element"][0]
    port = {
        "name": "port", "kind": "disk", "axis": "+z", "radius": 1e6 * sphere["radius"],
        "position": [sphere["position"][k] + (0, 0, 2.0 * sphere["radius"])[k] for k in range(3)],
        **CLEAR, "detector": {"side": "back", "generations": 40},
    }  # fmt: skip
    assert sphere["axis"] == "+z"
    found = trace(load({**tables, "element": [sphere, port]}), rays_per_batch=4096, batches=3)
    counted = found.detector("port")
    assert counted.power == found.escaped == plain.escaped
    assert sum(counted.ladder) == counted.power
    assert counted.count == int(found.far_field_counts.sum())
    assert (found.far_field_counts == plain.far_field_counts).all()
    assert found.far_field == plain.far_field
    assert found.absorbed("port") == 0
    assert found.absorbed(sphere["name"]) == plain.absorbed(sphere["name"])
    assert found.depth_capped == plain.depth_capped
    assert found.interactions == plain.interactions


def test_passing_is_no_interaction_and_brings_no_ray_nearer_to_the_cap():
    planes = [plane((0, 0, 0.1 * k)) for k in range(1, 6)]
    target = {**wall((0, 0, 1), "-z"), **BLACK, "detector": {"generations": 3}}
    found = trace(
        scene_of([beam((0, 0, 0), "+z")], [*planes, target]), rays_per_batch=64, generation_cap=1
    )
    assert found.interactions == 64
    assert found.depth_capped == 0
    assert found.detector("element 5").ladder == [64, 0, 0]


@pytest.mark.parametrize("choice", [
    {}, pytest.param({"lanes": 1}, marks=pytest.mark.slow), {"composition": "classical"},
    {"composition": "whole-path", "lanes": 1},
], ids=["packets", "one lane", "classical", "whole path"])  # fmt: skip
def test_a_ray_that_passes_many_detectors_goes_on(choice):
    """Each records it: more than there is room for at once, which stops it on its way."""
    planes = [plane((0, 0, 0.1 * k), side="back") for k in range(1, 10)]
    target = {**wall((0, 0, 1), "-z"), **BLACK, "detector": {}}
    found = trace(
        scene_of([beam((0, 0, 0), "+z")], [*planes, target]),
        rays_per_batch=64,
        plan=PLAN.with_(**choice),
    )
    assert [found.detector(f"element {n}").count for n in range(10)] == [64] * 10
    assert found.absorbed("element 9") == found.emitted


@pytest.mark.parametrize(("side", "direction", "seen"), [
    ("front", "-z", 64), ("front", "+z", 0), ("back", "+z", 64), ("back", "-z", 0),
    (None, "-z", 64),
])  # fmt: skip
@pytest.mark.parametrize("axis", ["+z", "-z"])
def test_the_side_that_is_counted(side, direction, seen, axis):
    start = (0, 0, 1) if direction == "-z" else (0, 0, -1)
    detector = {"map": [2, 2]} if side is None else {"map": [2, 2], "side": side}
    scene = scene_of([beam(start, direction)], [plane((0, 0, 0), axis, **detector)])
    found = trace(scene, rays_per_batch=64)
    assert found.escaped == 64
    assert found.detector("element 0").power == (seen if axis == "+z" else 64 - seen)
    assert found.detector("element 0").map_total == found.detector("element 0").power


def test_a_ray_that_comes_back_is_counted_on_both_sides():
    front, back = plane((0, 0, 0), side="front"), plane((0, 0, 0.01), side="back")
    scene = scene_of(
        [beam((0, 0, 1), "-z")], [front, back, {**wall((0, 0, -1), "+z"), **mirror(0.5)}]
    )
    found = trace(scene, rays_per_batch=64)
    assert found.detector("element 0").power == 64
    assert found.detector("element 1").power == 32
    assert found.escaped == 32


def test_a_ball_is_crossed_twice():
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5, **CLEAR}
    lamp = beam((0, 0, 1), "-z", 0.3)
    for side in ("inside", "outside"):
        found = trace(scene_of([lamp], [{**ball, "detector": {"side": side}}]), rays_per_batch=64)
        assert found.detector("element 0").power == 64
        assert (found.interactions, found.escaped) == (0, 64)


def test_in_front_of_a_mirror_it_is_crossed_before_and_after():
    front, back = plane((0, 0, 0), side="front"), plane((0, 0, 0), side="back")
    shiny = {**wall((0, 0, 0), "+z"), **mirror(0.5)}
    found = trace(scene_of([beam((0, 0, 1), "-z")], [front, back, shiny]), rays_per_batch=64)
    assert found.detector("element 0").power == 64
    assert found.detector("element 1").power == 32


def test_roulette_is_not_played_again():
    # each mirror halves the weight; planes between them must not change who survives
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 0.5]}
    mirrors = [
        {**wall((0, 0, 0), "+z", 5.0), **mirror(0.5)},
        {**wall((0, 0, 1), "-z", 5.0), **mirror(0.5)},
    ]
    planes = [plane((0, 0, 0.2 + 0.1 * k), half=5.0) for k in range(4)]
    run = {"rays_per_batch": 4096, "roulette_floor": 0.3, "generation_cap": 40, "batches": 2}
    plain, found = (
        trace(scene_of([lamp], mirrors), **run),
        trace(scene_of([lamp], mirrors + planes), **run),
    )
    assert (plain.killed, plain.boosted) == (found.killed, found.boosted)
    assert plain.interactions == found.interactions
    assert plain.killed > 0
    assert max(map(abs, found.closures())) <= Fraction(1, 10**15)


@pytest.mark.parametrize("choice", [
    {"composition": "classical"}, {"max_bounces": 3, "stack_rays": 1},
    pytest.param({"composition": "whole-path", "lanes": 1}, marks=pytest.mark.slow),
    pytest.param({"lanes": 1}, marks=pytest.mark.slow),
    pytest.param({"lanes": 16, "refill": 4}, marks=pytest.mark.slow),
    pytest.param({"max_bounces": 1}, marks=pytest.mark.slow),
])  # fmt: skip
def test_the_same_bits_however_it_is_run(choice):
    elements = [
        {**wall((0, 0, 0), "+z"), **glass(1.5)}, plane((0, 0, 0.3), map=[4, 4], generations=8),
        plane((0, 0, -0.3), side="back"), {**wall((0, 0, 1), "-z"), **mirror(0.75)},
        {**wall((0, 0, -1), "+z"), **mirror(0.75)},
    ]  # fmt: skip
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 0.5]}
    made = compiled(scene_of([lamp], elements), rays_per_batch=1024, roulette_floor=1e-3)
    assert (
        trace_compiled(made, 2, plan=PLAN.with_(**choice)).digest == trace_compiled(made, 2).digest
    )
    tree = compiled(
        made.scene, frozenset({"acceleration", "contact"}), rays_per_batch=1024, roulette_floor=1e-3
    )
    assert trace_compiled(tree, 2).digest == trace_compiled(made, 2).digest
