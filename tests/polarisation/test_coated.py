"""Coated faces and polarised light, beside coherency matrices and the coatings' own amplitudes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles.polarised import CLOSE, Step, arriving, bench, chain, glass, replay

import photizon_cl as pz

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


def test_malus_between_two_polarisers():
    # MacNeille's cube: behind one face of glass the films of a pile meet p at their Brewster angle,
    # n0 sin = nH nL / sqrt(nH² + nL²), and reflect s; its films are quarter waves there
    high, low, index, nm = 2.3, 1.38, 1.52, 550.0
    along = high * low / math.hypot(high, low)
    pair = [
        {"index": n, "thickness_nm": nm / 4.0 / math.sqrt(n * n - along * along)}
        for n in (high, low)
    ]
    pile = {"kind": "stack", "layers": [*pair * 8, pair[0]]}
    angle = math.degrees(math.asin(along / index))
    surface = {**glass(index, index), "coating": pile}
    waves = pz.StackCoating(layers=pile["layers"]).amplitudes(angle, index, index, nm=nm)
    t_s, t_p = abs(complex(waves.t_s)) ** 2, abs(complex(waves.t_p)) ** 2
    assert t_s < 1e-5
    assert t_p > 0.97
    for turn in range(0, 91, 15):
        phi = math.radians(turn)
        planes = np.array([1.0, 0.0, 0.0]), np.array([math.cos(phi), math.sin(phi), 0.0])
        steps = [Step(angle, plane, surface, through=True) for plane in planes]
        found = arriving(bench(steps, more=GREEN))
        square = math.cos(phi) ** 2
        crossed = t_s * t_p * (1.0 - square)
        assert found == pytest.approx(0.5 * (t_p**2 + t_s**2) * square + crossed, abs=1e-12)
        assert found / (0.5 * t_p**2) == pytest.approx(square, abs=2e-5)
