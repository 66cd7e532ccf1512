"""Processes to be killed: a server that forks them, and the test's end of it.

A script calls `serve`; a test starts it with `Kills`. What is imported is imported once: Python
does not start anew for each process, and more kills fall into what is ours. A process is killed
wherever it is, or held first at a named moment, so that a test knows what must be there afterwards.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5netcdf  # noqa: F401
import pyopencl  # noqa: F401  (imported, and not asked for anything: it would not survive the fork)
import xarray  # noqa: F401

from photizon_cl.run import checkpoint

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).resolve().parents[2]


def say(word: str) -> None:
    print(word, flush=True)


def hold() -> None:
    """Say that the moment has come, and stay there until the kill."""
    say("held")
    while True:
        signal.pause()


class Moment:
    """When a process stops: after so many batches, or where so many checkpoints lie unnamed.

    Parameters
    ----------
    kind : str
        ``"batches"``, ``"writing"`` or ``"anywhere"``, which never comes.
    number : int, optional
        Counted from 1, in this process.
    """

    def __init__(self, kind: str, number: int = 0) -> None:
        self.batches = number if kind == "batches" else 0
        self.writes = number if kind == "writing" else 0
        self.begun = False
        checkpoint.PERIOD = 0.0  # a checkpoint for every batch
        checkpoint._SHARE = 1e9
        write = checkpoint.write_state

        def written(*state: Any) -> None:
            write(*state)
            self.writes -= 1
            if self.writes == 0:
                hold()  # it is whole, and has not taken its place

        checkpoint.write_state = written  # type: ignore[assignment]

    def batch(self) -> None:
        """Note a batch: the program has been loaded."""
        if not self.begun:
            self.begun = True
            say("tracing")
        self.batches -= 1
        if self.batches == 0:
            hold()


def serve(run: Callable[..., None]) -> None:
    """Fork a process for every line on standard input, which holds what `run` is given, as JSON.

    It says ``ready`` and its number, and ``done``; the next line asks how it ended.
    """
    while line := sys.stdin.readline():
        process = os.fork()
        if process == 0:
            try:
                say(f"ready {os.getpid()}")
                run(*json.loads(line))
                say("done")
            except BaseException:
                traceback.print_exc()
                say("failed")  # for who waits for a word
            os._exit(0)
        sys.stdin.readline()  # not waited for before: its number stays its own until it is killed
        _, status = os.waitpid(process, 0)
        say(f"ended {os.waitstatus_to_exitcode(status)}")


class Kills:
    """Starts what a script serves, one process at a time, and kills it.

    Parameters
    ----------
    script : Path
        It calls `serve`.
    **environment : str
        Variables of its own.
    """

    def __init__(self, script: Path, **environment: str) -> None:
        there = f"{ROOT}{os.pathsep}{ROOT / 'tests'}"
        self.process = subprocess.Popen(
            [sys.executable, script],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": there, **environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.number: int | None = None

    def _say(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def _hear(self) -> list[str]:
        assert self.process.stdout is not None
        return self.process.stdout.readline().split()

    def start(self, *given: object, until: str = "ready") -> None:
        """Start a process and return when it has said a word."""
        self._say(json.dumps(given))
        word, number = self._hear()
        assert word == "ready"
        self.number = int(number)
        while word != until:
            (word,) = self._hear()
            assert word not in ("done", "failed"), f"{word}, and {until} was waited for"

    def wait(self) -> None:
        """Wait until the process is done."""
        while (heard := self._hear()) != ["done"]:
            assert heard != ["failed"]
        self.number = None
        self._say("")
        assert self._hear() == ["ended", "0"]

    def kill(self) -> bool:
        """Kill the process, whatever it is at; say whether it was done before."""
        assert self.number is not None
        os.kill(self.number, signal.SIGKILL)
        self.number = None
        self._say("")
        heard = []
        while (words := self._hear())[0] != "ended":
            heard.append(words)
        assert ["failed"] not in heard
        return ["done"] in heard

    def close(self) -> None:
        """Let nothing live on, also where a test failed on the way."""
        if self.number is not None:
            os.kill(self.number, signal.SIGKILL)
        self.process.communicate()
