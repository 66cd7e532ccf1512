"""Runs end when they are told to, with what is whole or one line that says why there is nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

import photizon_cl as pz
from benchmarks.limits import ROOM_FACTOR, ROOM_SECONDS, endless
from hostcode.run import queue


def program_of(scene):
    """Build the program of a scene, which is no part of a run's time."""
    with pytest.raises(pz.RunError):
        pz.trace(scene, max_seconds=0.01)


# those that wait have a budget, below
@pytest.mark.parametrize(
    "kind", ["white box", pytest.param("glass in mirrors", marks=pytest.mark.slow)]
)
def test_a_batch_that_never_ends_is_given_up(kind):
    scene = endless(kind, 2**16 if kind == "white box" else 16)
    program_of(scene)
    began = time.monotonic()
    with pytest.raises(pz.RunError) as caught:
        pz.trace(scene, max_seconds=1.0)
    assert time.monotonic() - began < ROOM_FACTOR + ROOM_SECONDS
    (line,) = str(caught.value).splitlines()
    assert "rays_per_batch" in line


def test_rays_that_wait_have_a_budget(monkeypatch):
    """Splitting without bound ends with a line, and nothing of it stays."""
    monkeypatch.setattr(queue, "BUDGET", 1 << 22)
    scene = endless("glass in mirrors", 16)
    with pytest.raises(pz.RunError) as caught:
        pz.trace(scene, max_seconds=20.0)
    (line,) = str(caught.value).splitlines()
    assert "more rays split off than may wait" in line
    assert "set roulette_floor (1e-6, say)" in line


SAYS_BATCHES = """
import sys
from photizon_cl.cli.main import main
from photizon_cl.run.progress import Clock

note, said = Clock.note, []

def once(self, batches):
    note(self, batches)
    if not said:
        said.append(print("batches", batches, flush=True))

Clock.note = once
sys.exit(main())
"""


def ignores_ctrl_c():
    """Have a process ignore SIGINT, as shells do for what they start in the background."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals of POSIX")
@pytest.mark.parametrize(
    ("number", "preexec"),
    [
        pytest.param(signal.SIGINT, None, marks=pytest.mark.slow),  # as in tests/api/test_cli.py
        (signal.SIGTERM, ignores_ctrl_c),
        pytest.param(signal.SIGHUP, ignores_ctrl_c, marks=pytest.mark.slow),
    ],
    ids=["SIGINT", "SIGTERM", "SIGHUP"],
)
def test_signals_end_a_run_and_save_it(tmp_path, number, preexec):
    out = tmp_path / "out"
    arguments = ["run", "box-room", "--target", "1e-6", "--out", str(out), "--no-figures"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(
        [sys.executable, "-c", SAYS_BATCHES, *arguments], preexec_fn=preexec, **pipes
    ) as run:
        while not run.stdout.readline().startswith("batches"):
            assert run.poll() is None, run.stderr.read()
        os.kill(run.pid, number)
        began = time.monotonic()
        printed, errors = run.communicate(timeout=60)
        assert time.monotonic() - began < 30.0  # and is saved
        assert "Traceback" not in errors
    assert "stopped by Ctrl-C or another signal" in printed
    result = pz.open_result(out)
    assert result.info.stopped == "interrupt"
    assert result.batches > 0


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="terminals of POSIX")
def test_a_terminal_that_closes_costs_no_result(tmp_path):
    import pty

    out = tmp_path / "out"
    child, terminal = pty.fork()
    if child == 0:  # the terminal is this process's own: closing it sends SIGHUP
        arguments = ["run", "box-room", "--target", "1e-6", "--out", str(out), "--no-figures"]
        os.execv(sys.executable, [sys.executable, "-c", SAYS_BATCHES, *arguments])
    said = b""
    while b"batches" not in said:
        said += os.read(terminal, 4096)
    os.close(terminal)
    _, status = os.waitpid(child, 0)
    assert os.WIFEXITED(status), status
    result = pz.open_result(out)
    assert result.info.stopped == "interrupt"
    assert result.batches > 0
