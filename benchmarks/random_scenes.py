"""Random scenes of many elements, of every kind, that share a program whatever their number."""

from __future__ import annotations

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
            "axis": AXES[(i // 10) % 6] if not simple else "+z",
            "surface": SURFACES[i % 5],
        }
        size = float(0.5 * n ** (-1.0 / 3.0) * g.uniform(0.3, 1.0))
        elements.append(_element(i % 6 if simple else i, g, size, common))
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.0, 0.0, 0.0))
    return pz.Scene(name="random", source=(source,), element=tuple(elements))
