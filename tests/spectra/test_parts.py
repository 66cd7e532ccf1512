"""Two tables that leave nothing: between their nodes rounding may make a little more of them."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
from oracles.engine import scene_of, trace
from oracles.scenes import cube

import photizon_cl as pz

LAMP = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
MANY = {"wavelengths_nm": [400.0 + 300.0 * k / 255 for k in range(256)]}
BANDS = {"edges_nm": [400.0 + 300.0 * k / 32 for k in range(33)]}


def both(x: float, y: float) -> list[dict]:
    """What x and y are at 400 and 700 nm, and what they leave, in decimals as a file has them."""
    ends, rest = [400.0, 700.0], [round(1.0 - x, 3), round(1.0 - y, 3)]
    return [{"wavelength_nm": ends, "value": v} for v in ([x, y], rest)]


def pairs(number: int) -> list[tuple[float, float]]:
    r = random.Random(number)
    return [(0.94, 0.32), *((round(r.random(), 3), round(r.random(), 3)) for _ in range(5))]


@pytest.mark.parametrize("light", [MANY, BANDS], ids=["lines", "bands"])
@pytest.mark.parametrize("number", [1, 2])
def test_specular_and_diffuse_parts_take_nothing(light, number):
    walls = cube({})
    for wall, (x, y) in zip(walls, pairs(number), strict=True):
        specular, diffuse = both(x, y)
        wall["surface"] = {"kind": "mixed", "specular": specular, "diffuse": diffuse}
    found = trace(scene_of([LAMP], walls, spectrum=light), rays_per_batch=256, generation_cap=6)
    for row in range(6):
        assert 0 <= found.amount(row) < Fraction(1, 10**12)
    # what splitting rounds a weight by, and no more
    assert max(map(abs, found.closures())) <= Fraction(1, 10**15)
    assert abs(found.depth_capped - found.emitted) < Fraction(1, 10**11)


@pytest.mark.parametrize("light", [MANY, BANDS], ids=["lines", "bands"])
def test_parts_without_rounding_are_conserved_exactly(light):
    """Shares that are powers of two, one way or the other: all that arrives goes on."""
    walls = cube({})
    for wall, (x, y) in zip(walls, [(0.5, 0.5), (1.0, 1.0), (0.0, 0.0)] * 2, strict=True):
        specular, diffuse = both(x, y)
        wall["surface"] = {"kind": "mixed", "specular": specular, "diffuse": diffuse}
    found = trace(scene_of([LAMP], walls, spectrum=light), rays_per_batch=256, generation_cap=6)
    assert found.closures() == [0]
    assert found.depth_capped == found.emitted


def test_nodes_of_one_lie_between_those_of_the_other():
    """At a node the other table is interpolated, and the sum of both rounded."""
    for x, y in pairs(3) + pairs(4):
        specular, diffuse = both(x, y)
        nodes = [400.0, 450.0, 533.3, 611.7, 700.0]
        rest = [round(1.0 - (x + (nm - 400.0) / 300.0 * (y - x)), 15) for nm in nodes]
        pz.Mixed(specular, {"wavelength_nm": nodes, "value": rest})
        pz.Mixed({"wavelength_nm": nodes, "value": rest}, specular)
        pz.FixedCoating(specular, {"wavelength_nm": nodes, "value": rest})
        assert pz.Mixed(specular, diffuse).at(533.3).absorptance <= 2.0**-49
    rest[2] += 1e-14
    with pytest.raises(pz.SceneError, match=r"at 533\.3 nm"):
        pz.Mixed(specular, {"wavelength_nm": nodes, "value": rest})


def test_a_surface_at_a_wavelength_has_the_numbers_of_its_tables():
    specular, diffuse = both(0.94, 0.32)
    surface = pz.Mixed(specular, diffuse)
    found = surface.at(433.7)
    assert type(found) is pz.Mixed
    assert found.specular == surface.specular.at(433.7)
    assert found.diffuse == surface.diffuse.at(433.7)
    assert pz.Mixed(0.5, 0.25).at(433.7) == pz.Mixed(0.5, 0.25)
