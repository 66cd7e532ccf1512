"""Memory has a budget: what a run takes is said, and what cannot fit is refused in one line."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import pytest
from plates import GB, line_of, parts, scene

import photizon_cl as pz
from benchmarks.limits import endless
from hostcode.device.memory import Room
from photizon_cl.cli.main import main
from photizon_cl.run import memory
from photizon_cl.run.memory import Needs, human, refusal, statement


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
