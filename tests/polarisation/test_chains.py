"""Every weight along chains of faces at random angles, beside coherency matrices in space."""

from __future__ import annotations

import pytest
from oracles import polarised
from oracles.polarised import CLOSE, chain, replay

LIGHT = (None, {"degree": 1.0, "angle_deg": 30.0}, {"degree": 0.4, "angle_deg": -70.0})


@pytest.mark.parametrize("seed", range(8))
def test_a_chain_of_faces(seed):
    found = replay(chain(seed, 9, LIGHT[seed % 3]), 1)
    assert found["r"] + found["i"] >= 3
    assert found["difference"] < CLOSE


def test_every_surface_of_a_room():
    polarised.replays_a_room()
