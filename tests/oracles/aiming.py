"""Gates on importance sampling, for the engine as it is and for broken ones.

A narrow beam meets the middle of a wide matt plate of reflectance ρ. Of what that scatters a disk
of radius r across the axis at the height h gets r²/(r² + h²), and a ball of radius r around that
place r²/h²: both are sin² of a cone about the normal, of which a cosine lobe sends that part.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import photizon_cl as pz
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, cube, matt, wall
from oracles.statistics import batch_z, z_limit

ALPHA = 1e-6
"""False alarms of a gate: each of its three tests has a third of it."""
LAMP = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
RHO = 0.75


def room(toward: Any = ("target",), surface: Any = None, **more: Any) -> pz.Scene:
    """A matt room with a small black target on its floor, that scattered rays are sent towards."""
    target = {**wall((0.2, 0.1, -0.999), "+z", 0.05), **BLACK, "detector": {}, "name": "target"}
    importance = {"importance": {"toward": list(toward), **more}} if toward else {}
    return scene_of([LAMP], [*cube(surface or matt(0.6)), target], **importance)


def over_plate(shape: dict[str, Any], **aim: Any) -> pz.Scene:
    """A black target over the middle of a plate that a beam comes to from below the target."""
    plate = {**wall((0, 0, 0), "+z", 1e4), **matt(RHO), "name": "plate"}
    target = {"name": "target", "axis": "-z", **BLACK, "detector": {}, **shape}
    lamp = beam((0, 0, 0.01), "-z", 1e-9)
    return scene_of([lamp], [plate, target], importance={"toward": ["target"], **aim})


def gets_its_share(shape: dict[str, Any], share: float, rays: int, **aim: Any) -> None:
    """What arrives, what escapes and the balance have their expectations; every batch closes."""
    found = trace(over_plate(shape, **aim), batches=32, rays_per_batch=rays)
    assert found.closures() == [0] * 32
    layout = found.compiled.layout
    power, row = layout.detectors[0].power, layout.row("importance.balance")
    limit = z_limit(ALPHA / 3.0, 31)
    for cell, wanted in (
        (power, RHO * share * rays), (layout.escaped, RHO * (1.0 - share) * rays), (row, 0.0),
    ):  # fmt: skip
        z = batch_z(found, lambda x, cell=cell: x[cell], wanted)
        assert abs(z) < limit, (cell, z)
    assert found.detector("target").count > 0.3 * 32 * rays


def disk_over_a_plate() -> None:
    """A wide disk, whose rim is seen under a slant of 63°."""
    gets_its_share({"kind": "disk", "radius": 2.0, "position": [0, 0, 1]}, 0.8, 2048)


def ball_over_a_plate() -> None:
    """A ball near the plate, of which the outside counts."""
    ball = {"kind": "sphere", "radius": 0.9, "position": [0, 0, 1], "detector": {"side": "outside"}}
    gets_its_share(ball, 0.81, 2048)


def far_tiny_disk() -> None:
    """A disk of a micrometre, a kilometre away: it gets 1e-18 of the light, by half of the rays."""
    gets_its_share({"kind": "disk", "radius": 1e-6, "position": [0, 0, 1e3]}, 1e-18, 256)


def busy_room_closes() -> None:
    """Splits, roulette, two targets and a cap at once."""
    glossy = {"surface": {"kind": "mixed", "specular": 0.3, "diffuse": 0.5}}
    found = trace(
        room(("target", "element 3"), glossy, weights=[2.0, 1.0]), batches=2, rays_per_batch=512,
        roulette_floor=0.05, generation_cap=6,
    )  # fmt: skip
    assert max(map(abs, found.closures())) <= 1e-15


def weights_are_bounded(flux: tuple[float, ...] = (1.0,), floor: float = 0.0) -> None:
    """Thousands of bounces among white walls: no ray is ever twice as heavy as it was launched."""
    lamps = [{**LAMP, "flux": f, "share": 1.0} for f in flux]
    target = {**wall((0.2, 0.1, -0.999), "+z", 0.01), "name": "target", **matt(0.999)}
    scene = scene_of(
        lamps, [*cube(matt(0.999)), target], importance={"toward": ["target"], "fraction": 0.9},
        run={"generation_cap": 4000, "roulette_floor": floor},
    )  # fmt: skip
    paths = pz.paths(scene, rays=16 if floor == 0.0 else 512, max_segments=4000)
    first = np.unique(paths.ray, return_index=True)[1]
    ratio = paths.weight / paths.weight[first][np.searchsorted(paths.ray[first], paths.ray)]
    assert ratio.max() <= 2.0 * (1.0 + 2.0**-50)
    assert ratio.max() > 1.5  # it comes near: the bound is what holds it
    assert paths.generation.max() > 500


def roulette_spares_what_is_aimed() -> None:
    """A far small target gets 1e-8 of a plate's light in light rays, and none is played for."""
    shape = {"kind": "disk", "radius": 1e-2, "position": [0, 0, 100.0]}
    found = trace(over_plate(shape), rays_per_batch=4096, roulette_floor=1e-3)
    assert (found.killed, found.boosted) == (0, 0)
    assert abs(found.detector("target").count - 2048) < 5 * math.sqrt(1024)
    assert abs(float(found.detector("target").power / 4096) / (RHO * 1e-8) - 1.0) < 0.1
