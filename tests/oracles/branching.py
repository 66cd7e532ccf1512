"""Gates of the choice of one child: what a surface that splits does where rays do not."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, cube, glass, wall

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

RAYS = 1 << 14


def mixed(specular: float, diffuse: float) -> dict[str, Any]:
    return {"surface": {"kind": "mixed", "specular": specular, "diffuse": diffuse}}


def pane(index: float = 1.5) -> Scene:
    """A pane between a beam and two black walls, one on either side."""
    ends = [{**wall((0, 0, z), axis), **BLACK} for z, axis in ((2, "-z"), (-1, "+z"))]
    return scene_of(
        [beam((0, 0, 0), "+z", 1e-3)], [{**wall((0, 0, 1), "-z"), **glass(index)}, *ends]
    )


def room(surface: dict[str, Any]) -> Scene:
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    return scene_of([lamp], cube(surface))


def chooses() -> None:
    """Each ray goes one way, whole, and as often as the reflectance says: 0.04 here."""
    found = trace(pane(), rays_per_batch=RAYS, splitting=False)
    assert found.closures() == [0]
    reflected, sent = found.absorbed("element 2"), found.absorbed("element 1")
    # whole rays: nothing is split, and nothing rounded
    assert reflected.denominator == sent.denominator == 1
    assert reflected + sent == RAYS
    assert found.interactions == 2 * RAYS
    # 5 sigma: a false alarm in 1.7 million
    assert abs(reflected - 0.04 * RAYS) < 5.0 * math.sqrt(RAYS * 0.04 * 0.96)


def rounds() -> None:
    """Where all of three thirds goes on, a wall takes no more than rounding, and never less."""
    takes_rounding(1 / 3, 2 / 3)


def takes_rounding(specular: float, diffuse: float) -> None:
    found = trace(
        room(mixed(specular, diffuse)), rays_per_batch=256, generation_cap=200, splitting=False
    )
    assert found.closures() == [0]
    taken = [found.absorbed(f"element {n}") for n in range(6)]
    assert all(amount >= 0 for amount in taken)
    # 200 roundings of at most 2^-53 each, on the way down
    assert sum(taken) <= 256 * 200 * Fraction(1, 2**52)


def takes_its_share() -> None:
    """A surface that splits and absorbs takes exactly what it takes of rays that split."""
    found = trace(room(mixed(0.25, 0.5)), rays_per_batch=512, generation_cap=7, splitting=False)
    kept = Fraction(3, 4) ** 7
    assert found.closures() == [0]
    assert found.depth_capped == 512 * kept
    assert sum(found.absorbed(f"element {n}") for n in range(6)) == 512 * (1 - kept)
    assert found.interactions == 512 * 7
