"""``photizon sweep`` and ``photizon resume`` of a sweep."""

from __future__ import annotations

import json

import pytest
from tubes import ANGLE, WALL, WIDE, a_sweep

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.cli.progress import sweep_line
from photizon_cl.run import batches as running
from photizon_cl.studies import sweep_folder, sweeping
from photizon_cl.studies.sweep_progress import SweepClock, SweepProgress


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "angles.json"
    path.write_text(json.dumps(a_sweep(WIDE)), encoding="utf-8")
    return path


def test_it_prints_a_table(file, capsys):
    assert main(["sweep", str(file)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    lines = said.out.splitlines()
    assert lines[0] == "tube"
    assert "3 points of tube, seed 1 at every point" in lines[1]
    assert "; 1 program, " in " ".join(said.out.split())
    (head,) = (line for line in lines if line.startswith("point"))
    assert head.split() == [
        "point", "angle,", "deg", "power,", "W", "±", "σ", "share", "±", "σ", "batches",
    ]  # fmt: skip
    assert "measured too: PST" in said.out
    assert max(map(len, lines)) <= 80
    assert not list(file.parent.glob("*.nc"))


def test_json_is_the_summary(file, capsys):
    assert main(["sweep", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "photizon-sweep-result/1"
    own = pz.sweep(file).summary()
    for summary in (found, own):
        for point in summary["points"]:
            del point["seconds"]
    assert found == own
    assert found["axes"] == [
        {"name": "angle", "path": "source.sun.tilt_deg[0]", "unit": "deg", "values": [0, 4, 8],
         "together": False},
    ]  # fmt: skip
    assert found["measures"][2]["meaning"].startswith("(P/A)/(Φ/S): mean irradiance")


def test_it_goes_on(file, capsys):
    assert main(["sweep", str(file), "--out", "out", "--no-figures"]) == 0
    assert "written to out" in capsys.readouterr().out
    assert not (file.parent / "out" / "sweep.png").exists()
    whole = pz.open_sweep("out")
    # the same again
    assert main(["sweep", str(file), "--out", "out", "--no-figures"]) == 0
    assert "holds this sweep already, done: nothing is run again" in capsys.readouterr().err
    assert main(["resume", "out"]) == 0
    assert "holds a sweep that is done" in capsys.readouterr().err
    # half of it
    (file.parent / "out" / "points" / "0001" / "point.json").unlink()
    (file.parent / "out" / "points" / "0001" / "result.nc").unlink()
    assert main(["sweep", str(file), "--out", "out"]) == 2
    assert "`photizon resume` goes on with it" in capsys.readouterr().err
    assert main(["resume", "out", "--batches", "9"]) == 2
    assert "--batches: found 9, expected nothing" in capsys.readouterr().err
    assert main(["resume", "out", "--no-figures"]) == 0
    assert [p.digest for p in pz.open_sweep("out")] == [p.digest for p in whole]
    # another
    file.write_text(json.dumps(a_sweep(ANGLE)), encoding="utf-8")
    assert main(["sweep", str(file), "--out", "out"]) == 2
    assert "[[vary]] differs; give another directory" in capsys.readouterr().err
    # a point of it is a run like any other
    assert main(["compare", "out/points/0000", "out/points/0002"]) == 0
    assert "paired" in capsys.readouterr().out


def test_what_is_not_done_is_told(file, capsys):
    file.write_text(json.dumps(a_sweep({**ANGLE, "linspace": [0, 9, 120]})), encoding="utf-8")
    assert main(["sweep", str(file), "--out", "out", "--max-seconds", "0.3", "--no-figures"]) == 0
    said = capsys.readouterr()
    assert "of 120 points are not done: `photizon resume out` goes on with the sweep" in said.err
    assert "more points" in said.out


def test_a_point_that_fails(file, capsys, monkeypatch):
    go_on = running.go_on

    def fails(start, *args, **kwargs):
        if start.scene.source["sun"].tilt_deg[0] == 4.0:
            raise pz.RunError("enough")
        return go_on(start, *args, **kwargs)

    monkeypatch.setattr(sweeping, "go_on", fails)
    assert main(["sweep", str(file)]) == 1
    said = capsys.readouterr()
    assert "photizon: point 1 (angle = 4) failed: enough" in said.err
    assert "1 of 3 point is not done" in said.err
    assert " failed " in said.out


def test_a_disk_that_is_full_ends_the_sweep_and_it_goes_on(file, capsys, monkeypatch):
    save = sweep_folder.save

    def full(result, home, **how):
        if home.name == "0001":
            raise pz.ResultError("no space left on the device")
        save(result, home, **how)

    monkeypatch.setattr(sweep_folder, "save", full)
    assert main(["sweep", str(file), "--out", "out", "--no-figures"]) == 1
    said = capsys.readouterr().err
    assert "no space left on the device; the sweep ends at point 1: `photizon resume`" in said
    monkeypatch.setattr(sweep_folder, "save", save)
    assert main(["resume", "out", "--no-figures"]) == 0
    assert pz.open_sweep("out").finished


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([""], "FILE: found nothing"),
        (["angles.json", "--out", ""], "--out: found nothing, expected a directory"),
        (["angles.json", "--max-seconds", "0"], "--max-seconds: found 0.0, expected a positive"),
        (["angles.json", "--device", "no such one", "--out", "out"], "device: "),
        (["angles.json", "--out", "angles.json"], '"angles.json" is a file'),
        (["."], 'found a directory, expected a sweep file'),
    ],
)  # fmt: skip
def test_bad_arguments(words, said, file, capsys):
    assert main(["sweep", *words]) == 2
    assert said in capsys.readouterr().err
    assert not (file.parent / "out").exists()


def test_only_detectors_and_what_escapes_are_printed_where_no_measure_is_named(file, capsys):
    file.write_text(json.dumps(a_sweep(WALL, measure={})), encoding="utf-8")
    assert main(["sweep", str(file)]) == 0
    out = capsys.readouterr().out
    assert " sensor.power, W " in out
    assert "reflectance: element.tube.surface.reflectance" in out
    assert "measured too: ledger.absorbed.tube, ledger.absorbed.sensor" in out


def test_the_line_of_progress():
    now = SweepProgress(60, 12, 12, "angle = 6", None, 24.0, 96.0)
    assert sweep_line(now) == "12 of 60 points done  96 s left  point 12: angle = 6"
    assert sweep_line(SweepProgress(60, 0, -1, "looking", None, 0.0, None)) == "looking"


def test_the_time_left_is_that_of_the_whole_job(monkeypatch):
    from photizon_cl.studies import sweep_progress

    now = [0.0]
    monkeypatch.setattr(sweep_progress.time, "perf_counter", lambda: now[0])
    clock = SweepClock(None)
    assert clock.eta(3, None) is None  # nothing is known yet
    clock.begin()
    now[0] = 2.0
    clock.end()
    clock.begin()
    now[0] = 2.5  # half a second into the second of four
    assert clock.eta(2, None) == pytest.approx(1.5 + 2 * 2.0)
    limited = SweepClock(3.0)
    limited.took = [2.0]
    assert limited.eta(2, None) == pytest.approx(3.0)
