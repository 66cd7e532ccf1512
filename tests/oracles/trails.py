"""Gates of the path table: what a plate's paths bring, and that they are all that arrives."""

from __future__ import annotations

from typing import Any

import numpy as np

from hostcode.run.trails import follow_trails
from hostcode.run.wavefront import Engine
from oracles.engine import PLAN, compiled, open_device
from photizon_cl.result.statistics import complete
from photizon_cl.result.trails import keys_of
from photizon_cl.scene.files import load

R = (0.5 / 2.5) ** 2


def _scene(rays: int) -> dict[str, Any]:
    def sheet(name: str, z: float, axis: str) -> dict[str, object]:
        return {
            "name": name, "kind": "disk", "position": [0, 0, z], "axis": axis, "radius": 0.5,
            "surface": {"kind": "fresnel", "index": 1.5},
        }  # fmt: skip

    return {
        "schema": "photizon/1", "name": "plate",
        "run": {"rays_per_batch": rays, "generation_cap": 9, "roulette_floor": 0.0},
        "source": [{
            "name": "beam", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -1],
            "axis": "+z", "radius": 0.1,
        }],
        "element": [
            sheet("front", 0.0, "-z"), sheet("back", 0.1, "+z"),
            {
                "name": "sensor", "kind": "rectangle", "position": [0, 0, 1], "axis": "-z",
                "half_width": 1.0, "half_height": 1.0, "surface": {"kind": "absorber"},
                "detector": {"paths": 9},
            },
        ],
    }  # fmt: skip


def beam(rays: int = 64) -> None:
    """Assert that rays with nothing in their way have one path, shown by the first of them."""
    tables = _scene(rays)
    made = compiled(load({**tables, "element": tables["element"][-1:]}), rays_per_batch=rays)
    (batch,) = Engine(open_device(), made.tables, PLAN).run(1, 1)
    found = batch.keyed
    assert found is not None
    assert found.first.tolist() == [rays]  # of batch 1
    assert found.rows[:, 3].tolist() == [rays]


def plate(rays: int = 64) -> None:
    """Assert the power, the arrivals, the first ray and the steps of every path of a plate."""
    scene = compiled(load(_scene(rays)), rays_per_batch=rays)
    device = open_device()
    (batch,) = Engine(device, scene.tables, PLAN).run(1, 1)
    found = batch.keyed
    assert found is not None
    power = complete(scene.layout, batch.cells)[scene.layout.detectors[0].power]
    low = found.rows[:, 0] * 2.0**-31 + found.rows[:, 1] * 2.0**-63
    assert abs(low.sum() - (power[0] * 2.0**-31 + power[1] * 2.0**-63)) < 1e-12
    # through, then with two, four and six reflections between the faces
    orders = np.argsort(-low)
    expected = [(1.0 - R) ** 2 * R ** (2 * k) * rays for k in range(4)]
    np.testing.assert_allclose(low[orders], expected, rtol=1e-12)
    assert (found.rows[:, 3] == rays).all()
    assert (found.first == rays).all()  # the first one of batch 1
    interactions = found.about & 0xFFFFFFFF
    steps = follow_trails(device, scene.tables, found.keys, found.first, interactions)
    front, back = 0, 1 << 20
    for k, order in enumerate(orders.tolist()):
        told = steps[order]
        assert told is not None
        turns = [back | 1, front | 1] * k
        assert told.tolist() == [front | 2, *turns, back | 2]
        key = keys_of(told, np.array([len(told)]), np.array([0]))
        assert key.tolist() == [found.keys[order]]
