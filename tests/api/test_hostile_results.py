"""Result files and recipes that are damaged or made up: refused in one line, before any work."""

from __future__ import annotations

import base64
import json
import time
import tracemalloc
import zlib
from pathlib import Path

import h5netcdf
import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result.file import _checksum
from photizon_cl.result.recipe import _PREFIX
from photizon_cl.scene.writing import to_toml

pytestmark = pytest.mark.usefixtures("built_quickly")

DATA = Path(__file__).resolve().parents[1] / "data" / "results"


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved")
    pz.trace("cosine-fourth", batches=3, rays_per_batch=512).save(folder, figures=False)
    return (folder / "result.nc").read_bytes()


def rewritten(path, change):
    """Write a file again, its tally changed by a function of its arrays and attributes.

    The checksum then fits, but where that would take long.
    """
    with h5netcdf.File(path, "r") as file:
        top = dict(file.attrs)
        group = file["tally"]
        attrs = dict(group.attrs)
        arrays = {name: v[...] for name, v in group.variables.items()}
    change(arrays, attrs, top)
    if "checksum" in attrs and sum(a.nbytes for a in arrays.values()) < 1 << 24:
        attrs["checksum"] = _checksum(arrays, attrs, str(top["scene"]))
    path.unlink()
    with h5netcdf.File(path, "w") as file:
        file.attrs.update(top)
        group = file.create_group("tally")
        for name, array in arrays.items():
            dims = tuple(f"{name}_{k}" for k in range(array.ndim))
            for dim, n in zip(dims, array.shape, strict=True):
                group.dimensions[dim] = n
            if array.nbytes > 1 << 24:  # declared, and never written
                kind = {"dtype": array.dtype, "chunks": (1 << 16, *array.shape[1:])}
                group.create_variable(name, dims, **kind)
            else:
                group.create_variable(name, dims, data=array)
        group.attrs.update(attrs)


def setting(name, place, value):
    def change(arrays, attrs, top):
        arrays[name] = arrays[name].copy()
        arrays[name][place] = value

    return change


def saying(**what):
    return lambda arrays, attrs, top: attrs.update(what)


def many(*names, n=100_000_000):
    def change(arrays, attrs, top):
        for name in names:
            kind = arrays[name].dtype if name in arrays else np.dtype("f8")
            ends = arrays[name].shape[1:] if name in arrays else ()
            arrays[name] = np.broadcast_to(kind.type(0), (n, *ends))

    return change


def without(*names):
    def change(arrays, attrs, top):
        for name in names:
            attrs.pop(name, None)
            arrays.pop(name, None)

    return change


def both(*changes):
    def change(*everything):
        for one in changes:
            one(*everything)

    return change


def one_more_watt(arrays, attrs, top):
    arrays["limbs"] = arrays["limbs"].copy()
    arrays["limbs"][0, 0] += 30
    arrays["mean"] = arrays["mean"].copy()
    arrays["mean"][0] += 30 * 2.0 / 3


def scene_text(text):
    return lambda arrays, attrs, top: top.update(scene=text)


def with_the_largest_map(arrays, attrs, top):
    """Declare, and do not hold, the cells of a scene that has very many."""
    tables = pz.load("cosine-fourth").to_dict()
    tables["element"][0]["detector"] = {"map": [8192, 8192]}
    scene = pz.load(tables)
    top["scene"] = to_toml(scene)
    n = compile_scene(scene, scene.run).layout.n_cells
    many("limbs", "count", n=n)(arrays, attrs, top)
    many("mean", "m2", n=n + 1)(arrays, attrs, top)


OLD = without("checksum", "version", "engine", "stopped")  # as the first version wrote
MADE_UP = {
    "very many cells": many("limbs", "count", "mean", "m2"),
    "very many limbs": many("limbs"),
    "an array beside them": many("junk"),
    "a long history": many("history_batches", "history_seconds", "history_sigma"),
    "a map that is not there": with_the_largest_map,
    "negative limbs": setting("limbs", (0, 1), -5),
    "limbs too large": setting("limbs", (3, 2), 2**40),
    "a negative power": setting("limbs", (2, 0), -1),
    "negative counts": setting("count", 5, -1),
    "no numbers": setting("mean", 5, np.nan),
    "an infinite mean": setting("mean", -1, np.inf),
    "another mean": setting("mean", 0, 0.25),
    "squares that are none": setting("m2", 5, np.nan),
    "negative squares": setting("m2", 5, -1e-3),
    "infinite squares": setting("m2", 5, np.inf),
    "a watt too many": one_more_watt,
    "more batches": saying(batches=np.int64(4)),
    "no batches": saying(batches=np.int64(0)),
    "minus one batch": saying(batches=np.int64(-1)),
    "half a batch": saying(batches=2.5),
    "very many batches": saying(batches=np.int64(2**62)),
    "batches in words": saying(batches="many"),
    "a short digest": saying(digest="ab"),
    "no digest": saying(digest="x" * 64),
    "a device to fool a terminal": saying(device="cpu\x1b[2J\u202e"),
    "a device without end": saying(device="x" * 50_000),
    "a time that is none": saying(seconds="nan"),
    "a negative time": saying(seconds="-0x1p+3"),
    "no end of time": saying(build_seconds="inf"),
    "negative interactions": saying(interactions="-7"),
    "interactions without end": saying(interactions="9" * 4000),
    "a closure that is none": saying(worst_closure=str(2**120)),
    "a goal that is none": saying(goal='["many", null, null]'),
    "a goal too long": saying(goal="[3, null, null, null]"),
    "a deep goal": saying(goal="[" * 30_000),
    "an unknown precision": saying(precision="fp8"),
    "an unknown end": saying(stopped="by magic"),
    "tallies that are none": saying(tallies="{}"),
    "a history that is none": setting("history_seconds", 0, np.inf),
    "a mended checksum missing": without("checksum"),
    "no limbs": without("limbs"),
    "limbs as doubles": lambda a, t, s: a.update(limbs=a["limbs"] * 1.0),
    "a scene with a key of many parts": scene_text(".".join(["a"] * 10_000) + " = 1"),
    "a scene that is none": scene_text("name = 1"),
    "a scene that is a number": scene_text(5),
}
"""Changes to a tally whose checksum then fits."""


def refused(path, capsys):
    """Return the one line that opening a file gives."""
    tracemalloc.start()
    started = time.perf_counter()
    with pytest.raises(pz.ResultError) as caught:
        pz.open_result(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert time.perf_counter() - started < 4.0
    assert peak < 60e6
    line = str(caught.value)
    assert line.isprintable()
    assert len(line) < 700
    assert main(["report", str(path.parent)]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith(line)
    assert err.count("\n") == 1
    return line


@pytest.mark.parametrize("name", MADE_UP)
def test_what_is_made_up_is_not_believed(name, saved, tmp_path, capsys):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    rewritten(path, MADE_UP[name])
    assert path.stat().st_size < 4 << 20
    line = refused(path, capsys)
    assert "damaged or not a photizon result" in line
    assert "checksum does not fit" not in line


@pytest.mark.parametrize(
    "name",
    ["negative limbs", "no numbers", "very many cells", "negative counts", "a watt too many"],
)
def test_a_tally_without_a_checksum_is_looked_at(name, saved, tmp_path, capsys):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    rewritten(path, both(OLD, MADE_UP[name]))
    refused(path, capsys)


def test_what_is_not_changed_opens(saved, tmp_path):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    before = pz.open_result(path).summary()
    rewritten(path, lambda *_: None)
    assert pz.open_result(path).summary() == before
    rewritten(path, OLD)
    assert pz.open_result(path).tally_digest == before["tally_digest"]
    for old in DATA.glob("*.nc"):
        assert pz.open_result(old).batches == 3


def test_arrays_that_are_derived_are_not_read(saved, tmp_path):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    with h5netcdf.File(path, "a") as file:
        file.dimensions["junk"] = 1_000_000_000
        file.create_variable("junk", ("junk",), dtype="f8", chunks=(1 << 20,))
    tracemalloc.start()
    assert pz.open_result(path).batches == 3
    assert tracemalloc.get_traced_memory()[1] < 60e6
    tracemalloc.stop()


# -- recipes ---------------------------------------------------------------------------------------


def token(content):
    text = content if isinstance(content, str) else json.dumps(content)
    packed = zlib.compress(text.encode(), 9)
    return _PREFIX + base64.urlsafe_b64encode(packed).rstrip(b"=").decode()


def made(**changes):
    """Return a token of a scene's tables with some of its members changed."""
    good = pz.load("box-room").to_dict()
    run = good.pop("run")
    content = {
        "scene": good, "scene_digest": "sha256:0", "run": run, "batches": 1, "precision": "fp64",
        "tally": "0" * 64, "version": "1", "engine": "0",
    }  # fmt: skip
    return token({**content, **changes})


TOKENS = {
    "64 MB of brackets": lambda: token("[" + "[]," * (2**24 - 2) + "0]"),
    "8 MB of brackets": lambda: token("[" + "[]," * 2**21 + "0]"),
    "64 MB of blanks": lambda: token(" " * 2**26 + "{}"),
    "nested deeply": lambda: token("[" * 100_000),
    "20 MB of characters": lambda: _PREFIX + "A" * 20_000_000,
    "very many elements": lambda: made(scene={"element": [0] * 200_000}),
    "batches without end": lambda: made(batches=10**400),
    "a run that is none": lambda: made(run=[1]),
    "a version to fool a terminal": lambda: made(version="\x1b[2J\u202e", scene="\x1b[2J"),
    "a scene of another digest": made,
}


@pytest.mark.parametrize("name", TOKENS)
def test_tokens_are_refused_at_once(name, tmp_path, capsys):
    text = TOKENS[name]()
    file = tmp_path / "recipe.txt"
    file.write_text(text)
    tracemalloc.start()
    started = time.perf_counter()
    status = main(["run", "--recipe", str(file)])
    assert time.perf_counter() - started < 4.0
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert status == 2
    assert peak < 150e6
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert err[:-1].isprintable()
    assert len(err) < 700
