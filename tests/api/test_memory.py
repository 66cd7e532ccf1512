"""Memory has a budget: what a run takes is said, what cannot fit refused, and nothing lost."""

from __future__ import annotations

import gc
import json
import os
import pickle
import subprocess
import sys
import tracemalloc
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pyopencl as cl
import pytest

import photizon_cl as pz
from benchmarks.limits import endless
from hostcode.device import memory as host_memory
from hostcode.device.memory import Room, room
from hostcode.run import queue, tally
from hostcode.run.sizes import Sizes
from photizon_cl.cli.main import main
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import NoRoomError, RunWarning
from photizon_cl.result.sums import SPARSE_CELL
from photizon_cl.run import batches, distribution, memory, workers
from photizon_cl.run.distribution import open_chosen, usual_plan
from photizon_cl.run.memory import Needs, human, refusal, statement

GB = 10**9
FACTOR = 2.0
"""By which what is said may be more than what is taken."""
SIDE = 500


def scene(side=SIDE, far=None, detectors=1):
    """Return plates above each other, each with a map."""
    tables = pz.load("cosine-fourth").to_dict()
    plate = tables["element"][0]
    tables["element"] = [
        {**plate, "name": f"plate {n}", "position": [0.0, 0.0, -0.1 * n]} for n in range(detectors)
    ]
    for element in tables["element"]:
        element["detector"] = {"map": [side, side]} if side else {}
    tables["far_field"] = {"n_mu": far or 1, "n_phi": far or 1}
    return pz.load(tables)


def compiled(a_scene):
    return compile_scene(a_scene, a_scene.run)


def parts(a_scene, **changes):
    """Return a compiled scene, the usual device with changes, and its plan."""
    record = replace(open_chosen(None).record, **changes)
    made = compiled(a_scene)
    return made, record, usual_plan(record, made.tables)


@pytest.fixture
def limited(monkeypatch):
    """Return a function that sets what a process may still take."""

    def limit(left):
        found = Room(left, 4 * GB, "`ulimit -v`")
        monkeypatch.setattr(memory, "room", lambda: found)
        return found

    return limit


# -- what is said is what is taken -----------------------------------------------------------------


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize(("side", "far"), [(SIDE, None), (0, SIDE)])
def test_what_is_said_is_what_is_taken(side, far, sparse, monkeypatch, tmp_path):
    if sparse:
        monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)
    a_scene = scene(side, far)
    a_scene = replace(a_scene, run=replace(a_scene.run, rays_per_batch=1 << 16))
    monkeypatch.setattr(memory, "_QUAD", 0)  # drawing is looked at below
    # what is imported and built is no part of it
    pz.trace(a_scene, batches=1).save(tmp_path / "before", figures=False)
    needs = Needs.of(*parts(a_scene))
    allocated = []
    buffer = cl.Buffer

    def counted(*arguments, **more):
        made = buffer(*arguments, **more)
        allocated.append(made.size)
        return made

    monkeypatch.setattr(cl, "Buffer", counted)
    gc.collect()
    tracemalloc.start()
    try:
        result = pz.trace(a_scene, batches=3)
        running = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        result.save(tmp_path / "out", figures=False)
        end = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    slack = 8 << 20  # of Python itself, the scene's text and such
    device = sum(needs.device.values())
    assert sum(allocated) <= device <= sum(allocated) + 4096
    grown = result.tally.held_bytes
    assert bool(grown) == sparse
    assert grown <= needs.more
    said = sum(needs.while_running.values()) + grown
    assert running <= said + slack
    assert said <= FACTOR * running + slack
    written = memory._WRITTEN / SPARSE_CELL * grown
    said = sum(needs.at_the_end.values()) + grown + written
    assert end <= said + slack
    assert said <= FACTOR * end + slack


@pytest.mark.slow
@pytest.mark.parametrize("side", [1024, 1500])
def test_drawing_takes_what_is_said(side, tmp_path):
    result = pz.trace(scene(side), batches=3, rays_per_batch=1 << 18)
    assert result.detectors["plate 0"].map is not None
    pz.figures.irradiance(pz.trace(scene(8), batches=2), "plate 0").savefig(tmp_path / "a.png")
    tracemalloc.start()
    pz.figures.irradiance(result, "plate 0").savefig(tmp_path / "a.png")
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken <= memory._drawn(side**2) + (16 << 20)


# -- what cannot fit is refused --------------------------------------------------------------------


def line_of(error):
    (line,) = str(error).splitlines()
    assert line.isprintable()
    return line


@pytest.mark.parametrize(
    ("side", "far", "detectors", "said"),
    [
        (8192, None, 1, 'take fewer bins in element[0].detector.map of "plate 0" (it is [8192, 81'),
        (0, 8192, 1, "lower far_field.n_mu and far_field.n_phi (they are 8192 and 8192)"),
        (2048, None, 20, "with 19 other maps 8388608"),
        (4096, 8192, 2, "lower far_field.n_mu and far_field.n_phi (they are 8192 and 8192; with 2"),
    ],
)
def test_a_scene_that_cannot_fit_is_refused(side, far, detectors, said, limited, tmp_path):
    limited(2 * GB)
    out = tmp_path / "out"
    tracemalloc.start()
    try:
        with pytest.raises(pz.RunError) as caught:
            pz.trace(scene(side, far, detectors), checkpoint=out)
        taken = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert taken < 64e6
    assert not out.exists()
    line = line_of(caught.value)
    assert said in line
    assert "2 GB are left of `ulimit -v` (4 GB)" in line
    assert "the largest part is the" in line


def test_what_fits_is_not_refused(limited):
    limited(8 * GB)
    memory.check_memory(*parts(scene(8192)), look=memory.room)
    limited(1)  # a small one is not even asked about
    assert pz.trace("cosine-fourth", batches=1).batches == 1


def test_fewer_batches_are_traced_at_once_where_memory_is_short(limited):
    made, record, plan = parts(replace(scene(), run=replace(scene().run, rays_per_batch=64)))
    assert Needs.of(made, record, plan).most_at_a_time > GB // 2
    limited(8 * GB)
    assert memory.check_memory(made, record, plan) is plan
    limited(GB // 2)
    assert memory.check_memory(made, record, plan).wave_rays == 64
    found = pz.trace(made.scene, batches=3)
    limited(8 * GB)
    assert found.tally_digest == pz.trace(made.scene, batches=3).tally_digest
    limited(GB // 10)
    with pytest.raises(pz.RunError, match="of memory"):
        memory.check_memory(made, record, plan)


def test_a_device_that_cannot_hold_it_is_told():
    made, record, plan = parts(scene(4096), max_allocation=10**8)
    line = refusal(made, Needs.of(made, record, plan), record, None)
    assert line.startswith("the tally of a batch on the device takes 537 MB in one piece, and ")
    assert "gives at most 100 MB: take fewer bins in element[0].detector.map" in line
    made, record, plan = parts(scene(4096), max_allocation=GB, global_memory=10**8)
    line = refusal(made, Needs.of(made, record, plan), record, None)
    assert line.startswith("the device's buffers take 540 MB, most of it the tally of a batch")


def test_rays_are_told_where_they_are_the_largest_part():
    made, record, plan = parts(endless("trapped in glass", 1 << 20))
    plan = plan.with_(composition="whole-path", lanes=1, wave_rays=1 << 20)
    line = refusal(made, Needs.of(made, record, plan), record, Room(GB // 10, GB, "this machine"))
    assert "lower run.rays_per_batch (it is 1048576)" in line


def test_a_device_with_memory_of_its_own_takes_none_of_the_host():
    made, record, plan = parts(scene(4096), type="gpu")
    needs = Needs.of(made, record, plan)
    assert not needs.shared
    assert sum(needs.tracing.values()) == sum(needs.while_running.values())


def test_check_says_what_a_run_takes(capsys, limited, tmp_path):
    file = tmp_path / "scene.toml"
    scene(4096).save(file)
    limited(8 * GB)
    assert main(["check", str(file)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert " memory: 952 MB at most at a time: device 540 MB (tally 537 MB," in out
    assert "more for sums, and to write them, as bins are lit" in out
    assert "will not fit" not in out
    limited(GB // 2)
    assert main(["check", str(file)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "It will not fit: this scene takes 1.22 GB of memory at the end, and 500 MB are" in out
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 1
    out, err = capsys.readouterr()
    assert not out
    assert line_of(err.strip()).startswith("this scene takes 1.22 GB")
    assert not (tmp_path / "out").exists()


def test_a_statement_is_one_line():
    made, record, plan = parts(endless("trapped in glass", 64))
    text = statement(made, record, plan, None)
    assert text.isprintable()
    assert "more for rays that wait" in text


@pytest.mark.parametrize(
    ("size", "text"),
    [(0, "0 bytes"), (999, "999 bytes"), (1000, "1 kB"), (2.147e9, "2.15 GB"), (999.6e6, "1 GB")],
)
def test_sizes_as_people_say_them(size, text):
    assert human(size) == text


# -- what may be taken -----------------------------------------------------------------------------


def test_the_least_limit_counts(tmp_path, monkeypatch):
    proc, groups = tmp_path / "proc", tmp_path / "groups"
    (proc / "self").mkdir(parents=True)
    (proc / "meminfo").write_text("MemTotal: 8000000 kB\nMemAvailable: 6000000 kB\n")
    assert room(proc, groups) == Room(
        6000000 << 10, 8000000 << 10, "this machine, of which others have some"
    )
    # version 2: the limit of a group around it counts, and what is only kept does not
    (proc / "self" / "cgroup").write_text("1:name=systemd:/x\n0::/job/step\n")
    (groups / "job" / "step").mkdir(parents=True)
    (groups / "job" / "step" / "memory.max").write_text("max\n")
    (groups / "job" / "step" / "memory.current").write_text("5\n")
    (groups / "job" / "memory.max").write_text("3000000000\n")
    (groups / "job" / "memory.current").write_text("1500000000\n")
    (groups / "job" / "memory.stat").write_text("anon 1\ninactive_file 500000000\n")
    found = room(proc, groups)
    assert (found.left, found.limit) == (2 * GB, 3 * GB)
    # version 1
    (proc / "self" / "cgroup").write_text("4:memory:/job\n")
    (groups / "memory" / "job").mkdir(parents=True)
    (groups / "memory" / "job" / "memory.limit_in_bytes").write_text("1000000000\n")
    (groups / "memory" / "job" / "memory.usage_in_bytes").write_text("400000000\n")
    assert room(proc, groups).left == 600_000_000
    (groups / "memory" / "job" / "memory.limit_in_bytes").write_text("9223372036854771712\n")
    assert room(proc, groups).left == 6000000 << 10


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="limits as Linux tells them")
def test_ulimit_counts(tmp_path):
    code = (
        "from hostcode.device.memory import room; r = room(); print(r.left, r.limit, r.what)\n"
        "print(open('/proc/self/status').read().split('VmSize:')[1].split()[0])"
    )
    shell = f'ulimit -v 3000000; exec {sys.executable} -c "$CODE"'
    environment = {**os.environ, "CODE": code}
    done = subprocess.run(
        ["sh", "-c", shell], env=environment, capture_output=True, text=True, check=True
    )
    first, used = done.stdout.splitlines()
    left, limit, what = first.split(" ", 2)
    assert (int(limit), what) == (3000000 << 10, "`ulimit -v`")
    assert abs(int(left) + (int(used) << 10) - int(limit)) < 8 << 20


def test_a_system_that_does_not_tell(tmp_path, monkeypatch):
    monkeypatch.delattr(host_memory.os, "sysconf")
    assert room(tmp_path, tmp_path) is None


# -- in mid-run ------------------------------------------------------------------------------------


def no_more_after(monkeypatch, n):
    """Have the queue be full in all batches from the n-th on, wherever they are traced."""
    usual = distribution.Engine.run

    def run(self, first, count):
        for batch in range(first, first + count):
            if batch >= n:
                raise queue.QueueFull("more rays split off than may wait")
            yield from usual(self, batch, 1)

    monkeypatch.setattr(distribution.Engine, "run", run)


@pytest.mark.parametrize("rays_of_a_task", [512, 4 * 512])
def test_a_worker_without_room_ends_a_run_as_this_process_does(monkeypatch, rays_of_a_task):
    no_more_after(monkeypatch, 7)
    monkeypatch.setattr(workers, "_RAYS_OF_A_TASK", rays_of_a_task)
    how = {"batches": 16, "rays_per_batch": 512}
    with pytest.warns(RunWarning, match="more rays split off than may wait"):
        here = pz.trace("cosine-fourth", **how)
    with ThreadPoolExecutor(2) as pool, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        there = pz.trace("cosine-fourth", executor=pool, **how)
    (line,) = [str(w.message) for w in said if issubclass(w.category, RunWarning)]
    assert "more rays split off than may wait" in line
    assert here.info.stopped == there.info.stopped == "memory"
    assert here.batches == there.batches == 7 if rays_of_a_task else 0
    assert here.tally_digest == there.tally_digest


def test_workers_without_room_for_a_single_batch_end_in_a_line(monkeypatch):
    monkeypatch.setattr(queue, "BUDGET", 1 << 22)
    with ThreadPoolExecutor(2) as pool, pytest.raises(pz.RunError) as caught:
        pz.trace(endless("glass in mirrors", 16), max_seconds=20.0, executor=pool)
    assert "set roulette_floor (1e-6, say)" in line_of(caught.value)


@pytest.mark.parametrize(
    ("changes", "left", "said"),
    [
        (
            {"max_allocation": 10**7},
            None,
            "one of 16 GB, and it gives at most 0.01 GB (most for the tally)",
        ),
        ({"global_memory": 10**7}, None, "and it has 0.01 GB (most for the tally)"),
        ({}, 10**7, "and 0.01 GB are left of `ulimit -v` (most for the tally)"),
    ],
)
def test_a_worker_looks_at_what_it_has(changes, left, said, monkeypatch):
    made, record, plan = parts(scene(1500), **changes)
    sizes = Sizes.of(made.tables, plan)
    monkeypatch.setattr(
        distribution, "room", lambda: None if left is None else Room(left, GB, "`ulimit -v`")
    )
    with pytest.raises(NoRoomError) as caught:
        distribution._check_buffers(record, sizes)
    assert said.replace("16 GB", f"{sizes.largest[1] / 1e9:.3g} GB") in line_of(caught.value)


def test_the_error_of_a_worker_travels():
    error = pickle.loads(pickle.dumps(NoRoomError("no room")))
    assert type(error) is NoRoomError
    assert str(error) == "no room"


def test_sums_that_cannot_grow_end_a_run_with_what_is_whole(monkeypatch, tmp_path):
    monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)
    whole = pz.trace(scene(), batches=2, rays_per_batch=512)
    looks = []

    def less_and_less():
        looks.append(1)
        return Room(GB if len(looks) < 3 else 1 << 20, 2 * GB, "`ulimit -v`")

    monkeypatch.setattr(batches, "no_room_for", lambda *a: memory.no_room_for(*a, less_and_less))
    with pytest.warns(RunWarning, match="are left of `ulimit -v`") as said:
        found = pz.trace(scene(), batches=8, rays_per_batch=512, checkpoint=tmp_path)
    line_of(said[0].message)
    assert (found.info.stopped, found.batches) == ("memory", 2)
    assert found.tally_digest == whole.tally_digest
    monkeypatch.undo()
    assert pz.resume(tmp_path, batches=3).batches == 3  # where there is more


def test_no_memory_at_all_is_a_line(monkeypatch, capsys, tmp_path):
    def gone(*_):
        raise MemoryError("Unable to allocate 2.00 GiB for an array with shape (67108864, 4)")

    monkeypatch.setattr(batches, "complete", gone)
    out = tmp_path / "out"
    assert main(["run", "cosine-fourth", "--batches", "2", "--out", str(out)]) == 1
    said = line_of(capsys.readouterr().err.strip())
    assert "no memory was left in mid-run" in said
    assert "photizon resume" in said
    monkeypatch.undo()
    result = pz.trace("cosine-fourth", batches=2, rays_per_batch=64)
    monkeypatch.setattr("photizon_cl.run.directory.write_arrays", gone)
    with pytest.raises(pz.ResultError, match="no memory is left for its arrays"):
        result.save(tmp_path / "other")
    monkeypatch.setattr("photizon_cl.cli.check._print", gone)
    assert main(["check", "cosine-fourth"]) == 1
    assert "no memory is left" in line_of(capsys.readouterr().err.strip())


# -- the large ones --------------------------------------------------------------------------------

PEAK = """
import json, resource, sys
from photizon_cl.cli.main import main
status = main(sys.argv[1:])
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([status, peak]), file=sys.__stderr__)
"""


def run_limited(arguments, kilobytes):
    """Run a command under ``ulimit -v``; return status, peak in bytes, and what it said."""
    command = f'ulimit -v {kilobytes}; exec "$0" -c "$PEAK" "$@"'
    done = subprocess.run(
        ["sh", "-c", command, sys.executable, *arguments],
        env={**os.environ, "PEAK": PEAK}, capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    *said, last = done.stderr.splitlines()
    status, peak = json.loads(last)
    assert "Traceback" not in done.stderr
    assert "MemoryError" not in done.stderr
    return status, peak << 10, said


LARGE = {
    "map": scene(8192),
    "far field": scene(0, 8192),
    "twenty detectors": scene(2048, None, 20),
    "two maps": scene(8192, None, 2),
}


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ulimit -v as Linux has it")
@pytest.mark.parametrize("limit", ["4194304", "8388608", "unlimited"])
@pytest.mark.parametrize("name", LARGE)
def test_large_scenes_run_in_four_gigabytes_or_are_refused(name, limit, tmp_path):
    file, out = tmp_path / "scene.toml", tmp_path / "out"
    LARGE[name].save(file)
    arguments = ["run", str(file), "--batches", "3", "--rays-per-batch", "4096"]
    status, peak, said = run_limited([*arguments, "--out", str(out)], limit)
    if status:
        assert "of memory" in line_of("\n".join(said))
        assert limit == "4194304" or (name, limit) == ("two maps", "8388608")
        assert not out.exists()
    else:
        assert peak < (4 if name != "two maps" else 6) * GB
        assert pz.open_result(out).batches == 3


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ulimit -v as Linux has it")
@pytest.mark.parametrize("limit", ["4194304", "8388608"])
def test_splitting_without_bound_ends_in_a_line(limit, tmp_path):
    file = tmp_path / "scene.toml"
    endless("glass in mirrors", 1024).save(file)
    status, peak, said = run_limited(["run", str(file), "--max-seconds", "30"], limit)
    assert status == 1
    assert "more rays split off than may wait" in said[-1]
    assert peak < 4 * GB
