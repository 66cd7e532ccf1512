"""Path tables: against closed forms, a second route, and the detector's own integers."""

from __future__ import annotations

import json
import math
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, open_device
from oracles.scenes import everything, glass, mirror

import photizon_cl as pz
from hostcode.run import keyed, trails
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result import keyed_sums
from photizon_cl.result.statistics import complete

pytestmark = pytest.mark.usefixtures("one_lane")

BLACK = {"surface": {"kind": "absorber"}}
SENSOR = {
    "name": "sensor", "kind": "rectangle", "position": [0, 0, 1], "axis": "-z",
    "half_width": 1.0, "half_height": 1.0, **BLACK, "detector": {"paths": 200},
}  # fmt: skip


def sheet(name, z, axis, index):
    return {
        "name": name, "kind": "disk", "position": [0, 0, z], "axis": axis, "radius": 0.5,
        "surface": {"kind": "fresnel", "index": index},
    }  # fmt: skip


def pile(plates, *, index=1.5, paths=200, cap=12, rays=64):
    """Return plane plates in a collimated beam at normal incidence, before a sensor."""
    elements = []
    for n in range(plates):
        elements += [
            sheet(f"in {n}", 0.1 * n, "-z", index), sheet(f"out {n}", 0.1 * n + 0.05, "+z", index)
        ]  # fmt: skip
    return {
        "schema": "photizon/1", "name": "pile",
        "run": {"rays_per_batch": rays, "generation_cap": cap, "roulette_floor": 0.0},
        "source": [{
            "name": "beam", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -1],
            "axis": "+z", "radius": 0.1,
        }],
        "element": [*elements, {**SENSOR, "detector": {"paths": paths}}],
    }  # fmt: skip


@cache
def plates(n):
    return pz.trace(pile(n), batches=2)


@pytest.mark.parametrize("n", [1, 3])
def test_every_path_of_a_pile_of_plates_is_its_product_of_r_and_t(n):
    table = plates(n).detectors["sensor"].paths
    r = (0.5 / 2.5) ** 2
    assert len(table) > 2
    for row in table:
        expected = r ** row.events.count("r") * (1.0 - r) ** row.events.count("t")
        assert row.power == pytest.approx(expected, rel=1e-12)
        assert row.interactions == len(row.steps) == len(row.events)
        assert row.ghost_order == row.events.count("r")
        assert row.count == 128
        assert row.sigma == pytest.approx(0.0, abs=1e-15)


def test_a_plate_has_every_order_of_its_ghosts_once():
    table = plates(1).detectors["sensor"].paths
    events = [row.events for row in table]
    assert events == [f"t{'r' * k}t" for k in range(0, 9, 2)]
    assert (
        table[1].sequence
        == '"in 0".face t > "out 0".face r > "in 0".face r > "out 0".face t > sensor'
    )


def test_two_hundred_and_ten_ghosts_of_21_surfaces():
    # ten plates and one more face: C(21, 2) pairs, each met first at the later face
    scene = pile(10, index=1.05, paths=5000, cap=64, rays=2)
    scene["run"]["roulette_floor"] = 1e-9
    scene["element"].insert(20, sheet("last", 0.99, "-z", 1.05))
    ghosts = pz.trace(scene, batches=2).detectors["sensor"].paths.ghosts()
    assert len(ghosts.faces) == 21
    assert len(ghosts.pairs()) == 210
    assert (np.triu(ghosts.count) == 0).all()  # the first reflection is at the later face
    r = (0.05 / 2.05) ** 2
    # between two reflections all faces in between are passed two more times
    for a, b in zip(*np.nonzero(ghosts.count), strict=True):
        passed = 21 - 2 + 2 * (a - b - 1) + 2
        assert ghosts.power[a, b] == pytest.approx(r**2 * (1 - r) ** passed, rel=1e-11)


def by_second_route(scene, rays):
    """Return power and arrivals by sequence of elements, from the segments of every ray."""
    found = defaultdict(lambda: [0, 0])
    paths = pz.paths(scene, rays=rays, max_segments=20_000)
    assert not len(paths.cut)
    names = [element.name for element in paths.scene.element]
    for n in np.flatnonzero(paths.ending == 1):  # absorbed
        sequence, at = [], n
        while at >= 0:
            sequence.append(names[paths.element[at]])
            at = paths.parent[at]
        key = tuple(reversed(sequence))
        found[key][0] += paths.weight[n]
        found[key][1] += 1
    return {key: (weight * paths.unit_power, n) for key, (weight, n) in found.items()}


def test_powers_and_counts_are_those_of_the_segments_that_paths_follows():
    scene = {
        "schema": "photizon/1", "name": "lens",
        "run": {"generation_cap": 7, "rays_per_batch": 256, "roulette_floor": 0.0},
        "source": [{
            "name": "sun", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -1],
            "axis": "+z", "radius": 0.2,
        }],
        "element": [
            sheet("in", 0.0, "-z", 1.5), sheet("out", 0.05, "+z", 1.5),
            {
                "name": "ball", "kind": "sphere", "position": [0, 0, 0.4], "radius": 0.25,
                "axis": "+z", "surface": {"kind": "fresnel", "index": 1.6},
            },
            {
                "name": "white", "kind": "rectangle", "position": [0, 0, -1.5], "axis": "+z",
                "half_width": 1.0, "half_height": 1.0,
                "surface": {"kind": "mixed", "specular": 0.3, "diffuse": 0.4},
            },
            SENSOR,
        ],
    }  # fmt: skip
    expected = by_second_route(scene, 256)
    table = pz.trace(scene, batches=1).detectors["sensor"].paths
    found = defaultdict(lambda: [0.0, 0])
    for row in table:
        key = (*(step.element for step in row.steps), "sensor")
        found[key][0] += row.power
        found[key][1] += row.count
    wanted = {key: value for key, value in expected.items() if key[-1] == "sensor"}
    assert table.rest.count == 0
    assert found.keys() == wanted.keys()
    for key, (power, count) in wanted.items():
        assert found[key][1] == count
        assert found[key][0] == pytest.approx(power, rel=1e-12)


def test_letters():
    # a slab lit at 60 degrees from inside reflects totally; a mirror and a white wall follow
    letters = set()
    scene = {
        "schema": "photizon/1", "name": "letters", "run": {"rays_per_batch": 1024},
        "source": [{
            "name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.02],
        }],
        "element": [
            {
                "name": "glass", "kind": "plano-convex", "position": [0, 0, 0], "axis": "+z",
                "curvature_radius": 0.1, "aperture_radius": 0.1, **glass(1.5),
            },
            {
                "name": "white", "kind": "rectangle", "position": [0, 0, 0.5], "axis": "-z",
                "half_width": 1.0, "half_height": 1.0,
                "surface": {"kind": "lambertian", "reflectance": 0.5},
            },
            {
                "name": "shiny", "kind": "rectangle", "position": [0.5, 0, 0], "axis": "-x",
                "half_width": 1.0, "half_height": 1.0, **mirror(0.9),
            },
            {**SENSOR, "position": [0, 0, -0.5], "axis": "+z", "detector": {"paths": 500}},
        ],
    }  # fmt: skip
    table = pz.trace(scene, batches=2).detectors["sensor"].paths
    for row in table:
        for step in row.steps:
            letters.add((step.element, step.event))
            assert step.refracting == (step.element == "glass")
    assert letters == {
        ("glass", "t"), ("glass", "r"), ("glass", "i"), ("white", "s"), ("shiny", "r"),
    }  # fmt: skip
    turned = [row for row in table if [s.element for s in row.steps if s.event == "r"] == ["shiny"]]
    assert turned
    assert all(row.ghost_order == 0 for row in turned)  # a mirror's reflection is no ghost's


def test_choosing_one_child_tells_which_one():
    scene = pile(2)
    scene["run"] |= {"splitting": False, "rays_per_batch": 4096}
    table = pz.trace(scene, batches=4).detectors["sensor"].paths
    both = {row.sequence: row.power for row in plates(2).detectors["sensor"].paths}
    for row in table[:4]:
        assert abs(row.power - both[row.sequence]) < 5 * max(row.sigma, 1e-12)
    assert {row.events for row in table} <= {
        key.events for key in plates(2).detectors["sensor"].paths
    }


# -- exactness -----------------------------------------------------------------------------------


def with_tables(scene, paths=100):
    made = json.loads(json.dumps(scene))
    for element in made["element"]:
        if "detector" in element:
            element["detector"]["paths"] = paths
    return made


@pytest.mark.parametrize(
    "name",
    [
        "box-room",
        "ghost-ladder",
        pytest.param("plano-convex-condenser", marks=pytest.mark.slow),
        pytest.param("cassegrain", marks=pytest.mark.slow),
        pytest.param("cpc-concentrator", marks=pytest.mark.slow),
        pytest.param("integrating-sphere", marks=pytest.mark.slow),
        "everything",
    ],
)
def test_rows_sum_to_the_detectors_integers_in_every_batch_and_change_none_of_them(name):
    scene = everything() if name == "everything" else pz.load(name).to_dict()
    off = compiled(pz.load(scene), rays_per_batch=512)
    on = compiled(pz.load(with_tables(scene)), rays_per_batch=512)
    device = open_device()
    without = list(Engine(device, off.tables, PLAN).run(0, 3))
    for plain, batch in zip(without, Engine(device, on.tables, PLAN).run(0, 3), strict=True):
        assert (plain.cells == batch.cells).all()
        cells = complete(on.layout, batch.cells)
        for number, d in enumerate(on.layout.detectors):
            mine = batch.keyed.rows[batch.keyed.about >> 32 == number]
            total = sum((int(a) << 64) + (int(b) << 32) + int(c) for a, b, c, _ in mine)
            power = cells[d.power]
            assert total == (int(power[0]) << 64) + (int(power[1]) << 32) + int(power[2])
            assert mine[:, 3].sum() == power[3]


def test_rows_and_rest_are_the_power_to_the_last_bit():
    result = plates(3)
    for kept in (1, 3, 1000):
        scene = pile(3, paths=kept)
        table = pz.trace(scene, batches=2).detectors["sensor"].paths
        whole = result.detectors["sensor"].paths
        assert len(table) == min(kept, len(whole))
        assert table.exact + table.rest.exact == whole.exact + whole.rest.exact
        assert table.rest.count == sum(row.count for row in whole[kept:])
        assert table.rest.paths == len(whole) - len(table)


def keyed_digest(scene, plan, batches=3):
    c = compile_scene(scene, scene.run)
    out = []
    for batch in Engine(open_device(), c.tables, plan).run(0, batches):
        out += [array.tobytes() for array in batch.keyed.arrays]
    return b"".join(out)


def test_the_same_table_however_it_is_computed(monkeypatch):
    scene = pz.load(with_tables(pile(3, rays=700)))
    expected = keyed_digest(scene, PLAN)
    for plan in (
        PLAN.with_(lanes=1, items=3),
        PLAN.with_(composition="classical"),
        PLAN.with_(composition="whole-path", lanes=1),
        PLAN.with_(tally_copies=0, tally_parts=3, wave_rays=1 << 10),
    ):
        assert keyed_digest(scene, plan) == expected
    monkeypatch.setattr(keyed, "FIRST_CAPACITY", 2)  # too small: it grows, and begins again
    monkeypatch.setattr(keyed.KeyedTable.size, "__defaults__", (2,))
    assert keyed_digest(scene, PLAN) == expected


def test_going_on_opening_and_sharing_give_the_same_table(tmp_path):
    scene = pile(3, paths=5)
    whole = pz.trace(scene, batches=6)
    pz.trace(scene, batches=2).save(tmp_path / "run", figures=False)
    opened = pz.open_result(tmp_path / "run").detectors["sensor"].paths
    assert list(opened) == list(pz.trace(scene, batches=2).detectors["sensor"].paths)
    resumed = pz.resume(tmp_path / "run", batches=6)
    with ThreadPoolExecutor(2) as pool:
        shared = pz.trace(scene, batches=6, executor=pool)
    for other in (resumed, shared):
        assert other.tally_digest == whole.tally_digest
        table, own = other.detectors["sensor"].paths, whole.detectors["sensor"].paths
        assert list(table) == list(own)
        assert table.rest == own.rest


def test_paths_that_find_no_room_are_in_the_rest(monkeypatch):
    monkeypatch.setattr(keyed_sums, "LEAST_ADMITTED", 4)
    scene = pile(3, paths=1)
    table = pz.trace(scene, batches=2).detectors["sensor"].paths
    assert not table.complete
    whole = plates(3).detectors["sensor"].paths
    assert whole.complete
    assert [row.sequence for row in table] == [row.sequence for row in whole[:1]]
    assert table.exact + table.rest.exact == whole.exact


def test_a_bright_detector_takes_no_place_from_a_dark_one(monkeypatch):
    monkeypatch.setattr(keyed_sums, "LEAST_ADMITTED", 8)
    scene = pile(2, paths=1)
    scene["element"].append({
        "name": "dark", "kind": "rectangle", "position": [0, 0, -2], "axis": "+z",
        "half_width": 1.0, "half_height": 1.0, **BLACK, "detector": {"paths": 1},
    })  # fmt: skip
    result = pz.trace(scene, batches=2)
    for name in ("sensor", "dark"):
        table = result.detectors[name].paths
        assert len(table) == 1
        assert table[0].sequence.endswith(f"> {name}")


def test_each_detector_has_its_own_share_of_what_is_admitted():
    keys = np.array([1, 2, 3, 4, 9])
    about = np.array([0, 0, 0, 0, 1], np.int64) << 32
    rows = np.array([[p, 0, 0, 1] for p in (50, 80, 70, 60, 1)], np.int64)
    sums = keyed_sums.KeyedSums({0: 2, 1: 2})
    sums.add(keyed.KeyedRows(keys, about, np.zeros(5, np.int64), rows), 1)
    assert sums.keys.tolist() == [2, 3, 9]
    assert (sums.full(0), sums.full(1)) == (True, False)


def test_going_on_keeps_the_words_of_rows_that_stay_and_follows_new_ones():
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    scene = with_tables(scene, 40)
    first = pz.trace(scene, batches=1)
    further, whole = first.refine(batches=4), pz.trace(scene, batches=4)
    new = 0
    for name, detector in whole.detectors.items():
        own, before = further.detectors[name].paths, first.detectors[name].paths
        assert list(own) == list(detector.paths)
        assert all(row.known for row in own)
        new += len({row.sequence for row in own} - {row.sequence for row in before})
    assert new


def test_words_that_were_missed_are_followed_when_the_run_is_resumed(tmp_path, monkeypatch):
    scene = pile(2)
    whole = pz.trace(scene, batches=2)
    with monkeypatch.context() as broken:
        broken.setattr("photizon_cl.run.trails.follow_trails", lambda *_: [None] * len(_[2]))
        silent = pz.trace(scene, batches=2)
    table = silent.detectors["sensor"].paths
    assert all(not row.known and row.ghost_order is None for row in table)
    assert len(table.filter(ghost_order=0)) == len(table.filter(avoiding="in 0")) == 0
    assert [g.label for g in table.grouped()] == ["(its example ray was not followed)"]
    assert json.loads(json.dumps(silent.summary()))["detectors"]["sensor"]["paths"]["rows"]
    silent.save(tmp_path / "run", figures=False)
    again = pz.resume(tmp_path / "run")
    assert list(again.detectors["sensor"].paths) == list(whole.detectors["sensor"].paths)
    further = again.refine(batches=3)
    assert all(row.known for row in further.detectors["sensor"].paths)


def test_following_ends_in_time_and_keeps_what_it_has(monkeypatch):
    told = iter([False, True, True, True])
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    monkeypatch.setattr("hostcode.run.trails._AT_ONCE", 4)
    real = trails.follow_trails

    def hasty(device, tables, keys, rays, interactions, over):
        return real(device, tables, keys, rays, interactions, lambda: next(told))

    monkeypatch.setattr("photizon_cl.run.trails.follow_trails", hasty)
    result = pz.trace(with_tables(scene, 40), batches=2)
    table = next(d.paths for d in result.detectors.values() if d.power.value)
    known = sum(row.known for row in table)
    assert 0 < known < len(table)


def test_with_many_batches_in_flight_a_large_table_takes_fewer_of_them(monkeypatch):
    scene = pz.load(with_tables(pile(3, rays=256)))
    plan = PLAN.with_(wave_rays=1 << 12)
    expected = keyed_digest(scene, plan, 20)
    monkeypatch.setattr(keyed, "FIRST_CAPACITY", 2)
    monkeypatch.setattr(keyed.KeyedTable.size, "__defaults__", (2,))
    monkeypatch.setattr(keyed, "_MOST_BYTES", 1 << 15)
    assert keyed_digest(scene, plan, 20) == expected


def test_sums_by_key_admit_the_strongest_first_and_keep_what_they_have():
    def batch(**powers):
        keys = sorted(int(k[1:]) for k in powers)
        n = len(keys)
        rows = np.array([[powers[f"k{k}"], 0, 0, 1] for k in keys], np.int64)
        return keyed.KeyedRows(
            np.array(keys), np.zeros(n, np.int64), np.arange(n, dtype=np.int64), rows
        )

    sums = keyed_sums.KeyedSums({0: 2})
    sums.add(batch(k1=5, k2=7, k3=6), 1)
    sums.add(batch(k1=9, k2=1), 2)
    assert sums.keys.tolist() == [2, 3]
    assert [sums.exact(0), sums.exact(1)] == [8 << 64, 6 << 64]
    assert sums.full(0)
    mean = np.array([4.0, 3.0]) * 2.0**-31
    np.testing.assert_array_equal(sums.mean, mean)
    np.testing.assert_array_equal(sums.m2, np.array([18.0, 18.0]) * 2.0**-62)
    again = keyed_sums.KeyedSums.restore({0: 2}, sums.state(), 2)
    again.add(batch(k3=4), 3)
    sums.add(batch(k3=4), 3)
    assert (again.m2 == sums.m2).all()
    assert (again.table() == sums.table()).all()


# -- errors of groups ----------------------------------------------------------------------------


def test_sigma_of_groups_and_of_the_rest_follow_from_their_batches():
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    result = pz.trace(with_tables(scene, 8), batches=8)
    name, detector = next((n, d) for n, d in result.detectors.items() if d.power.value)
    table = detector.paths
    values = result.batch_values(f"detectors.{name}.power")
    sums = result.tally.keyed
    rows = sums.table()[:, table._columns] * result.compiled.unit_power
    n = len(values)
    rest = (values - rows.sum(axis=1)).std(ddof=1) / math.sqrt(n)
    assert table.rest.sigma == pytest.approx(rest, rel=1e-6)
    assert table.sigma == pytest.approx(rows.sum(axis=1).std(ddof=1) / math.sqrt(n), rel=1e-9)
    for row, column in zip(table, rows.T, strict=True):
        assert row.sigma == pytest.approx(column.std(ddof=1) / math.sqrt(n), rel=1e-9)
    assert math.isclose(table.power + table.rest.power, detector.power.value, rel_tol=1e-12)


def test_without_values_of_batches_a_sum_has_an_upper_bound(monkeypatch):
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    exact = pz.trace(with_tables(scene, 30), batches=6)
    name = next(n for n, d in exact.detectors.items() if d.power.value)
    monkeypatch.setattr(keyed_sums, "FOLLOWED", 3)
    bounded = pz.trace(with_tables(scene, 30), batches=6).detectors[name].paths
    table = exact.detectors[name].paths
    assert [row.power for row in bounded] == [row.power for row in table]
    assert bounded.sigma >= table.sigma
    assert bounded.rest.sigma >= table.rest.sigma
    assert bounded.sigma <= sum(row.sigma for row in table)


# -- what a person does with it --------------------------------------------------------------------


def test_filters_groups_and_ghosts():
    table = plates(2).detectors["sensor"].paths
    via = table.filter(via=["in 1", "out 0"], ghost_order=2)
    for row in via:
        assert {"in 1", "out 0"} <= {step.element for step in row.steps}
        assert row.ghost_order == 2
    assert len(via) == sum(
        row.ghost_order == 2 and {"in 1", "out 0"} <= {s.element for s in row.steps}
        for row in table
    )
    assert via.exact + via.rest.exact == table.exact + table.rest.exact
    at = table.filter(via='"out 0".face r')
    assert at
    assert all(("out 0", "r") in [(s.element, s.event) for s in row.steps] for row in at)
    gone = table.filter(avoiding="out 0 r")
    assert len(gone) + len(table.filter(via="out 0 r")) == len(table)
    groups = table.grouped()
    assert sum(len(group.rows) for group in groups) == len(table)
    assert [g.power for g in groups] == sorted((g.power for g in groups), reverse=True)
    assert {g.label for g in table.grouped("ghost_order")} == {str(r.ghost_order) for r in table}
    ghosts = table.ghosts()
    assert len(ghosts.pairs()) == 6
    both = sum(row.power for row in table if row.ghost_order == 2)
    assert ghosts.power.sum() == pytest.approx(both, rel=1e-12)
    with pytest.raises(pz.PhotizonError, match="in 0"):
        table.filter(via="in O")
    with pytest.raises(pz.PhotizonError, match="event"):
        table.filter(event="x")
    with pytest.raises(pz.PhotizonError, match="ghost_order"):
        table.grouped("ghosts")


def test_the_example_ray_shows_the_path():
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 6}
    result = pz.trace(with_tables(scene, 12), batches=3)
    name, table = next((n, d.paths) for n, d in result.detectors.items() if d.power.value)
    for row in table[:6]:
        followed = pz.paths(result.scene, ray_numbers=[row.example_ray], ending_on=name)
        met = [
            tuple(result.scene.element[e].name for e in line.element)
            for line in followed
            if line.ending == "absorbed"
        ]
        assert (*(step.element for step in row.steps), name) in met
        assert set(followed.ray.tolist()) == {row.example_ray}


def test_only_what_leads_to_an_arrival_by_way_of_a_face_is_kept():
    scene = pile(2)
    numbers = range(4)
    every = pz.paths(scene, ray_numbers=numbers)
    names = [element.name for element in every.scene.element]
    wanted = set()
    for n in np.flatnonzero((every.element == names.index("sensor")) & (every.ending == 1)):
        chain, at = [], int(n)
        while at >= 0:
            chain.append(at)
            at = int(every.parent[at])
        if any(every.element[k] == names.index("out 0") for k in chain):
            wanted.update(chain)
    found = pz.paths(scene, ray_numbers=numbers, ending_on="sensor", via="out 0")
    assert 0 < len(found) == len(wanted) < len(every)
    kept = sorted(wanted)
    assert (found.start == every.start[kept]).all()
    assert (found.end == every.end[kept]).all()
    assert (found.ray == every.ray[kept]).all()
    assert found.ledger == {}


def test_a_detector_that_light_passes_has_the_paths_to_it():
    scene = pile(1, paths=50)
    scene["element"].append({
        "name": "counter", "kind": "disk", "position": [0, 0, 0.5], "axis": "-z", "radius": 0.4,
        "surface": {"kind": "clear"}, "detector": {"paths": 50},
    })  # fmt: skip
    result = pz.trace(scene, batches=2)
    there, behind = (result.detectors[n].paths for n in ("counter", "sensor"))
    assert [row.power for row in there] == [row.power for row in behind]
    assert [row.events for row in there] == [row.events for row in behind]
    assert there[0].sequence.endswith("> counter")


def test_a_tube_names_its_wall_and_baffles_once():
    scene = {
        "schema": "photizon/1", "name": "tube",
        "run": {"rays_per_batch": 4096, "generation_cap": 3},
        "source": [{
            "name": "lamp", "kind": "cosine-point", "flux": 1.0, "position": [0, 0, -0.1],
            "axis": "+z",
        }],
        "element": [
            {
                "name": "tube", "kind": "baffled-tube", "position": [0, 0, 0], "axis": "+z",
                "half_width": 0.3, "length": 0.8, "baffles": 2, "clear_half_width": 0.2,
                "surface": {"kind": "lambertian", "reflectance": 0.5},
            },
            SENSOR,
        ],
    }  # fmt: skip
    table = pz.trace(scene, batches=2).detectors["sensor"].paths
    places = {str(step) for row in table for step in row.steps}
    assert places == {"tube.wall s", 'tube."baffle 1" s', 'tube."baffle 2" s'}
    once = [row for row in table if row.events == "s"]
    assert len(once) == len({row.sequence for row in once})
    assert len(table) == len({row.sequence for row in table})


@pytest.mark.parametrize("precision", ["mixed", "fp32"])
def test_other_precisions_have_paths_too(precision):
    table = pz.trace(pile(1), batches=2, precision=precision).detectors["sensor"].paths
    own = plates(1).detectors["sensor"].paths
    assert [row.sequence for row in table] == [row.sequence for row in own]
    for row, exact in zip(table, own, strict=True):
        assert row.power == pytest.approx(exact.power, rel=1e-5)


def test_refusals(tmp_path, capsys):
    scene = pile(1, paths=0)
    with pytest.raises(pz.SceneError, match=r"detector\.paths"):
        pz.load(scene)
    scene["element"][-1]["detector"] = {}
    pz.trace(scene, batches=2).save(tmp_path / "none", figures=False)
    from photizon_cl.cli.main import main

    assert main(["paths", str(tmp_path / "none")]) == 2
    assert "path table" in capsys.readouterr().err
    plates(1).save(tmp_path / "run", figures=False)
    assert main(["paths", str(tmp_path / "run"), "--top", "2"]) == 0
    out = capsys.readouterr().out
    assert '"in 0".face t > "out 0".face t > sensor' in out
    assert main(["paths", str(tmp_path / "run"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["sensor"]["rows"]
    assert [row["ghost_order"] for row in rows] == [0, 2, 4, 6, 8]
    for wrong in (["--detector", "x"], ["--via", "x"], ["--top", "0"], ["--ghosts", "-1"]):
        assert main(["paths", str(tmp_path / "run"), *wrong]) == 2
        assert "Traceback" not in capsys.readouterr().err
