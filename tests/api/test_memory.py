"""Memory has a budget: what a run takes is what is said, and what may be taken is known."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from pathlib import Path

import pyopencl as cl
import pytest
from plates import GB, SIDE, parts, scene

import photizon_cl as pz
from hostcode.device import memory as host_memory
from hostcode.device.memory import Room, room
from hostcode.run import tally
from photizon_cl.result.sums import SPARSE_CELL
from photizon_cl.run import needs as needs_of
from photizon_cl.run.needs import Needs

FACTOR = 2.0
"""By which what is said may be more than what is taken."""


# -- what is said is what is taken -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("side", "far", "sparse"),
    [
        (SIDE, None, False),
        (0, SIDE, True),
        pytest.param(SIDE, None, True, marks=pytest.mark.slow),
        pytest.param(0, SIDE, False, marks=pytest.mark.slow),
    ],
)
def test_what_is_said_is_what_is_taken(side, far, sparse, monkeypatch, tmp_path):
    if sparse:
        monkeypatch.setattr(tally, "_SPARSE_FROM", 1000)
    a_scene = scene(side, far)
    a_scene = replace(a_scene, run=replace(a_scene.run, rays_per_batch=1 << 16))
    # what is imported and built is no part of it
    pz.trace(a_scene, batches=1).save(tmp_path / "before", figures=False)
    needs = Needs.of(*parts(a_scene))
    allocated = []
    buffer = cl.Buffer

    def counted(*arguments, **more):
        made = buffer(*arguments, **more)
        allocated.append(made.size)
        return made

    monkeypatch.setattr(cl, "Buffer", counted)
    gc.collect()
    tracemalloc.start()
    try:
        result = pz.trace(a_scene, batches=3)
        running = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        result.save(tmp_path / "out", figures=False)
        end = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    slack = 8 << 20  # of Python itself, the scene's text and such
    device = sum(needs.device.values())
    assert sum(allocated) <= device <= sum(allocated) + 4096
    grown = result.tally.held_bytes
    assert bool(grown) == sparse
    assert grown <= needs.more
    said = sum(needs.while_running.values()) + grown
    assert running <= said + slack
    assert said <= FACTOR * running + slack
    written = needs_of.WRITTEN / SPARSE_CELL * grown
    said = sum(needs.at_the_end.values()) + needs.files + grown + written
    assert end <= said + slack
    assert said <= FACTOR * end + slack


@pytest.mark.slow
@pytest.mark.parametrize("side", [1024, 1500])
def test_drawing_takes_what_is_said(side, tmp_path):
    result = pz.trace(scene(side), batches=3, rays_per_batch=1 << 18)
    assert result.detectors["plate 0"].map is not None
    pz.figures.irradiance(pz.trace(scene(8), batches=2), "plate 0").savefig(tmp_path / "a.png")
    tracemalloc.start()
    pz.figures.irradiance(result, "plate 0").savefig(tmp_path / "a.png")
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken <= needs_of.drawn(side**2) + (16 << 20)


# -- what may be taken -----------------------------------------------------------------------------


def test_the_least_limit_counts(tmp_path, monkeypatch):
    proc, groups = tmp_path / "proc", tmp_path / "groups"
    (proc / "self").mkdir(parents=True)
    (proc / "meminfo").write_text("MemTotal: 8000000 kB\nMemAvailable: 6000000 kB\n")
    assert room(proc, groups) == Room(
        6000000 << 10, 8000000 << 10, "this machine, of which others have some"
    )
    # version 2: the limit of a group around it counts, and what is only kept does not
    (proc / "self" / "cgroup").write_text("1:name=systemd:/x\n0::/job/step\n")
    (groups / "job" / "step").mkdir(parents=True)
    (groups / "job" / "step" / "memory.max").write_text("max\n")
    (groups / "job" / "step" / "memory.current").write_text("5\n")
    (groups / "job" / "memory.max").write_text("3000000000\n")
    (groups / "job" / "memory.current").write_text("1500000000\n")
    (groups / "job" / "memory.stat").write_text(
        "anon 1\ninactive_file 300000000\nactive_file 200000000\n"
    )
    found = room(proc, groups)
    assert (found.left, found.limit) == (2 * GB, 3 * GB)
    # version 1
    (proc / "self" / "cgroup").write_text("4:memory:/job\n")
    (groups / "memory" / "job").mkdir(parents=True)
    (groups / "memory" / "job" / "memory.limit_in_bytes").write_text("1000000000\n")
    (groups / "memory" / "job" / "memory.usage_in_bytes").write_text("400000000\n")
    assert room(proc, groups).left == 600_000_000
    (groups / "memory" / "job" / "memory.stat").write_text(
        "cache 9\ninactive_file 7\ntotal_inactive_file 100000000\ntotal_active_file 50000000\n"
    )
    assert room(proc, groups).left == 750_000_000
    (groups / "memory" / "job" / "memory.limit_in_bytes").write_text("9223372036854771712\n")
    assert room(proc, groups).left == 6000000 << 10


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="limits as Linux tells them")
def test_ulimit_counts(tmp_path):
    code = (
        "from hostcode.device.memory import room; r = room(); print(r.left, r.limit, r.what)\n"
        "print(open('/proc/self/status').read().split('VmSize:')[1].split()[0])"
    )
    shell = f'ulimit -v 3000000; exec {sys.executable} -c "$CODE"'
    environment = {**os.environ, "CODE": code}
    done = subprocess.run(
        ["sh", "-c", shell], env=environment, capture_output=True, text=True, check=True
    )
    first, used = done.stdout.splitlines()
    left, limit, what = first.split(" ", 2)
    assert (int(limit), what) == (3000000 << 10, "`ulimit -v`")
    assert abs(int(left) + (int(used) << 10) - int(limit)) < 8 << 20


def test_a_system_that_does_not_tell(tmp_path, monkeypatch):
    monkeypatch.delattr(host_memory.os, "sysconf")
    assert room(tmp_path, tmp_path) is None
