"""Plates in a beam before a sensor, and scenes whose detectors all have path tables."""

from __future__ import annotations

import json
from functools import cache

import photizon_cl as pz

BLACK = {"surface": {"kind": "absorber"}}
SENSOR = {
    "name": "sensor", "kind": "rectangle", "position": [0, 0, 1], "axis": "-z",
    "half_width": 1.0, "half_height": 1.0, **BLACK, "detector": {"paths": 200},
}  # fmt: skip


def sheet(name, z, axis, index):
    return {
        "name": name, "kind": "disk", "position": [0, 0, z], "axis": axis, "radius": 0.5,
        "surface": {"kind": "fresnel", "index": index},
    }  # fmt: skip


def pile(plates, *, index=1.5, paths=200, cap=12, rays=64):
    """Return plane plates in a collimated beam at normal incidence, before a sensor."""
    elements = []
    for n in range(plates):
        elements += [
            sheet(f"in {n}", 0.1 * n, "-z", index), sheet(f"out {n}", 0.1 * n + 0.05, "+z", index)
        ]  # fmt: skip
    return {
        "schema": "photizon/1", "name": "pile",
        "run": {"rays_per_batch": rays, "generation_cap": cap, "roulette_floor": 0.0},
        "source": [{
            "name": "beam", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -1],
            "axis": "+z", "radius": 0.1,
        }],
        "element": [*elements, {**SENSOR, "detector": {"paths": paths}}],
    }  # fmt: skip


@cache
def plates(n):
    return pz.trace(pile(n), batches=2)


def with_tables(scene, paths=100):
    made = json.loads(json.dumps(scene))
    for element in made["element"]:
        if "detector" in element:
            element["detector"]["paths"] = paths
    return made
