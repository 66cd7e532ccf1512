"""Where compiled kernels cannot be kept a run still runs, and says so."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

import pytest

from hostcode.device.kernel_cache import provide_cache
from hostcode.errors import CacheWarning

NAMES = ("HOME", "XDG_CACHE_HOME", "POCL_CACHE_DIR")


@pytest.fixture
def usual(tmp_path, monkeypatch):
    """Set the variables as where nobody set any, with a home directory of its own."""
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


@pytest.fixture
def file(tmp_path):
    """Return a file, below which nobody can write, root included."""
    made = tmp_path / "file"
    made.write_text("")
    return str(made)


def test_a_home_that_cannot_be_written(file, tmp_path):
    environment = {**os.environ, "HOME": file, "XDG_CACHE_HOME": "", "TMPDIR": str(tmp_path)}
    del environment["POCL_CACHE_DIR"]
    command = [sys.executable, "-m", "photizon_cl.cli.main", "run", "box-room", "--batches", "1"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "absorbed by floor" in done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith(
        f"photizon: the kernel cache {file}/.cache/pocl/kcache cannot be written"
    )
    assert "set XDG_CACHE_HOME to a directory that can be written" in line
    assert not list(tmp_path.glob("photizon-cache-*"))


def test_nothing_is_made_or_said_where_it_can_be_written(usual):
    provide_cache()
    assert not list(usual.iterdir())
    assert "XDG_CACHE_HOME" not in os.environ


def test_each_variable_is_seen_to(usual, file, monkeypatch):
    monkeypatch.setenv("POCL_CACHE_DIR", file)
    with pytest.warns(CacheWarning, match="Not a directory.*set POCL_CACHE_DIR to"):
        provide_cache()
    assert os.path.isdir(os.environ["POCL_CACHE_DIR"])
    monkeypatch.setenv("XDG_CACHE_HOME", file)
    with pytest.warns(CacheWarning, match=r"file/pytools cannot.*set XDG_CACHE_HOME to"):
        provide_cache()
    provide_cache()  # what was put in their place can be written


def test_an_empty_name_is_none(usual, monkeypatch):
    # PoCL aborts the process at it
    monkeypatch.setenv("POCL_CACHE_DIR", "")
    provide_cache()
    assert "POCL_CACHE_DIR" not in os.environ


def test_nowhere_to_write_at_all(usual, file, monkeypatch):
    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("XDG_CACHE_HOME", file)
    monkeypatch.setattr(tempfile, "mkdtemp", fail)
    with pytest.raises(OSError, match=r"the kernel cache .*nor a temporary one: .*No space left"):
        provide_cache()
