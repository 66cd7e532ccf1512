"""The preset `absorbing-cuvette`: what a dyed liquid between two windows takes and lets through."""

from __future__ import annotations

import pytest

import photizon_cl as pz

R, S, HALF = 0.04, 1 / 289, 0.5
WINDOW = (1 - R) * (1 - S) / (1 - R * S)
BACK = 1 - WINDOW
THROUGH = WINDOW**2 * HALF / (1 - (BACK * HALF) ** 2)
RETURNED = BACK + THROUGH * BACK * HALF


def test_its_anchor():
    result = pz.trace("absorbing-cuvette", batches=4, rays_per_batch=1024)
    ledger = result.ledger
    # roulette plays for children below 1e-9, some hundreds of a ray
    assert result.detectors["transmitted"].power.value == pytest.approx(THROUGH, abs=1e-8)
    assert result.detectors["reflected"].power.value == pytest.approx(RETURNED, abs=1e-8)
    taken = ledger.absorbed_in["dyed water"]
    assert taken.value == pytest.approx(1.0 - THROUGH - RETURNED, abs=1e-8)
    assert ledger.absorbed_in["glass"].value == 0.0
    assert abs(ledger.closure) <= 1e-15
    assert result.counts == {"media_mismatches": 0}
    anchor = pz.presets()["absorbing-cuvette"].anchor
    for watts in (THROUGH, RETURNED, 1.0 - THROUGH - RETURNED):
        assert f"{watts:.9f} W" in anchor


def test_a_sweep_over_the_dye_compiles_nothing_anew():
    """And at 0 the cuvette is one that takes nothing."""
    sweep = pz.sweep(
        {
            "schema": "photizon-sweep/1",
            "scene": "absorbing-cuvette",
            "vary": [
                {"path": 'medium."dyed water".absorption_per_m', "values": [0.0, 10.0, 200.0]}
            ],
            "run": {"rays_per_batch": 256},
            "measure": {
                "through": "detectors.transmitted.power",
                "taken": 'ledger.absorbed_in."dyed water"',
            },
        },
        batches=2,
    )
    assert sweep.programs == 1
    taken = [point.measures["taken"].value for point in sweep.points]
    assert taken[0] == 0.0
    assert 0.0 < taken[1] < taken[2]
