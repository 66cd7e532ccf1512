"""Sizes have no smallest and no largest: what is 2^k times as large is hit 2^k times as far away.

Powers of two change no rounding, so everything must scale to the last bit; what does not has left
the range of doubles on its way, in a product of lengths.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from contract import turned

import photizon_cl as pz
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.registry import ELEMENTS

# a program a kind, for a few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

EXPONENTS = (-480, -340, 340, 480)
RAYS = 1500


def scaled(element, factor):
    """Return an element with every length times a factor."""
    lengths = {}
    for name, parameter in parameters_of(type(element)).items():
        value = getattr(element, name)
        if getattr(parameter, "unit", "") == "m" and value is not None:
            many = isinstance(value, tuple)
            lengths[name] = tuple(factor * x for x in value) if many else factor * value
    return replace(element, detector=None, **lengths)


def rays(element):
    """Rays from near and far towards the element's box, half of them to its corners and rims."""
    random = np.random.default_rng(3)
    low, high = map(np.array, element.local_box)
    aims = low + (high - low) * random.random((RAYS, 3))
    turn = 2.0 * np.pi * random.random(RAYS // 2)
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=1) * high[:2]
    aims[: RAYS // 2, :2] = rim
    aims[: RAYS // 2, 2] = random.choice([low[2], high[2]], RAYS // 2)
    spread = random.choice([0.1, 1.0, 5.0], (RAYS, 1)) * max(high - low)
    starts = (low + high) / 2.0 + random.normal(size=(RAYS, 3)) * spread
    along = (aims - starts) @ np.array(element.frame)
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.array(element.position) + starts @ np.array(element.frame), along


def probed(element, starts, along, factor):
    lamp = pz.IsotropicPoint(name="lamp", flux=1.0, position=(0.0, 0.0, 0.0))
    scene = pz.Scene(name="scaled", source=(lamp,), element=(scaled(element, factor),))
    return pz.probe(scene, factor * starts, along)


@pytest.mark.parametrize("kind", ELEMENTS)
def test_hits_scale_with_the_scene(kind):
    element = turned(kind)
    starts, along = rays(element)
    once = probed(element, starts, along, 1.0)
    met = once.element >= 0
    assert met.sum() > 100
    for exponent in EXPONENTS:
        factor = 2.0**exponent
        found = probed(element, starts, along, factor)
        assert (found.element == once.element).all()
        assert (found.face[met] == once.face[met]).all()
        assert (found.distance[met] / factor == once.distance[met]).all()
        assert (found.normal[met] == once.normal[met]).all()
