"""Whether a ray aimed at an edge or a corner gets through: ``python -m benchmarks.corners``.

Closed chambers of walls that touch, end on and cross each other and closed regions between curved
and flat elements, at many sizes, places and tilts. Rays are aimed at the edges and corners and up
to 8 units in the last place beside them, and followed for 30 interactions. Counts, exactly, those
that get outside. Exit status 1 where any does.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.report import Report
from photizon_cl.scene.surfaces.lambertian import Lambertian
from photizon_cl.scene.surfaces.mirror import Mirror

# the chambers are those of the tests
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from oracles.chambers import KINDS, walls
from oracles.corners import from_inside, leaks, polyhedron, prism, rays_at_edges
from oracles.curved import leaks_of, rays_in
from oracles.engine import open_device
from oracles.regions import REGIONS, made

if TYPE_CHECKING:
    from collections.abc import Callable

    Sample = Callable[[np.random.Generator, Any, float, np.ndarray], tuple[int, tuple[int, ...]]]

SCALES = (1.0, 1e-6, 1e6, 1e-9, 1e9)
AWAY = (0.0, 0.01, 1.3, 37.0, 1e3)
TURNS = (0.0, 0.0, 1e-8, 12.0, 33.3, -71.7, 89.999999, 90.0)
WEDGES = (60.0, 30.0, 10.0, 1.0, 0.1, 1e-2, 1e-4, 1e-6)
RAYS = 2000


def of_plates(make: Callable[..., Any], inside: bool = False) -> Sample:
    """Return what samples one body of plates: rays, and those escaped, absorbed and outside.

    `inside`: leave out the rays that start outside.
    """

    def sample(r: np.random.Generator, surface: Any, scale: float, at: np.ndarray) -> Any:
        body = make(r, surface, scale, at)
        rays = rays_at_edges(r, body, RAYS)
        starts, along = from_inside(body, *rays) if inside else rays
        return len(starts), leaks(body, starts, along)

    return sample


def chamber_of(kind: str) -> Sample:
    """Return what samples one chamber of walls."""

    def make(r: np.random.Generator, surface: Any, scale: float, at: np.ndarray) -> Any:
        low, high = at - scale * r.uniform(0.2, 1, 3), at + scale * r.uniform(0.2, 1, 3)
        turn = float(r.choice(TURNS))
        tilt = (turn, 0.0) if r.random() < 0.5 else (0.0, turn)
        return walls(kind, low, high, tilt, surface, r)

    return of_plates(make)


def polyhedra(sides: int) -> Sample:
    """Return what samples one polyhedron of crossing plates."""
    return of_plates(lambda r, surface, scale, at: polyhedron(r, sides, scale, at, surface))


def wedge(degrees: float) -> Sample:
    """Return what samples one prism with a sharp edge."""
    return of_plates(lambda r, surface, scale, at: prism(r, degrees, scale, at, surface), True)


def region_of(kind: str) -> Sample:
    """Return what samples one region with curved walls."""

    def sample(r: np.random.Generator, surface: Any, scale: float, at: np.ndarray) -> Any:
        a, b = r.choice(TURNS, 2)
        region = made(kind, surface, (float(a), float(b)), scale, at)
        starts, along = rays_in(r, region, RAYS)
        return len(starts), leaks_of(region, starts, along)

    return sample


def kinds() -> dict[str, Sample]:
    """Return everything that is sampled, by what it is."""
    found = {kind: chamber_of(kind) for kind in KINDS}
    found |= {f"polyhedron of {n} plates": polyhedra(n) for n in (4, 7)}
    found |= {f"wedge of {degrees:g} degrees": wedge(degrees) for degrees in WEDGES}
    return found | {kind: region_of(kind) for kind in REGIONS}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.corners")
    parser.add_argument("--rays", type=float, default=3e5, help="at each kind of edges")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="folder for corners.txt and .json")
    asked = parser.parse_args(arguments)
    device = open_device().record.label
    report = Report()
    report.say(f"rays aimed at edges and corners on {device}, up to 30 interactions each", "")
    report.say("edges of                                     rays   got through")
    rows = []
    for number, (kind, sample) in enumerate(kinds().items()):
        rays, through, place = 0, 0, 0
        while rays < asked.rays:
            r = np.random.default_rng([asked.seed, number, place])
            surface = (Mirror(1.0), Lambertian(1.0))[place % 2]
            scale = float(r.choice(SCALES))
            # far away along one axis and near along another is a case of its own
            at = r.choice(AWAY, 3 if r.random() < 0.5 else 1) * scale * r.uniform(-1, 1, 3)
            many, ways = sample(r, surface, scale, at)
            rays, through, place = rays + many, through + max(ways), place + 1
        rows.append({"edges": kind, "rays": rays, "through": through, "places": place})
        report.say(f"{kind:36s} {rays:12,d}   {through:11d}")
    total = sum(row["rays"] for row in rows)
    report.say("", f"{total:,d} rays, {sum(row['through'] for row in rows)} got through")
    if asked.out:
        report.write(asked.out, "corners", {"rows": rows, "device": device})
    return int(any(row["through"] for row in rows))


if __name__ == "__main__":
    raise SystemExit(main())
