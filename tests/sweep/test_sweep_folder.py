"""What is kept of a sweep: states in which it may be found, and what is refused."""

from __future__ import annotations

import dataclasses
import json
import signal
import threading

import pytest
from tubes import WALL, WIDE, a_sweep

import photizon_cl as pz
from photizon_cl.atomic import Lock
from photizon_cl.result.estimates import Estimates
from photizon_cl.result.file import write_state
from photizon_cl.result.stopping import Goal
from photizon_cl.run import batches as running
from photizon_cl.studies import sweeping

SAME = a_sweep(WIDE)


@pytest.fixture
def traced(monkeypatch):
    """Return the first batch of every run that was made while the test runs."""
    begun = []
    go_on = running.go_on

    def noted(start, *args, **kwargs):
        begun.append(start.batches)
        return go_on(start, *args, **kwargs)

    monkeypatch.setattr(sweeping, "go_on", noted)
    return begun


def digests(found):
    return [point.digest for point in found]


def changes(found):
    return [point.summary()["change"] for point in found]


def test_what_is_there(kept):
    assert {f.name for f in kept.iterdir()} == {
        "points", "sweep.csv", "sweep.json", "sweep.nc", "sweep.png",
    }  # fmt: skip
    found = pz.open_sweep(kept)
    assert found.finished
    assert found.to_csv() == (kept / "sweep.csv").read_text("utf-8")
    for point in found:
        result = found.open(point.number)
        assert result.tally_digest == point.digest
        assert pz.open_result(kept / "points" / f"{point.number:04d}").tally_digest == point.digest
    assert found.difference("PST", 0, 2).difference == found[2].change["PST"]
    assert found.difference("PST", 0, 2).paired
    import xarray as xr

    with xr.open_dataset(kept / "sweep.nc", engine="h5netcdf") as data:
        assert data["PST"].values.tolist() == [point["PST"].value for point in found]
        assert data["digest"].values.tolist() == digests(found)
        assert data["angle"].attrs["units"] == "deg"
        assert data.attrs["programs"] == 1


def test_its_file_is_a_sweep_file(kept):
    again = pz.sweep(kept / "sweep.json")
    assert digests(again) == digests(pz.open_sweep(kept))


def test_the_same_sweep_that_is_done_is_not_run_again(kept, traced):
    before = (kept / "sweep.csv").stat().st_mtime_ns
    found = pz.sweep(SAME, out=kept)
    assert found.finished
    assert found.programs is None
    assert not traced
    assert (kept / "sweep.csv").stat().st_mtime_ns == before


def test_points_that_died_behind_their_run_are_not_run_again(kept, traced):
    whole = pz.open_sweep(kept)
    (kept / "points" / "0000" / "point.json").unlink()
    (kept / "points" / "0002" / "point.json").unlink()
    (kept / "points" / "0002" / "summary.json").unlink()  # in the midst of its files
    assert pz.open_sweep(kept).n_done == 1
    found = pz.open_sweep(kept).resume(figure=False)
    assert not traced
    assert digests(found) == digests(whole)
    assert changes(found) == changes(whole)
    assert (kept / "points" / "0002" / "summary.json").exists()


@pytest.mark.parametrize(("batches", "then"), [(3, [3]), (4, [])])
def test_a_point_goes_on_from_its_checkpoint(kept, traced, batches, then):
    whole = pz.open_sweep(kept)
    home = kept / "points" / "0001"
    for file in home.iterdir():
        file.unlink()
    scene = whole.open(0).scene.replace({"source.sun.tilt_deg[0]": 4.0})
    left = pz.trace(scene, batches=batches)
    info = dataclasses.replace(left.info, goal=Goal(4), stopped="")  # as a run under way says
    write_state(Estimates(left.compiled, left.tally, info), home / "checkpoint.nc")
    found = pz.open_sweep(kept).resume(figure=False)
    assert traced == then
    assert digests(found) == digests(whole)
    assert found[1].stopped == "batches"
    assert not (home / "checkpoint.nc").exists()


def test_an_unfinished_one_is_told(kept):
    (kept / "points" / "0001" / "point.json").unlink()
    with pytest.raises(pz.ResultError, match="unfinished, with 2 of 3 points done: `photizon res"):
        pz.sweep(SAME, out=kept)


@pytest.mark.parametrize(
    ("more", "what"),
    [
        ({"vary": [{**WIDE, "values": [0, 4, 9]}]}, "[[vary]] differs"),
        ({"vary": [{**WIDE, "name": "tilt"}]}, "[[vary]] differs"),
        ({"run": {"batches": 5}}, "[run] differs"),
        ({"measure": {}}, "[measure] differs"),
        ({"scene": "integrating-sphere", "vary": [{"path": "run.seed", "values": [1]}],
          "measure": {}}, "the scene and [[vary]] and [measure] differ"),
    ],
)  # fmt: skip
def test_a_changed_sweep_is_refused(kept, more, what, traced):
    with pytest.raises(pz.ResultError) as error:
        pz.sweep({**SAME, **more}, out=kept)
    assert what in str(error.value)
    assert "\n" not in str(error.value)
    assert not traced


def test_title_and_notes_may_change(kept, traced):
    pz.sweep({**SAME, "title": "another", "notes": "words"}, out=kept)
    assert not traced


def test_what_is_no_sweep_is_refused(tmp_path, kept):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(pz.ResultError, match=r'holds files and no sweep \("notes.txt"\)'):
        pz.sweep(SAME, out=tmp_path / "mine")
    with pytest.raises(pz.ResultError, match="is a file"):
        pz.sweep(SAME, out=tmp_path / "mine" / "notes.txt")
    with pytest.raises(pz.ResultError, match="holds no sweep"):
        pz.open_sweep(tmp_path / "mine")
    with pytest.raises(pz.ResultError, match="is a directory: pz"):
        pz.sweep(kept)
    with pytest.raises(pz.ResultError, match=r"resume\(\) of pz.open_sweep, goes on"):
        pz.resume(kept)
    with pytest.raises(pz.ResultError, match=r"holds a sweep: pz.open_sweep opens it"):
        pz.open_result(kept)


def test_damage_is_told(kept):
    file = kept / "points" / "0001" / "point.json"
    text = file.read_text("utf-8")
    for broken in ("", "{}", text[:-20], text.replace('"number": 1', '"number": 2'),
                   text.replace('"stopped": "batches"', '"stopped": 3'),
                   text.replace('"PST"', '"PTS"')):  # fmt: skip
        file.write_text(broken, encoding="utf-8")
        with pytest.raises(pz.ResultError, match="damaged or of another sweep") as error:
            pz.open_sweep(kept)
        assert "\n" not in str(error.value)
    file.unlink()
    assert pz.open_sweep(kept).n_done == 2
    (kept / "sweep.json").write_text("{", encoding="utf-8")
    with pytest.raises(pz.ResultError, match="is damaged"):
        pz.open_sweep(kept)


def test_points_of_another_engine_are_not_mixed(kept):
    file = kept / "points" / "0001" / "point.json"
    point = json.loads(file.read_text("utf-8"))
    file.write_text(json.dumps({**point, "engine": "0123"}), encoding="utf-8")
    (kept / "points" / "0002" / "point.json").unlink()
    with pytest.raises(pz.ResultError, match="made by the engine 0123"):
        pz.open_sweep(kept).resume(figure=False)


def test_the_result_of_another_scene_is_refused(kept):
    home = kept / "points" / "0001"
    (home / "point.json").unlink()
    (home / "result.nc").unlink()
    (kept / "points" / "0002" / "result.nc").rename(home / "result.nc")
    with pytest.raises(pz.ResultError, match="none of this sweep"):
        pz.open_sweep(kept).resume(figure=False)


def test_one_process_at_a_time(kept):
    (kept / "points" / "0001" / "point.json").unlink()
    lock = Lock(kept)
    try:
        with pytest.raises(pz.ResultError, match="being written to by another run"):
            pz.open_sweep(kept).resume(figure=False)
    finally:
        lock.free()


# -- ends before the end ---------------------------------------------------------------------------


def test_the_time_of_a_call_is_for_all_points():
    many = {"path": "source.sun.tilt_deg[0]", "linspace": [0, 10, 200]}
    tables = a_sweep(many, run={"batches": 4})
    found = pz.sweep(tables, max_seconds=0.5)
    assert 0 < found.n_done < 200
    assert not found.failed
    assert not found.interrupted
    assert "of them done" in repr(found)


def test_a_point_that_is_cut_short_by_the_call_is_not_done(tmp_path):
    long = a_sweep(WALL, run={"batches": 1_000_000, "rays_per_batch": 16384})
    found = pz.sweep(long, out=tmp_path / "out", max_seconds=1.0, figure=False)
    assert found.n_done == 0
    assert not found.failed
    assert (tmp_path / "out" / "points" / "0000" / "checkpoint.nc").exists()


def test_the_time_of_a_point_ends_the_point():
    run = {"batches": 1_000_000, "max_seconds": 0.3}
    found = pz.sweep(a_sweep(WALL, run=run))
    assert [point.stopped for point in found] == ["time", "time"]
    assert found.finished


def test_a_point_that_fails_is_told_and_the_others_go_on(tmp_path, monkeypatch):
    go_on = running.go_on

    def fails(start, *args, **kwargs):
        if start.scene.source["sun"].tilt_deg[0] == 4.0:
            raise pz.RunError("the device\nhad enough")
        return go_on(start, *args, **kwargs)

    folder = tmp_path / "out"
    monkeypatch.setattr(sweeping, "go_on", fails)
    found = pz.sweep(SAME, out=folder, figure=False)
    assert [(p.number, p.why) for p in found.failed] == [(1, "the device had enough")]
    assert (found.n_done, found[2].done, found[1].stopped) == (2, True, "failed")
    assert ",failed," in (folder / "sweep.csv").read_text("utf-8")
    monkeypatch.setattr(sweeping, "go_on", go_on)
    again = found.resume(figure=False)
    assert again.finished
    assert digests(again) == digests(pz.sweep(SAME))


def test_points_before_the_first_one_have_their_change_too(tmp_path, monkeypatch):
    go_on = running.go_on

    def fails(start, *args, **kwargs):
        if start.scene.source["sun"].tilt_deg[0] == 0.0:
            raise pz.RunError("not yet")
        return go_on(start, *args, **kwargs)

    monkeypatch.setattr(sweeping, "go_on", fails)
    found = pz.sweep(SAME, out=tmp_path / "out", figure=False)
    assert not found[2].change
    monkeypatch.setattr(sweeping, "go_on", go_on)
    again = found.resume(figure=False)
    assert changes(again) == changes(pz.sweep(SAME))


def test_ctrl_c_keeps_what_is_done(tmp_path):
    if threading.current_thread() is not threading.main_thread():
        pytest.skip("needs the main thread")

    def interrupts(now):
        if now.number == 1:
            signal.raise_signal(signal.SIGINT)
            interrupts.done = True

    interrupts.done = False

    def once(now):
        if not interrupts.done:
            interrupts(now)

    found = pz.sweep(SAME, out=tmp_path / "out", progress=once, figure=False)
    assert interrupts.done
    assert found.interrupted
    assert 1 <= found.n_done < 3
    assert digests(found.resume(figure=False)) == digests(pz.sweep(SAME))
