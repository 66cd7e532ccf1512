"""Importance sampling: what targets draw, exact ledgers, bounded weights, what it leaves alone."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from oracles import aiming
from oracles.aiming import LAMP, room
from oracles.engine import PLAN, compiled, open_device, scene_of, trace
from oracles.kernels import run_text
from oracles.scenes import BLACK, beam, cube, matt, wall

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.geometry.targets import BALL, RING, SQUARE

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

# -- what targets draw -----------------------------------------------------------------------------

_BODY = """
__kernel void test(__global const double *t, __global const double *numbers, __global double *out) {
    const size_t i = get_global_id(0);
    __global const double *n = numbers + 8 * i;
    packet_t p = {0};
    contact_t c = no_contact(&p, splat(0.0));
    c.x = n[0]; c.y = n[1]; c.z = n[2];
    const sight_t s = see_target(t, &c, n[3], n[4], n[5]);
    real x, y, z;
    const real own = draw_target(t, &s, n[6], n[7], &x, &y, &z);
    const real again = density_target(t, &s, x, y, z);
    const real behind = density_target(t, &s, -x, -y, -z);
    const double found[7] = {(double)-s.seen, x, y, z, own, again, behind};
    for (int k = 0; k < 7; k++) out[7 * i + k] = found[k];
}
"""


@cache
def spec():
    return compiled(room()).tables.spec


def row(shape, centre, frame, a, b, side=0):
    area = {SQUARE: 4.0 * a * b, RING: math.pi * (a - b) * (a + b), BALL: 0.0}[shape]
    reach = math.hypot(a, b) if shape == SQUARE else a
    per_area = 1.0 / area if area else 0.0
    what = [a, b, per_area, reach, side, shape]
    return np.array([*centre, *np.ravel(frame), *what, 1.0, 1.0, 0.0, 1.0])


def drawn(target, place, up=(0.0, 0.0, 1.0), n=64):
    """Draw n × n directions towards a target, evenly in u and v, and their densities."""
    at = (np.arange(n) + 0.5) / n
    u, v = (grid.ravel() for grid in np.meshgrid(at, at))
    numbers = np.column_stack([np.tile([*place, *up], (n * n, 1)), u, v])
    out = np.zeros((n * n, 7))
    _, _, found = run_text(_BODY, [target, numbers, out], n * n, spec=spec(), device=open_device())
    seen, way, own, again, behind = (
        found[:, 0], found[:, 1:4], found[:, 4], found[:, 5], found[:, 6]
    )  # fmt: skip
    return seen != 0.0, way, own, again, behind


FLAT = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
TURNED = np.array([[0.0, 0.6, 0.8], [1, 0, 0], [0, 0.8, -0.6]])
EDGE_ON = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
CASES = {
    "rectangle": (SQUARE, 0.3, 0.5, (0, 0, 1.0), FLAT),
    "turned rectangle": (SQUARE, 0.3, 0.5, (0, 0, 2.0), TURNED),
    "rectangle aside": (SQUARE, 0.3, 0.5, (1.5, -0.7, 1.0), FLAT),
    "disk": (RING, 0.5, 0.0, (0, 0, 1.0), FLAT),
    "ring": (RING, 0.5, 0.3, (0.2, 0, 1.0), FLAT),
    "ball": (BALL, 0.5, 0.0, (0.3, 0.4, 1.0), FLAT),
    "near rectangle": (SQUARE, 0.3, 0.5, (0, 0, 0.2), FLAT),
    "far rectangle": (SQUARE, 0.3, 0.5, (0, 0, 1e6), FLAT),
    "far ball": (BALL, 0.5, 0.0, (3e5, 0, 1e6), FLAT),
    "tiny rectangle": (SQUARE, 3e-7, 5e-7, (0, 0.2, 1.0), FLAT),
    "tiny ring": (RING, 5e-7, 3e-7, (0, 0, 1.0), TURNED),
    "tiny ball": (BALL, 5e-7, 0.0, (0, 0, 1.0), FLAT),
    "far and tiny": (SQUARE, 3e-7, 5e-7, (0, 0, 1e6), TURNED),
    "grazing": (SQUARE, 0.3, 0.5, (0, 0.02, 1.0), EDGE_ON),
}
"""Shape, sizes, centre and frame, seen from the origin."""


def solid_angle(shape, a, b, centre, frame, n=400):
    """The solid angle by quadrature over the target, or of the ball's cone."""
    if shape == BALL:
        sine = a / np.linalg.norm(centre)
        return 2.0 * math.pi * sine**2 / (1.0 + math.sqrt(1.0 - sine**2))
    s = (np.arange(n) + 0.5) / n
    if shape == SQUARE:
        p, q = np.meshgrid((2 * s - 1) * a, (2 * s - 1) * b)
        area = 4.0 * a * b
    else:
        r, turn = np.meshgrid(np.sqrt(b * b + s * (a * a - b * b)), 2.0 * math.pi * s)
        p, q, area = r * np.cos(turn), r * np.sin(turn), math.pi * (a * a - b * b)
    points = np.array(centre) + p[..., None] * frame[0] + q[..., None] * frame[1]
    r = np.linalg.norm(points, axis=-1)
    return float(np.mean(np.abs(points @ frame[2]) / r**3) * area)


@pytest.mark.parametrize("case", CASES)
def test_directions_meet_the_target_with_their_density(case):
    shape, a, b, centre, frame = CASES[case]
    seen, way, own, again, behind = drawn(row(shape, centre, frame, a, b), (0.0, 0.0, 0.0))
    assert seen.all()
    assert np.abs(np.linalg.norm(way, axis=1) - 1.0).max() < 1e-15
    # what is drawn and what is found for a direction agree, to its rounding over the target's size
    rounding = 1e-15 * np.linalg.norm(centre) / a
    assert again == pytest.approx(own, rel=1e-12 + 64.0 * rounding)
    assert not behind.any()
    # the mean of the density's reciprocal is the solid angle, by the midpoint rule
    assert np.mean(1.0 / own) == pytest.approx(solid_angle(shape, a, b, centre, frame), rel=3e-3)


def test_a_place_that_cannot_see_a_target_has_no_part_of_it():
    ball, plate = row(BALL, (0, 0, 1), FLAT, 0.5, 0.0), row(SQUARE, (0, 0, 1), FLAT, 0.3, 0.3)
    front, back = (row(SQUARE, (0, 0, 1), FLAT, 0.3, 0.3, side) for side in (1, -1))
    up, down = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
    for target, place, normal, sees in (
        (ball, (0, 0, 0), up, True),
        (ball, (0, 0, 0.7), up, False),  # inside
        (ball, (0, 0, 0.5), up, False),  # on it
        (ball, (0, 0, 1.0), up, False),  # in its middle
        (ball, (0, 0, 0), down, False),  # below the horizon
        (ball, (0, 0, 1.2), down, False),
        (plate, (0, 0, 0), up, True),
        (plate, (0, 0, 0), down, False),
        (plate, (2.0, 0, 1), up, False),  # in its plane
        (plate, (2.0, 0, 1 - 1e-14), up, False),
        (front, (0, 0, 0), up, False),  # its normal points away
        (front, (0, 0, 2), down, True),
        (back, (0, 0, 0), up, True),
        (back, (0, 0, 2), down, False),
    ):
        seen = drawn(target, place, normal, n=2)[0]
        assert seen.all() if sees else not seen.any(), (place, normal)


# -- what it does to a scene -----------------------------------------------------------------------


def balance(found):
    return found.amount(found.compiled.layout.row("importance.balance"))


GLOSSY = {"surface": {"kind": "mixed", "specular": 0.3, "diffuse": 0.5}}


def test_every_batch_closes_and_the_target_is_met_more_often():
    found = trace(room(), batches=3, rays_per_batch=1024, generation_cap=6)
    assert found.closures() == [0] * 3
    assert balance(found) != 0
    plain = trace(room(()), batches=3, rays_per_batch=1024, generation_cap=6)
    assert found.detector("target").count > 4 * plain.detector("target").count


@pytest.mark.parametrize("splitting", [True, False], ids=["both", "one"])
def test_of_two_children_the_drawn_one_is_sent(splitting):
    run = {"generation_cap": 6, "roulette_floor": 0.05, "splitting": splitting}
    found = trace(room(surface=GLOSSY), batches=2, rays_per_batch=1024, **run)
    assert max(map(abs, found.closures())) <= 1e-15
    assert balance(found) != 0
    # it is a part in 2400 of the walls
    assert found.detector("target").count > 0.1 * 2048


def test_lanes_and_tree_change_no_bit():
    scene = room(("target", "element 3"), weights=[3.0, 1.0], fraction=0.7)
    plain = trace(scene, rays_per_batch=1024)
    tree = trace(
        scene, rays_per_batch=1024, force=frozenset({"acceleration"}), plan=PLAN.with_(lanes=1)
    )
    assert tree.digest == plain.digest


@pytest.mark.slow  # each a program
@pytest.mark.parametrize("lanes", [1, 8])
def test_no_width_changes_a_bit(lanes):
    scene = room(("target", "element 3"), weights=[3.0, 1.0], fraction=0.7)
    found = trace(scene, rays_per_batch=1024, plan=PLAN.with_(lanes=lanes))
    assert found.digest == trace(scene, rays_per_batch=1024).digest


@pytest.mark.slow
@pytest.mark.parametrize("composition", ["whole-path", "classical"])
def test_no_composition_changes_a_bit(composition):
    scene = room(("target", "element 3"), weights=[3.0, 1.0], fraction=0.7)
    plan = PLAN.with_(lanes=1)
    plain = trace(scene, rays_per_batch=256, plan=plan)
    other = trace(scene, rays_per_batch=256, plan=plan.with_(composition=composition))
    assert other.digest == plain.digest


def test_what_is_off_is_not_compiled():
    plain = room(())
    none = replace(plain, importance=pz.Importance(toward=["target"], fraction=0.0))
    text = program_source(compiled(plain).tables.spec.for_device(4, ("wave",)))
    assert program_source(compiled(none).tables.spec.for_device(4, ("wave",))) == text
    assert "toward" not in text
    assert "density" not in text
    assert trace(none, rays_per_batch=256).digest == trace(plain, rays_per_batch=256).digest
    assert "importance" in compiled(room()).effects
    black = scene_of([LAMP], cube(BLACK), importance={"toward": ["element 0"]})
    assert "importance" not in compiled(black).effects
    assert any("no surface" in advice for advice in pz.advisories(black))


@pytest.mark.parametrize(
    ("flux", "floor"),
    [
        ((1.0,), 0.0),
        ((1.0, 1e-3), 1.0),
        pytest.param((1.0,), 1.0, marks=pytest.mark.slow),
        pytest.param((1.0, 1e-3), 0.0, marks=pytest.mark.slow),
    ],
)
def test_no_ray_is_ever_twice_as_heavy_as_it_was_launched(flux, floor):
    aiming.weights_are_bounded(flux, floor)


def test_splits_roulette_and_several_targets_close():
    aiming.busy_room_closes()


def test_towards_all_that_a_beam_can_meet_every_ray_arrives():
    """Half a room that is all target: what is sent there has its exact share of the cosine lobe."""
    floor = {**wall((0, 0, 0), "+z", 100.0), **matt(1.0)}
    dome = {
        "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 50.0, "name": "dome",
        "surface": {"kind": "absorber"}, "detector": {"side": "inside"},
    }  # fmt: skip
    scene = scene_of([beam((0, 0, 1), "-z")], [floor, dome], importance={"toward": ["dome"]})
    found = trace(scene, rays_per_batch=512)
    # every place lies inside the ball: its share goes to the surface
    assert balance(found) == 0
    assert found.detector("dome").power == 512


def test_a_ray_into_the_surface_ends_and_is_booked():
    """A target that stands half below the horizon."""
    plate = {**wall((0, 0, 0), "+z", 1.0), **matt(1.0), "name": "plate"}
    ball = {"kind": "sphere", "position": [3.0, 0, 0], "axis": "+z", "radius": 0.5, "name": "ball"}
    scene = scene_of(
        [beam((0, 0, 1), "-z")], [plate, {**ball, **BLACK}], importance={"toward": ["ball"]}
    )
    found = trace(scene, rays_per_batch=4096)
    assert found.closures() == [0]
    # half are sent towards the ball, half of those below the plate: they end with what they weigh
    paths = pz.paths(scene, rays=1024)
    going = int((paths.generation == 1).sum())
    assert abs(going - 768) < 5 * math.sqrt(1024 * 3 / 16)
    assert found.absorbed("plate") == 0


def test_roulette_does_not_play_for_what_is_light_because_it_was_aimed():
    aiming.roulette_spares_what_is_aimed()


@pytest.mark.parametrize(
    "gate", [aiming.disk_over_a_plate, aiming.ball_over_a_plate, aiming.far_tiny_disk]
)
def test_a_target_over_a_plate_gets_its_share(gate):
    gate()


# -- precision -------------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", ["fp32", pytest.param("mixed", marks=pytest.mark.slow)])
def test_other_precisions_close_and_agree(precision):
    scene = room()
    full = trace(scene, batches=2, rays_per_batch=2048).detector("target").power
    found = trace(scene, batches=2, rays_per_batch=2048, precision=precision)
    assert max(map(abs, found.closures())) <= 1e-5
    assert float(found.detector("target").power) == pytest.approx(float(full), rel=1e-3)
