"""Who computes, as a user names it: one line where that cannot be."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.run import dask
from photizon_cl.run.engines import open_executor
from photizon_cl.run.processes import Processes


@pytest.mark.parametrize("n", [0, -1, 1025, 1.5, True, "2", 1 << 90])
def test_a_number_of_workers(n):
    with pytest.raises(pz.ArgumentError, match=r"workers: found .*, expected an integer from 1 to"):
        pz.trace("box-room", batches=1, workers=n)


@pytest.mark.parametrize(
    "address",
    ["nowhere", "tcp://host", "http://host:80", "tcp://host:8786/x", "tcp://:1", "", 5, "a b:1"],
)
def test_an_address(address):
    with pytest.raises(
        pz.ArgumentError, match=r"scheduler: found .*, expected the address"
    ) as told:
        pz.trace("box-room", batches=1, scheduler=address)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("address", ["tcp://10.0.0.1:8786", "host:8786", "tls://[fe80::1]:8786"])
def test_addresses(address):
    assert dask._ADDRESS.fullmatch(address)


def test_two_at_a_time():
    with pytest.raises(pz.ArgumentError, match=r"workers: found 2 and scheduler .*, expected one"):
        pz.trace("box-room", batches=1, workers=2, scheduler="tcp://host:1")
    with pytest.raises(pz.ArgumentError, match=r"workers: found 2, expected nothing beside exec"):
        pz.trace("box-room", batches=1, workers=2, executor=object())


def test_nothing_named_is_this_process():
    with open_executor() as executor:
        assert executor is None


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--workers", "0"], "workers: found 0, expected an integer from 1 to 1024"),
        (["--workers", "two"], "argument --workers: found 'two', expected an integer"),
        (["--workers", "1", "--scheduler", "h:1"], "--scheduler: not allowed with argument --wor"),
        (["--scheduler", "h"], 'scheduler: found "h", expected the address of a Dask scheduler'),
    ],
)
@pytest.mark.parametrize("verb", ["run", "resume"])
def test_the_command_line(verb, arguments, line, capsys, tmp_path):
    where = "box-room"
    if verb == "resume":
        where = str(tmp_path)
        pz.trace("cosine-fourth", batches=1, rays_per_batch=64).save(where, figures=False)
    assert main([verb, where, "--batches", "2", *arguments]) == 2
    said = capsys.readouterr()
    assert line in said.err
    assert said.err.count("\n") == 1
    assert not said.out


WITHOUT_DASK = """
import sys
sys.modules["distributed"] = None
from photizon_cl.cli.main import main
sys.exit(main(["run", "box-room", "--scheduler", "tcp://127.0.0.1:1"]))
"""


def test_an_extra_that_is_not_there():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_DASK], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "install it with `pip install 'photizon-cl[dask]'`" in done.stderr


def test_threads_are_shared_out(monkeypatch):
    monkeypatch.setattr("photizon_cl.run.processes.cores", lambda: frozenset(range(6)))
    assert [Processes(n).threads for n in (1, 2, 4, 6, 9)] == [6, 3, 1, 1, 1]
