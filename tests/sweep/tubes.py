"""A small scene that tests of sweeps vary, and sweeps of it."""

from __future__ import annotations

TUBE = {
    "schema": "photizon/1",
    "name": "tube",
    "run": {"rays_per_batch": 512},
    "source": [
        {
            "name": "sun",
            "kind": "collimated-disk",
            "flux": 1.0,
            "position": [0.0, 0.0, 0.3],
            "axis": "-z",
            "radius": 0.05,
        }
    ],
    "element": [
        {
            "name": "tube",
            "kind": "cylinder",
            "position": [0.0, 0.0, 0.2],
            "axis": "-z",
            "radius": 0.02,
            "length": 0.2,
            "surface": {"kind": "lambertian", "reflectance": 0.1},
        },
        {
            "name": "sensor",
            "kind": "disk",
            "position": [0.0, 0.0, 0.0],
            "axis": "+z",
            "radius": 0.02,
            "surface": {"kind": "absorber"},
            "detector": {},
        },
    ],
}
ANGLE = {"path": "source.sun.tilt_deg[0]", "name": "angle", "linspace": [0, 11, 12]}
WIDE = {"path": "source.sun.tilt_deg[0]", "name": "angle", "values": [0, 4, 8]}
WALL = {"path": "element.tube.surface.reflectance", "values": [0.1, 0.5]}
MEASURE = {
    "power": "detectors.sensor.power",
    "share": {"ratio": ["detectors.sensor.power", "ledger.absorbed.tube"]},
    "PST": {"pst": "sensor", "source": "sun"},
}


def a_sweep(*vary, **more):
    """Return the tables of a sweep of the tube, by default over the angle."""
    given = {"run": {"batches": 4}, "measure": MEASURE, **more}
    return {"schema": "photizon-sweep/1", "scene": TUBE, "vary": list(vary or (ANGLE,)), **given}
