"""What a pilot says, of all numbers that it can have and of all that a file may hold."""

from __future__ import annotations

import itertools
import json
import random
from dataclasses import replace

import pytest

import photizon_cl as pz
from photizon_cl.result.file import read_file, write_state
from photizon_cl.result.pilot import NEGLIGIBLE, UNTOLD, Pilot

GOOD = Pilot(512, 32, 3.0, 0.25, ((16, 0.5), (32, 0.25)))
PARTS = (0.0, 5e-324, 1e-9, NEGLIGIBLE, 2e-6, 1 / 512, 0.02, 0.5, 0.999, 1.0, 1.1)


def caps_of(cap, more):
    return [*([cap // 2] if cap > 1 else []), *(cap << k for k in range(more + 1))]


def told(pilot, rays=1024):
    """Return all that a pilot says; whatever it is, it says it."""
    return str(pilot), pilot.before(rays), pilot.remedy()


def made(cap, parts, rays=512):
    caps = caps_of(cap, len(parts))[: len(parts)]
    return Pilot(rays, cap, 3.0, 0.0, tuple(zip(caps, parts, strict=True)))


def test_light_that_all_ends_at_once_needs_the_cap_at_which_it_had():
    pilot = Pilot(512, 32, 32.0, 0.0, ((16, 1.0), (32, 1.0), (64, 0.0)))
    assert pilot.needed_cap == 64
    assert "raise generation_cap to 64, where all rays of the pilot had ended" in pilot.before(1024)
    absorbed = Pilot(512, 32, 32.0, 0.0, ((16, 1.0), (32, 1.0), (64, 1e-7)))
    assert 32 < absorbed.needed_cap <= 64


def test_a_slope_that_what_came_after_refutes_is_not_followed():
    """A slow loss would leave nearly all at a cap at which nothing is left."""
    assert made(32, (1.0, 0.999, 0.0)).needed_cap == 64
    assert made(32, (1.0, 0.9, 1e-7)).needed_cap <= 64
    # one ray of 512 that ends refutes nothing
    assert made(32, (0.05, 0.02, 0.0)).needed_cap > 150


def test_one_cap_alone_gives_no_slope():
    assert made(1, (0.5,)).remedy() == UNTOLD


def test_roulette_may_add_to_what_is_under_way():
    text = made(32, (0.5, 0.6, 0.61)).remedy()
    assert "a higher cap does not help" in text
    assert "nothing of that is lost from 16 interactions on" in text
    assert "from 32 interactions on" in made(32, (0.7, 0.6, 0.61)).remedy()


def test_every_pilot_says_something():
    """All sequences of parts that matter: with steps, plateaus, rises and ends."""
    for cap in (1, 2, 3, 32, 2**18):
        for n in range(1, 5 if cap == 32 else 4):
            if n < len(caps_of(cap, 0)):
                continue
            for parts in itertools.product(PARTS, repeat=n):
                pilot = made(cap, parts)
                _, before, remedy = told(pilot)
                assert bool(before) == (pilot.capped > NEGLIGIBLE)
                assert "inf" not in remedy
                assert "nan" not in remedy
                needed = pilot.needed_cap
                if before and needed is not None:
                    assert cap < needed < 2**20
                    assert f"{needed}" in remedy
                    ended = [m for m, part in pilot.left if m > cap and part == 0.0]
                    over = [m for m, part in pilot.left if m > cap and part <= NEGLIGIBLE]
                    # more than what left nothing only where the rays are too few to tell
                    assert ended == over or needed <= 1.1 * over[0] or pilot.left[-2][1] < 0.5
                assert Pilot.read(pilot.text(), cap) == pilot


def test_a_pilot_that_was_given_up_says_what_may_be():
    for left in ((), ((16, 0.5),)):
        pilot = Pilot(512, 32, 1e6, 0.0, left, complete=False)
        assert "had not ended" in pilot.before(1 << 20)
        assert pilot.remedy() == UNTOLD
        assert Pilot.read(pilot.text(), 32) == pilot


@pytest.mark.parametrize(
    "change",
    [
        {0: 0}, {0: 1.5}, {0: True}, {1: 2**20}, {2: -1.0}, {2: float("inf")}, {3: 1.5},
        {4: [[16, 2.0]]}, {4: [[32, 0.5], [16, 0.5]]}, {4: [[0, 0.5]]}, {4: 3}, {4: [[16]]},
        # not the caps that a pilot tries
        {4: []}, {4: [[16, 0.5]]}, {4: [[32, 0.5]]}, {4: [[8, 0.5], [32, 0.5]]},
        {4: [[16, 0.5], [32, 0.5], [96, 0.5]]}, {4: [[16, 1e300], [32, 0.5]]},
        {4: [[16, float("nan")], [32, 0.5]]},
        # not the scene's cap
        {1: 16}, {1: 64}, {1: 64, 4: [[32, 0.5], [64, 0.25]]},
        # complete and not, and neither
        {5: False}, {5: 1}, {5: None}, {4: [], 5: True},
    ],
)  # fmt: skip
def test_a_pilot_in_a_file_is_checked(change):
    assert Pilot.read(GOOD.text(), 32) == GOOD
    values = json.loads(GOOD.text())
    for place, value in change.items():
        values[place] = value
    with pytest.raises(ValueError, match="its pilot"):
        Pilot.read(json.dumps(values), 32)


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "{}", "[" * 2000, "x" * 5000, 7,
        "[512, 1, 1.0, 0.0, [[1, 0.5]], true]",
        "[512, 8, 1.0, 0.0, [[4, 0.1], [8, 0.2], [16, 0.0]], true]",
    ],
    ids=range(8),
)  # fmt: skip
def test_a_text_that_is_no_pilot_of_the_scene_is_refused(text):
    with pytest.raises(ValueError, match="its pilot"):
        Pilot.read(text, 32)


def test_whatever_a_file_holds_is_refused_or_said():
    """Made up at random around what a pilot writes; what is accepted has its sentences."""
    draw = random.Random(5)
    whole = [-1, 0, 1, 2, 8, 16, 32, 512, 2**20 - 1, 2**20, 2**70, True, None, "3", 1.5]
    parts = [*PARTS, 1e300, -1e-9, float("nan"), float("inf"), None, "0.5", True, [], 10**400]
    accepted = 0
    for _ in range(5000):
        cap = draw.choice([1, 2, 8, 32, 2**19, 2**20 - 1])
        caps = [min(m, 2**20 - 1) for m in caps_of(cap, 3)][: draw.randint(0, 5)]
        left = [[m, draw.choice(PARTS)] for m in caps]
        values = [512, cap, draw.choice((0.0, 3.0, 1e308)), 0.5, left, draw.random() < 0.8]
        if draw.random() < 0.5:
            values[draw.choice((0, 1, 5))] = draw.choice(whole)
        if draw.random() < 0.3:
            values[draw.choice((2, 3))] = draw.choice(parts)
        if left and draw.random() < 0.3:
            draw.choice(left)[draw.randint(0, 1)] = draw.choice([*whole, *parts])
        try:
            pilot = Pilot.read(json.dumps(values), cap)
        except ValueError:
            continue
        accepted += 1
        told(pilot, 2**24)
        assert pilot.cap == cap
    assert accepted > 500


def test_a_file_with_the_pilot_of_another_cap_is_refused(tmp_path):
    result = pz.trace("box-room", batches=1, rays_per_batch=64)
    cap = result.scene.run.generation_cap
    pilot = Pilot(512, cap, 1.0, 0.0, ((cap // 2, 1e-3), (cap, 1e-5)))
    file = tmp_path / "result.nc"

    def kept(found):
        info = replace(result.info, pilot=found)
        write_state(type(result)(result.compiled, result.tally, info), file)
        return read_file(file).info.pilot

    assert kept(pilot) == pilot
    with pytest.raises(pz.ResultError, match="its pilot has numbers that cannot be"):
        kept(Pilot(512, cap + 1, 1.0, 0.0, (((cap + 1) // 2, 1e-3), (cap + 1, 1e-5))))
