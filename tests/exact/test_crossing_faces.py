"""Faces that cross, and hits that tie to within rounding: no leak, no trap, one order."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from oracles.engine import open_device, scene_of, trace, with_tree
from oracles.scenes import beam, matt

import photizon_cl as pz
from hostcode.run.probe import probe_rays
from photizon_cl.compile.compiled import compile_scene

pytestmark = pytest.mark.usefixtures("built_quickly")

BALL = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0, **matt(1.0)}
ULP = 2.0**-53


@pytest.mark.parametrize("tilt", [0.0, 17.0, 45.0])
def test_a_sphere_that_a_rectangle_cuts_leaks_nothing(tilt: float) -> None:
    """Rays run beside the rectangle, units in the last place away, into the line of the cut."""
    normal = np.array([np.sin(np.radians(tilt)), 0.0, np.cos(np.radians(tilt))])
    plate = {"kind": "rectangle", "position": [0, 0, 0], "axis": "+z", "tilt_deg": [0.0, tilt],
             "half_width": 1.5, "half_height": 1.5, **matt(1.0)}  # fmt: skip
    starts = [normal * k * ULP + [0.0, 0.5, 0.0] for k in (0, 2, 8, 20, 50, 200)]
    lamps = [beam(tuple(map(float, s)), "+y", 1e-20) for s in starts]
    found = trace(scene_of(lamps, [BALL, plate]), rays_per_batch=6 * 2048, generation_cap=60)
    assert found.escaped == 0


@pytest.mark.parametrize("shape", ["disk", "rectangle"])
def test_no_ray_is_trapped_where_a_disk_meets_a_sphere(shape: str) -> None:
    """Rays aimed at the rim go on; without losses all of them leave through the port."""
    size = {"radius": 1.0} if shape == "disk" else {"half_width": 1.0, "half_height": 1.0}
    plate = {"kind": shape, "position": [0, 0, 0], "axis": "+z", **size, **matt(1.0)}
    starts = [0.5, *(1.0 - 2.0**-k for k in (40, 50, 51, 52, 53))]
    lamps = [beam((x, 0.0, 2.0**-31), "-z", 1e-20) for x in starts]
    scene = scene_of(lamps, [{**BALL, "port_fraction": 0.25}, plate])
    found = trace(scene, rays_per_batch=6 * 512, generation_cap=1000)
    assert found.depth_capped == 0
    assert found.interactions < 10 * 6 * 512


def test_hits_that_tie_have_one_order_in_tree_and_scan() -> None:
    """Planes units in the last place apart, one hit at its edge: the first named of the nearest."""
    gap = 2.0**-50

    def plate(name, z, x, half):
        size = {"half_width": half, "half_height": 1.0, "surface": {"kind": "absorber"}}
        return {"name": name, "kind": "rectangle", "position": [x, 0.0, z], "axis": "+z", **size}

    lamp = {"name": "s", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 1.0]}
    g = np.random.default_rng(1)
    device = open_device()
    for order in list(itertools.permutations("ABC")) * 8:
        far = [plate(f"f{i}", 30.0 - 60.0 * (i % 2), float(g.uniform(-10, 10)), 0.3)
               for i in range(60)]  # fmt: skip
        a, c = g.uniform(-8.0, 8.0, 2)
        half = float(2.0 ** g.integers(0, 4))
        tied = {
            "A": plate("A", -2.0 * gap, float(a), abs(float(a)) + 1.0),
            "B": plate("B", -gap, half * float(g.choice([-1.0, 1.0])), half),
            "C": plate("C", -gap, float(c), abs(float(c)) + 1.0),
        }
        elements = [tied[name] for name in order] + far
        scene = pz.load(
            {"schema": "photizon/1", "name": "ties", "source": [lamp], "element": elements}
        )
        hit = set()
        for accelerate in (False, True):
            tables = compile_scene(scene, scene.run, **with_tree(accelerate)).tables
            origins = np.tile([0.0, 0.0, 1.0], (16, 1))
            directions = np.tile([0.0, 0.0, -1.0], (16, 1))
            _, found = probe_rays(device, tables, np.hstack([origins, directions]), 16)
            hit.add(elements[int(found[0])]["name"])
        first = min("BC", key=order.index)  # they lie in one plane, A behind them
        assert hit == {first}, order
