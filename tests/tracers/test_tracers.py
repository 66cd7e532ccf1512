"""Scenes with media, spectra or scatter against Mitsuba 3 and Raysect, which share nothing with us.

Both go from the sensor to the lamp, and are programs of their own. Left out unless asked for with
``-m tracers``, where ``pip install photizon-cl[tracers]`` has brought them; Mitsuba needs a libLLVM
besides (Debian's ``libllvm19``).

False alarms: fifteen |z| ≤ 4 of normal estimates, 15 · 6.3e-5 = 1e-3 in all; the seeds are fixed.
"""

from __future__ import annotations

import ctypes.util
import importlib.util
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from shared_scenes import MITSUBA, RAYSECT

import photizon_cl as pz

HERE = Path(__file__).parent
SIGMA = 0.005
"""Relative, at most, on either side."""
LLVM = "DRJIT_LIBLLVM_PATH"

pytestmark = [pytest.mark.tracers, pytest.mark.statistical]


def told_by(program: str, scene: dict[str, Any], samples: int) -> Any:
    """Return what a program says of a scene."""
    env = dict(os.environ)
    found = ctypes.util.find_library("LLVM-19")
    if found and LLVM not in env:
        env[LLVM] = found
    done = subprocess.run(
        [sys.executable, HERE / program, str(samples), "1"],
        input=json.dumps(scene), capture_output=True, text=True, env=env, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def agree(ours: Any, theirs: dict[str, float]) -> None:
    assert ours.sigma <= SIGMA * ours.value
    assert theirs["sigma"] <= SIGMA * theirs["value"]
    z = (ours.value - theirs["value"]) / math.hypot(ours.sigma, theirs["sigma"])
    print(ours, theirs, f"{z:+.2f}")
    assert abs(z) <= 4.0


@pytest.mark.skipif(not importlib.util.find_spec("mitsuba"), reason="needs mitsuba")
@pytest.mark.parametrize("scene", MITSUBA, ids=lambda scene: scene["name"])
def test_mitsuba_agrees(scene):
    theirs = told_by("by_mitsuba.py", scene, 1 << 19)
    ours = pz.trace(scene, target=0.002, target_on=["detectors.sensor.power"], max_seconds=600.0)
    agree(ours.detectors["sensor"].power, theirs)


@pytest.mark.skipif(not importlib.util.find_spec("raysect"), reason="needs raysect")
@pytest.mark.parametrize("scene", RAYSECT, ids=lambda scene: scene["name"])
def test_raysect_agrees_in_every_line(scene):
    theirs = told_by("by_raysect.py", scene, 1_000_000)
    ours = pz.trace(scene, target=0.0014, target_on=["detectors.sensor.power"], max_seconds=600.0)
    lines = ours.detectors["sensor"].power.by_wavelength
    for one, other in zip(lines, theirs, strict=True):
        agree(one, other)
