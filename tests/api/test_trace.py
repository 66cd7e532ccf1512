"""`trace` and its result: ledger, summary, refinement, limits, executors."""

from __future__ import annotations

import dataclasses
import json
import math
import multiprocessing
import re
import signal
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result.ledger import check_batch
from photizon_cl.result.stopping import LEAST_BATCHES, Goal
from photizon_cl.run.batches import _no_batch
from photizon_cl.run.progress import Clock
from photizon_cl.run.task import run_task

pytestmark = pytest.mark.usefixtures("built_quickly")

QUICK = 2048


def same(a, b, *but):
    """Say whether two results agree in everything but time."""
    first, second = a.summary(), b.summary()
    for summary in (first, second):
        for key in ("seconds", "build_seconds", "forecast", "advisories", *but):
            del summary[key]
    arrays = [
        (getattr(a.tally.state(), name), getattr(b.tally.state(), name))
        for name in ("limbs", "count", "mean", "m2")
    ]
    return first == second and all((x == y).all() for x, y in arrays)


# -- ledger and summary ----------------------------------------------------------------------------


def test_ledger_closes(room, sphere):
    for result in (room, sphere):
        ledger = result.ledger
        assert abs(ledger.closure) <= 1e-15
        assert ledger.worst_closure <= 1e-15
        rows = [row.value for _, row in ledger.rows()]
        assert math.fsum(rows) + ledger.closure == pytest.approx(ledger.emitted.value, abs=1e-15)
        assert ledger.emitted.value == 1.0
        assert ledger.emitted.sigma == 0.0
    assert room.ledger.escaped.value == 0.0
    assert room.ledger.escaped.sigma == 0.0


def test_escaped_is_the_far_fields_total(sphere):
    far = sphere.far_field
    assert far.solid_angle == pytest.approx(9.817e-3, rel=1e-4)
    assert far.intensity.shape == (40, 32)
    total = math.fsum((far.intensity * far.solid_angle).ravel())
    assert total == pytest.approx(sphere.ledger.escaped.value, rel=1e-14)
    assert (far.hatched == (far.count < 10)).all()


def test_detectors_add_up(room):
    floor = room.detectors["floor"]
    assert math.fsum(rung.value for rung in floor.ladder) == pytest.approx(floor.power.value)
    assert sum(rung.count for rung in floor.ladder) == floor.power.count
    assert floor.map.count.sum() == floor.power.count
    total = math.fsum((floor.map.irradiance * floor.map.area).ravel())
    assert total == pytest.approx(floor.power.value, rel=1e-14)
    assert floor.power.value == room.ledger.absorbed["floor"].value
    assert [rung.generation for rung in floor.ladder] == list(range(16))


def test_a_defect_of_the_engine_is_told(room):
    compiled = room.compiled
    cells = np.zeros((compiled.layout.n_cells, 4), np.int64)
    with pytest.raises(pz.RunError, match=r"batch 7: the ledger misses 1\.000e"):
        check_batch(compiled, 7, cells)


def test_far_field_that_misses_a_ray_is_told(sphere):
    layout = sphere.compiled.layout
    cells = np.zeros((layout.n_cells, 4), np.int64)
    cells[layout.escaped, 0] = sphere.compiled.emitted >> 64
    with pytest.raises(pz.RunError, match="batch 3: the far field's total"):
        check_batch(sphere.compiled, 3, cells)


KEYS = {
    "schema": str, "scene": str, "scene_digest": str, "seed": int, "device": str, "precision": str,
    "batches": int, "rays_per_batch": int, "rays": int, "interactions": int, "seconds": float,
    "converged": bool, "target_sigma": float, "achieved_sigma": float, "tally_digest": str,
    "ledger": dict, "detectors": dict, "advisories": list,
}  # fmt: skip


def test_summary_has_the_keys_of_the_contract(room):
    summary = room.summary()
    for key, kind in KEYS.items():
        assert isinstance(summary[key], kind), key
    assert summary["schema"] == "photizon-result/1"
    assert summary["rays"] == 10 * QUICK
    assert summary["interactions"] > summary["rays"]
    ledger = summary["ledger"]
    assert set(ledger) == {"emitted", "absorbed", "escaped", "roulette", "depth_capped", "closure"}
    assert next(iter(ledger["absorbed"])) == "floor"
    for row in (ledger["emitted"], ledger["escaped"], *ledger["roulette"].values()):
        assert set(row) == {"value", "sigma"}
    floor = summary["detectors"]["floor"]
    assert set(floor) == {"power", "ladder", "map"}
    assert set(floor["power"]) == {"value", "sigma", "count"}
    assert set(floor["ladder"][0]) == {"generation", "value", "sigma", "count"}
    assert floor["map"] == {"nx": 32, "ny": 32, "hatched_below": 10}
    assert summary["tally_digest"].startswith("sha256:")
    assert 0.0 < summary["lit_fraction"] <= 1.0
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_one_batch_has_no_sigma():
    result = pz.trace("box-room", batches=1, rays_per_batch=QUICK)
    summary = result.summary()
    json.dumps(summary, allow_nan=False)
    assert summary["achieved_sigma"] is None
    assert summary["converged"] is False
    assert summary["ledger"]["emitted"]["sigma"] is None
    assert summary["ledger"]["roulette"]["balance"]["sigma"] is None
    assert summary["detectors"]["floor"]["power"]["sigma"] is None
    assert result.ledger.escaped.sigma is None
    assert np.isnan(result.detectors["floor"].map.sigma).all()
    assert any("single batch" in text for text in result.advisories)


def test_what_every_ray_does_has_no_scatter():
    result = pz.trace("ghost-ladder", batches=3, rays_per_batch=256)
    for name in ("transmitted", "reflected"):
        assert result.detectors[name].power.sigma == 0.0
    assert result.achieved_sigma == 0.0
    assert result.lit_fraction is None
    assert result.detectors["transmitted"].ladder[2].value == pytest.approx(0.9216, rel=1e-12)


# -- one stream ------------------------------------------------------------------------------------


def test_refinement_is_one_uninterrupted_run(room):
    part = pz.trace("box-room", batches=3, rays_per_batch=QUICK)
    before = part.tally_digest
    whole = part.refine(batches=10)
    assert same(whole, room)
    assert part.tally_digest == before
    assert part.batches == 3
    assert whole.refine(batches=10).tally_digest == room.tally_digest
    with pytest.raises(pz.ArgumentError, match="expected at least the 10"):
        room.refine(batches=9)


def test_refinement_to_a_target_is_a_run_to_that_target():
    whole = pz.trace("integrating-sphere", target=4e-3, rays_per_batch=QUICK)
    assert whole.converged
    assert whole.batches >= LEAST_BATCHES
    part = pz.trace("integrating-sphere", batches=5, rays_per_batch=QUICK).refine(target=4e-3)
    # a wave that goes past the goal is dropped in part: its interactions are shared out
    assert same(whole, part, "interactions")
    assert part.refine().batches == part.batches


def test_the_seed_names_the_stream(sphere):
    other = pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK, seed=2)
    assert other.tally_digest != sphere.tally_digest
    again = pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK, seed=1)
    assert same(again, sphere)


def test_the_scene_of_a_result_is_as_run():
    result = pz.trace(
        "box-room", seed=9, batches=2, target=0.5, max_seconds=7, rays_per_batch=QUICK
    )
    run = result.scene.run
    assert (run.seed, run.target_sigma, run.max_seconds, run.rays_per_batch) == (9, 0.5, 7.0, QUICK)
    assert run.generation_cap == 64
    assert pz.load("box-room").run.seed == 1


# -- limits ----------------------------------------------------------------------------------------


def test_a_target_is_met_from_the_eighth_batch_on():
    result = pz.trace("integrating-sphere", target=0.9, rays_per_batch=QUICK)
    assert result.batches == LEAST_BATCHES
    assert result.converged
    result = pz.trace("integrating-sphere", target=0.9, batches=5, rays_per_batch=QUICK)
    assert result.batches == 5


def test_time_runs_out():
    started = time.perf_counter()
    result = pz.trace("integrating-sphere", target=1e-9, max_seconds=0.3)
    assert time.perf_counter() - started < 10.0
    assert result.batches >= 1
    assert not result.converged
    (said,) = [text for text in result.advisories if "target was not met" in text]
    needed = result.batches * (result.achieved_sigma / result.target_sigma) ** 2
    (told,) = re.findall(r"about ([\d.e+]+) batches in all", said)
    assert max(needed, 8) <= float(told) <= max(1.1 * needed + 1, 8)
    shortest = pz.trace("integrating-sphere", batches=50, max_seconds=1e-9, rays_per_batch=QUICK)
    assert shortest.batches == 1


def test_a_run_without_a_batch_names_what_splits():
    def told(surface):
        ball = pz.Sphere(name="ball", position=(0, 0, 0), axis="+z", radius=1, surface=surface)
        lamp = pz.IsotropicPoint(name="lamp", flux=1, position=(0, 0, 0))
        scene = pz.Scene(name="lone", source=(lamp,), element=(ball,))
        run = dataclasses.replace(scene.run, generation_cap=60)
        return _no_batch(compile_scene(scene, run), Clock(Goal(None, 0.1, 5.0), 0))

    text = told(pz.Mixed(specular=0.5, diffuse=0.5))
    assert 'a surface that splits, as that of "ball" does' in text
    assert "generation cap of 60: raise roulette_floor" in text
    assert "Fresnel" not in text
    assert told(pz.Mirror(1.0)).endswith("report: lower rays_per_batch or raise max_seconds")


def test_ctrl_c_ends_the_run_with_what_is_there():
    def press(now):
        if now.batches >= 2:
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    result = pz.trace("integrating-sphere", target=1e-9, rays_per_batch=65536, progress=press)
    assert 2 <= result.batches < 100
    assert signal.getsignal(signal.SIGINT) is before
    check = pz.trace("integrating-sphere", batches=result.batches, rays_per_batch=65536)
    assert check.tally_digest == result.tally_digest


def test_a_second_ctrl_c_ends_it_at_once():
    def press(now):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        pz.trace("integrating-sphere", target=1e-9, rays_per_batch=QUICK, progress=press)


def test_progress_is_told():
    seen = []
    pz.trace("integrating-sphere", batches=600, rays_per_batch=QUICK, progress=seen.append)
    assert [now.batches for now in seen] == sorted({now.batches for now in seen})
    last = seen[-1]
    assert (last.batches, last.goal_batches, last.target) == (600, 600, None)
    assert last.eta_seconds == 0.0
    assert last.interactions_per_second > 0.0
    assert last.achieved_sigma > 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seed": -1}, "run.seed: found -1"),
        ({"seed": 2**64}, "run.seed"),
        ({"target": 0.0}, "run.target_sigma: found 0.0"),
        ({"target": math.nan}, "run.target_sigma"),
        ({"max_seconds": 0}, "run.max_seconds"),
        ({"rays_per_batch": 0}, "run.rays_per_batch"),
        ({"batches": 0}, "batches: found 0"),
        ({"batches": 2.5}, "batches: found 2.5"),
        ({"batches": True}, "batches: found true"),
        ({"batches": 2**40}, "expected an integer from 1 to 4294967296"),
        ({"precision": "fp16"}, 'precision: found "fp16", expected one of "fp64", "mixed", "fp32"'),
        ({"device": "no such device"}, "device: no device matches"),
        ({"device": 99}, "device: no device matches"),
        ({"device": 3.7}, "device: found 3.7, expected a number, type or part of a name"),
        ({"executor": 5}, "executor: found 5"),
        ({"progress": True}, "progress: found true, expected a function or None"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(pz.ArgumentError) as caught:
        pz.trace("box-room", **arguments)
    assert message in str(caught.value)
    assert caught.value.exit_code == 2


def test_a_device_named_by_the_environment_is_an_argument(monkeypatch):
    monkeypatch.setenv("PHOTIZON_DEVICE", "no such device")
    with pytest.raises(pz.ArgumentError, match="no device matches"):
        pz.trace("box-room", batches=1)


def test_fewer_rays_than_sources():
    tables = pz.load("box-room").to_dict()
    tables["source"].append({**tables["source"][0], "name": "second"})
    with pytest.raises(pz.ArgumentError, match="expected at least 2, one for each source"):
        pz.trace(tables, rays_per_batch=1, batches=1)


# -- advisories ------------------------------------------------------------------------------------


def altered(preset, **changes):
    tables = pz.load(preset).to_dict()
    tables["element"][0].update(changes)
    return tables


def test_a_detector_that_faces_away_is_named_with_the_remedy():
    result = pz.trace(altered("cosine-fourth", axis="-z"), batches=2, rays_per_batch=QUICK)
    assert result.detectors["target"].power.count == 0
    assert result.ledger.absorbed["target"].value > 0.5
    text = next(t for t in result.advisories if "reads exactly nothing" in t)
    assert '"target"' in text
    assert 'set its side to "back" (it is "front")' in text


def test_depth_capped_power_is_told():
    tables = pz.load("integrating-sphere").to_dict()
    tables["run"]["generation_cap"] = 20
    result = pz.trace(tables, batches=2, rays_per_batch=QUICK)
    assert result.ledger.depth_capped.value > 0.01
    assert any("raise generation_cap" in text for text in result.advisories)


def test_unlit_maps_are_told():
    tables = altered("cosine-fourth", detector={"map": [256, 256]})
    result = pz.trace(tables, batches=2, rays_per_batch=QUICK)
    assert result.lit_fraction < 0.5
    assert any("that any ray reaches carry at least 10" in text for text in result.advisories)
    assert result.detectors["target"].map.hatched.mean() > 0.5


# -- executors -------------------------------------------------------------------------------------


def test_threads_give_the_same_bits(sphere):
    with ThreadPoolExecutor(2) as executor:
        result = pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK, executor=executor)
        assert same(result, sphere)
        whole = pz.trace("integrating-sphere", target=4e-3, rays_per_batch=QUICK)
        part = pz.trace("integrating-sphere", target=4e-3, rays_per_batch=QUICK, executor=executor)
        assert part.tally_digest == whole.tally_digest


def test_processes_give_the_same_bits(sphere):
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as executor:
        result = pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK, executor=executor)
    assert same(result, sphere)


def test_forked_processes_are_refused_with_the_remedy(sphere):
    fork = multiprocessing.get_context("fork")
    with (
        ProcessPoolExecutor(1, mp_context=fork) as executor,
        pytest.raises(pz.RunError, match="spawn"),
    ):
        pz.trace("integrating-sphere", batches=2, rays_per_batch=QUICK, executor=executor)


class Shuffling:
    """An executor that loses the first try of each task and finishes tasks in any order."""

    def __init__(self):
        self.tries = 0
        self.lock = threading.Lock()

    def submit(self, call, task):
        assert call is run_task
        self.tries += 1
        future = Future()
        if self.tries % 3 == 1:
            future.set_exception(ConnectionError("the host went away"))
        else:
            future.set_result(call(task))
        return future


def test_a_lost_task_is_run_again(sphere):
    executor = Shuffling()
    result = pz.trace("integrating-sphere", batches=10, rays_per_batch=QUICK, executor=executor)
    assert same(result, sphere)
    assert executor.tries > 4


@pytest.mark.parametrize("run", [{"roulette_floor": 0.7}, {"generation_cap": 2}])
def test_the_ledger_closes_where_roulette_adds_and_takes_and_at_a_low_cap(run):
    scene = pz.load("box-room")
    settings = dataclasses.replace(scene.run, rays_per_batch=2048, **run)
    ledger = pz.trace(dataclasses.replace(scene, run=settings), batches=3).ledger
    if "roulette_floor" in run:
        assert ledger.roulette.boosted.value > 0.0
        assert ledger.roulette.killed.value > 0.0
    else:
        assert ledger.depth_capped.value > 0.0
    assert abs(ledger.closure) <= ledger.worst_closure <= 1e-15 * ledger.emitted.value
