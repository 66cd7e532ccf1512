"""Gates with as many rays as it takes to see a mutant, and some of which a table has no other."""

from __future__ import annotations

from fractions import Fraction

from oracles import chance, gates, scattering
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, cube, matt, wall


def scatter() -> None:
    chance.lambertian_scatter(rays=1 << 15)


def tilted_scatter() -> None:
    chance.lambertian_scatter("-x", "back", rays=1 << 15)


def furnace() -> None:
    gates.closed_cube(matt(), rays=4096, cap=40)


def lobes() -> None:
    for name in ("gaussian", "harvey-shack", "abg", "table"):
        scattering.follows_the_bsdf(name, rays=1 << 13, angles=(80.0,))


def roulette() -> None:
    chance.roulette_is_unbiased()


def ghosts() -> None:
    gates.ghost_ladder(rays=64)


def sphere() -> None:
    chance.integrating_sphere(rays=1 << 14, batches=32, sigma=1e-3)


def isotropic() -> None:
    chance.source_directions("isotropic-point", rays=1 << 15)


def cosine_source() -> None:
    chance.source_directions("cosine-point", "-y", rays=1 << 15)


def disk_source() -> None:
    chance.disk_positions("collimated-disk", rays=1 << 14)


def reference() -> None:
    gates.reference_agrees(4)


def cap() -> None:
    gates.generation_cap(7)


def splits_and_absorbs() -> None:
    """Every bounce of a closed room takes a quarter, and the ledger says so."""
    mixed = {"surface": {"kind": "mixed", "specular": 0.25, "diffuse": 0.5}}
    found = trace(scene_of([LAMP], cube(mixed)), rays_per_batch=64, generation_cap=3)
    assert found.closures() == [0]
    assert found.depth_capped == 64 * Fraction(27, 64)


def passing() -> None:
    """Two planes that light passes, between a beam and a target."""
    planes = [
        {**wall((0, 0, z), "+z"), "surface": {"kind": "clear"}, "detector": {"side": "back"}}
        for z in (0.3, 0.6)
    ]
    elements = [*planes, {**wall((0, 0, 1), "-z"), **BLACK}]
    found = trace(scene_of([beam((0, 0, 0), "+z")], elements), rays_per_batch=64)
    assert found.interactions == 64
    assert [found.detector(f"element {n}").power for n in (0, 1)] == [64, 64]
    assert found.absorbed("element 2") == 64
    ball = {
        "kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5,
        "surface": {"kind": "clear"}, "detector": {"side": "inside"},
    }  # fmt: skip
    found = trace(scene_of([beam((0, 0, 1), "-z")], [ball]), rays_per_batch=64)
    assert found.detector("element 0").power == 64


LAMP = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
