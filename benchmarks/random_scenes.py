"""Scenes of many elements, of every kind, that share a program whatever their number."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

import photizon_cl as pz

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
SURFACES = (
    pz.Absorber(), pz.Mirror(0.9), pz.Lambertian(0.8), pz.Mirror(0.5), pz.Lambertian(0.3),
)  # fmt: skip


def _flat(cls, i, g, size, tilted, common):
    tilt = tuple(g.uniform(-80.0, 80.0, 2)) if tilted else (0.0, 0.0)
    if cls is pz.Disk:
        return pz.Disk(radius=size, tilt_deg=tilt, **common)
    return pz.Rectangle(half_width=size, half_height=0.7 * size, tilt_deg=tilt, **common)


def _element(i, g, size, common):
    # kinds in turn, not at random: the classes and so the program are the same for every scene
    kind = i % 10
    if kind < 4:
        return _flat((pz.Rectangle, pz.Disk)[kind % 2], i, g, size, kind >= 2, common)
    if kind < 6:
        return pz.Sphere(radius=size, port_fraction=0.2 * (kind - 4), **common)
    if kind == 6:
        return pz.PlanoConvex(curvature_radius=2.0 * size, aperture_radius=size, **common)
    if kind == 7:
        return pz.Biconvex(
            front_radius=2.0 * size, back_radius=1.5 * size, aperture_radius=size, **common
        )
    if kind == 8:
        return pz.BaffledTube(
            half_width=0.5 * size, length=size, baffles=1, clear_half_width=0.3 * size, **common
        )
    return pz.Cpc(exit_radius=0.2 * size, acceptance_deg=40.0, **common)


def random_scene(n, seed, simple=False):
    """Return a scene of n elements in a cube of 2 m around a point source.

    `simple` keeps to planes and spheres, for scenes too small to hold every kind twice.
    """
    g = np.random.default_rng(seed)
    elements = []
    for i in range(n):
        common = {
            "name": f"e{i}",
            "position": tuple(float(x) for x in g.uniform(-1.0, 1.0, 3)),
            # one axis where there are too few elements for every class to occur twice
            "axis": AXES[(i // 10) % 6] if n >= 130 and not simple else "+z",
            "surface": SURFACES[i % 5],
        }
        size = float(0.5 * n ** (-1.0 / 3.0) * g.uniform(0.3, 1.0))
        elements.append(_element(i % 6 if simple else i, g, size, common))
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.0, 0.0, 0.0))
    return pz.Scene(name="random", source=(source,), element=tuple(elements))


def filled_scene(n, seed, simple=False):
    """Return about n elements that fill a closed room, each in a cell of its own.

    A ray goes a cell or two from hit to hit, however many there are. The cells are a cube of an
    even number a side, so that the source stands between them. `simple` keeps to planes and
    spheres, whose program builds faster.
    """
    g = np.random.default_rng(seed)
    side = 2 * round(0.5 * n ** (1.0 / 3.0))
    cell = 2.0 / side
    elements = list(_room())
    for i, at in enumerate(np.ndindex(side, side, side)):
        middle = (np.array(at) + 0.5) * cell - 1.0
        common = {
            "name": f"e{i}",
            "position": tuple(float(x) for x in middle + 0.05 * cell * g.uniform(-1.0, 1.0, 3)),
            "axis": AXES[(i // 10) % 6],
            "surface": SURFACES[i % 5],
        }
        elements.append(_element(i % 6 if simple else i, g, float(0.4 * cell), common))
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.0, 0.0, 0.0))
    return pz.Scene(name="filled", source=(source,), element=tuple(elements))


def tiled_scene(n, seed, simple=False):
    """Return a closed room whose walls are tiled by n rectangles, with a few things in it.

    `simple` keeps to planes and spheres.
    """
    g = np.random.default_rng(seed)
    side = max(int(np.ceil(np.sqrt(n / 6.0))), 1)
    half = 1.0 / side
    elements = []
    for wall in range(6):
        axis, sign = wall // 2, 1.0 - 2.0 * (wall % 2)
        for i in range(side * side):
            u, v = (2 * (i % side) + 1) * half - 1.0, (2 * (i // side) + 1) * half - 1.0
            position = [0.0, 0.0, 0.0]
            position[axis], position[(axis + 1) % 3], position[(axis + 2) % 3] = -sign, u, v
            elements.append(pz.Rectangle(
                name=f"w{wall}t{i}", position=tuple(position), axis=AXES[wall],
                half_width=half, half_height=half, surface=SURFACES[i % 5],
            ))  # fmt: skip
    for i in range(60):
        common = {
            "name": f"e{i}", "position": tuple(float(x) for x in g.uniform(-0.8, 0.8, 3)),
            "axis": AXES[(i // 10) % 6], "surface": SURFACES[i % 5],
        }  # fmt: skip
        elements.append(_element(i % 6 if simple else i, g, 0.05, common))
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.01, 0.02, 0.03))
    return pz.Scene(name="tiled", source=(source,), element=tuple(elements))


LENGTHS = frozenset({
    "radius", "half_width", "half_height", "curvature_radius", "aperture_radius", "front_radius",
    "back_radius", "length", "clear_half_width", "exit_radius",
})  # fmt: skip


def elsewhere(elements, unit, away):
    """Return elements in units of another length, moved along every axis."""
    for e in elements:
        row = {f.name: unit * getattr(e, f.name) for f in fields(e) if f.name in LENGTHS}
        yield replace(e, position=tuple(unit * x + away for x in e.position), **row)


def _room():
    for wall, axis in enumerate(AXES):
        position = [0.0, 0.0, 0.0]
        position[wall // 2] = -1.2 if wall % 2 == 0 else 1.2
        yield pz.Rectangle(
            name=f"room{axis}", position=tuple(position), axis=axis, half_width=1.2,
            half_height=1.2, surface=pz.Lambertian(0.8),
        )  # fmt: skip
