"""Coated faces and polarised light, beside coherency matrices and the coatings' own amplitudes."""

from __future__ import annotations

import pytest
from oracles.polarised import CLOSE, chain, replay

LIGHT = (None, {"degree": 1.0, "angle_deg": 30.0}, {"degree": 0.4, "angle_deg": -70.0})
GREEN = {"spectrum": {"wavelengths_nm": [550.0]}}
COATINGS = (
    {"kind": "stack", "layers": [{"index": 1.38, "thickness_nm": 99.6}]},
    {"kind": "fixed", "reflectance": 0.3, "transmittance": 0.6},
    {
        "kind": "stack",
        "layers": [
            {"index": 2.3, "thickness_nm": 130.0},
            {"index": 1.46, "thickness_nm": 210.0},
            {"index": 0.9, "extinction": 0.8, "thickness_nm": 20.0},
        ],
    },
    {
        "kind": "table", "angle_deg": [0.0, 50.0, 90.0], "reflectance": [0.1, 0.3, 0.9],
        "transmittance": [0.8, 0.6, 0.0],
    },
)  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_a_chain_of_coated_faces(seed):
    scene = chain(seed, 9, LIGHT[1 + seed % 2], COATINGS, **GREEN)
    found = replay(scene, 1)
    assert found["r"] + found["i"] >= 3
    assert found["difference"] < CLOSE
