"""The command line: exit statuses, what goes where, messages instead of tracebacks."""

from __future__ import annotations

import dataclasses
import importlib
import json
import os
import subprocess
import sys

import pytest
from malformed import CASES, edited

import photizon_cl as pz
from photizon_cl.cli.main import VERBS, main
from photizon_cl.compile.effects.table import EFFECT_ROWS as EFFECTS
from photizon_cl.errors import show
from photizon_cl.scene.described import Described, parameters_of, shown_default
from photizon_cl.scene.presets import preset_path, presets
from photizon_cl.scene.registry import (
    COATINGS,
    DETECTORS,
    DISPERSIONS,
    ELEMENTS,
    MEDIA,
    SCATTERS,
    SOURCES,
    SURFACES,
)

pytestmark = pytest.mark.usefixtures("built_quickly")

RUN = ["run", "box-room", "--batches", "2", "--rays-per-batch", "1024"]


@pytest.fixture
def run(capsys):
    """Return a function that runs a command in this process: status, output, errors."""

    def call(*arguments):
        status = main([str(a) for a in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return status, out, err

    return call


def process(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "photizon_cl.cli.main", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        **options,
    )


# -- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize("verb", ["check", "run"])
@pytest.mark.parametrize(("name", "changes", "expected"), CASES, ids=[name for name, _, _ in CASES])
def test_malformed_scenes(verb, name, changes, expected, run, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(edited(changes)), encoding="utf-8")
    status, out, err = run(verb, path)
    assert status == 2
    assert out == ""
    lines = err.splitlines()
    assert len(lines) == len(expected)
    for line, (where, found, wanted) in zip(lines, expected, strict=True):
        assert line.startswith(f"{path}: {where}: found {found}, expected {wanted}")


@pytest.mark.parametrize(
    ("content", "suffix"),
    [
        (b"", ".toml"),
        (b"a = = 1", ".toml"),
        (b'name = "caf\xe9"', ".toml"),
        (b"{", ".json"),
        (b"x", ".txt"),
    ],
)
def test_unreadable_scenes(content, suffix, run, tmp_path):
    path = tmp_path / f"scene{suffix}"
    path.write_bytes(content)
    status, out, err = run("run", path)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(str(path))
    if suffix == ".txt":  # and so in a process of its own
        done = process("run", path)
        assert (done.returncode, done.stdout, done.stderr) == (2, "", err)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "VERB"),
        (["ru"], "invalid choice"),
        (["polish", "x"], "invalid choice"),
        (["run"], "SCENE"),
        (["run", "no-such-scene"], "neither a preset nor a file"),
        (["run", "box-room", "--batches", "two"], "expected an integer"),
        (["run", "box-room", "--batches", "0"], "batches: found 0"),
        (["run", "box-room", "--target", "x"], "expected a number"),
        (["run", "box-room", "--target", "nan"], "target_sigma"),
        (["run", "box-room", "--target", "2"], "target_sigma"),
        (["run", "box-room", "--batches", "1", "--target", "0.1"], "not allowed with"),
        (["run", "box-room", "--seed", "-1"], "seed"),
        (["run", "box-room", "--max-seconds", "0"], "max_seconds"),
        (["run", "box-room", "--rays-per-batch", "99999999"], "rays_per_batch"),
        (["run", "box-room", "--device", "no such device"], "no device matches"),
        (["run", "box-room", "--precision", "fp16"], "precision"),
        (["run", "box-room", "--batch", "3"], "unrecognized"),
        (["run", "box-room", "--out", ""], "--out"),
        (["run", "box-room", "--colour"], "unrecognized"),
        (["check"], "SCENE"),
    ],
)  # fmt: skip
def test_bad_arguments(arguments, message, run):
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert message in err


def test_out_is_refused_before_anything_runs(run, tmp_path):
    (tmp_path / "thesis.tex").write_text("text")
    status, out, err = run(*RUN, "--out", tmp_path)
    assert (status, out) == (2, "")
    assert "holds files and no photizon result" in err
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    ("arguments", "lost"),
    [
        (["cosine-fourth"], "'box-room' with seed 1, which"),
        (["box-room", "--seed", "2"], "'box-room' with seed 1, which"),
        (["box-room", "--rays-per-batch", "512"], "'box-room' with seed 1, of other settings"),
        (["box-room", "--rays-per-batch", "2048"], None),
    ],
)
def test_losing_the_result_of_another_run_is_said(arguments, lost, run, room, tmp_path):
    room.save(tmp_path, figures=False)
    status, _, err = run("run", *arguments, "--batches", "11", "--no-figures", "--out", tmp_path)
    assert status == 0
    assert pz.open_result(tmp_path).batches == 11
    assert f"holds the result of {lost}" in err if lost else "holds the result" not in err


def test_a_shorter_run_leaves_nothing_unfinished(run, tmp_path):
    again = [*RUN[:2], "--rays-per-batch", "64", "--no-figures", "--out", tmp_path]
    assert run(*again, "--batches", "4")[0] == 0
    status, _, err = run(*again, "--batches", "2")
    assert status == 1
    assert "is kept" in err
    assert not (tmp_path / "checkpoint.nc").exists()
    assert run("run", "cosine-fourth", "--batches", "2", "--no-figures", "--out", tmp_path)[0] == 0


# -- success ---------------------------------------------------------------------------------------


def test_json_is_the_summary_and_nothing_else(run):
    status, out, err = run(*RUN, "--json", "--seed", "3")
    assert (status, err) == (0, "")
    summary = json.loads(out)
    expected = pz.trace("box-room", batches=2, rays_per_batch=1024, seed=3).summary()
    for key in ("seconds", "build_seconds", "forecast"):
        del summary[key], expected[key]
    assert summary == expected


def test_out_holds_the_result(run, tmp_path):
    folder = tmp_path / "out"
    for more in (["--no-figures"], []):  # the second run replaces the first
        status, out, _ = run(*RUN, *more, "--out", folder)
        assert status == 0
        assert str(folder) in out
    assert {p.name for p in folder.iterdir()} == {
        "summary.json", "scene.toml", "result.nc", "recipe.txt", "figures", "ledger.csv",
        "detectors.csv",
    }  # fmt: skip
    assert (folder / "figures" / "map-floor.png").exists()
    assert pz.open_result(folder).batches == 2
    assert run("check", folder / "scene.toml")[0] == 0


def test_the_ledger_fits_a_terminal(run):
    status, out, err = run(*RUN)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    for word in (
        "emitted",
        "absorbed by wall -x",
        "escaped",
        "closure",
        "generation 3",
        "advisory",
    ):
        assert word in out
    assert "1 / 1" not in out


def test_advisories_are_said_once(run, tmp_path):
    tables = pz.load("ghost-ladder").to_dict()
    mirror = {
        "name": "aside", "kind": "rectangle", "position": [100.0, 0.0, 0.0], "axis": "+x",
        "half_width": 1.0, "half_height": 1.0, "surface": {"kind": "mirror", "reflectance": 0.5},
    }  # fmt: skip
    tables["element"].append(mirror)
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(tables))
    advisories = pz.advisories(pz.load(path))
    assert any("splits a ray in two" in text for text in advisories)
    status, out, err = run("run", path, "--batches", "1", "--rays-per-batch", "64")
    assert status == 0
    said = " ".join((err + out).split())
    assert [said.count(text) for text in advisories] == [1] * len(advisories)
    assert "advisory: a single batch" in said


def test_names_are_never_markup(run, tmp_path):
    tables = pz.load("cosine-fourth").to_dict()
    tables["title"] = "[red]title[red] :smile:"
    tables["element"][0]["name"] = "[bold]x[bold] :smile:"
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(tables))
    for command in (["check", path], ["run", path, "--batches", "2", "--rays-per-batch", "64"]):
        status, out, _ = run(*command)
        assert status == 0
        assert "[bold]x[bold] :smile:" in out
        assert "[red]title[red] :smile:" in out


@pytest.mark.parametrize("preset", [p.name for p in presets().values()])
def test_check_prints_what_follows(preset, run):
    pilot = preset == "integrating-sphere"
    status, out, err = run("check", preset, *([] if pilot else ["--no-pilot"]))
    assert (status, err) == (0, "")
    assert "advisories" in out
    assert ("pilot: 512 rays" in out) is pilot
    assert max(map(len, out.splitlines()[:-1])) <= 80
    if preset == "integrating-sphere":
        assert "sphere multiplier 6.8965" in " ".join(out.split())
        assert "m²" in out


def test_presets_are_listed_with_their_anchors(run):
    status, out, _ = run("presets")
    assert status == 0
    text = " ".join(out.split())
    for preset in presets().values():
        assert preset.name in out
        assert preset.anchor in text


def test_devices_are_listed(run):
    status, out, _ = run("devices")
    assert status == 0
    assert "usable" in out
    assert "chosen:" in out


def test_help_and_version(run):
    assert run("--help")[0] == 0
    assert run("--version")[1] == f"photizon {pz.__version__}\n"
    assert "--rays-per-batch" in run("run", "--help")[1]


def test_a_reader_that_had_enough():
    command = f"'{sys.executable}' -m photizon_cl.cli.main presets | head -1"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("cosine-fourth")
    assert done.stderr == ""


def test_a_terminal_without_unicode():
    done = process(*RUN, env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"})
    assert done.returncode == 0, done.stderr
    assert "absorbed by floor" in done.stdout


def test_no_device_at_all_is_a_failed_run_with_the_remedy(tmp_path):
    empty = tmp_path / "none.icd"
    empty.write_text("")
    done = process(*RUN, env={**os.environ, "OCL_ICD_VENDORS": str(empty)})
    assert done.returncode == 1
    assert "apt install pocl-opencl-icd" in done.stderr
    assert "Traceback" not in done.stderr


# -- what there is ---------------------------------------------------------------------------------


@pytest.mark.parametrize("preset", [p.name for p in presets().values()])
def test_a_preset_is_printed_byte_for_byte(preset):
    done = subprocess.run(
        [sys.executable, "-m", "photizon_cl.cli.main", "presets", preset],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        check=True,
    )
    assert done.stdout == preset_path(preset).read_bytes()
    assert done.stderr == b""


def test_a_preset_that_does_not_exist(run):
    status, out, err = run("presets", "box-rom")
    assert (status, out) == (2, "")
    assert err.startswith('NAME: found "box-rom", expected the name of a preset: one of cosine')
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("group", ["source", "sources", "elements", "surface"])
def test_kinds_lists_a_group(group, run):
    status, out, err = run("kinds", group)
    assert (status, err) == (0, "")
    assert out.startswith(f"{group.removesuffix('s')}s\n")
    everything = run("kinds")[1]
    assert out.strip() in everything
    for other in {"sources", "elements", "surfaces", "tables"} - {group.removesuffix("s") + "s"}:
        assert f"\n{other}\n" not in out


def test_what_may_have_been_meant_by_a_file_is_said(run, tmp_path):
    (tmp_path / "lamp.toml").write_text("")
    status, _, err = run("run", tmp_path / "lamb.toml")
    assert status == 2
    assert 'did you mean "lamp.toml"?' in err
    assert 'did you mean the preset "box-room"?' in run("check", "box-rom.toml")[2]
    assert "check the path, or see the presets" in run("check", "zzz.toml")[2]


def test_a_scenes_advisories_stand_before_the_run(run, tmp_path):
    text = pz.load("cosine-fourth").to_dict()
    text["element"][0] |= {"detector": {"side": "back"}}
    pz.load(text).save(tmp_path / "dark.toml")
    status, out, err = run("run", tmp_path / "dark.toml", "--batches", "2")
    assert status == 0
    assert err.startswith("advisory: ")
    assert "faces away from every source" in err
    assert "faces away from every source" not in out
    assert run("run", tmp_path / "dark.toml", "--batches", "2", "--json")[2] == ""


GROUPS = (SOURCES, ELEMENTS, SURFACES, SCATTERS, COATINGS, DETECTORS, MEDIA, DISPERSIONS)


def test_kinds_lists_all_that_a_scene_can_hold(run):
    status, out, err = run("kinds")
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    for group in GROUPS:
        for kind, cls in group.items():
            assert sum(line.startswith(f"  {kind}: ") for line in lines) >= 1
            assert all(name in out for name in parameters_of(cls))
    for effect in EFFECTS.values():
        if "." not in effect.name:
            assert f"  {effect.name}: {effect.what}"[:70] in out
    text = " ".join(out.split())
    assert "half_width (m), length (m), baffles = 0, clear_half_width (m) = none" in text
    assert "index, index_outside = 1.0" in text


@pytest.mark.parametrize(
    ("label", "kind", "cls"),
    [(c.label, k, c) for group in GROUPS for k, c in group.items()],
)
def test_a_kind_is_described(label, kind, cls, run):
    status, out, err = run("kinds", kind)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert f"\n{kind}  {label}\n" in f"\n{out}"
    text = " ".join(out.split())
    head = cls.__doc__.partition("\n\n")[0].replace("`", "")
    assert " ".join(head.split()) in text
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line[:1].strip()}
    for name, parameter in parameters_of(cls).items():
        if parameter.unit:
            assert rows[name][1] == parameter.unit
        default = shown_default(cls, name)
        if isinstance(default, Described):  # as a file has it
            default = default.to_table()
        plain = {dataclasses.MISSING: "required", None: "none"}
        shown = show(default) if isinstance(default, dict) else plain.get(default, show(default))
        at = 2 if parameter.unit else 1
        assert " ".join(rows[name][at:]).startswith(shown + " ")
    if not parameters_of(cls):
        assert "It takes no parameters." in out


def test_an_effect_is_described(run):
    assert run("kinds", "roulette")[1].startswith("roulette  effect\n")


def test_a_kind_that_does_not_exist(run):
    status, out, err = run("kinds", "spher")
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith('KIND: found "spher", expected one of sources: isotropic-point, ')
    assert "did you mean sphere?" in err
    for kind in (*SOURCES, *ELEMENTS, *SURFACES):
        assert kind in err


def test_every_verb_is_a_module_with_its_two_functions():
    for name, does, module in VERBS:
        verb = importlib.import_module(module)
        assert module == f"photizon_cl.cli.{name}"
        assert callable(verb.add_arguments)
        assert callable(verb.call)
        assert does


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["run", "x", "--seed", "q"]])
def test_help_and_bad_arguments_import_next_to_nothing(arguments, run_python):
    code = f"""
import sys
from photizon_cl.cli.main import main
main({arguments!r})
heavy = {{"numpy", "rich", "mako", "pyopencl", "matplotlib", "xarray"}} & set(sys.modules)
assert not heavy, heavy
verbs = {{m for m in sys.modules if m.startswith("photizon_cl.cli.")}}
assert verbs <= {{f"photizon_cl.cli.{{n}}" for n in ("main", "run", "arguments", "workers")}}, verbs
"""
    run_python(code)
