"""Rays at lines where tubes, lenses, concentrators, balls and plates meet: none gets through."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles import gates
from oracles.curved import leaks_of, rays_in
from oracles.pairs import alternately
from oracles.regions import REGIONS, made

from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror

if TYPE_CHECKING:
    from oracles.curved import Region

PLACES = [(1.0, 0.0), (1e-6, 0.0), (1e6, 1.3), (1e-6, 37.0), (1.0, 1e3), (1e-9, 0.1), (1e9, 3.0)]
"""Size of a region, and its distance from the origin in that size."""
TILTS = [(33.3, 0.0), (0.0, -71.7), (1e-8, 0.0), (89.999999, 0.0), (21.0, -34.0)]
RAYS = 1000


def placed(r: np.random.Generator, kind: str, surface: Any, number: int, tilt: Any) -> Region:
    scale, away = PLACES[number]
    return made(kind, surface, tilt, scale, away * scale * r.uniform(-1, 1, 3))


@pytest.mark.parametrize(
    ("kind", "surface"),
    alternately(REGIONS, {"mirrors": Mirror(1.0), "matt": Lambertian(1.0)}, every=3),
)
def test_no_ray_gets_through_where_surfaces_meet(kind: str, surface: Any) -> None:
    """Mirrors along the axes and matt surfaces that are tilted, at every size and distance."""
    for number in range(len(PLACES)):
        r = np.random.default_rng([21, number])
        tilt = (0.0, 0.0) if surface.kind == "mirror" else TILTS[number % len(TILTS)]
        region = placed(r, kind, surface, number, tilt)
        starts, along = rays_in(r, region, RAYS)
        assert leaks_of(region, starts, along) == (0, 0), (PLACES[number], tilt)


@pytest.mark.parametrize("reflected", [False, True], ids=["refracted", "reflected"])
@pytest.mark.parametrize("kind", ["halved lens", "lens on a plate", "ball in lens"])
def test_no_ray_gets_through_where_glass_meets_a_wall(kind: str, reflected: bool) -> None:
    """In and out of a glass lens that a mirror cuts, in a ball of mirrors."""
    for number in range(len(PLACES)):
        r = np.random.default_rng([22, number])
        region = placed(r, kind, Mirror(1.0), number, TILTS[number % len(TILTS)])
        region.elements[0] = replace(region.elements[0], surface=Fresnel(index=1.5))
        del region.heights[0]
        if kind != "ball in lens":
            region.ball((0.0, 0.0, 0.0), 1.2)
        starts, along = rays_in(r, region, RAYS)
        assert leaks_of(region, starts, along, reflected=reflected) == (0, 0), PLACES[number]


@pytest.mark.slow  # tests/mutants asserts it before it breaks anything
def test_the_gate_of_the_mutants_holds() -> None:
    gates.curved_corners_hold()
