"""SIGKILL at any moment of a sweep: the same digests, and no point run twice once done."""

from __future__ import annotations

import json
import random
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from oracles.kills import Kills
from tubes import a_sweep

import photizon_cl as pz
from photizon_cl.run.directory import unfinished

if TYPE_CHECKING:
    from collections.abc import Iterator

SCRIPT = Path(__file__).with_name("killed_sweep.py")
BATCHES = 5

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")


@pytest.fixture
def sweeps(tmp_path) -> Iterator[Kills]:
    cache = tmp_path / "cache"
    cache.mkdir()
    # a cache of their own: one that is killed while it loads a program spoils that
    made = Kills(SCRIPT, POCL_CACHE_DIR=str(cache))
    yield made
    made.close()


def marks(folder: Path) -> dict[str, tuple[int, int]]:
    """Return what would change were a point that is done written again."""
    found = {}
    for file in sorted(folder.glob("points/*/point.json")):
        for name in ("point.json", "result.nc"):
            stat = (file.parent / name).stat()
            found[f"{file.parent.name}/{name}"] = stat.st_ino, stat.st_mtime_ns
    return found


def half_done(folder: Path) -> list[int]:
    """Return the batches of the points that were killed in their midst."""
    homes = [f for f in (folder / "points").glob("*") if not (f / "point.json").exists()]
    left = [unfinished(home) for home in homes if not (home / "result.nc").exists()]
    return [one.batches for one in left if one is not None and one.batches]


def ends_as_if_nothing_had_happened(file: Path, folder: Path) -> None:
    known = marks(folder)
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


def angles(file: Path, points: int) -> None:
    angle = {"path": "source.sun.tilt_deg[0]", "linspace": [0, 10, points]}
    file.write_text(json.dumps(a_sweep(angle, run={"batches": BATCHES})), encoding="utf-8")


def test_killed_at_named_moments(tmp_path, sweeps):
    file, folder = tmp_path / "angles.json", tmp_path / "out"
    angles(file, 4)
    known: dict[str, tuple[int, int]] = {}
    # behind the first point and two batches of the next; in the checkpoint of its fourth batch;
    # behind that point and three batches of the third
    moments = [("batches", BATCHES + 2, 1, [2]), ("writing", 2, 1, [3]), ("batches", 5, 2, [3])]
    for kind, number, done, midway in moments:
        sweeps.start(str(file), str(folder), (kind, number), until="held")
        assert not sweeps.kill()
        now = marks(folder)
        assert known.items() <= now.items()  # nothing that was done was touched again
        known = now
        assert pz.open_sweep(folder).n_done == done
        assert half_done(folder) == midway
    ends_as_if_nothing_had_happened(file, folder)


@pytest.mark.slow
def test_killed_at_random_moments(tmp_path, sweeps):
    kills = 20
    file, folder = tmp_path / "angles.json", tmp_path / "out"
    angles(file, 5 * kills + 2)  # more than can be done until the last one
    # first, so that its program is compiled: else no sweep would live long enough for that
    one = tmp_path / "one.json"
    angles(one, 2)
    sweeps.start(str(one), str(tmp_path / "one"), ("anywhere",))
    sweeps.wait()
    chance = random.Random(20261129)
    known: dict[str, tuple[int, int]] = {}
    done, midway = [], 0
    for k in range(kills):
        until = "tracing" if k % 5 else "ready"
        sweeps.start(str(file), str(folder), ("anywhere",), until=until)
        time.sleep(chance.uniform(0.0, 1.5))
        assert not sweeps.kill(), "it was done before the kill: raise the number of points"
        if not (folder / "sweep.json").exists():
            continue  # before it had begun
        now = marks(folder)
        assert known.items() <= now.items()
        known = now
        done.append(pz.open_sweep(folder).n_done)
        midway += bool(half_done(folder))
    assert done == sorted(done)
    assert done[-1] > 0  # kills fell behind points
    assert midway > 0  # ... and into them
    ends_as_if_nothing_had_happened(file, folder)
