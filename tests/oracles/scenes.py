"""Scenes that several tests use, as a file's tables."""

from __future__ import annotations

import random
from typing import Any

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
BLACK = {"surface": {"kind": "absorber"}}


def mirror(reflectance: float = 1.0) -> dict[str, Any]:
    """Return a mirror surface, to be merged into an element."""
    return {"surface": {"kind": "mirror", "reflectance": reflectance}}


def matt(reflectance: float = 1.0) -> dict[str, Any]:
    """Return a Lambertian surface."""
    return {"surface": {"kind": "lambertian", "reflectance": reflectance}}


def glass(index: float, outside: float = 1.0) -> dict[str, Any]:
    """Return a Fresnel surface."""
    return {"surface": {"kind": "fresnel", "index": index, "index_outside": outside}}


def random_scene(number: int, *, rays: int = 300, alike: bool = False) -> dict[str, Any]:
    """Return a scene with every kind of everything, at random places and turned at random.

    Scenes that are `alike` have one program where tilt and shares are forced: there are two of
    every sphere and of every material, and of flat elements one across each axis and a tilted one.
    """
    r = random.Random(1000 + number)

    def place(spread: float) -> dict[str, Any]:
        position = [r.uniform(-spread, spread) for _ in range(3)]
        tilt = [r.uniform(-180, 180), r.uniform(-90, 90)] if r.random() < 0.7 else [0.0, 0.0]
        return {"position": position, "axis": r.choice(AXES), "tilt_deg": tilt}

    def rectangle() -> dict[str, Any]:
        half = {"half_width": r.uniform(0.3, 1.2), "half_height": r.uniform(0.3, 1.2)}
        return {"kind": "rectangle", **place(2.0), **half}

    def disk() -> dict[str, Any]:
        return {"kind": "disk", **place(2.0), "radius": r.uniform(0.3, 1.2)}

    def sphere(**port: float) -> dict[str, Any]:
        return {"kind": "sphere", **place(2.0), "radius": r.uniform(0.3, 1.2), **port}

    some_mirror = lambda: mirror(r.uniform(0.5, 1.0))  # noqa: E731
    some_matt = lambda: matt(r.uniform(0.5, 1.0))  # noqa: E731
    some_glass = lambda: glass(r.uniform(1.0, 2.5), r.uniform(1.0, 2.5))  # noqa: E731
    elements = [
        {**rectangle(), **BLACK, "detector": {"map": [5, 3], "generations": 6}},
        {**disk(), **BLACK, "detector": {"map": [4, 7]}},
        {**sphere(), **BLACK, "detector": {"map": [6, 4], "side": "outside", "generations": 3}},
        {**sphere(), **BLACK, "detector": {"map": [7, 3], "side": "inside"}},
        {**rectangle(), **some_mirror()},
        {**disk(), **some_mirror()},
        {**rectangle(), **some_matt()},
        {**disk(), **some_matt()},
        {**rectangle(), **some_glass()},
        {**disk(), **some_glass()},
        {**sphere(), **some_glass()},
        {**sphere(port_fraction=r.uniform(0.01, 0.6)), **some_mirror()},
        {**sphere(port_fraction=r.uniform(0.01, 0.6)), **some_matt()},
    ]
    if alike:
        for kind in ("rectangle", "disk"):
            for n, flat in enumerate(e for e in elements if e["kind"] == kind):
                letter = "xyzt"[(n + number) % 4]
                if letter != "t":
                    flat |= {"axis": flat["axis"][0] + letter, "tilt_deg": [0.0, 0.0]}
                elif not any(flat["tilt_deg"]):
                    flat["tilt_deg"] = [30.0 + number, -20.0]
    r.shuffle(elements)
    sources = []
    kinds = ("isotropic-point", "cosine-point", "lambertian-disk", "lambertian-sphere")
    for kind in (*kinds, "collimated-disk"):
        source = {"name": kind, "kind": kind, "flux": r.uniform(0.1, 10.0), **place(2.0)}
        if kind in ("isotropic-point", "lambertian-sphere"):
            del source["axis"], source["tilt_deg"]
        if not kind.endswith("point"):
            source["radius"] = r.uniform(0.05, 0.5)
        sources.append(source)
    return {
        "schema": "photizon/1",
        "name": f"random {number}",
        "run": {"rays_per_batch": rays, "generation_cap": 9, "roulette_floor": 0.05},
        "far_field": {"n_mu": 5, "n_phi": 6},
        "source": sources,
        "element": [{"name": f"element {n}", **e} for n, e in enumerate(elements)],
    }


def everything() -> dict[str, Any]:
    """Return a random scene in which most of it is lit, with shares that are not the fluxes'."""
    tables = random_scene(4)
    for source, share in zip(tables["source"], (1.0, 2.0, 3.0, 1.0, 1.5), strict=True):
        source["share"] = share
    return tables


def wall(position: tuple[float, float, float], axis: str, half: float = 1.0) -> dict[str, Any]:
    """Return a square rectangle without a surface."""
    shape = {"kind": "rectangle", "half_width": half, "half_height": half}
    return {**shape, "position": list(position), "axis": axis}


def cube(surface: dict[str, Any], half: float = 1.0) -> list[dict[str, Any]]:
    """Return the six walls of a closed cube around the origin, normals inwards."""
    walls = []
    for n, axis in enumerate(AXES):
        position = [0.0, 0.0, 0.0]
        position[n // 2] = -half if axis[0] == "+" else half
        walls.append({**wall(tuple(position), axis, half), **surface})
    return walls


def beam(
    position: tuple[float, float, float], axis: str, radius: float = 1e-6, **more: Any
) -> dict[str, Any]:
    """Return a collimated source of 1 W."""
    where = {"position": list(position), "axis": axis}
    return {"kind": "collimated-disk", "flux": 1.0, **where, "radius": radius, **more}
