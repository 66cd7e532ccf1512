"""The ledger: closure, rows that agree with one another, countable scenes, the ghost ladder."""

from __future__ import annotations

from fractions import Fraction

import pytest
from oracles import gates
from oracles.engine import PLAN, scene_of, trace
from oracles.scenes import BLACK, beam, cube, everything, glass, matt, mirror, random_scene, wall

from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names

LIKE_OTHERS = ("cassegrain", "square-lightpipe")
"""Presets whose elements the baffled ones have as well, the telescope and the tube."""
BRIEFLY = ("absorbing-cuvette", "box-room", "ghost-ladder", "polariscope", "scattering-mirror")
"""One of each thing that makes a ledger's rows."""
every_preset = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in LIKE_OTHERS else ())
        for name in preset_names()
    ],
)


# a program a preset; tests/benchmarks compares the tallies of all with stored ones, which closed
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in BRIEFLY else pytest.mark.slow)
        for name in preset_names()
    ],
)
def test_every_preset_closes_in_every_batch(name: str) -> None:
    found = trace(name, batches=8, rays_per_batch=4096)
    gates.closes(found)
    flux = sum(source.flux for source in found.compiled.scene.source)
    watts = found.emitted * Fraction(found.compiled.unit_power) / 8
    assert abs(watts - Fraction(flux)) < Fraction(flux) * Fraction(1, 10**15)


@every_preset
def test_every_preset_closes_with_a_low_cap(name: str) -> None:
    gates.closes(trace(name, batches=4, rays_per_batch=2048, generation_cap=3))


# roulette is a program of its own; the box room's is in test_a_busy_room_closes
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name,
            marks=() if name in {"integrating-sphere", "ghost-ladder"} else pytest.mark.slow,
        )
        for name in preset_names()
    ],
)
def test_every_preset_closes_with_roulette(name: str) -> None:
    gates.closes(trace(name, batches=4, rays_per_batch=2048, roulette_floor=0.7))


@pytest.mark.parametrize("number", range(20, 30))
def test_scenes_of_everything_close(number: int) -> None:
    """Several sources with weights of their own, roulette, splitting, a cap of 9, far field."""
    scene = load(random_scene(number, alike=True))
    gates.closes(trace(scene, batches=3, rays_per_batch=1000, force=gates.ONE_PROGRAM))


def test_a_busy_room_closes() -> None:
    gates.busy_room_closes()


def test_closure_over_a_long_run_of_tiny_weights() -> None:
    """Weights down to the smallest numbers: what rounding takes is nowhere lost."""
    scene = scene_of([beam((0, 0, 0), "+z")], cube(mirror(0.5)))
    found = trace(scene, rays_per_batch=1024, generation_cap=1200)
    assert found.depth_capped == 0
    assert found.closures() == [0]
    # from 2^-96 on the weights have no image; the walls still sum to all of it
    rays = found.compiled.settings.rays_per_batch
    assert found.absorbed("element 4") + found.absorbed("element 5") == rays


@pytest.mark.parametrize("rays", [10**5, pytest.param(10**6, marks=pytest.mark.slow)])
def test_ghost_ladder_at_many_rays(rays: int) -> None:
    gates.ghost_ladder(rays)


def test_ghost_ladder_over_several_batches_and_roulette_off() -> None:
    found = trace("ghost-ladder", rays_per_batch=512, batches=5)
    assert len({cells.tobytes() for cells in found.batches}) == 1  # no noise at all
    total = found.detector("transmitted").power / found.emitted
    assert abs(total - Fraction(12, 13)) < Fraction(1, 10**14)


@pytest.mark.parametrize("cap", [1, 2, 7, 90])
def test_with_a_cap_of_c_exactly_c_interactions_are_made(cap: int) -> None:
    gates.generation_cap(cap)


def test_a_cap_of_splitting_rays() -> None:
    """A plate, cap 2: after two interactions everything is in the row, nothing arrives."""
    plate = [
        {**wall((0, 0, 0), "-z"), **glass(1.5)},
        {**wall((0, 0, 0.1), "+z"), **glass(1.5)},
        {**wall((0, 0, 1), "-z"), **BLACK},
    ]
    scene = scene_of([beam((0, 0, -1), "+z")], plate)
    found = trace(scene, rays_per_batch=16, generation_cap=2)
    # reflected at once: escapes with 0.04 after one interaction; both others end at the cap
    assert abs(found.escaped / 16 - Fraction("0.04")) < Fraction(1, 10**14)
    assert abs(found.depth_capped / 16 - Fraction("0.96")) < Fraction(1, 10**14)
    assert found.absorbed("element 2") == 0
    assert found.interactions == 32
    # an absorber met as interaction number cap still takes its light
    found = trace(scene, rays_per_batch=16, generation_cap=3)
    assert abs(found.absorbed("element 2") / 16 - Fraction("0.9216")) < Fraction(1, 10**14)


def test_a_periscope_has_countable_bounces() -> None:
    gates.periscope()


def test_detectors_are_one_sided() -> None:
    gates.one_sided_detectors()


def test_far_field_bins_by_direction() -> None:
    gates.far_field_bins()


def test_sums_do_not_depend_on_their_order() -> None:
    gates.order_does_not_matter()


def test_the_last_entry_of_a_ladder_collects_the_rest() -> None:
    """The same room with ladders of 1, 2, 5 and 64 entries."""
    ladders = {}
    for n in (1, 2, 5, 64):
        tables = load("box-room").to_dict()
        tables["element"][0]["detector"] = {"generations": n}
        found = trace(load(tables), rays_per_batch=1000, generation_cap=64)
        ladders[n] = found.detector("floor").ladder
        assert len(ladders[n]) == n
    for n in (1, 2, 5):
        assert ladders[n][:-1] == ladders[64][: n - 1]
        assert ladders[n][-1] == sum(ladders[64][n - 1 :])


def test_detector_never_shows_more_than_its_element_absorbs() -> None:
    found = trace(load(everything()), batches=2, rays_per_batch=2000, plan=PLAN)
    lit = 0
    for d in found.compiled.layout.detectors:
        name = found.compiled.scene.element[d.element].name
        assert found.detector(name).power <= found.absorbed(name)
        lit += found.absorbed(name) > 0
    assert lit >= 2


def test_a_scene_without_elements_lets_everything_out() -> None:
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0]}
    found = trace(scene_of([lamp], [], far_field={}), rays_per_batch=1000)
    assert found.escaped == found.emitted == sum(found.far_field) == 1000
    assert found.far_field_counts.sum() == 1000
    assert found.interactions == 0


@pytest.mark.parametrize("reflectance", [0.0, 1.0])
@pytest.mark.parametrize("surface", [mirror, matt])
def test_reflectances_at_their_ends(surface, reflectance: float) -> None:
    found = trace(scene_of([beam((0, 0, 0), "+z")], cube(surface(reflectance))), generation_cap=10)
    rays = found.compiled.settings.rays_per_batch
    if reflectance:
        assert found.depth_capped == rays
        assert found.interactions == 10 * rays
        assert sum(found.absorbed(f"element {n}") for n in range(6)) == 0
    else:
        assert found.absorbed("element 5") == rays
        assert found.interactions == rays


@pytest.mark.parametrize("floor", [0.3, 1.0])
def test_roulette_books_each_ray_it_ends_or_doubles(floor: float) -> None:
    """Weights 1, 1/2, 1/4 …: what is killed and boosted are whole numbers of those."""
    found = trace(
        scene_of([beam((0, 0, 0), "+z")], cube(mirror(0.5))),
        rays_per_batch=4096,
        generation_cap=40,
        roulette_floor=floor,
    )
    gates.closes(found)
    assert found.killed > 0
    assert found.boosted > 0
    # below the floor half of the rays end: each generation's survivors go on with double weight
    absorbed = found.absorbed("element 4") + found.absorbed("element 5")
    assert absorbed + found.killed - found.boosted + found.depth_capped == found.emitted
    # the balance is that of a fair coin: z below 5 (killed and boosted are nearly equal variances)
    lost = float(found.killed - found.boosted)
    assert abs(lost) < 5.0 * (2.0 * float(found.killed + found.boosted)) ** 0.5


def test_roulette_floor_is_relative_to_the_rays_own_weight() -> None:
    """A dim source's rays are not below the floor for being dim."""
    lamps = [beam((0, 0, 0.5), "-z"), {**beam((0.5, 0, 0.5), "-z"), "flux": 1e-6}]
    for n, lamp in enumerate(lamps):
        lamp["share"] = 1.0
        lamp["name"] = f"lamp {n}"
    target = [{**wall((0, 0, 0), "+z"), **glass(1.5)}, {**wall((0, 0, -1), "+z"), **BLACK}]
    # transmitted 0.96 is above a floor of 0.5 for both lamps; reflected 0.04 is below for both
    found = trace(scene_of(lamps, target), rays_per_batch=2000, roulette_floor=0.5)
    want = 1000 * (1 + Fraction(1e-6)) * Fraction("0.96")
    assert abs(found.absorbed("element 1") - want) < Fraction(1, 10**9)
