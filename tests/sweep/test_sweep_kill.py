"""SIGKILL at random moments of a sweep: the same digests, and no point run twice once done."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tubes import a_sweep

import photizon_cl as pz
from photizon_cl.run.directory import unfinished

SCRIPT = Path(__file__).with_name("killed_sweep.py")
ROOT = Path(__file__).resolve().parents[2]
BATCHES = 5


class Sweeps:
    """Starts sweeps, one at a time, and kills them; see killed_sweep.py."""

    def __init__(self, cache: Path) -> None:
        cache.mkdir()
        # a cache of their own: one that is killed while it loads a program spoils that
        own = {"PYTHONPATH": str(ROOT), "POCL_CACHE_DIR": str(cache)}
        self.process = subprocess.Popen(
            [sys.executable, SCRIPT],
            cwd=ROOT,
            env={**os.environ, **own},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.number: int | None = None

    def say(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def hear(self) -> list[str]:
        assert self.process.stdout is not None
        return self.process.stdout.readline().split()

    def start(self, file: Path, folder: Path, until: str) -> None:
        """Start a sweep, or go on with it, and return when it has said a word."""
        self.say(json.dumps([str(file), str(folder)]))
        word, number = self.hear()
        assert word == "ready"
        self.number = int(number)
        if until == "running":
            assert self.hear() == ["running"]

    def wait(self) -> None:
        """Wait until the sweep is done."""
        while self.hear() != ["done"]:
            pass
        self.number = None
        self.say("")
        assert self.hear() == ["ended", "0"]

    def kill(self) -> bool:
        """Kill the sweep, whatever it is at; say whether it was done before."""
        assert self.number is not None
        os.kill(self.number, signal.SIGKILL)
        self.number = None
        self.say("")
        heard = []
        while (words := self.hear())[0] != "ended":
            heard.append(words)
        assert ["failed"] not in heard
        return ["done"] in heard


@pytest.fixture
def sweeps(tmp_path):
    made = Sweeps(tmp_path / "cache")
    yield made
    if made.number is not None:  # the test failed on the way
        os.kill(made.number, signal.SIGKILL)
    made.process.communicate()


def marks(folder: Path) -> dict[str, tuple[int, int]]:
    """Return what would change were a point that is done written again."""
    found = {}
    for file in sorted(folder.glob("points/*/point.json")):
        for name in ("point.json", "result.nc"):
            stat = (file.parent / name).stat()
            found[f"{file.parent.name}/{name}"] = stat.st_ino, stat.st_mtime_ns
    return found


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
@pytest.mark.parametrize("kills", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_killed_at_random_moments(tmp_path, sweeps, kills):
    points = (5 if kills > 9 else 2) * kills + 2  # more than can be done until the last one
    angle = {"path": "source.sun.tilt_deg[0]", "linspace": [0, 10, points]}
    file, folder = tmp_path / "angles.json", tmp_path / "out"
    file.write_text(json.dumps(a_sweep(angle, run={"batches": BATCHES})), encoding="utf-8")
    # first, so that its program is compiled: else no sweep would live long enough for that
    one = tmp_path / "one.json"
    tables = a_sweep({**angle, "linspace": [0, 10, 2]}, run={"batches": 1})
    one.write_text(json.dumps(tables), encoding="utf-8")
    sweeps.start(one, tmp_path / "one", "running")
    sweeps.wait()
    chance = random.Random(20261129)
    known: dict[str, tuple[int, int]] = {}
    done, midway = [], 0
    for k in range(kills):
        sweeps.start(file, folder, "running" if k % 5 else "ready")
        time.sleep(chance.uniform(0.0, 1.5))
        assert not sweeps.kill(), "it was done before the kill: raise the number of points"
        if not (folder / "sweep.json").exists():
            continue  # before it had begun
        now = marks(folder)
        assert known.items() <= now.items()  # nothing that was done was touched again
        known = now
        opened = pz.open_sweep(folder)
        done.append(opened.n_done)
        homes = [f for f in (folder / "points").glob("*") if not (f / "point.json").exists()]
        left = [unfinished(home) for home in homes if not (home / "result.nc").exists()]
        midway += any(one is not None and one.batches for one in left)
    assert done == sorted(done)
    assert done[-1] > 0  # kills fell behind points
    assert midway > 0  # ... and into them
    found = pz.open_sweep(folder).resume(figure=False)
    assert found.finished
    whole = pz.sweep(file)
    assert known.items() <= marks(folder).items()
    assert [point.digest for point in found] == [point.digest for point in whole]
    numbers = [
        [p.summary()[key] for p in s] for key in ("measures", "change") for s in (found, whole)
    ]
    assert numbers[0] == numbers[1]
    assert numbers[2] == numbers[3]
    assert not list(folder.glob("points/*/checkpoint.nc"))
    assert (folder / "sweep.csv").exists()
    assert [point.digest for point in pz.open_sweep(folder)] == [p.digest for p in whole]
