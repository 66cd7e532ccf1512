"""Rays from outside at the edges of closed bodies: none gets in."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.corners import box, entered, named, prism, rays_from_outside

from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame
from photizon_cl.scene.model import Scene
from photizon_cl.scene.settings import RunSettings
from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
from photizon_cl.scene.surfaces.absorber import Absorber
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.families_mixed import room

if TYPE_CHECKING:
    from oracles.corners import Chamber

SURFACES = pytest.mark.parametrize(
    "surface", [Mirror(1.0), Lambertian(1.0)], ids=["mirrors", "matt"]
)
PLACES = [(1.0, 0.0), (1e-6, 0.0), (1e6, 1.3), (1e-6, 37.0), (1.0, 1e3)]
TILTS = [(0.0, 0.0), (33.3, 0.0), (0.0, -71.7), (1e-8, 0.0), (89.999999, 0.0)]
RAYS = 4000


def in_a_ball(chamber: Chamber, surface: Any, size: float) -> Chamber:
    place = tuple(chamber.corners.mean(axis=0).astype(float).tolist())
    ball = Sphere(name="ball", position=place, axis="+z", radius=size, surface=surface)
    return replace(chamber, elements=named((*chamber.elements, ball)))


@SURFACES
def test_no_ray_gets_into_a_closed_box(surface: Any) -> None:
    for number, ((scale, away), tilt) in enumerate(zip(PLACES, TILTS, strict=True)):
        r = np.random.default_rng([31, number])
        at = away * scale * r.uniform(-1, 1, 3)
        low, high = at - scale * r.uniform(0.2, 1, 3), at + scale * r.uniform(0.2, 1, 3)
        walls = named(room(low.tolist(), high.tolist(), tilt, surface))
        chamber = in_a_ball(box(walls, low, high, tilt), surface, 9.0 * scale)
        starts, along = rays_from_outside(r, chamber, RAYS, 6)
        assert len(starts) > RAYS / 2
        assert entered(chamber, starts, along) == 0, (scale, away, tilt)


@pytest.mark.parametrize("degrees", [60.0, 30.0, 10.0, 1.0])
def test_no_ray_gets_into_a_sharp_prism(degrees: float) -> None:
    for number, (scale, away) in enumerate(PLACES):
        r = np.random.default_rng([32, number])
        chamber = prism(r, degrees, scale, away * scale * r.uniform(-1, 1, 3), Mirror(1.0))
        chamber = in_a_ball(chamber, Mirror(1.0), 9.0 * scale)
        starts, along = rays_from_outside(r, chamber, RAYS, 3)
        assert len(starts) > 500
        assert entered(chamber, starts, along) == 0, (scale, away)


def test_few_rays_get_into_a_tube_between_plates() -> None:
    """A ray that goes around a long edge within rounding may be taken for one that went through."""
    silver = Mirror(1.0)
    lost, aimed = 0, 0
    for number, ((scale, away), tilt) in enumerate(zip(PLACES, TILTS, strict=True)):
        r = np.random.default_rng([33, number])
        rows = np.array(frame("+z", tilt))
        low, high = np.array([-0.3, -0.3, 0.0]) * scale, np.array([0.3, 0.3, 2.0]) * scale
        at = away * scale * r.uniform(-1, 1, 3)
        ends = [tuple((z * scale * rows[2] + at).tolist()) for z in (0.0, 2.0)]
        where: dict[str, Any] = {"axis": "+z", "tilt_deg": tilt, "surface": silver}
        tube = BaffledTube(
            name="tube", position=ends[0], half_width=0.3 * scale, length=2.0 * scale, **where
        )
        wide: dict[str, Any] = {"half_width": 4.0 * scale, "half_height": 4.0 * scale}
        plates = [Rectangle(name="plate", position=end, **wide, **where) for end in ends]
        shift = rows @ at
        chamber = box((tube, *plates), low + shift, high + shift, tilt)
        # planes in the order of walls, then ends
        order = [0, 1, 3, 4, 2, 5]
        chamber = replace(chamber, normals=chamber.normals[order], offsets=chamber.offsets[order])
        chamber = in_a_ball(chamber, silver, 6.0 * scale)
        starts, along = rays_from_outside(r, chamber, RAYS, 4)
        aimed += len(starts)
        lost += entered(chamber, starts, along)
    assert aimed > 5000
    assert lost < 1e-3 * aimed


def test_what_stands_outside_decides_whether_sides_are_remembered() -> None:
    """A room with everything inside costs nothing more; a lamp or a plate outside of it does."""
    walls = room((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), surface=Absorber())
    plate = Rectangle(
        name="plate", position=(3.0, 0.0, 0.0), axis="+x", half_width=0.1, half_height=0.1,
        surface=Absorber(),
    )  # fmt: skip

    def remembers(elements: Any, place: tuple[float, float, float]) -> bool:
        lamp = IsotropicPoint(name="lamp", flux=1.0, position=place)
        scene = Scene(name="room", source=(lamp,), element=tuple(elements))
        return "contact" in compile_scene(scene, RunSettings()).effects

    assert not remembers(walls, (0.2, 0.3, 0.4))
    assert remembers(walls, (2.0, 0.3, 0.4))
    assert remembers((*walls, plate), (0.2, 0.3, 0.4))
