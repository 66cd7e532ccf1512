"""Whether anything leaks out of closed bodies: ``python -m benchmarks.leaks``.

Traces 10^9 interactions in each body (``--interactions``), 2000 along each ray, and counts what
escaped, exactly. Exit status 1 where anything did.
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.report import Report
from hostcode.device.device import choose, open_device, preferred_lanes
from hostcode.program.plan import default_plan
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cone import Cone
from photizon_cl.scene.elements.conic import Conic
from photizon_cl.scene.elements.cylinder import Cylinder
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.general_lens import Lens
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.sheets import equator
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.frames import frame
from photizon_cl.scene.model import Scene
from photizon_cl.scene.settings import RunSettings
from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
from photizon_cl.scene.surfaces.clear import Clear
from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.families_mixed import room

if TYPE_CHECKING:
    from photizon_cl.scene.elements import Element

BOUNCES = 2000
RAYS = 65536
TILT = (33.3, -71.7)


def closed_bodies() -> dict[str, Scene]:
    """Return closed bodies that reflect everything, with a source inside each."""
    where: dict[str, Any] = {"name": "body", "position": (0.3, -0.2, 0.1), "axis": "+z"}
    tilted: dict[str, Any] = {**where, "tilt_deg": TILT}
    middle = np.add(where["position"], np.array([0.1, 0.1, 0.02]) @ np.array(frame("+z", TILT)))
    inside = tuple(middle.tolist())
    turned = tuple((np.array([0.1, 0.3, 0.4]) @ np.array(frame("+z", (33.3, 0.0)))).tolist())
    made: dict[str, Scene] = {}

    def add(name: str, elements: list[Element], at: tuple[float, ...]) -> None:
        source = IsotropicPoint(name="lamp", flux=1.0, position=at)
        made[name] = Scene(name="leak", source=(source,), element=tuple(elements))

    for kind, surface in (("mirrors", Mirror(1.0)), ("matt", Lambertian(1.0))):
        flat = list(room((0.1, 0.1, 0.1), (0.4, 0.5, 0.7), surface=surface))
        add(f"room of {kind}", flat, (0.2, 0.3, 0.4))
        skew = list(room((0.0, 0.0, 0.0), (0.3, 1.1, 0.7), (33.3, 0.0), surface))
        add(f"tilted room of {kind}", skew, turned)
        ball = Sphere(**where, radius=0.7, surface=surface)
        add(f"sphere, {kind}", [ball], (0.3, -0.1, 0.2))
        lens = Biconvex(
            **tilted, aperture_radius=1.0, front_radius=1.5, back_radius=1e6, surface=surface
        )
        add(f"biconvex, {kind}", [lens], inside)
        half = PlanoConvex(**tilted, aperture_radius=1.0, curvature_radius=1.5, surface=surface)
        add(f"plano-convex, {kind}", [half], inside)
        for name, shape in LENSES.items():
            # at the origin nothing but the lens itself is a measure of rounding
            here = {**tilted, "position": (0.0, 0.0, 0.0)} if kind == "matt" else tilted
            glass = Lens(
                **here, aperture_radius=1.0, **shape, surface=surface, edge=Lambertian(1.0)
            )
            low, high = glass.vertices[1], glass.vertices[0]
            at = np.add(glass.position, (0.4 * low + 0.6 * high) * np.array(glass.frame[2]))
            add(f"{name}, {kind}", [glass], tuple(at.tolist()))
        add(f"cemented doublet, {kind}", cemented(here, surface), on_glass(here))
        for name, walls in round_bodies(tilted, surface).items():
            add(f"{name}, {kind}", walls, on_axis(walls[0]))
    return made


def cemented(where: dict[str, Any], outer: Any) -> list[Element]:
    """Return two lenses that share a face, refracting where they are cemented, closed elsewhere."""
    white = Lambertian(1.0)
    crown = Lens(
        **where, aperture_radius=1.0, front_radius=1.5, back_radius=1.2, thickness=1.1,
        surface=outer, edge=white, back=Fresnel(1.5, 1.7),
    )  # fmt: skip
    flint = Lens(
        **{**where, "name": "flint"}, aperture_radius=1.0, front_radius=-1.2, back_radius=2.0,
        thickness=0.4, surface=outer, edge=white, front=Clear(),
    )  # fmt: skip
    down = (crown.vertices[1] - flint.vertices[0]) * np.array(crown.frame[2])
    at: Any = tuple(np.add(crown.position, down).tolist())
    return [crown, dataclasses.replace(flint, position=at)]


def on_glass(where: dict[str, Any]) -> tuple[float, ...]:
    """Return a point in the crown."""
    up = 0.05 * np.array(frame(where["axis"], where["tilt_deg"]))[2]
    return tuple(np.add(where["position"], up).tolist())


LENSES: dict[str, dict[str, float]] = {
    "meniscus": {"front_radius": 1.5, "back_radius": -2.5, "thickness": 0.3},
    "thin meniscus": {"front_radius": -1.5, "back_radius": 2.5, "thickness": 0.02},
    "biconcave": {"front_radius": -1.5, "back_radius": -2.5, "thickness": 0.2},
    "conic faces": {
        "front_radius": 0.9, "back_radius": 1.5, "front_conic": -2.25, "back_conic": -0.5,
        "thickness": 0.9,
    },
    "knife-edged meniscus": {
        "front_radius": 1.5, "back_radius": -2.5, "thickness": 1.5 - 1.25**0.5 - (2.5 - 5.25**0.5),
    },
}  # fmt: skip
"""Lenses by their faces; the rim has the radius 1."""


def on_axis(wall: Any) -> tuple[float, ...]:
    """Return a point on the axis of a wall of revolution, between its rims."""
    low, high = wall.heights
    place = np.add(wall.position, (0.4 * low + 0.6 * high) * np.array(wall.frame[2]))
    return tuple(place.tolist())


def round_bodies(where: dict[str, Any], surface: Any) -> dict[str, list[Any]]:
    """Return walls of revolution, each closed by disks or by another wall.

    Parameters
    ----------
    where : dict
        Name, position, axis and tilt of the walls.
    surface : Surface
        Of everything.
    """
    made: dict[str, list[Any]] = {}

    def close(name: str, wall: Any, rims: dict[float, tuple[float, ...]]) -> None:
        """Add disks of the radii at heights; with two radii an annulus and the disk in its hole."""
        parts = [wall]
        for z, radii in rims.items():
            place = np.add(wall.position, z * np.array(wall.frame[2]))
            for n, radius in enumerate(radii):
                sizes = {"radius": radius, "inner_radius": (*radii, 0.0)[n + 1]}
                at: Any = tuple(place.tolist())
                lid = {**where, "name": f"lid {len(parts)}", "position": at}
                parts.append(Disk(**lid, **sizes, surface=surface))
        made[name] = parts

    tube = Cylinder(**where, radius=0.4, length=1.1, surface=surface)
    close("cylinder", tube, {0.0: (0.4,), 1.1: (0.4,)})
    close("cylinder with annulus", tube, {0.0: (0.4, 0.15), 1.1: (0.4,)})
    frustum = Cone(**where, entrance_radius=0.5, exit_radius=0.2, length=0.7, surface=surface)
    close("frustum", frustum, {0.0: (0.5,), 0.7: (0.2,)})
    full = Cone(**where, entrance_radius=0.0, exit_radius=0.6, length=0.7, surface=surface)
    close("cone", full, {0.7: (0.6,)})
    for name, k, aperture in (
        ("paraboloid", -1.0, 0.8),
        ("hyperboloid", -2.5, 0.9),
        ("half an ellipsoid", -0.6, equator(0.5, -0.6)),
        ("ellipsoid", -0.6, 0.6),
        ("shallow sheet", -1.0, 0.02),
    ):
        sheet = Conic(
            **where,
            curvature_radius=0.5,
            conic_constant=k,
            aperture_radius=aperture,
            surface=surface,
        )
        close(name, sheet, {sheet.heights[1]: (aperture,)})
    holed = Conic(
        **where, curvature_radius=0.5, aperture_radius=0.4, inner_radius=0.1, surface=surface
    )
    low, high = holed.heights
    close("holed sheet", holed, {high: (0.4,), low: (0.1,)})
    return made


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.leaks")
    parser.add_argument("--device")
    parser.add_argument("--interactions", type=float, default=1e9, help="in each body")
    parser.add_argument("--out", type=Path, help="folder for leaks.txt and .json")
    parser.add_argument("--body", action="append", help="part of a body's name; may be given again")
    asked = parser.parse_args(arguments)
    device = open_device(choose(asked.device))
    report = Report()
    report.say(f"closed bodies on {device.record.label}, {BOUNCES} bounces a ray", "")
    report.say("body                     interactions   escaped (arrivals)   M interactions/s")
    # of two children one is chosen: a closed body of glass would hold ever more of them
    run = RunSettings(
        rays_per_batch=RAYS, generation_cap=BOUNCES, roulette_floor=0.0, splitting=False
    )
    rows = []
    for name, scene in closed_bodies().items():
        if asked.body and not any(part in name for part in asked.body):
            continue
        compiled = compile_scene(scene, run)
        lanes = preferred_lanes(device.record, compiled.tables.spec.effects)
        engine = Engine(device, compiled.tables, default_plan(device.record, lanes))
        escaped, first = 0, 0
        while engine.statistics.interactions < asked.interactions:
            batches = engine.batches_at_once
            for batch in engine.run(first, batches):
                # exact: the weight that left, in units of 2^-95
                escaped += int(np.abs(batch.cells[compiled.layout.escaped, :3]).sum())
            first += batches
        done = engine.statistics.interactions
        missing = first * RAYS * BOUNCES - done
        rate = done / engine.statistics.seconds / 1e6
        rows.append({"body": name, "interactions": done, "escaped": escaped, "missing": missing})
        report.say(f"{name:24s} {done:13,d}   {escaped + missing:18d}   {rate:16.1f}")
    if asked.out:
        report.write(asked.out, "leaks", {"rows": rows, "device": device.record.label})
    return int(any(row["escaped"] or row["missing"] for row in rows))


if __name__ == "__main__":
    raise SystemExit(main())
