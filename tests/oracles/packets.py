"""Whether a ray's neighbours in a packet decide a bit of its path."""

from __future__ import annotations

from oracles.engine import PLAN, trace
from oracles.scenes import BLACK, glass
from photizon_cl.scene.files import load

_CENTRE = (-6210368627144.086, 20035115748699.0, -1.0)
"""Where one unit in the last place is a part in a few hundred of the bodies' sizes."""


def neighbours_decide_nothing() -> None:
    """Rays beside a concentrator's wall, far from the origin, at one lane and at four."""
    x, y, z = _CENTRE
    scene = load(
        {
            "schema": "photizon/1",
            "name": "a lens in a concentrator",
            "run": {"generation_cap": 8},
            "source": [
                {
                    "name": "lamp",
                    "kind": "lambertian-disk",
                    "flux": 1.0,
                    "position": [x, y - 0.61, z + 1.5],
                    "axis": "+x",
                    "radius": 0.5,
                }
            ],
            "element": [
                {
                    "name": "lens",
                    "kind": "biconvex",
                    "position": [x, y, z + 0.5],
                    "axis": "-x",
                    "front_radius": 1.0,
                    "back_radius": 0.5,
                    "aperture_radius": 0.5,
                    **glass(1.5),
                },
                {
                    "name": "wall",
                    "kind": "cpc",
                    "position": [x, y, z],
                    "axis": "-x",
                    "exit_radius": 0.5,
                    "acceptance_deg": 30.0,
                    **BLACK,
                },
            ],
        }
    )
    one, four = (
        trace(scene, rays_per_batch=256, plan=PLAN.with_(lanes=lanes)).digest for lanes in (1, 4)
    )
    assert one == four
