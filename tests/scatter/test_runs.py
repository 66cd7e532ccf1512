"""Scatter in traces: shares, choices, targets, furnace, bits, precisions, paths."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles import scattering
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.lobes import LOBES
from oracles.scattering import plate
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.compile.compiled import compile_scene

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


def test_both_parts_of_every_ray_go_on():
    scattering.both_parts_go_on()


def test_ledgers_close():
    scattering.closes()


@pytest.mark.statistical
def test_one_of_two_goes_on_where_rays_do_not_split():
    scattering.one_of_two_goes_on()


NAMED = ("gaussian", "abg", "harvey-shack", "lambertian", "table")
CASES = [
    *((name, {"kind": "absorber"}, 1.0) for name in NAMED),
    ("gaussian", {"kind": "mirror", "reflectance": 0.9}, 1.0),
    ("gaussian", {"kind": "fresnel", "index": 1.5}, 0.04),
]


@pytest.mark.statistical
@pytest.mark.parametrize("aimed", [True, False])
def test_targets_get_what_the_bsdf_sends_there(aimed):
    """Of every model and surface: drawn towards them, which changes no mean, and as it comes."""
    scattering.rings_over_plates(CASES, aimed=aimed)


@pytest.mark.statistical
@pytest.mark.parametrize(
    "name",
    [
        "abg, flat",
        "table, hill",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("gaussian, wide", "lambertian")),
    ],
)
def test_a_white_furnace_stays_white(name):
    scattering.white_furnace(name)


# -- bits ------------------------------------------------------------------------------------------


def busy(**run):
    """Glass, mirrors and black walls that scatter, a target, roulette, a path table."""
    lobes = {name: LOBES[name].to_table() for name in ("abg", "gaussian", "table", "lambertian")}
    glass = {"kind": "fresnel", "index": 1.5, "scatter": lobes["gaussian"]}
    elements = [
        {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.4, "surface": glass},
        {**wall((0, 0, 1), "-z"), "surface": {"kind": "mirror", "reflectance": 0.9,
                                              "scatter": lobes["abg"]}},
        {**wall((0, 0, -1), "+z"), "surface": {"kind": "absorber", "scatter": lobes["table"]}},
        {**wall((1, 0, 0), "-x"), "surface": {"kind": "mirror", "reflectance": 0.7}},
        {**wall((-1, 0, 0), "+x"), "surface": {"kind": "lambertian", "reflectance": 0.6}},
        {**wall((0, 1, 0), "-y"), **BLACK, "detector": {"map": [4, 4], "paths": 64}},
        {**wall((0, -1, 0), "+y"), "surface": {"kind": "absorber", "scatter": lobes["lambertian"]}},
    ]  # fmt: skip
    scene = scene_of(
        [{"kind": "isotropic-point", "flux": 1.0, "position": [0.5, 0.1, 0.6]}],
        elements,
        importance={"toward": ["element 5"], "fraction": 0.3},
    )
    return compiled(scene, rays_per_batch=512, generation_cap=8, roulette_floor=1e-3, **run)


@pytest.mark.parametrize(
    "changes",
    [
        {"composition": "classical", "lanes": 8},
        pytest.param({"lanes": 8}, marks=pytest.mark.slow),
        pytest.param({"composition": "classical", "lanes": 1}, marks=pytest.mark.slow),
        pytest.param(
            {"composition": "whole-path", "lanes": 1, "stack_rays": 1}, marks=pytest.mark.slow
        ),
        pytest.param({"lanes": 16, "interleaved": True}, marks=pytest.mark.slow),
    ],
)
def test_the_bits_are_the_same_however_it_runs(changes):
    made = busy()
    assert made.tables.spec.children == 3
    runs = [trace_compiled(made, 2, plan=plan) for plan in (PLAN, PLAN.with_(**changes))]
    assert runs[0].digest == runs[1].digest
    assert max(map(abs, runs[0].closures())) <= 1e-14


def test_rays_that_do_not_split_close_exactly():
    found = trace_compiled(busy(splitting=False), 2)
    assert not found.compiled.tables.spec.splits
    assert found.closures() == [0, 0]


@pytest.mark.parametrize("precision", [pytest.param("mixed", marks=pytest.mark.slow), "fp32"])
def test_other_precisions_scatter_the_same_share(precision):
    lobe = LOBES["harvey-shack"]
    scene = plate({"kind": "absorber", "scatter": lobe.to_table()})
    found = trace(scene, rays_per_batch=256, precision=precision)
    assert float(found.escaped / found.emitted) == pytest.approx(float(lobe.total(40.0)), rel=3e-6)
    assert found.closures() == [0]


def test_what_has_no_scatter_has_nothing_of_it():
    """Not even where it is forced on does a bit change."""
    scene = pz.load("ghost-ladder")
    made = compile_scene(scene, scene.run)
    text = program_source(made.tables.spec.for_device(4, ("wave",)))
    assert "lobe_t" not in text
    forced = compile_scene(scene, scene.run, frozenset({"scattering", "scatter.abg"}))
    assert "try_abg" in program_source(forced.tables.spec.for_device(4, ("wave",)))
    assert trace_compiled(made).digest == trace_compiled(forced).digest


# -- words -----------------------------------------------------------------------------------------


def seen_by_a_sensor(**run):
    """A mirror at 45° in a beam, seen by a sensor that is wider than the beam."""
    surface = {"kind": "mirror", "reflectance": 0.9, "scatter": LOBES["gaussian"].to_table()}
    fold = {**wall((0, 0, 0), "+z", 0.5), "tilt_deg": [0.0, 45.0], "surface": surface}
    sensor = {**wall((1, 0, 0), "-x", 0.2), **BLACK, "detector": {"paths": 8}}
    lamp = beam((0, 0, 1.0), "-z", 0.01)
    names = [{"name": "fold", **fold}, {"name": "sensor", **sensor}]
    return scene_of([lamp], names, run={"rays_per_batch": 2048, **run})


def test_path_tables_tell_what_scattered():
    result = pz.trace(seen_by_a_sensor(), batches=2)
    detector = result.detectors["sensor"]
    found = {row.sequence: row.power for row in detector.paths}
    assert set(found) == {"fold.face r > sensor", "fold.face s > sensor"}
    tis = float(LOBES["gaussian"].total(45.0))
    assert found["fold.face r > sensor"] == pytest.approx(0.9 - tis, rel=1e-8)
    assert math.fsum(found.values()) == pytest.approx(detector.power.value, rel=1e-15)


def test_a_parameter_of_a_lobe_is_swept():
    sweep = pz.sweep(
        {
            "schema": "photizon-sweep/1",
            "scene": seen_by_a_sensor(),
            "vary": [{"path": "element.fold.surface.scatter.sigma", "values": [0.02, 0.1, 0.4]}],
            "run": {"batches": 1},
            "measure": {"power": "detectors.sensor.power"},
        }
    )
    power = np.asarray(sweep.to_dataframe()["power"])
    assert (np.diff(power) < 0.0).all()
