"""Layers that absorb against their answer, ray by ray: what each medium takes, at every setting."""

from __future__ import annotations

import math

import pytest
from oracles import media
from oracles.engine import PLAN, open_device, scene_of, trace
from oracles.scenes import BLACK, beam, wall

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


def test_a_slab_with_all_its_reflections():
    media.slab()


def test_a_bubble_in_glass_in_water():
    media.nested()


def test_wrong_media_are_counted_where_they_are_met():
    media.wrong()


def test_the_closed_form_of_a_slab():
    """R, T and A of a plate with absorption: R + T² R t² / (1 − R² t²) and so on."""
    layers = media.plate(1.5, 30.0)
    parts = media.stack(layers, [0.0, 0.01], -0.05, 0.05, rays_per_batch=64, generation_cap=60)
    found = media.rows_of(trace(scene_of(**parts)))
    part, kept = 0.04, math.exp(-0.3)
    through = (1 - part) ** 2 * kept / (1 - (part * kept) ** 2)
    back = part + through * part * kept
    assert found["plate"] == pytest.approx(through, abs=1e-12)
    assert found["escaped"] == pytest.approx(back, abs=1e-12)
    assert found["in glass"] == pytest.approx(1.0 - through - back, abs=1e-12)


@pytest.mark.parametrize("angle", [20.0, 55.0, 80.0])
def test_the_closed_form_of_a_slab_at_an_angle(angle):
    """R is that of one face at the angle, t of the way d / cos θ' in the glass."""
    index, alpha, depth = 1.5, 30.0, 0.01
    sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    inner = math.sqrt(1 - (sine / index) ** 2)
    rs = (cosine - index * inner) / (cosine + index * inner)
    rp = (index * cosine - inner) / (index * cosine + inner)
    part, kept = 0.5 * (rs * rs + rp * rp), math.exp(-alpha * depth / inner)
    through = (1 - part) ** 2 * kept / (1 - (part * kept) ** 2)
    back = part + through * part * kept
    surface = {"surface": {"kind": "fresnel", "medium": "glass"}}
    lamp = {**beam((0, 0, -0.02), "+z", 1e-9), "tilt_deg": [0.0, angle]}
    elements = [
        {**wall((0, 0, 0), "-z", media.HALF), **surface},
        {**wall((0, 0, depth), "+z", media.HALF), **surface},
        {**wall((0, 0, 0.05), "-z", media.HALF), **BLACK},
    ]
    glass = {"name": "glass", "index": index, "absorption_per_m": alpha}
    scene = scene_of([lamp], elements, medium=[glass])
    found = media.rows_of(trace(scene, rays_per_batch=64, generation_cap=60))
    assert found["element 2"] == pytest.approx(through, abs=1e-12)
    assert found["escaped"] == pytest.approx(back, abs=1e-12)


@pytest.mark.parametrize(
    "number", [*range(2), *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 12))]
)
def test_layers_at_random(number):
    """Every row, and every interaction, of stacks whose layers may absorb and have no end."""
    layers, planes, start, plate = media.random_stack(number)
    cap = 9
    parts = media.stack(layers, planes, start, plate, generation_cap=cap, rays_per_batch=16)
    found = trace(scene_of(**parts), batches=2)
    media.agrees(found, media.followed(layers, planes, start, cap, plate))
    assert not any(media.mismatches(found))


@pytest.mark.parametrize(
    "number", [4, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, 5, 6, 7))]
)
def test_the_reference_tracer_agrees(number):
    """Ray by ray, in scenes at random in which rays are in a wrong medium as often as not."""
    assert media.reference_agrees(number) or number == 6  # little of its light meets glass


WAYS = [
    {"plan": PLAN.with_(composition="classical", lanes=8)}, {"force": frozenset({"acceleration"})},
]  # fmt: skip
MORE = [
    {"plan": PLAN.with_(lanes=1)}, {"plan": PLAN.with_(lanes=8, refill=2)},
    {"plan": PLAN.with_(composition="classical")},
    {"plan": PLAN.with_(composition="whole-path", lanes=1)},
    {"force": frozenset({"tilt", "contact", "coincidence"})},
]  # fmt: skip


# each way is another program
@pytest.mark.parametrize(
    "origin", ["", pytest.param("more", marks=pytest.mark.slow), "debian", "pypi", "intel"]
)
def test_every_way_of_running_gives_the_same_bits(origin):
    """And one compute unit, and every runtime that there is."""
    layers, planes, start, plate = media.random_stack(3)
    parts = media.stack(layers, planes, start, plate, generation_cap=9, rays_per_batch=96)
    scene = scene_of(**parts)
    plain = trace(scene, batches=3)
    own = "" if origin == "more" else origin
    ways = {"": WAYS, "more": MORE}.get(origin) or [{"device": open_device(origin)}]
    for way in [*ways, {"device": open_device(own, 1)}]:
        assert trace(scene, batches=3, **way).digest == plain.digest, way


@pytest.mark.parametrize(("precision", "tolerance"), [("mixed", 2e-6), ("fp32", 4e-6)])
def test_in_single_precision(precision, tolerance):
    """Lengths are floats, so a loss is as good as they are; weights of doubles close exactly."""
    layers = media.plate(1.5, 25.0)
    parts = media.stack(layers, [0.0, 0.01], -0.02, 0.05, generation_cap=40, rays_per_batch=32)
    found = trace(scene_of(**parts), precision=precision)
    sums = media.followed(layers, [0.0, 0.01], -0.02, 40, 0.05)
    for name, part in media.rows_of(found).items():
        assert part == pytest.approx(sums[name], abs=tolerance), name
    limit = 1e-15 if precision == "mixed" else 64 * 2.0**-24
    assert all(abs(closure) <= limit for closure in found.closures())
