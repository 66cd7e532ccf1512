"""Scenes of plates with maps, as large as a test of memory wants them."""

from __future__ import annotations

from dataclasses import replace

import photizon_cl as pz
from hostcode.run.usual import usual_plan
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.run.distribution import open_chosen

GB = 10**9
SIDE = 500


def scene(side=SIDE, far=None, detectors=1):
    """Return plates above each other, each with a map."""
    tables = pz.load("cosine-fourth").to_dict()
    plate = tables["element"][0]
    tables["element"] = [
        {**plate, "name": f"plate {n}", "position": [0.0, 0.0, -0.1 * n]} for n in range(detectors)
    ]
    for element in tables["element"]:
        element["detector"] = {"map": [side, side]} if side else {}
    tables["far_field"] = {"n_mu": far or 1, "n_phi": far or 1}
    return pz.load(tables)


def compiled(a_scene):
    return compile_scene(a_scene, a_scene.run)


def parts(a_scene, **changes):
    """Return a compiled scene, the usual device with changes, and its plan."""
    record = replace(open_chosen(None).record, **changes)
    made = compiled(a_scene)
    return made, record, usual_plan(record, made.tables)


def line_of(error):
    (line,) = str(error).splitlines()
    assert line.isprintable()
    return line
