"""Kept kernels are trusted only where they are whole, and never again where a process died of them.

The slow tests replay what was found: caches damaged in every way, and single bits flipped.
"""

from __future__ import annotations

import dataclasses
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import warnings
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from hostcode.device import kept_kernels, kernel_cache
from hostcode.errors import CacheWarning
from hostcode.program.build import OPTIONS

ROOT = Path(__file__).resolve().parents[2]
TEXT = """
__kernel void twice(__global long *numbers) {{
    numbers[get_global_id(0)] *= {factor};
    if (numbers[0] == {case}) numbers[0] = 0;
}}
"""


@pytest.fixture
def program(device, request):
    """Give a program of this test alone: its key, and a function that builds and runs it."""
    # of another text, not of another comment: PoCL takes no notice of those
    text = TEXT.format(factor=2, case=hash((request.node.name, os.getpid())) % 2**31 + 1)
    key = kept_kernels.program_key(device, text, OPTIONS)

    def run(opened=device):
        import pyopencl as cl

        built = kept_kernels.build(opened, key, text, OPTIONS)
        numbers = np.arange(4)
        buffer = cl.Buffer(
            opened.context, cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR, hostbuf=numbers
        )
        kernel = cl.Kernel(built, "twice")
        kernel.set_args(buffer)
        cl.enqueue_nd_range_kernel(opened.queue, kernel, (4,), (1,))
        cl.enqueue_copy(opened.queue, numbers, buffer)
        kept_kernels.keep(key)
        return numbers.tolist() == [0, 2, 4, 6]

    yield key, run
    kept_kernels._known.pop(key, None)
    kept_kernels._file(key).unlink(missing_ok=True)


def forget(key):
    """Be as another process, in which nothing is compiled."""
    known = kept_kernels._known.pop(key)
    for folder in known.folders:
        shutil.rmtree(kernel_cache.place().running / folder)


@pytest.fixture
def pocl_only(device):
    if not device.record.is_pocl:
        pytest.skip("the driver keeps its binaries itself")


def test_what_the_environment_adds_to_builds_makes_other_kernels(device, pocl_only, monkeypatch):
    key = kept_kernels.program_key(device, TEXT, OPTIONS)
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable")
    quick = kept_kernels.program_key(device, TEXT, OPTIONS)
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "")
    assert kept_kernels.program_key(device, TEXT, OPTIONS) == key != quick


def test_they_are_not_those_that_this_process_built_before(pocl_only, program, monkeypatch):
    key, run = program
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable")
    assert run()
    quick = kept_kernels._known.pop(key).folders
    monkeypatch.delenv("POCL_EXTRA_BUILD_FLAGS")
    assert run()
    assert kept_kernels._known[key].folders
    assert kept_kernels._known[key].folders.isdisjoint(quick)
    assert kept_kernels.digest_of(key)


def test_what_is_kept_is_what_runs_again(pocl_only, program):
    key, run = program
    assert run()
    digest, content = kept_kernels._read(key)
    assert any(name.endswith(".so") for name in content)
    forget(key)
    assert run()
    assert kept_kernels._known[key].digest == digest
    again = kept_kernels._read(key)
    assert again == (digest, content)  # nothing was compiled anew
    assert not list(kernel_cache.place().kept.glob(f"{key}.*{kernel_cache.TRYING}"))


def test_a_process_that_runs_is_not_forgotten(pocl_only, program):
    key, run = program
    assert run()
    running = kernel_cache.place().running
    os.utime(running, (1.0, 1.0))
    kept_kernels.keep(key)
    assert running.stat().st_mtime > 1.0


def test_a_damaged_one_is_said_removed_and_compiled_anew(pocl_only, program):
    key, run = program
    assert run()
    forget(key)
    file = kept_kernels._file(key)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 4
    file.write_bytes(data)
    with pytest.warns(CacheWarning, match=r"the kept kernels .* are damaged.*compiled anew"):
        assert run()
    assert kept_kernels.digest_of(key)


def test_one_that_the_driver_refuses_is_compiled_anew(pocl_only, program, monkeypatch):
    import pyopencl as cl

    key, run = program
    assert run()
    forget(key)
    refused = []
    built = kept_kernels._built

    def build(made, options):
        if not refused:
            refused.append(1)
            raise cl.RuntimeError("BUILD_PROGRAM_FAILURE")
        return built(made, options)

    monkeypatch.setattr(kept_kernels, "_built", build)
    with pytest.warns(CacheWarning, match="were refused by the driver"):
        assert run()
    assert kept_kernels.digest_of(key)


def test_one_that_is_being_loaded_by_another_is_used(pocl_only, program):
    key, run = program
    assert run()
    forget(key)
    mark, handle = kept_kernels._mark(key)  # another process, alive
    try:
        assert run()
    finally:
        os.close(handle)
    assert mark.exists()
    forget(key)
    with pytest.warns(CacheWarning, match="when a process was killed or crashed"):
        assert run()  # it died
    assert not mark.exists()
    forget(key)
    assert run()  # what was compiled anew is trusted


def test_a_driver_without_a_cache_has_its_binary_kept(pocl_only, device, program, monkeypatch):
    import pyopencl as cl

    other = dataclasses.replace(device, record=dataclasses.replace(device.record, is_pocl=False))
    nvidia = dataclasses.replace(other.record, vendor="NVIDIA Corporation")
    assert not kept_kernels.are_kept(dataclasses.replace(other, record=nvidia))
    key, run = program
    assert run(other)
    assert list(kept_kernels._read(key)[1]) == ["binary"]
    sources = []
    made = cl.Program
    monkeypatch.setattr(
        cl, "Program", lambda *given: (sources.append(isinstance(given[1], str)), made(*given))[1]
    )
    assert run(other)
    assert sources == [False]  # from the binary, not from the source


def test_each_flipped_bit_and_each_cut_is_noticed(tmp_path, monkeypatch):
    where = kernel_cache.Place(tmp_path, tmp_path)
    monkeypatch.setattr(kernel_cache, "_place", where)
    content = {"AB/CD/program.bc": b"bitcode" * 40, "AB/CD/wave/1/wave.so": b"\x7fELF" * 50}
    digest = kept_kernels._write(where, "key", content, "")
    assert kept_kernels._read("key") == (digest, content)
    file = tmp_path / f"key{kernel_cache.KEPT}"
    whole = file.read_bytes()
    cases = [whole[:n] for n in range(0, len(whole), 7)]
    for bit in range(0, 8 * len(whole), 11):
        flipped = bytearray(whole)
        flipped[bit // 8] ^= 1 << bit % 8
        cases.append(bytes(flipped))
    for case in [*cases, whole + b"\0"]:
        file.write_bytes(case)
        with pytest.warns(CacheWarning, match="are damaged"):
            assert kept_kernels._read("key") is None
        assert not file.exists()


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Have kernels in a place of this test alone."""
    where = kernel_cache.Place(tmp_path, tmp_path / "running")
    where.running.mkdir()
    monkeypatch.setattr(kernel_cache, "_place", where)
    return where


@pytest.mark.parametrize("step", ["_listing", "_write"])
def test_a_compiler_in_another_thread_does_not_end_a_run(pocl_only, program, monkeypatch, step):
    key, run = program
    done, failed = getattr(kept_kernels, step), []

    def gone(*given):
        if not failed:
            failed.append(1)
            raise FileNotFoundError(2, "No such file or directory", "wave.so")
        return done(*given)

    monkeypatch.setattr(kept_kernels, step, gone)
    assert run()
    assert failed
    assert not kept_kernels.digest_of(key)
    kept_kernels.keep(key)
    assert kept_kernels.digest_of(key)  # the next call kept it


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_nothing_is_left_of_what_could_not_be_written(
    pocl_only, program, monkeypatch, error, recwarn
):
    key, run = program
    assert run()
    content = kept_kernels._read(key)[1]
    forget(key)
    write, written = Path.write_bytes, []

    def fail(path, data):
        written.append(path)
        if len(written) == 2:
            write(path, data[: len(data) // 2])
            raise error
        return write(path, data)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", fail)
        if isinstance(error, OSError):
            assert kept_kernels._fetch(key) is None
        else:
            with pytest.raises(KeyboardInterrupt):
                kept_kernels._fetch(key)
    assert len(written) == 2
    running = kernel_cache.place().running
    folders = {"/".join(name.split("/")[:2]) for name in content}
    assert not any((running / folder).exists() for folder in folders)
    assert run()
    assert not [w for w in recwarn if issubclass(w.category, CacheWarning)]
    assert kept_kernels.digest_of(key)


def test_nobody_sees_a_mark_without_its_lock(place, monkeypatch):
    hold, visible = kernel_cache.hold, []

    def look(handle):
        visible.extend(place.kept.glob(f"*{kernel_cache.TRYING}"))
        return hold(handle)

    monkeypatch.setattr(kernel_cache, "hold", look)
    mark, handle = kept_kernels._mark("key")
    assert visible == []
    assert mark.exists()
    os.close(handle)
    mark.unlink()
    monkeypatch.setattr(kernel_cache, "hold", lambda _: False)
    assert kept_kernels._mark("key") is None  # nor one that another has
    assert [*place.kept.iterdir(), *place.running.iterdir()] == [place.running]


def test_a_mark_that_is_taken_away_meanwhile_accuses_nobody(place, monkeypatch):
    kept_kernels._write(place, "key", {"AB/CD/program.bc": b"code"}, "")
    mark, handle = kept_kernels._mark("key")
    os.close(handle)
    hold = kernel_cache.hold

    def after_its_end(lock):
        mark.unlink()
        return hold(lock)

    monkeypatch.setattr(kernel_cache, "hold", after_its_end)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert kept_kernels._usable("key")
    assert not mark.exists()


def test_a_mark_of_another_host_is_not_judged(place, monkeypatch):
    kept_kernels._write(place, "key", {"AB/CD/program.bc": b"code"}, "")
    with monkeypatch.context() as patch:
        patch.setattr(kernel_cache.socket, "gethostname", lambda: "another")
        mark, handle = kept_kernels._mark("key")
    os.close(handle)  # locks are each host's own: here it looks free
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert kept_kernels._usable("key")
    assert mark.exists()
    monkeypatch.setattr(kernel_cache.socket, "gethostname", lambda: "another")
    with pytest.warns(CacheWarning, match="when a process was killed or crashed"):
        assert kept_kernels._usable("key") is None
    assert not mark.exists()


# -- a whole process -------------------------------------------------------------------------------

CRASH = f"""
import ctypes, os
from hostcode.device import kept_kernels
from hostcode.device.device import choose, enumerate_devices, open_device
text = {TEXT.format(factor=3, case=1)!r}
opened = open_device(enumerate_devices()[0], self_test=False)
key = kept_kernels.program_key(opened, text, ())
kept_kernels.build(opened, key, text, ())
if os.environ["CASE"] == "crash":
    ctypes.string_at(0)
kept_kernels.keep(key)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGSEGV"), reason="needs signals")
def test_what_a_process_died_of_is_not_loaded_again(pocl_only, tmp_path):
    def process(case):
        return subprocess.run(
            [sys.executable, "-c", CRASH],
            env={**os.environ, "CASE": case, "POCL_CACHE_DIR": str(tmp_path), "PYTHONPATH": ROOT},
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )

    def kept():
        return sorted(p.suffix for p in tmp_path.iterdir() if p.is_file())

    assert process("run").returncode == 0
    assert kept() == [".kernels"]
    assert process("crash").returncode == -signal.SIGSEGV
    assert kept() == [".kernels", ".trying"]
    third = process("run")
    assert third.returncode == 0
    assert "were being loaded when a process was killed or crashed" in third.stderr
    assert kept() == [".kernels"]
    assert "loaded" not in process("run").stderr


# -- the replay ------------------------------------------------------------------------------------


def run_scene(home):
    environment = {k: v for k, v in os.environ.items() if k != "POCL_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-m", "photizon_cl.cli.main", "run", "cosine-fourth", "--batches", "1",
         "--rays-per-batch", "4096", "--json"],
        env={**environment, "XDG_CACHE_HOME": str(home), "PYTHONPATH": str(ROOT)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    digest = json.loads(done.stdout)["tally_digest"] if done.returncode == 0 else None
    return digest, done.stderr.splitlines()


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    home = tmp_path_factory.mktemp("warm")
    digest, _ = run_scene(home)
    assert run_scene(home) == (digest, [])
    return home, digest


def damaged(data, how, chance):
    if how == "flip":
        flipped = bytearray(data)
        flipped[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        return bytes(flipped)
    return {
        "half": data[: len(data) // 2],
        "zero": bytes(len(data)),
        "garbage": chance.randbytes(len(data)),
        "empty": b"",
    }[how]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ways", "number"), [(["half", "zero", "garbage", "empty"], 40), (["flip"], 60)]
)
def test_replay_of_damaged_caches(ways, number, warm, tmp_path):
    home, digest = warm
    files = sorted(p.relative_to(home) for p in home.rglob("*") if p.is_file())
    assert {p.suffix for p in files} == {".kernels", ".json"}
    chance = random.Random(20261129)
    said = defaultdict(set)
    for n in range(number):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(home, copy)
        file = copy / chance.choice(files)
        file.write_bytes(damaged(file.read_bytes(), ways[n % len(ways)], chance))
        found, lines = run_scene(copy)
        assert found == digest, (file, ways[n % len(ways)], lines)
        assert len(lines) == ("are damaged" in "".join(lines)), lines  # one line, or none
        said[file].add(bool(lines))
        if n % 5 == 0:
            assert run_scene(copy) == (digest, [])  # and it is over
    # every damage to kernels is said; what was measured is measured again without a word
    assert said
    assert all(found == {file.suffix == ".kernels"} for file, found in said.items()), dict(said)
