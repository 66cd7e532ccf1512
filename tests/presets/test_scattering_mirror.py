"""The preset `scattering-mirror`: what an ABg lobe of g = 2 sends where."""

from __future__ import annotations

import math

import pytest

import photizon_cl as pz

A, B, INNER, OUTER = 1e-3, 1e-2, 1 / 401, 1 / 5
TIS = math.pi * A * math.log(1.0 + 1.0 / B)
DISK = math.pi * A * math.log(1.0 + INNER / B)
RING = math.pi * A * math.log((B + OUTER) / (B + INNER))
REST = math.pi * A * math.log((B + 1.0) / (B + OUTER))


@pytest.mark.statistical
def test_its_anchor():
    """Within 5 σ, a false alarm in 10^4 with 31 degrees of freedom for the three of them."""
    scene = pz.load("scattering-mirror").replace({"element.specular.detector.paths": 4})
    result = pz.trace(scene, batches=32, max_seconds=1e6)
    ledger, detectors = result.ledger, result.detectors
    assert ledger.absorbed["mirror"].value == pytest.approx(0.02, abs=1e-15)
    assert abs(ledger.closure) <= 1e-15
    paths = {row.sequence: row for row in detectors["specular"].paths}
    specular = paths["mirror.face r > specular"]
    assert specular.power == pytest.approx(0.98 - TIS, rel=1e-8)
    aside = paths["mirror.face s > specular"]
    escaped = ledger.escaped
    for power, sigma, wanted in (
        (aside.power, aside.sigma, DISK),
        (detectors["ring"].power.value, detectors["ring"].power.sigma, RING),
        (escaped.value, escaped.sigma, REST),
    ):
        assert abs(power - wanted) < 5.0 * sigma
        assert sigma < 0.02 * wanted
    anchor = pz.presets()["scattering-mirror"].anchor
    assert f"{TIS:.10f} W" in anchor
    for watts in (DISK, RING, REST):
        assert f"{watts:.9f} W" in anchor
