"""Path tables over batches: the detector's own integers, whatever computes and keeps them."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, open_device
from oracles.scenes import everything
from piles import BLACK, pile, plates, with_tables

import photizon_cl as pz
from hostcode.run import keyed, trails
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result import keyed_sums
from photizon_cl.result.statistics import complete

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("one_lane")


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
        frame = table.to_dataframe()
        assert math.fsum(frame["power"]) == pytest.approx(
            result.detectors["sensor"].power, rel=1e-15
        )
        assert frame["count"].sum() == result.detectors["sensor"].power.count
        assert len(frame) == len(table) + (table.rest.count > 0)
        if table.rest.count:
            last = frame.iloc[-1]
            assert (last["sequence"], last["sigma"]) == ("all other paths", table.rest.sigma)
            assert frame["example_ray"][0] == table[0].example_ray
            assert last[["interactions", "ghost_order", "example_ray"]].isna().all()
        direct = table.filter(interactions=table[0].interactions)
        assert len(direct.to_dataframe()) == len(direct)


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


def test_a_run_whose_strongest_paths_change_is_resumed_and_read_again(tmp_path):
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    scene = with_tables(scene, 6)
    pz.trace(scene, batches=1).save(tmp_path / "run", figures=False)
    for batches in (3, 5):
        pz.resume(tmp_path / "run", batches=batches)
        found, whole = pz.open_result(tmp_path / "run"), pz.trace(scene, batches=batches)
        assert found.tally_digest == whole.tally_digest
        for name, detector in whole.detectors.items():
            assert list(found.detectors[name].paths) == list(detector.paths)


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
