"""Rays at the rims of lenses that stand on plates, fill tubes, touch each other: none gets through.

And rays that leave the edge as if it went on: each gets out where the 60-digit oracle has it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from oracles import lens_guards
from oracles.curved import leaks_of, rays_in
from oracles.lens_regions import LENS_REGIONS, lens_made

from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror

PLACES = [(1.0, 0.0), (1e-6, 0.0), (1e6, 1.3), (1e-6, 37.0), (1.0, 1e3), (1e-9, 0.1), (1e9, 3.0)]
"""Size of a region, and its distance from the origin in that size."""
TILTS = [(33.3, 0.0), (0.0, -71.7), (1e-8, 0.0), (89.999999, 0.0), (21.0, -34.0)]
RAYS = 1000


def regions() -> list[Any]:
    """Return kinds and shapes; of each kind all but the first shape are slow."""
    kinds: dict[str, int] = {}
    found = []
    for kind, shape in LENS_REGIONS:
        n = kinds[kind] = kinds.get(kind, -1) + 1
        marks = [pytest.mark.slow] if n else []
        found.append(pytest.param(kind, shape, id=f"{kind}-{shape}", marks=marks))
    return found


@pytest.mark.parametrize(("kind", "shape"), regions())
def test_no_ray_gets_through_at_a_rim(kind: str, shape: str) -> None:
    """Mirrors along the axes and matt surfaces that are tilted, in either order in the file."""
    for number, (scale, away) in enumerate(PLACES):
        for surface in (Mirror(1.0), Lambertian(1.0)):
            matt = surface.kind == "lambertian"
            r = np.random.default_rng([27, number, matt])
            tilt = TILTS[number % len(TILTS)] if matt else (0.0, 0.0)
            at = away * scale * r.uniform(-1, 1, 3)
            region = lens_made(kind, shape, surface, tilt, scale, at)
            if (number + matt) % 2:
                region.elements.reverse()
            starts, along = rays_in(r, region, RAYS)
            assert len(starts) > RAYS // 10
            assert leaks_of(region, starts, along) == (0, 0), (PLACES[number], tilt)


@pytest.mark.parametrize(
    "reflected",
    [False, pytest.param(True, marks=pytest.mark.slow)],
    ids=["refracted", "reflected"],
)
@pytest.mark.parametrize("shape", ["knife", "biconcave", "meniscus"])
def test_no_ray_gets_through_where_lenses_fill_a_tube(shape: str, reflected: bool) -> None:
    """In and out of lenses of glass that touch, in a mirror tube that disks close."""
    for number, (scale, away) in enumerate(PLACES):
        r = np.random.default_rng([28, number])
        at = away * scale * r.uniform(-1, 1, 3)
        tilt = TILTS[number % len(TILTS)]
        region = lens_made("stack", shape, Mirror(1.0), tilt, scale, at, Fresnel(index=1.5))
        starts, along = rays_in(r, region, RAYS)
        assert leaks_of(region, starts, along, reflected=reflected) == (0, 0), (
            PLACES[number],
            tilt,
        )


def test_rays_along_the_edge_get_out_where_they_do() -> None:
    """Where a half ball goes on from the edge, at sines from 1e-8 to 1e-15."""
    for seed, where in ((2, lens_guards.CENTRED), (3, lens_guards.AWAY)):
        assert lens_guards.wrong_ways_along_the_edge(where, seed, 400) == []


def test_what_runs_along_the_edge_leaves_by_the_face_that_goes_on_from_it() -> None:
    lens_guards.grazing_rays_leave_by_a_smooth_rim()


def test_a_screen_hides_a_lens_in_single_precision_too() -> None:
    lens_guards.a_screen_hides_the_lens_behind_it("fp32")


@pytest.mark.slow  # tests/mutants asserts them before it breaks anything
@pytest.mark.parametrize(
    "gate",
    [
        lens_guards.rims_hold,
        lens_guards.grazing_roots_stay,
        lens_guards.a_screen_hides_the_lens_behind_it,
    ],
    ids=lambda gate: gate.__name__,
)
def test_the_gates_of_the_mutants_hold(gate: Any) -> None:
    gate()
