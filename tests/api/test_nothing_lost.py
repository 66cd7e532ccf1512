"""What a result, a report or a drawing may be written over: nothing but files of ours."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import photizon_cl as pz
from photizon_cl import atomic
from photizon_cl.atomic import TEMPORARY, Lock, replacing, sweep
from photizon_cl.cli.main import main
from photizon_cl.result import csv_tables
from photizon_cl.run.directory import CHECKPOINT, steady
from photizon_cl.scene.writing import to_toml
from photizon_cl.views.figures import draw_ledger, write_all

pytestmark = pytest.mark.usefixtures("built_quickly")

ROOT = Path(__file__).resolve().parents[2]
MINE = "# mine\n"
NAMES = ["scene.toml", "summary.json", "ledger.csv", "detectors.csv", "recipe.txt"]
LIKE_OTHERS = ("scene.toml", "detectors.csv", "recipe.txt")


def content(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if not p.is_dir()}


def run_out(folder, *more):
    return main(["run", "box-room", "--batches", "2", "--rays-per-batch", "64", "--out",
                 str(folder), *more])  # fmt: skip


@pytest.fixture(scope="module")
def small():
    return pz.trace("box-room", batches=2, rays_per_batch=64)


# -- files of the user's ---------------------------------------------------------------------------


@pytest.mark.parametrize("names", [["scene.toml"], NAMES, ["summary.json"], ["figures"]])
def test_a_run_into_a_directory_of_the_users_own_files(names, small, tmp_path, capsys):
    for name in names:
        (tmp_path / name).write_text(MINE)
    if "scene.toml" in names:
        (tmp_path / "scene.toml").write_text(MINE + to_toml(pz.load("box-room")))
    before = content(tmp_path)
    assert run_out(tmp_path) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f'"{names[0]}"' in line
    assert "give another directory, or move" in line
    with pytest.raises(pz.ResultError, match="did not write"):
        small.save(tmp_path, figures=False)
    with pytest.raises(pz.ResultError, match="did not write"):
        pz.trace("box-room", batches=1, rays_per_batch=64, checkpoint=tmp_path)
    assert content(tmp_path) == before


@pytest.mark.usefixtures("few_figures")
@pytest.mark.parametrize(
    "name",
    [
        # a table, the summary and a figure: one rule for all files
        *(pytest.param(n, marks=pytest.mark.slow if n in LIKE_OTHERS else ()) for n in NAMES),
        "figures/ledger.png",
        pytest.param("figures/convergence.png", marks=pytest.mark.slow),
    ],
)
def test_what_was_changed_since_is_the_users(name, small, tmp_path, capsys):
    small.save(tmp_path, figures="figures" in name)
    file = tmp_path / name
    if file.suffix == ".png":
        file.write_bytes(b"\x89PNG drawn by hand")
    else:
        file.write_text(file.read_text("utf-8").replace("1", "2", 1), encoding="utf-8")
    before = content(tmp_path)
    assert run_out(tmp_path) == 2
    assert f'"{name}"' in capsys.readouterr().err
    assert main(["resume", str(tmp_path), "--batches", "3"]) == 2
    with pytest.raises(pz.ResultError, match="changed since"):
        small.save(tmp_path, figures=False)
    assert content(tmp_path) == before
    file.unlink()
    small.save(tmp_path, figures=False)


def test_copies_of_ours_without_a_result_beside_them_are_kept(small, tmp_path):
    small.save(tmp_path / "run", figures=False)
    for name in NAMES:
        alone = tmp_path / name
        alone.mkdir()
        shutil.copy(tmp_path / "run" / name, alone / name)
        if name != "summary.json":
            with pytest.raises(pz.ResultError, match="did not write"):
                small.save(alone, figures=False)


@pytest.mark.usefixtures("few_figures")
def test_where_the_arrays_alone_were_removed_a_result_may_be_written(small, tmp_path):
    small.save(tmp_path)
    (tmp_path / "result.nc").unlink()
    small.save(tmp_path)
    assert pz.open_result(tmp_path).tally_digest == small.tally_digest


def test_another_scenes_result_is_replaced_only_where_it_is_asked_for(small, tmp_path):
    small.save(tmp_path, figures=False)
    before = content(tmp_path)
    others = [
        pz.trace("cosine-fourth", batches=2, rays_per_batch=64),
        pz.trace("box-room", batches=2, rays_per_batch=64, seed=2),
    ]
    for other in others:
        with pytest.raises(pz.ResultError, match=r"'box-room' with seed 1, and is kept.*replace=T"):
            other.save(tmp_path, figures=False)
        assert content(tmp_path) == before
    small.refine(batches=3).save(tmp_path, figures=False)  # the same run, longer
    others[0].save(tmp_path, figures=False, replace=True)
    assert pz.open_result(tmp_path).tally_digest == others[0].tally_digest


def test_another_engines_batches_are_told_as_anothers(small, tmp_path, monkeypatch, capsys):
    small.save(tmp_path, figures=False)
    monkeypatch.setattr("photizon_cl.run.directory.engine_digest", lambda: "other")
    with pytest.raises(pz.ResultError, match="by another version of the engine, and is kept"):
        small.save(tmp_path, figures=False)
    assert run_out(tmp_path, "--no-figures") == 0
    assert "which this run's will replace" in capsys.readouterr().err


@pytest.mark.usefixtures("few_figures")
def test_figures_and_drawings_are_not_written_over_pictures(small, tmp_path, capsys):
    for form in ("png", "svg"):
        file = tmp_path / f"box.{form}"
        for _ in range(2):  # a drawing is replaced by a drawing
            assert main(["show", "box-room", "--rays", "2", "--out", str(file)]) == 0
        capsys.readouterr()
        file.write_bytes(b"photograph")
        assert main(["show", "box-room", "--rays", "2", "--out", str(file)]) == 2
        assert "no photizon figure" in capsys.readouterr().err
        assert file.read_bytes() == b"photograph"
    (tmp_path / "drawn").mkdir()
    write_all(small, tmp_path / "drawn")
    write_all(small, tmp_path / "drawn")
    draw_ledger(small).savefig(tmp_path / "drawn" / "ledger.png")  # changed by the user
    with pytest.raises(pz.ArgumentError, match="no photizon figure"):
        write_all(small, tmp_path / "drawn")
    assert main(["stability", "--family", "fresnel", "--figure", str(tmp_path / "box.png")]) == 2


# -- links ---------------------------------------------------------------------------------------


def test_no_link_is_written_through(small, tmp_path, capsys):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    for name in (f"{TEMPORARY}lock", CHECKPOINT, "result.nc", *NAMES):
        folder = tmp_path / f"in {name}"
        folder.mkdir()
        (folder / name).symlink_to(victim)
        assert run_out(folder) == 2, name
        (line,) = capsys.readouterr().err.splitlines()
        assert name in line or "damaged" in line
        with pytest.raises(pz.ResultError):
            small.save(folder, figures=False)
        assert victim.read_text() == "precious", name
    drawing = tmp_path / "drawing.png"
    drawing.symlink_to(victim)
    assert main(["show", "box-room", "--rays", "2", "--out", str(drawing)]) == 2
    assert "symbolic link" in capsys.readouterr().err
    assert victim.read_text() == "precious"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_lock_that_is_no_file(small, tmp_path):
    lock = tmp_path / f"{TEMPORARY}lock"
    os.mkfifo(lock)
    with pytest.raises(pz.ResultError, match="no regular file"):
        small.save(tmp_path, figures=False)
    lock.unlink()
    victim = tmp_path.parent / f"{tmp_path.name}-linked"
    victim.write_text("precious")
    os.link(victim, lock)
    small.save(tmp_path, figures=False)
    assert victim.read_text() == "precious"


# -- runs beside others --------------------------------------------------------------------------


def test_a_result_is_not_saved_over_a_run_under_way(small, tmp_path):
    seen = []

    def meanwhile(_):
        if not seen:
            before = content(tmp_path)
            with pytest.raises(pz.ResultError, match="being written to by another run"):
                small.save(tmp_path, figures=False)
            seen.append(content(tmp_path) == before)

    pz.trace("box-room", batches=2, rays_per_batch=64, checkpoint=tmp_path, progress=meanwhile)
    assert seen == [True]
    assert (tmp_path / CHECKPOINT).exists()


def test_of_two_that_wait_for_a_lock_one_gets_it(tmp_path):
    first = Lock(tmp_path)
    handle = os.open(tmp_path / f"{TEMPORARY}lock", os.O_RDONLY)  # another, about to lock it
    first.free()
    second = Lock(tmp_path)
    # what the other has open is no longer the lock
    assert not os.path.samestat(os.fstat(handle), os.stat(tmp_path / f"{TEMPORARY}lock"))
    os.close(handle)
    with pytest.raises(BlockingIOError):
        Lock(tmp_path)
    first.free()  # does nothing to the second's
    assert (tmp_path / f"{TEMPORARY}lock").exists()
    second.free()
    assert not list(tmp_path.iterdir())


def test_a_reader_beside_a_run_that_ends(small, tmp_path):
    longer = small.refine(batches=4)
    small.save(tmp_path / "a", figures=False)
    longer.save(tmp_path / "b", figures=False)
    here = tmp_path / "result.nc"
    shutil.copy(tmp_path / "a" / "result.nc", here)
    done = threading.Event()

    def write():
        n = 0
        while not done.is_set():
            n += 1
            with replacing(here) as temporary:
                shutil.copy(tmp_path / "ab"[n % 2] / "result.nc", temporary)
            (tmp_path / CHECKPOINT).unlink(missing_ok=True)
            shutil.copy(tmp_path / "a" / "result.nc", tmp_path / ".made")
            os.replace(tmp_path / ".made", tmp_path / CHECKPOINT)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        for _ in range(25):
            assert pz.open_result(tmp_path).batches in (2, 4)
    finally:
        done.set()
        writer.join()


def test_a_directory_that_changed_is_read_again(tmp_path):
    file = tmp_path / "result.nc"
    file.write_text("one")
    tries = []

    def look():
        tries.append(1)
        if len(tries) == 1:
            (tmp_path / "new").write_text("two, and longer")
            os.replace(tmp_path / "new", file)
            raise pz.ResultError("damaged")
        return "read"

    assert steady(tmp_path, look) == "read"
    with pytest.raises(pz.ResultError):
        steady(tmp_path, lambda: tries.append(1) or exec("raise ResultError", vars(pz)))
    assert len(tries) == 3  # what does not change is read once


# -- what killed writers leave --------------------------------------------------------------------


def old(path):
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(b"half a file")
    os.utime(path, (time.time() - 60.0,) * 2)
    return path


@pytest.mark.usefixtures("few_figures")
def test_every_writer_clears_what_killed_ones_left(small, tmp_path, capsys):
    left = [f"{TEMPORARY}abcd1234.nc", f"figures/{TEMPORARY}abcd1234.png", f"{TEMPORARY}abcd1234"]
    small.save(tmp_path, figures=False)
    kept = old(tmp_path / "notes" / f"{TEMPORARY}abcd1234.nc")
    for write in (
        lambda: small.save(tmp_path, figures=False),
        lambda: main(["report", str(tmp_path)]),
        lambda: main(["resume", str(tmp_path), "--batches", "3"]),
    ):
        made = [old(tmp_path / name) for name in left]
        (tmp_path / f"{TEMPORARY}lock").write_text("")  # of a killed run
        write()
        assert not [p for p in made if p.exists()]
        assert not (tmp_path / f"{TEMPORARY}lock").exists()
    drawn = old(tmp_path / "drawn" / f"{TEMPORARY}abcd1234.svg")
    file = str(drawn.parent / "a.svg")
    assert main(["show", "box-room", "--rays", "2", "--out", file]) == 0
    assert not drawn.exists()
    assert kept.exists()
    capsys.readouterr()


def test_what_a_living_writer_holds_is_not_swept(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic, "_YOUNG", -1.0)
    for name in ("page.html", "result.nc"):
        with replacing(tmp_path / name) as temporary:
            temporary.write_text("half")
            sweep(tmp_path, held=False)
            assert temporary.exists()
            temporary.write_text("whole")
        assert (tmp_path / name).read_text() == "whole"
    foreign = tmp_path / f"{TEMPORARY}abcd1234.txt"
    foreign.symlink_to(tmp_path / "page.html")
    sweep(tmp_path, held=True)
    assert foreign.is_symlink()


# -- spreadsheets ----------------------------------------------------------------------------------

FORMULAS = ["=1+1", "+1", "-1", "@sum", "'=1", "\uff1d1", "-lamp"]


def test_names_are_no_formulas_and_numbers_are_numbers(tmp_path):
    tables = pz.load("cosine-fourth").to_dict()
    target = tables["element"][0]
    names = [*FORMULAS, "lamp", "a=b", "'quoted'"]
    tables["element"] = [
        {**target, "name": name, "position": [0.0, 0.0, -float(n)]} for n, name in enumerate(names)
    ]
    result = pz.trace(tables, batches=2, rays_per_batch=64)
    result.save(tmp_path, figures=False)
    with open(tmp_path / "detectors.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = [row["detector"] for row in rows if row["generation"] == ""]
    assert found == [f"'{name}" for name in FORMULAS] + names[len(FORMULAS) :]
    assert [float(row["value_W"]) for row in rows if row["generation"] == ""] == [
        d.power.value for d in result.detectors.values()
    ]
    for file in tmp_path.glob("*.csv"):
        for row in csv.reader(file.read_text("utf-8").splitlines()[1:]):
            for cell in row:
                assert cell[:1] not in tuple("=+-@\t\r") or float(cell) < 0
    result.save(tmp_path, figures=False)  # the tables are known as ours
    assert json.loads((tmp_path / "summary.json").read_text("utf-8")) == result.summary()


def test_negative_numbers_have_no_apostrophe():
    assert csv_tables.csv_text(("a",), [("-x", -1.5, -2)]) == "a\n'-x,-1.5,-2\n"
    for cell in ("\t1", " =1", "'' @x"):  # no names, but labels of effects are anybody's
        assert csv_tables._plain(cell) == f"'{cell}"


# -- a day of it ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_reports_beside_runs_that_end(tmp_path):
    """A report asked for again and again while runs begin and end is never told of damage."""
    code = (
        "import sys, photizon_cl as pz\n"
        "for n in range(2, 14):\n"
        "    f = sys.argv[1]\n"
        "    r = pz.trace('box-room', batches=n, rays_per_batch=2048, checkpoint=f)\n"
        "    r.save(f, figures=False)\n"
    )
    told, read = [], 0
    with subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    ) as run:
        while run.poll() is None:
            try:
                pz.open_result(tmp_path)
                read += 1
            except pz.ResultError as error:
                told.append(str(error))
        assert run.returncode == 0, run.stderr and run.stderr.read()
    assert read > 20
    assert not [text for text in told if "damaged" in text]
