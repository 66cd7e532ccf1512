"""Memory has a budget: what a run takes is said, and what cannot fit is refused in one line."""

from __future__ import annotations

import re
import tomllib
import tracemalloc
from dataclasses import replace

import pytest
from plates import GB, line_of, parts, scene
from test_hostile_results import rewritten

import photizon_cl as pz
from benchmarks.limits import endless
from hostcode.device.memory import Room
from hostcode.run import tally
from photizon_cl.cli.main import main
from photizon_cl.errors import RunWarning
from photizon_cl.run import memory
from photizon_cl.run.memory import refusal, statement
from photizon_cl.run.needs import Needs, human
from photizon_cl.scene.writing import to_toml


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
    assert Needs.of(made, record, plan).most_at_a_time() > GB // 2
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
    made, record, plan = parts(scene(8192), max_allocation=1 << 31)
    line = refusal(made, Needs.of(made, record, plan), record, None)
    assert re.search(
        r"takes 21474\d+ bytes in one piece, and .* at most 2147483648 bytes: take", line
    )
    made, record, plan = parts(scene(4096), max_allocation=GB, global_memory=10**8)
    line = refusal(made, Needs.of(made, record, plan), record, None)
    assert line.startswith("the device's buffers take 540 MB, most of it the tally of a batch")


def test_wavelengths_are_told_where_they_are_what_takes_it(limited):
    """A map of a few bins is one for each line; without maps the ledger's rows are."""
    many = {"wavelengths_nm": [400.0 + k / 4 for k in range(1024)]}
    made, record, plan = parts(scene(256).replace({"spectrum": many}))
    assert refusal(made, Needs.of(made, record, plan), record, Room(GB, GB, "here")) == ""
    told = made.scene.replace({'element."plate 0".detector.wavelengths': True})
    made, record, plan = parts(told)
    line = refusal(made, Needs.of(made, record, plan), record, Room(GB, GB, "here"))
    assert "(it is [256, 256], 1025 times by its wavelengths = true)" in line
    # each line's map is an array of its own
    limited(GB)
    with pytest.raises(pz.RunError, match="wavelengths = true"):
        pz.trace(told, batches=1)


def test_rays_are_told_where_they_are_the_largest_part():
    made, record, plan = parts(endless("trapped in glass", 1 << 20))
    plan = plan.with_(composition="whole-path", lanes=1, wave_rays=1 << 20)
    line = refusal(made, Needs.of(made, record, plan), record, Room(GB // 10, GB, "this machine"))
    assert "lower run.rays_per_batch (it is 1048576)" in line


def test_a_device_with_memory_of_its_own_takes_none_of_the_host():
    made, record, plan = parts(scene(4096), type="gpu")
    needs = Needs.of(made, record, plan)
    assert not needs.shared
    running = needs.phases(saved=False, drawn=False)["while it traces"]
    assert running == {**needs.while_running, "values": needs.values}


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
    assert "It will not fit: this scene takes 814 MB of memory while it traces, and 500 MB" in out
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 1
    out, err = capsys.readouterr()
    assert not out
    assert line_of(err.strip()).startswith("this scene takes 1.07 GB of memory while it is saved")
    assert not (tmp_path / "out").exists()


def test_only_what_is_asked_for_is_refused(limited):
    """Files count where a run keeps them; figures never do, since they can be drawn later."""
    made, record, plan = parts(scene(4096))
    limited(GB)
    assert memory.check_memory(made, record, plan) is plan
    with pytest.raises(pz.RunError, match=r"1\.07 GB of memory while it is saved") as caught:
        memory.check_memory(made, record, plan, saved=True)
    line_of(caught.value)
    left = limited(GB + GB // 10)
    assert memory.check_memory(made, record, plan, saved=True) is plan
    said = statement(made, record, plan, left)
    assert "Its figures (`--no-figures` leaves them out) will not fit: this scene takes 1.2" in said
    assert "the largest part is the arrays of the result" in said
    assert "Its files will not fit: this" in statement(made, record, plan, limited(GB))
    assert "not fit" not in statement(made, record, plan, limited(2 * GB))


@pytest.fixture
def to_the_byte(monkeypatch):
    """Look at memory however little is asked for."""
    monkeypatch.setattr(memory, "_GROWING", 0)


MB = 10**6
"""Maps of 500 × 500 bins: arrays of 8 MB, files of 20, figures of 39."""


def test_figures_without_room_are_left_out_and_said(limited, to_the_byte, tmp_path, capsys):
    result = pz.trace(scene(), batches=2, rays_per_batch=512)
    limited(30 * MB)
    with pytest.warns(RunWarning, match="no figures are drawn for .*: drawing them takes") as said:
        result.save(tmp_path / "kept")
    assert line_of(said[0].message).endswith(
        "`photizon report` draws them later, where more is free"
    )
    assert (tmp_path / "kept" / "result.nc").is_file()
    assert not (tmp_path / "kept" / "figures").exists()
    assert main(["report", str(tmp_path / "kept")]) == 2
    assert "most of it drawing its figures (39 MB), and 30 MB are left" in capsys.readouterr().err
    limited(GB)
    assert main(["report", str(tmp_path / "kept")]) == 0
    assert list((tmp_path / "kept" / "figures").glob("*.png"))


def test_a_result_that_cannot_be_written_or_opened_is_told(limited, to_the_byte, tmp_path, capsys):
    how = {"batches": 2, "rays_per_batch": 512}
    result = pz.trace(scene(), checkpoint=tmp_path / "left", **how)
    result.save(tmp_path / "kept", figures=False)
    limited(5 * MB)
    with pytest.raises(pz.ResultError, match="takes 8 MB of memory for 250001 bins"):
        pz.open_result(tmp_path / "left")  # of a run that was not saved
    with pytest.raises(pz.ResultError, match="takes 8 MB of memory for 250001 bins") as caught:
        pz.open_result(tmp_path / "kept")
    assert "open it where more is free" in line_of(caught.value)
    assert main(["report", str(tmp_path / "kept")]) == 2
    line_of(capsys.readouterr().err.strip())
    limited(10 * MB)
    opened = pz.open_result(tmp_path / "kept")
    assert opened.tally_digest == result.tally_digest
    with pytest.raises(pz.ResultError, match="cannot be written: the result takes 28 MB") as caught:
        opened.save(tmp_path / "other")
    assert "free some and save it again" in line_of(caught.value)
    assert not (tmp_path / "other").exists()
    limited(24 * MB)  # its arrays are there
    assert opened.summary()["detectors"]["plate 0"]["map"]
    opened.save(tmp_path / "other", figures=False)


def a_large_map(arrays, attrs, top):
    """Have a small file stand for a map that takes gigabytes."""
    tables = tomllib.loads(top["scene"])
    tables["element"][0]["detector"]["map"] = [8192, 8192]
    top["scene"] = to_toml(pz.load(tables))


def test_a_small_file_that_stands_for_gigabytes_is_told(limited, monkeypatch, tmp_path):
    monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)
    pz.trace(scene(), batches=2, rays_per_batch=512).save(tmp_path, figures=False)
    file = tmp_path / "result.nc"
    rewritten(file, a_large_map)
    assert file.stat().st_size < MB
    limited(2 * GB)
    tracemalloc.start()
    try:
        with pytest.raises(pz.ResultError) as caught:
            pz.open_result(tmp_path)
        assert tracemalloc.get_traced_memory()[1] < 64 * MB
    finally:
        tracemalloc.stop()
    assert "takes 2.15 GB of memory for 67108865 bins" in line_of(caught.value)
    limited(3 * GB)
    assert pz.open_result(tmp_path).batches == 2


def test_what_each_batch_gives_has_room_as_far_as_it_is_kept():
    made, record, plan = parts(scene(32))
    cells = sum(n for _, n in made.layout.scalars)
    most = (1 << 22) // cells
    before = Needs.of(made, record, plan)
    assert (before.values, before.more_values) == (0, 8 * cells * most)
    for batches, rows in ((10, 10), (most, most), (10**9, most)):
        needs = Needs.of(made, record, plan, 0, batches)
        assert needs.values == 8 * cells * rows
        for saved, times in ((False, 1), (True, 2)):
            more = needs.most_at_a_time(saved=saved) - before.most_at_a_time(saved=saved)
            assert more == times * needs.values
    # what is kept of a run is what was said
    found = pz.trace(scene(32), batches=10, rays_per_batch=64).tally.batch_values.table()
    assert found.nbytes == Needs.of(made, record, plan, 0, 10).values
    text = statement(made, record, plan, None)
    assert "up to 33.6 MB more for what single batches give" in text
    left = Room(300 << 20, GB, "this machine")
    assert refusal(made, before, record, left, saved=True) == ""
    why = refusal(made, needs, record, left, saved=True)
    assert "takes 347 MB of memory while it traces" in why
    assert "single quantities, 67.1 MB: take fewer batches of more rays (run.rays_per" in why


def test_a_run_counts_what_its_batches_give(limited):
    made, record, plan = parts(scene(1500))
    one = plan.with_(wave_rays=made.settings.rays_per_batch)
    limited(Needs.of(made, record, one).most_at_a_time() + (256 + 10 << 20))
    assert memory.check_memory(made, record, plan, batches=100) is not None
    with pytest.raises(pz.RunError, match="MB of memory while it traces, and"):
        pz.trace(scene(1500), batches=10**6, max_seconds=1.0)


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
