"""A scene file traced by Raysect, for test_tracers.py: a program of its own.

``by_raysect.py SAMPLES SEED < scene.json`` prints watts on the element ``sensor`` and their
standard error for every line of the spectrum, so many samples each. Rays begin at the sensor. Needs
`raysect`.

What it knows: one `lambertian-disk` as bright in every line; spheres and `biconvex` lenses of
`fresnel` media with dispersion and absorption, a number or a table; rectangles of `lambertian`.
"""

from __future__ import annotations

import json
import math
import sys
from typing import Any

import numpy as np
from raysect.core import AffineMatrix3D, Point3D, rotate_x, rotate_y, translate
from raysect.core.math.random import seed as set_seed
from raysect.core.workflow import SerialEngine
from raysect.optical import ConstantSF, InterpolatedSF, World
from raysect.optical.material import Dielectric, Lambert, UniformSurfaceEmitter
from raysect.optical.material.dielectric import Sellmeier
from raysect.optical.observer import Pixel, PowerPipeline0D
from raysect.primitive import Box, Cylinder, Intersect, Sphere

TURNS = {
    "+z": AffineMatrix3D(), "-z": rotate_x(180), "+x": rotate_y(90), "-x": rotate_y(-90),
    "+y": rotate_x(-90), "-y": rotate_x(90),
}  # fmt: skip
"""Turns that bring +z onto an axis; what they turn is round, or square."""
THIN = 1e-7


def placed(given: dict[str, Any]) -> AffineMatrix3D:
    x, y, z = given["position"]
    return translate(x, y, z) * TURNS[given["axis"]]


def spectral(given: Any, key: str) -> Any:
    """Return a number or a table over wavelength; constant outside it."""
    if not isinstance(given, dict):
        return ConstantSF(given)
    at, value = given["wavelength_nm"], given[key]
    return InterpolatedSF([0.0, *at, 1e5], [value[0], *value, value[-1]])


def glass(medium: dict[str, Any]) -> Dielectric:
    """Return a body's material; Raysect tells transmission of one metre."""
    law = medium["dispersion"]
    pairs = [number for pair in zip(law["B"], law["C_um2"], strict=True) for number in pair]
    index = Sellmeier(*(pairs[k] for k in (0, 2, 4, 1, 3, 5)))
    lost = medium["absorption_per_m"]
    if isinstance(lost, dict):
        # exp(−α) is not linear between the nodes of α: as fine as need be
        at = np.linspace(min(lost["wavelength_nm"]), max(lost["wavelength_nm"]), 2001)
        kept = np.exp(-np.interp(at, lost["wavelength_nm"], lost["per_m"]))
        return Dielectric(index, InterpolatedSF(at, kept))
    return Dielectric(index, ConstantSF(math.exp(-lost)))


def build(scene: dict[str, Any], world: World) -> dict[str, Any]:
    """Put a scene into a world; return its sensor."""
    media = {one["name"]: one for one in scene["medium"]}
    (lamp,) = scene["source"]
    lines = len(scene["spectrum"]["wavelengths_nm"])
    radiance = lamp["flux"] / lines / (math.pi * math.pi * lamp["radius"] ** 2)
    # a slab shines on both sides, and nothing stands behind it
    Cylinder(lamp["radius"], THIN, world, placed(lamp), UniformSurfaceEmitter(ConstantSF(radiance)))
    sensor: dict[str, Any] = {}
    for element in scene["element"]:
        surface, where = element["surface"], placed(element)
        if element["name"] == "sensor":
            sensor = element
        elif element["kind"] == "sphere":
            Sphere(element["radius"], world, where, glass(media[surface["medium"]]))
        elif element["kind"] == "biconvex":
            parts, rim = [], element["aperture_radius"]
            for key, up in (("front_radius", -1.0), ("back_radius", 1.0)):
                radius = element[key]
                middle = up * math.sqrt(radius * radius - rim * rim)
                parts.append(Sphere(radius, transform=translate(0, 0, middle)))
            Intersect(
                *parts, parent=world, transform=where, material=glass(media[surface["medium"]])
            )
        else:
            u, v = element["half_width"], element["half_height"]
            Box(
                Point3D(-u, -v, -THIN), Point3D(u, v, 0.0), world, where,
                Lambert(spectral(surface["reflectance"], "value")),
            )  # fmt: skip
    return sensor


def main() -> None:
    """Answer with power and standard error of every line, in watts."""
    samples, number = map(int, sys.argv[1:])
    scene = json.load(sys.stdin)
    world = World()
    sensor = build(scene, world)
    found = []
    for at in scene["spectrum"]["wavelengths_nm"]:
        set_seed(number)
        pipeline = PowerPipeline0D(accumulate=False)
        pixel = Pixel(
            [pipeline], 2 * sensor["half_width"], 2 * sensor["half_height"], world,
            placed(sensor), pixel_samples=samples, spectral_bins=1,
            min_wavelength=at - 0.5, max_wavelength=at + 0.5, quiet=True,
        )  # fmt: skip
        pixel.ray_extinction_min_depth, pixel.ray_extinction_prob = 20, 0.05
        pixel.ray_max_depth = 500
        pixel.render_engine = SerialEngine()
        pixel.observe()
        found.append({"value": pipeline.value.mean, "sigma": pipeline.value.error()})
    print(json.dumps(found))


if __name__ == "__main__":
    main()
