"""Scenes in which a small detector is lit by what scatters, for importance sampling and without.

`TEN` are such that tracing without it reaches σ = 0.5 % in seconds; between them they have every
shape of a target, several targets, one that scatters on, what splits, sources of unequal weights
and elements of every fate in the way.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any, Final

import photizon_cl as pz

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["TEN", "patch_of_sphere", "plain", "tube"]

BLACK: Final = {"surface": pz.Absorber(), "detector": pz.Detector()}


def plain(scene: pz.Scene) -> pz.Scene:
    """Return the scene without importance sampling."""
    return dataclasses.replace(scene, importance=None)


def _scene(name: str, sources: Any, elements: Any, **aim: Any) -> pz.Scene:
    importance = pz.Importance(**{"toward": ("sensor",), **aim})
    run = pz.RunSettings(generation_cap=60, roulette_floor=0.0)
    return pz.Scene(name, sources, elements, run=run, importance=importance)


def _lamp(**more: Any) -> pz.IsotropicPoint:
    values = {"name": "lamp", "flux": 1.0, "position": (0.1, -0.2, 0.3), **more}
    return pz.IsotropicPoint(**values)


def _room(surface: pz.Lambertian | pz.Mixed, half: float = 1.0) -> tuple[pz.Rectangle, ...]:
    """Return the six walls of a closed cube, normals inwards."""
    walls = []
    for n, axis in enumerate(("+x", "-x", "+y", "-y", "+z", "-z")):
        at = [0.0, 0.0, 0.0]
        at[n // 2] = -half if axis[0] == "+" else half
        walls.append(
            pz.Rectangle(
                name=f"wall {axis}", position=tuple(at), axis=axis, half_width=half,
                half_height=half, surface=surface,
            )
        )  # fmt: skip
    return tuple(walls)


def _sensor(**more: Any) -> pz.Rectangle:
    values = {
        "name": "sensor", "position": (0.2, 0.1, -0.9), "axis": "+z", "half_width": 0.15,
        "half_height": 0.1, **BLACK, **more,
    }  # fmt: skip
    return pz.Rectangle(**values)


def patch_of_sphere(reflectance: float = 0.9, cap: int = 200) -> pz.Scene:
    """Return a sphere, a lamp off its centre and a one-sided patch of 1 % of the wall."""
    area = 0.01 * 4.0 * math.pi
    radius = math.sqrt(area / math.pi)
    wall = pz.Sphere(
        name="wall", position=(0, 0, 0), axis="+z", radius=1.0, surface=pz.Lambertian(reflectance)
    )
    patch = pz.Disk(
        name="sensor", position=(0, 0, -math.sqrt(1.0 - radius * radius)), axis="+z",
        radius=radius, surface=pz.Absorber(), detector=pz.Detector(generations=2),
    )  # fmt: skip
    made = _scene("patch of a sphere", (_lamp(position=(0.3, 0.2, 0.1)),), (wall, patch))
    return dataclasses.replace(made, run=pz.RunSettings(generation_cap=cap, max_seconds=1000))


def tube(
    reflectance: float, length: float, baffles: int, clear: float, sensor: float = 0.02
) -> pz.Scene:
    """Return a square tube of 0.2 m with matt baffles, lit at 60°, and a sensor at its far end.

    The beam's disk covers the entrance; 1 W/m² across the beam.
    """
    half, away, angle = 0.1, 0.5, 60.0
    radius, turn = 1.5 * half, math.radians(angle)
    sun = pz.CollimatedDisk(
        name="sun", flux=math.pi * radius * radius, axis="+z", tilt_deg=(angle, 0.0),
        position=(0.0, away * math.sin(turn), -away * math.cos(turn)), radius=radius,
    )  # fmt: skip
    walls = pz.BaffledTube(
        name="tube", position=(0, 0, 0), axis="+z", half_width=half, length=length,
        baffles=baffles, clear_half_width=clear, surface=pz.Lambertian(reflectance),
    )  # fmt: skip
    end = _sensor(position=(0, 0, length), axis="-z", half_width=sensor, half_height=sensor)
    return _scene(f"tube of {length:g} m", (sun,), (walls, end))


def matt_room() -> pz.Scene:
    """Return a closed matt room."""
    return _scene("matt room", (_lamp(),), (*_room(pz.Lambertian(0.7)), _sensor()))


def turned_sensor() -> pz.Scene:
    """Return a room with a target off the axes, of which both sides are met and one counts."""
    sensor = _sensor(position=(0.2, 0.1, -0.2), tilt_deg=(25.0, 40.0))
    return _scene("turned sensor", (_lamp(),), (*_room(pz.Lambertian(0.5)), sensor))


def annulus() -> pz.Scene:
    """Return a room with a ring as its target."""
    ring = pz.Disk(
        name="sensor", position=(0.2, 0.1, -0.9), axis="+z", radius=0.2, inner_radius=0.12, **BLACK
    )
    return _scene("annulus", (_lamp(),), (*_room(pz.Lambertian(0.7)), ring), fraction=0.3)


def ball() -> pz.Scene:
    """Return a room with a ball as its target, met from outside."""
    sensor = pz.Sphere(
        name="sensor", position=(-0.3, 0.4, -0.3), axis="+z", radius=0.1, surface=pz.Absorber(),
        detector=pz.Detector(side="outside"),
    )  # fmt: skip
    return _scene("ball", (_lamp(),), (*_room(pz.Lambertian(0.6)), sensor), fraction=0.6)


def glossy_room() -> pz.Scene:
    """Return a room whose walls split, each ray in a mirror's and a matt child."""
    made = _scene("glossy room", (_lamp(),), (*_room(pz.Mixed(0.2, 0.4)), _sensor()))
    return dataclasses.replace(made, run=pz.RunSettings(generation_cap=6, roulette_floor=0.02))


def glossy_by_choice() -> pz.Scene:
    """Return the same where one child of each ray is followed."""
    made = glossy_room()
    run = dataclasses.replace(made.run, splitting=False, roulette_floor=0.0)
    return dataclasses.replace(made, name="glossy room, one child", run=run)


def lens() -> pz.Scene:
    """Return a room with a lens in front of a sensor; rays are sent towards the lens."""
    glass = pz.PlanoConvex(
        name="lens", position=(0, 0, -0.6), axis="+z", curvature_radius=0.3, aperture_radius=0.2,
        surface=pz.Fresnel(1.5),
    )  # fmt: skip
    sensor = _sensor(position=(0, 0, -0.8))
    made = _scene("lens", (_lamp(),), (*_room(pz.Lambertian(0.5)), glass, sensor), toward=["lens"])
    return dataclasses.replace(made, run=pz.RunSettings(generation_cap=60, roulette_floor=1e-4))


def hidden() -> pz.Scene:
    """Return a sensor behind a screen, lit by way of a plate that rays are sent towards as well."""
    screen = pz.Disk(
        name="screen", position=(0, 0, 0), axis="+z", radius=0.6, surface=pz.Absorber()
    )
    plate = pz.Rectangle(
        name="plate", position=(1.2, 0, 0), axis="-x", half_width=0.3, half_height=0.3,
        surface=pz.Lambertian(0.8),
    )  # fmt: skip
    source = pz.CosinePoint(name="lamp", flux=1.0, position=(0, 0, 0.3), axis="+z")
    lid = pz.Rectangle(
        name="lid", position=(0, 0, 1.0), axis="-z", half_width=1.0, half_height=1.0,
        surface=pz.Lambertian(0.8),
    )  # fmt: skip
    sensor = _sensor(position=(0, 0, -0.5), half_width=0.3, half_height=0.3)
    return _scene(
        "hidden sensor", (source,), (screen, plate, lid, sensor), toward=("plate", "sensor"),
        weights=(2.0, 1.0), fraction=0.6,
    )  # fmt: skip


def two_lamps() -> pz.Scene:
    """Return a room with a weak lamp that launches as many rays as a strong one."""
    lamps = (_lamp(share=1.0), _lamp(name="weak", flux=0.05, position=(-0.4, 0.3, 0.0), share=1.0))
    return _scene("two lamps", lamps, (*_room(pz.Lambertian(0.7)), _sensor()), fraction=0.4)


TEN: Final[tuple[Callable[[], pz.Scene], ...]] = (
    lambda: patch_of_sphere(0.9, 60), matt_room, turned_sensor, annulus, ball, glossy_room,
    glossy_by_choice, lens, hidden, two_lamps,
)  # fmt: skip
"""What makes each of the ten; the detector is on ``sensor``."""
