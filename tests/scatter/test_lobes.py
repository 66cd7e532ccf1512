"""Every model's sampler against its density, the shares that kernels take, and reciprocity.

Directions are compared with the BSDF by χ², in rings of Δ times sectors around the specular
direction, of which what lies beyond the horizon is cut off. All χ² are one family of level `ALPHA`;
seeds are fixed.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles.lobes import LOBES, NORMAL, drawn, way
from oracles.scattering import ALPHA, beta, follows_the_bsdf
from oracles.statistics import sidak

from photizon_cl.scene.scatters.total import total_at

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


@pytest.mark.statistical
@pytest.mark.parametrize("name", LOBES)
def test_directions_follow_the_bsdf_above_the_horizon(name):
    follows_the_bsdf(name, level=sidak(ALPHA, len(LOBES)))


@pytest.mark.parametrize("name", LOBES)
def test_a_lobe_is_the_same_at_two_widths_and_has_the_density_that_it_says(name):
    lobe, rays = LOBES[name], 36 * 16
    ways = np.array([way(angle, 77.0) for angle in np.linspace(0.0, 90.0, 37)[:-1]])
    narrow, broad = (drawn(name, ways, rays, lanes) for lanes in (1, 8))
    assert narrow.tobytes() == broad.tobytes()
    about = np.tile(ways, (16, 1))
    cosine = about @ NORMAL
    tis = total_at(lobe, cosine**2 / (1.0 + np.linalg.norm(beta(about), axis=1)))
    assert np.abs(narrow[0] - tis).max() <= 1e-8 * lobe.greatest_tis()[0]
    directions = narrow[1:4].T
    delta = np.linalg.norm(beta(directions - about), axis=1)
    wanted = lobe.bsdf(delta) * (directions @ NORMAL) / tis
    rounding = 4e-16 / lobe.width  # of a direction, in parts of the lobe
    assert narrow[4] == pytest.approx(wanted, rel=1e-7 + 16.0 * rounding, abs=0.0)
    # and what goes from one direction into another comes back by the same
    seen = (narrow[0] > 0.0) & (np.abs(directions @ NORMAL) > 1e-6) & (cosine > 1e-6)
    assert seen.sum() > rays // 2
    assert narrow[6, seen] == pytest.approx(narrow[5, seen], rel=1e-6 + 16.0 * rounding)
