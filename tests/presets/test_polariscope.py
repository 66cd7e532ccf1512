"""The preset `polariscope`: Malus's law between two glasses at Brewster's angle."""

from __future__ import annotations

import pytest

import photizon_cl as pz

pytestmark = pytest.mark.usefixtures("one_lane")


def test_its_anchor():
    scene = pz.load("polariscope")
    detectors = pz.trace(scene, batches=1, rays_per_batch=64).detectors
    wanted = {"first block": 0.875, "second block": 0.1171875, "sensor": 1 / 128}
    anchor = pz.presets()["polariscope"].anchor
    for name, watts in wanted.items():
        assert detectors[name].power.value == pytest.approx(watts, rel=0.0, abs=1e-14)
        assert f"{watts} W" in anchor
    mean = scene.replace({"run.polarisation": False})
    without = pz.trace(mean, batches=1, rays_per_batch=64).detectors["sensor"].power.value
    assert without == pytest.approx(1 / 64, rel=0.0, abs=1e-14)
    assert "1/64 W" in anchor
