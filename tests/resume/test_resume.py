"""Checkpoints, and going on with them to the same bits."""

from __future__ import annotations

import itertools
import math
import shutil

import numpy as np
import pytest

import photizon_cl as pz
from hostcode.program.plan import ExecutionPlan
from photizon_cl.atomic import TEMPORARY, Lock
from photizon_cl.cli.main import main
from photizon_cl.result.stopping import History
from photizon_cl.run import checkpoint
from photizon_cl.run.directory import CHECKPOINT

pytestmark = pytest.mark.usefixtures("built_quickly")

SCENE, RAYS = "box-room", 2048
EACH = ExecutionPlan(lanes=8, items=4, wave_rays=RAYS)  # a wave for each batch


class KilledError(Exception):
    """Ends a run in the middle, as a kill would: nothing is written after it."""


@pytest.fixture(autouse=True)
def at_every_wave(monkeypatch):
    monkeypatch.setattr(checkpoint, "PERIOD", 0.0)
    monkeypatch.setattr(checkpoint, "_SHARE", 1e9)
    monkeypatch.setattr(History, "_SHARE", 1e9)


def die_after(batches):
    def progress(now):
        if now.batches >= batches:
            raise KilledError

    return progress


def killed(folder, after=3, scene=SCENE, batches=10, target=None):
    """Leave in a directory what a killed run leaves."""
    with pytest.raises(KilledError):
        pz.trace(
            scene, rays_per_batch=RAYS, batches=batches, target=target, max_seconds=600.0,
            progress=die_after(after), checkpoint=folder, plan=EACH,
        )  # fmt: skip


@pytest.fixture(scope="module")
def whole():
    return pz.trace(SCENE, rays_per_batch=RAYS, batches=10)


def test_a_killed_run_goes_on_to_the_same_bits(whole, tmp_path):
    killed(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [CHECKPOINT]
    left = pz.open_result(tmp_path)
    assert 0 < left.batches < 10
    again = pz.resume(tmp_path)  # to the goal that it had
    assert again.batches == 10
    assert again.tally_digest == whole.tally_digest
    assert again.summary()["ledger"] == whole.summary()["ledger"]
    assert again.info.interactions == whole.info.interactions
    again.save(tmp_path, figures=False)
    assert not (tmp_path / CHECKPOINT).exists()
    assert pz.open_result(tmp_path).tally_digest == whole.tally_digest


def test_killed_before_the_first_batch(whole, tmp_path, monkeypatch):
    def never(*_):
        raise KilledError

    with monkeypatch.context() as patch:
        patch.setattr("photizon_cl.run.batches.Local", never)
        with pytest.raises(KilledError):
            pz.trace(SCENE, rays_per_batch=RAYS, batches=10, checkpoint=tmp_path)
    with pytest.raises(pz.ResultError, match="before its first batch"):
        pz.open_result(tmp_path)
    with pytest.raises(pz.ResultError, match="found no batch"):
        pz.open_result(tmp_path / "checkpoint.nc")
    assert pz.resume(tmp_path).tally_digest == whole.tally_digest


def test_a_finished_run_goes_on(whole, tmp_path):
    pz.trace(SCENE, rays_per_batch=RAYS, batches=4).save(tmp_path, figures=False)
    assert pz.resume(tmp_path).batches == 4  # its goal is reached
    with pytest.raises(pz.ArgumentError, match="at least the 4"):
        pz.resume(tmp_path, batches=3)
    assert pz.resume(tmp_path, batches=10).tally_digest == whole.tally_digest
    assert pz.open_result(tmp_path).batches == 10  # from the checkpoint, until it is saved
    assert pz.open_result(tmp_path / "result.nc").batches == 4
    assert pz.resume(tmp_path).batches == 10


def test_a_new_target_is_the_new_goal(tmp_path):
    killed(tmp_path, after=4, target=1e-6)
    target = 0.2
    again = pz.resume(tmp_path, target=target)
    straight = pz.trace(SCENE, rays_per_batch=RAYS, target=target, max_seconds=600.0)
    assert again.tally_digest == straight.tally_digest
    assert again.scene.run.target_sigma == target


def test_killed_again_while_going_on(whole, tmp_path):
    killed(tmp_path, after=2)
    for n in (4, 6, 8):
        with pytest.raises(KilledError):
            pz.resume(tmp_path, progress=die_after(n), plan=EACH)
    assert pz.resume(tmp_path).tally_digest == whole.tally_digest


def test_an_unfinished_run_is_not_overwritten(whole, tmp_path):
    killed(tmp_path)
    for start in (
        lambda: pz.trace(SCENE, batches=2, rays_per_batch=RAYS, seed=5, checkpoint=tmp_path),
        lambda: pz.trace("cosine-fourth", batches=2, rays_per_batch=RAYS).save(tmp_path),
    ):
        with pytest.raises(pz.ResultError, match=r"holds an unfinished run of 'box-room'|unfinish"):
            start()
    assert pz.resume(tmp_path).tally_digest == whole.tally_digest


def test_a_new_run_over_an_old_result(whole, tmp_path):
    whole.save(tmp_path, figures=False)
    killed(tmp_path, scene="cosine-fourth")
    with pytest.raises(pz.ResultError, match="older result"):
        pz.open_result(tmp_path)
    assert pz.open_result(tmp_path / "result.nc").tally_digest == whole.tally_digest
    assert pz.resume(tmp_path).scene.name == "cosine-fourth"


def test_the_same_run_begun_anew_over_its_result_loses_nothing(whole, tmp_path):
    whole.save(tmp_path, figures=False)
    killed(tmp_path, after=2)
    assert pz.resume(tmp_path).batches == 10
    with pytest.raises(pz.ArgumentError, match="at least the 10"):
        pz.resume(tmp_path, batches=4)
    short = pz.trace(SCENE, rays_per_batch=RAYS, batches=3)
    with pytest.raises(pz.ResultError, match="more than these 3, and is kept"):
        short.save(tmp_path, figures=False)


def test_two_runs_do_not_write_to_one_directory(tmp_path):
    lock = Lock(tmp_path)
    with pytest.raises(pz.ResultError, match="being written to by another run"):
        pz.trace(SCENE, rays_per_batch=RAYS, batches=2, checkpoint=tmp_path)
    lock.free()
    pz.trace(SCENE, rays_per_batch=RAYS, batches=2, checkpoint=tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [CHECKPOINT]


def test_other_peoples_files_stay(whole, tmp_path):
    kept = [tmp_path / name for name in (".photizon-notes.txt", "report.html")]
    whole.save(tmp_path, figures=False)
    for file in kept:
        file.write_text("mine")
    pz.resume(tmp_path, batches=12).save(tmp_path, figures=False)
    assert [file.read_text() for file in kept] == ["mine", "mine"]


def test_a_flipped_bit_is_found_by_its_checksum(tmp_path):
    killed(tmp_path)
    file = tmp_path / CHECKPOINT
    data = file.read_bytes()
    state = pz.open_result(tmp_path).tally.state()
    place = data.index(state.mean.tobytes())
    flipped = bytearray(data)
    flipped[place + 6] ^= 1
    file.write_bytes(bytes(flipped))
    with pytest.raises(pz.ResultError, match="its bytes are not those that were written"):
        pz.resume(tmp_path)


def test_a_run_that_added_to_a_result_was_killed(whole, tmp_path):
    pz.trace(SCENE, rays_per_batch=RAYS, batches=4).save(tmp_path, figures=False)
    with pytest.raises(KilledError):
        pz.resume(tmp_path, batches=10, progress=die_after(7), plan=EACH)
    assert 4 < pz.open_result(tmp_path).batches < 10  # the further of the two
    assert pz.resume(tmp_path).tally_digest == whole.tally_digest


@pytest.mark.parametrize("name", [CHECKPOINT, "result.nc"])
def test_half_a_file_does_not_open(name, tmp_path):
    killed(tmp_path)
    if name != CHECKPOINT:
        pz.resume(tmp_path).save(tmp_path, figures=False)
    data = (tmp_path / name).read_bytes()
    for part in (0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0 - 1.0 / len(data)):
        (tmp_path / name).write_bytes(data[: int(part * len(data))])
        with pytest.raises(pz.ResultError, match="damaged"):
            pz.resume(tmp_path)


def test_what_a_killed_writer_leaves_is_swept(whole, tmp_path):
    killed(tmp_path)
    left = tmp_path / f"{TEMPORARY}abcd1234.nc"
    left.write_bytes(b"half a file")
    pz.resume(tmp_path).save(tmp_path, figures=False)
    assert not left.exists()
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "detectors.csv", "ledger.csv", "recipe.txt", "result.nc", "scene.toml", "summary.json"
    ]  # fmt: skip


def test_a_checkpoint_that_cannot_be_written_is_told(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(checkpoint, "write_state", full)
    with pytest.raises(pz.RunError, match="No space left"):
        pz.trace(SCENE, batches=2, rays_per_batch=RAYS, checkpoint=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_checkpoints_take_a_small_part_of_the_time(tmp_path, monkeypatch):
    ticks = itertools.count()
    monkeypatch.setattr(checkpoint.time, "perf_counter", lambda: 0.01 * next(ticks))
    monkeypatch.setattr(checkpoint, "_SHARE", 0.02)
    written = []
    whole = checkpoint.write_state
    monkeypatch.setattr(checkpoint, "write_state", lambda *a: (written.append(1), whole(*a)))
    killed(tmp_path, after=30, batches=40)
    # a checkpoint takes a tick at least, so that there is one in fifty ticks at most
    assert 1 <= len(written) <= 1 + next(ticks) // 50


@pytest.mark.usefixtures("few_figures")
def test_command_line(whole, tmp_path, capsys):
    killed(tmp_path)
    assert main(["resume", str(tmp_path), "--json"]) == 0
    assert whole.tally_digest in capsys.readouterr().out
    assert (tmp_path / "figures" / "ledger.png").exists()
    assert main(["resume", str(tmp_path), "--batches", "12"]) == 0
    assert "12 batches" in capsys.readouterr().out
    assert main(["resume", str(tmp_path / "nothing")]) == 2
    assert "is not there" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["resume", str(tmp_path / "empty")]) == 2
    assert "neither a result nor a checkpoint" in capsys.readouterr().err


@pytest.mark.parametrize("places", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_bits_flipped_anywhere_are_told(whole, tmp_path, monkeypatch, places):
    whole.save(tmp_path, figures=False)
    # most places hold what is derived: the run goes on, and its figures would take all the time
    monkeypatch.setattr("photizon_cl.run.directory._draw", lambda *_: set())
    data = bytearray((tmp_path / "result.nc").read_bytes())
    told = 0
    for at in range(0, len(data) - 64, len(data) // places):
        flipped = bytes(b ^ 0xA5 for b in data[at : at + 64])
        (tmp_path / "result.nc").write_bytes(data[:at] + flipped + data[at + 64 :])
        for verb in ("resume", "recipe"):
            status = main([verb, str(tmp_path)])
            assert status in (0, 2)  # never a traceback
            told += status == 2
        (tmp_path / "result.nc").write_bytes(data)
    assert told > places // 3


def test_a_full_disk_is_told(whole, tmp_path, monkeypatch):
    class Full:
        free = 1000

    monkeypatch.setattr("photizon_cl.result.file.shutil.disk_usage", lambda _: Full)
    with pytest.raises(pz.ResultError, match="No space left"):
        whole.save(tmp_path)
    with pytest.raises(pz.RunError, match="No space left"):
        pz.trace(SCENE, batches=2, rays_per_batch=RAYS, checkpoint=tmp_path / "new")
    assert not (tmp_path / "result.nc").exists()


def test_what_ended_a_run_is_said(whole, tmp_path, capsys):
    assert whole.info.stopped == "batches" == whole.summary()["stopped"]
    assert pz.trace(SCENE, rays_per_batch=RAYS, target=0.5).info.stopped == "target"
    late = pz.trace(SCENE, rays_per_batch=RAYS, target=1e-6, max_seconds=0.05)
    assert late.info.stopped == "time"
    late.save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).info.stopped == "time"
    assert main(["run", SCENE, "--target", "1e-6", "--max-seconds", "0.05"]) == 0
    assert "stopped by max_seconds after" in capsys.readouterr().out


# -- history -------------------------------------------------------------------------------------


def test_the_history_comes_back(tmp_path):
    result = pz.trace(SCENE, rays_per_batch=RAYS, batches=40, plan=EACH)
    history = result.history
    assert len(history) == 40
    assert (np.diff(history["batches"]) > 0).all()
    assert (np.diff(history["seconds"]) > 0).all()
    assert (history["rays"] == history["batches"] * RAYS).all()
    assert history[-1]["batches"] == 40
    assert history[-1]["sigma"] == result.achieved_sigma
    result.save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).history.tobytes() == history.tobytes()
    more = pz.resume(tmp_path, batches=60).history
    assert more[: len(history)].tobytes() == history.tobytes()
    assert more[-1]["batches"] == 60
    assert (np.diff(more["seconds"]) > 0).all()


def test_a_long_history_is_thinned(whole, monkeypatch):
    monkeypatch.undo()
    history = History((), 0.0)
    tally = whole.tally.copy()
    for n in range(5000):
        tally.batches = n + 2
        history.note(whole.compiled.layout, tally, float(n) + 1.0)
    batches = [row[0] for row in history.rows]
    assert 256 <= len(batches) <= 512
    assert batches == sorted(set(batches))
    assert batches[-1] == 5001


def test_a_single_batch_has_no_sigma_in_its_history(tmp_path):
    result = pz.trace(SCENE, rays_per_batch=RAYS, batches=1)
    assert math.isnan(result.history[-1]["sigma"])
    result.save(tmp_path, figures=False)
    assert pz.open_result(tmp_path).info == result.info


# -- files of earlier versions -------------------------------------------------------------------


@pytest.mark.parametrize("name", ["2026-11-22", "2026-11-22-without-history"])
def test_files_of_earlier_versions_open(name, data, tmp_path):
    stored = data / "results" / f"{name}.nc"
    shutil.copy(stored, tmp_path / "result.nc")
    result = pz.open_result(tmp_path)
    assert result.batches == 3
    assert result.tally_digest == (data / "results" / f"{name}.txt").read_text().split()[0]
    detector = result.detectors["target"]
    assert detector.power.count == 848
    assert (
        float(detector.power.value).hex()
        == (data / "results" / f"{name}.txt").read_text().split()[1]
    )
    assert len(result.history) == (0 if "without" in name else 1)
    # every number is derived anew from the exact tallies, and can be written by this version
    result.save(tmp_path / "again", figures=False)
    assert pz.open_result(tmp_path / "again").tally_digest == result.tally_digest


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), RuntimeError("HDF5")])
def test_a_checkpoint_that_cannot_be_written_is_tried_again(error, whole, tmp_path, monkeypatch):
    write, wrote = checkpoint.write_state, []

    def full_for_a_while(result, path):
        wrote.append(result.batches)
        if 2 <= len(wrote) <= 4:
            raise error
        write(result, path)

    monkeypatch.setattr(checkpoint, "write_state", full_for_a_while)
    monkeypatch.setattr(checkpoint, "_AGAIN", 0.0)
    with pytest.warns(pz.RunWarning, match="the run goes on, and it is tried again") as said:
        result = pz.trace(SCENE, rays_per_batch=RAYS, batches=10, checkpoint=tmp_path, plan=EACH)
    assert len(said) == 1  # not once for each try
    assert len(wrote) > 6
    assert result.tally_digest == whole.tally_digest
    assert pz.open_result(tmp_path).tally_digest == whole.tally_digest
    assert [p.name for p in tmp_path.iterdir()] == [CHECKPOINT]


def test_a_last_checkpoint_that_cannot_be_written_costs_no_result(whole, tmp_path, monkeypatch):
    write, wrote = checkpoint.write_state, []

    def full(result, path):
        wrote.append(result.batches)
        if len(wrote) > 1:
            raise OSError(28, "No space left on device")
        write(result, path)

    monkeypatch.setattr(checkpoint, "write_state", full)
    with pytest.warns(pz.RunWarning, match="No space left on device"):
        result = pz.trace(SCENE, rays_per_batch=RAYS, batches=10, checkpoint=tmp_path)
    assert result.tally_digest == whole.tally_digest


def test_a_first_checkpoint_that_cannot_be_written_is_told_before_the_run(tmp_path, monkeypatch):
    def full(result, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(checkpoint, "write_state", full)
    with pytest.raises(pz.RunError, match="No space left on device"):
        pz.trace(SCENE, rays_per_batch=RAYS, batches=10, checkpoint=tmp_path)
