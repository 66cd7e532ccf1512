"""Coated faces and polarised light, beside coherency matrices and the coatings' own amplitudes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles.polarised import GREEN, Step, arriving, bench, coated_chain, glass

import photizon_cl as pz


@pytest.mark.parametrize("seed", range(6))
def test_a_chain_of_coated_faces(seed):
    coated_chain(seed)


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
