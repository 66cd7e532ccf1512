"""The command line as shells, job systems and odd locales call it."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.parameter_paths import read_assignment
from photizon_cl.scene.presets import preset_path

QUICK = ["--batches", "2", "--rays-per-batch", "1024"]
C_LOCALE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@pytest.fixture
def run(capsys):
    """Return a function that runs a command in this process: status, output, errors."""

    def call(*arguments):
        status = main([str(a) for a in arguments])
        return status, *capsys.readouterr()

    return call


def shell(line, folder, **environment):
    """Run a line of sh in which $P is ``python -m photizon_cl``."""
    command = line.replace("$P", f"{sys.executable} -m photizon_cl")
    return subprocess.run(
        ["sh", "-c", command], cwd=folder, env={**os.environ, **environment},
        capture_output=True, timeout=120, check=False,
    )  # fmt: skip


# -- --set ----------------------------------------------------------------------------------------


def test_set_changes_the_scene_of_every_verb(run, tmp_path):
    wall = "element.wall -x.surface.reflectance=0.25"
    status, out, _ = run("check", "box-room", "--set", wall, "--set", "run.seed=9")
    assert status == 0
    assert "reflectance 0.25" in out
    assert "run: seed 9" in out
    folder = tmp_path / "out"
    assert run("run", "box-room", "--set", wall, *QUICK, "--out", folder, "--no-figures")[0] == 0
    assert pz.load(folder / "scene.toml").element["wall -x"].surface.reflectance == 0.25
    picture = tmp_path / "room.png"
    shown = run("show", "box-room", "--set", "run.generation_cap=1", "--rays", 99, "--out", picture)
    assert shown[0] == 0
    assert "reached the generation cap of 1" in shown[1]


@pytest.mark.parametrize(
    ("setting", "key", "value"),
    [
        ("source[0].axis=+z", "axis", "+z"),
        ("source[0].axis='+z'", "axis", "+z"),
        ("source[0].position=[0, 0, 0.5]", "position", (0.0, 0.0, 0.5)),
        ("source[0].position[2]=.5", "position", (0.0, 0.0, 0.5)),
        ("source[0].name=a=b", "name", "a=b"),
        ("source[0].flux = 1e-3", "flux", 1e-3),
    ],
)
def test_values_of_set(setting, key, value):
    path, read = read_assignment(setting)
    scene = pz.load("cosine-fourth").replace({"source[0].position": [0, 0, 1]})
    assert getattr(scene.replace({path: read}).source[0], key) == value


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--set", "element.flor.half_width=1"], 'element.flor.half_width: found "flor"'),
        (["--set", "element.floor.half_width=x"], 'found "x", expected a positive length'),
        (["--set", "element.floor.half_width"], "--set: found"),
        (["--set", "run.seed="], "--set: run.seed: found no value"),
        (["--set", "run.seed=1", "--set", "run.seed=2"], "--set run.seed: found two values"),
        (["--set", "run.seed=1\nx=2"], "run.seed: found"),
    ],
)
def test_a_wrong_set_is_told(arguments, said, run):
    status, out, err = run("check", "box-room", *arguments)
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_a_recipe_is_what_it_is(run):
    status, _, err = run("run", "--recipe", "x", "--set", "run.seed=2")
    assert status == 2
    assert err.startswith('--set: found ["run.seed=2"], expected nothing: the recipe')


# -- what is written and said ---------------------------------------------------------------------


def test_figures_are_left_out_where_nobody_wants_them(run_python, tmp_path):
    code = f"""
import sys
from photizon_cl.cli.main import main
call = ["run", "box-room", "--batches", "2", "--rays-per-batch", "1024"]
assert main(call) == 0
assert main([*call, "--out", {str(tmp_path / "out")!r}, "--no-figures"]) == 0
assert main(["resume", {str(tmp_path / "out")!r}, "--batches", "3", "--no-figures"]) == 0
assert "matplotlib" not in sys.modules
"""
    run_python(code)
    assert (tmp_path / "out" / "result.nc").is_file()
    assert not (tmp_path / "out" / "figures").exists()


def test_no_figures_is_said_in_vain_where_no_files_are_written(run):
    words = ("run", "box-room", "--batches", "1", "--rays-per-batch", "64", "--json")
    status, out, err = run(*words, "--no-figures")
    assert (status, err) == (0, "")
    assert json.loads(out)["batches"] == 1


def test_a_file_beside_the_name_is_told(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box-roo.toml").write_text("")
    status, _, err = run("run", "box-roo")
    assert status == 2
    assert 'did you mean "box-roo.toml", the file that is there?' in err


@pytest.mark.parametrize("table", ["run", "far_field", "scene"])
def test_tables_are_kinds(table, run):
    status, out, _ = run("kinds", table)
    assert status == 0
    assert out.startswith(f"{table}  table\n")
    wanted = {"run": "max_seconds     s     60.0", "far_field": "n_phi", "scene": "title"}[table]
    assert wanted in out
    assert f"  {table}: " in run("kinds")[1]


def test_what_steers_a_terminal_is_escaped(run, tmp_path):
    scene = pz.load("box-room").replace({"title": "left \u202e right"})
    scene.save(tmp_path / "s.toml")
    for words in (["check", tmp_path / "s.toml"], ["run", tmp_path / "s.toml", *QUICK]):
        status, out, err = run(*words)
        assert status == 0
        assert "left \\u202e right" in out
        assert "\u202e" not in out + err
    status, _, err = run("check", "box-room", "--\x1b[31m\u2066x")
    assert status == 2
    assert "\x1b" not in err
    assert "\\u001b[31m\\u2066x" in err


# -- environments ---------------------------------------------------------------------------------


def test_the_module_is_the_command(tmp_path):
    done = shell("$P presets box-room", tmp_path)
    assert done.stdout == preset_path("box-room").read_bytes()
    assert done.returncode == 0
    assert b"usage: photizon" in shell("$P --help", tmp_path).stdout


@pytest.mark.parametrize(
    ("line", "status"),
    [
        pytest.param("$P check box-room --no-pilot >&-", 0, marks=pytest.mark.slow),
        ("$P presets box-room >&-", 0),
        # the last has all three closed
        pytest.param(
            "$P run box-room --batches 2 --rays-per-batch 1024 --json >&-",
            0,
            marks=pytest.mark.slow,
        ),
        ("$P check nothing >&-", 2),
        ("$P run box-room --batches 2 --rays-per-batch 1024 --out o --no-figures <&- >&- 2>&-", 0),
    ],
)
def test_closed_streams_lead_nowhere(line, status, tmp_path):
    done = shell(line, tmp_path)
    assert done.returncode == status
    assert done.stdout == b""
    assert b"Traceback" not in done.stderr
    assert (b"expected a preset" in done.stderr) == (status == 2)
    if "--out" in line:  # what has the number of a closed stream is no file of the result
        assert pz.open_result(tmp_path / "o").batches == 2


def test_errors_do_not_go_to_a_closed_standard_error_s_neighbour(tmp_path):
    done = shell("$P check nothing 2>&-", tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, b"", b"")
    done = shell("$P check --nothing 2>&-", tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, b"", b"")


@pytest.fixture(scope="module")
def of_80_columns(tmp_path_factory):
    """Return what is printed where the width is the usual one."""
    folder = tmp_path_factory.mktemp("usual")
    return shell("$P check box-room --no-pilot", folder, COLUMNS="80").stdout


@pytest.mark.parametrize(
    "columns", ["0", *(pytest.param(c, marks=pytest.mark.slow) for c in ("1", "-3")), "wide"]
)
def test_columns_that_are_no_width(columns, of_80_columns, tmp_path):
    done = shell("$P check box-room --no-pilot", tmp_path, COLUMNS=columns)
    assert done.returncode == 0
    assert b"".join(done.stdout.split()) == b"".join(of_80_columns.split())


def test_names_that_the_locale_cannot_write(tmp_path):
    # a map, whose figures have the name, and no ladder
    names = {"element.floor.name": "größe Ω", "element.floor.detector": {"map": [4, 4]}}
    pz.load("box-room").replace({**names, "title": "Räume"}).save(tmp_path / "größe.toml")
    quick = " ".join(QUICK)
    done = shell(f"$P run größe.toml {quick} --out outö", tmp_path, **C_LOCALE)
    assert done.returncode == 0, done.stderr
    assert done.stderr == b""
    figures = os.listdir(tmp_path / "outö" / "figures")
    assert "map-größe_ω.png" in figures
    assert sorted(pz.figures.figure_names(pz.open_result(tmp_path / "outö"))) == sorted(figures)


@pytest.mark.slow
def test_files_that_the_locale_cannot_write(tmp_path):
    pz.load("box-room").replace({"title": "Räume"}).save(tmp_path / "größe.toml")
    more = "$P check nöx.toml; $P kinds größe; $P show größe.toml --rays 1"
    done = shell(more, tmp_path, **C_LOCALE)
    assert b"Traceback" not in done.stderr
    assert done.returncode == 0


@pytest.mark.slow
def test_a_report_in_a_locale_that_cannot_write_its_figures_names(tmp_path):
    scene = pz.load("box-room").replace({"element.floor.name": "größe Ω", "title": "Räume"})
    pz.trace(scene, batches=2, rays_per_batch=1024).save(tmp_path / "outö", figures=False)
    done = shell("$P report outö", tmp_path, **C_LOCALE)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (tmp_path / "outö" / "report.html").is_file()
    assert "map-größe_ω.png" in os.listdir(tmp_path / "outö" / "figures")
