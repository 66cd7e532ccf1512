"""Where compiled kernels cannot be kept a run still runs, and says so."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

import pytest

from hostcode.device import kernel_cache
from hostcode.device.kernel_cache import provide_cache
from hostcode.errors import CacheWarning
from photizon_cl.cli.main import main

NAMES = ("HOME", "XDG_CACHE_HOME", "POCL_CACHE_DIR")


@pytest.fixture
def usual(tmp_path, monkeypatch):
    """Set the variables as where nobody set any, with a home directory of its own."""
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


@pytest.fixture
def own_place(monkeypatch):
    """Put back, afterwards, where this process's kernels are; give where they were put."""
    monkeypatch.setattr(kernel_cache, "_place", kernel_cache.place())
    monkeypatch.setattr(kernel_cache.atexit, "register", lambda *_: None)
    monkeypatch.setenv("PYOPENCL_NO_CACHE", "1")

    def where():
        made = kernel_cache.place()
        return made.kept, made.running

    return where


@pytest.fixture
def file(tmp_path):
    """Return a file, below which nobody can write, root included."""
    made = tmp_path / "file"
    made.write_text("")
    return str(made)


def test_a_home_that_cannot_be_written(file, tmp_path):
    environment = {**os.environ, "HOME": file, "XDG_CACHE_HOME": "", "TMPDIR": str(tmp_path)}
    del environment["POCL_CACHE_DIR"]
    command = [
        sys.executable,
        "-m",
        "photizon_cl.cli.main",
        "run",
        "cosine-fourth",
        "--batches",
        "1",
    ]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "absorbed by target" in done.stdout
    (line,) = done.stderr.splitlines()
    kept = f"{file}/.cache/photizon_cl/kernels"
    assert line.startswith(f"photizon: the kernel cache {kept} cannot be written")
    assert "set XDG_CACHE_HOME to a directory that can be written" in line
    assert not list(tmp_path.glob("photizon-cache-*"))


def test_nothing_is_said_where_it_can_be_written(usual, own_place):
    provide_cache()
    kept, running = own_place()
    assert kept == usual / ".cache" / "photizon_cl" / "kernels"
    assert running.parent.parent == kept
    assert os.environ["POCL_CACHE_DIR"] == str(running)
    assert "XDG_CACHE_HOME" not in os.environ
    assert kernel_cache.root() == kept  # for the processes that this one starts


def test_each_variable_is_seen_to(usual, own_place, file, monkeypatch):
    monkeypatch.setenv("POCL_CACHE_DIR", file)
    with pytest.warns(CacheWarning, match="Not a directory.*set POCL_CACHE_DIR to"):
        provide_cache()
    temporary, _ = own_place()
    assert os.path.isdir(os.environ["POCL_CACHE_DIR"])
    provide_cache()  # what was put in its place can be written
    assert own_place()[0] == temporary
    monkeypatch.setenv("POCL_CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", file)
    with pytest.warns(CacheWarning, match=r"/kernels cannot.*set XDG_CACHE_HOME to"):
        provide_cache()


def test_an_empty_name_is_none(usual, own_place, monkeypatch):
    # PoCL aborts the process at it
    monkeypatch.setenv("POCL_CACHE_DIR", "")
    provide_cache()
    assert os.environ["POCL_CACHE_DIR"]
    assert own_place()[0] == usual / ".cache" / "photizon_cl" / "kernels"


def test_the_users_own_directory_keeps_the_kernels(usual, own_place, monkeypatch):
    monkeypatch.setenv("POCL_CACHE_DIR", str(usual / "mine"))
    provide_cache()
    assert own_place()[0] == usual / "mine"
    assert kernel_cache.root() == usual / "mine"


def test_what_dead_processes_worked_in_goes(usual, own_place):
    provide_cache()
    _, mine = own_place()
    host = kernel_cache.host_prefix()
    dead, young = mine.parent / f"{host}dead", mine.parent / f"{host}young"
    dead.mkdir()
    young.mkdir()
    (dead / "held").write_text("")
    (dead / "AB").mkdir()
    provide_cache()
    assert not dead.exists()
    assert mine.exists()  # this process holds it
    assert young.exists()  # about to be held, perhaps
    os.utime(young, (1.0, 1.0))
    provide_cache()
    assert not young.exists()


def test_another_hosts_directory_goes_only_when_long_forgotten(usual, own_place, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(kernel_cache.socket, "gethostname", lambda: "node_2/b")
        provide_cache()
        theirs = own_place()[1]
        os.close(kernel_cache._held.pop())  # locks are each host's own: here it looks free
    assert theirs.name.startswith("node-2-b_")
    provide_cache()
    assert own_place()[1].name.startswith(kernel_cache.host_prefix())
    os.utime(theirs, (time.time() - 6 * 86400,) * 2)
    provide_cache()
    assert theirs.exists()
    os.utime(theirs, (time.time() - 8 * 86400,) * 2)
    provide_cache()
    assert not theirs.exists()


def test_nobody_sees_a_directorys_lock_before_it_is_held(usual, own_place, monkeypatch):
    hold, visible = kernel_cache.hold, []

    def look(handle):
        visible.extend(usual.rglob("held"))
        return hold(handle)

    monkeypatch.setattr(kernel_cache, "hold", look)
    provide_cache()
    assert visible == []
    assert [path.name for path in own_place()[1].iterdir()] == ["held"]


def test_without_locks_its_age_tells(usual, own_place, monkeypatch):
    def fail(_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(kernel_cache, "hold", fail)
    provide_cache()
    first = own_place()[1]
    assert [path.name for path in first.iterdir()] == ["held"]
    os.utime(first, (time.time() - 6 * 86400,) * 2)
    provide_cache()
    assert first.exists()
    os.utime(first, (time.time() - 8 * 86400,) * 2)
    provide_cache()
    assert not first.exists()


def test_where_processes_work_must_be_writable_as_well(usual, own_place):
    kept = usual / ".cache" / "photizon_cl" / "kernels"
    kept.mkdir(parents=True)
    (kept / "photizon-running").write_text("")  # as one of root's, but for root as well
    with pytest.warns(CacheWarning, match=r"/photizon-running cannot.*set XDG_CACHE_HOME to"):
        provide_cache()
    temporary, running = own_place()
    assert temporary != kept
    assert running.parent.parent == temporary


def test_pyopencl_keeps_nothing(device):
    import pyopencl

    assert pyopencl._PYOPENCL_NO_CACHE  # neither binaries nor code that a flipped bit may change


def test_the_verb_shows_and_clears(usual, own_place, monkeypatch, capsys):
    monkeypatch.setattr(kernel_cache, "_place", None)
    assert main(["cache"]) == 0
    kept = usual / ".cache" / "photizon_cl" / "kernels"
    assert capsys.readouterr().out == (
        f"compiled kernels: 0 programs, 0.0 MB, kept: {kept}\n"
        f"self-tests of devices: 0 passes known: {kept.parent}/selftest.json\n"
    )
    kept.mkdir(parents=True)
    (kept / "ab.kernels").write_bytes(bytes(1_500_000))
    (kept / "ab.host_1.trying").write_text("")
    (kept / "notes.txt").write_text("mine")
    (kept.parent / "selftest.json").write_text('{"passed": {"device": "digest"}}')
    assert main(["cache"]) == 0
    assert "1 program, 1.5 MB, kept" in capsys.readouterr().out
    assert main(["cache", "--clear"]) == 0
    out = capsys.readouterr().out
    assert "1 program, 1.5 MB, removed" in out
    assert "1 pass forgotten" in out
    assert [p.name for p in kept.iterdir()] == ["notes.txt"]
    assert not (kept.parent / "selftest.json").exists()


def test_nowhere_to_write_at_all(usual, own_place, file, monkeypatch):
    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("XDG_CACHE_HOME", file)
    monkeypatch.setattr(tempfile, "mkdtemp", fail)
    with pytest.raises(OSError, match=r"the kernel cache .*nor a temporary one: .*No space left"):
        provide_cache()
