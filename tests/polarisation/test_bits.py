"""Polarised traces: bits, precisions, closure, and what a scene without has of it."""

from __future__ import annotations

import dataclasses

import pytest
from oracles import brewster
from oracles.brewster import X, pile
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled, with_tree
from oracles.polarised import CLOSE, ON, Step, arriving, bench, chain, glass
from oracles.scenes import BLACK, wall

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.presets import preset_names

TOLD = {"degree": 0.8, "angle_deg": 20.0}


def busy(force=frozenset(), without=frozenset(), **run):
    """Dyed glass, mirrors, matt walls, scatter, a target, roulette, a path table, a plane."""
    lobe = {"kind": "gaussian", "sigma": 0.2, "tis": 0.3}
    pane = {"kind": "fresnel", "medium": "dyed", "scatter": lobe}
    elements = [
        {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.4, "surface": pane},
        {**wall((0, 0, 1), "-z"), "surface": {"kind": "mirror", "reflectance": 0.9,
                                              "scatter": lobe}},
        {**wall((0, 0, -1), "+z"), "surface": {"kind": "mixed", "specular": 0.5, "diffuse": 0.3}},
        {**wall((1, 0, 0), "-x"), "surface": {"kind": "mirror", "reflectance": 0.7}},
        {**wall((-1, 0, 0), "+x"), "surface": {"kind": "lambertian", "reflectance": 0.6}},
        {**wall((0, 1, 0), "-y"), **BLACK, "detector": {"map": [4, 4], "paths": 64}},
        {**wall((0, -1, 0), "+y"), "surface": {"kind": "fresnel", "index": 1.6}},
        {**wall((0, 0.7, 0), "-y", 0.9), "surface": {"kind": "clear"}, "detector": {}},
    ]  # fmt: skip
    lamps = [
        {"kind": "isotropic-point", "flux": 1.0, "position": [0.5, 0.1, 0.6], "polarisation": TOLD},
        {"kind": "isotropic-point", "flux": 1.0, "position": [-0.5, 0.1, -0.6]},
    ]
    scene = scene_of(
        lamps,
        elements,
        importance={"toward": ["element 5"], "fraction": 0.3},
        medium=[{"name": "dyed", "index": 1.5, "absorption_per_m": 0.7}],
        run=ON,
    )
    settings = {"rays_per_batch": 512, "generation_cap": 8, "roulette_floor": 1e-3, **ON, **run}
    made = dataclasses.replace(scene.run, **settings)
    return compile_scene(scene, made, force, without)


@pytest.mark.parametrize(
    "changes",
    [
        {"lanes": 8},
        pytest.param({"composition": "classical", "lanes": 1}, marks=pytest.mark.slow),
        pytest.param(
            {"composition": "whole-path", "lanes": 1, "stack_rays": 1}, marks=pytest.mark.slow
        ),
        pytest.param({"lanes": 16, "interleaved": True}, marks=pytest.mark.slow),
    ],
)
def test_the_bits_are_the_same_however_it_runs(changes):
    made = busy()
    runs = [trace_compiled(made, 2, plan=plan) for plan in (PLAN, PLAN.with_(**changes))]
    assert runs[0].digest == runs[1].digest
    assert max(map(abs, runs[0].closures())) <= 1e-14
    without = trace_compiled(busy(polarisation=False), 2)
    assert without.digest != runs[0].digest


def test_neither_a_tree_nor_what_else_is_compiled_in_changes_a_bit():
    digest = trace_compiled(busy(), 1).digest
    assert trace_compiled(busy(**with_tree(tree=True)), 1).digest == digest
    force = frozenset({"tilt", "contact", "coincidence", "shares"})
    assert trace_compiled(busy(force), 1).digest == digest


def test_rays_that_do_not_split_close_exactly():
    found = trace_compiled(busy(splitting=False), 2)
    assert not found.compiled.tables.spec.splits
    assert found.closures() == [0, 0]


def one_face(on: bool) -> str:
    elements = [
        {**wall((0, 0, 0), "+z", 50.0), "surface": {"kind": "fresnel", "index": 1.52}},
        {**wall((0, 0, -1), "+z", 500.0), **BLACK, "detector": {}},
        {**wall((0, 0, 2), "-z", 500.0), **BLACK, "detector": {}},
    ]
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 1]}
    return trace(scene_of([lamp], elements), rays_per_batch=4096, polarisation=on).digest


def test_unpolarised_light_at_one_face_has_the_bits_that_it_had():
    assert one_face(on=True) == one_face(on=False)


def test_where_nothing_acts_by_it_no_bit_changes():
    """Mirrors and matt walls, where it may be forced on; with glass it may not."""
    scene = pz.load("cpc-concentrator")
    run = dataclasses.replace(scene.run, rays_per_batch=2048)
    plain = compile_scene(scene, run)
    forced = compile_scene(scene, run, frozenset({"polarisation"}))
    assert "polarisation" in forced.effects
    assert trace_compiled(plain).digest == trace_compiled(forced).digest
    ladder = pz.load("ghost-ladder")
    assert (
        "polarisation" not in compile_scene(ladder, ladder.run, frozenset({"polarisation"})).effects
    )


def test_a_scene_without_has_nothing_of_it():
    for name in preset_names():
        scene = pz.load(name)
        made = compile_scene(scene, scene.run)
        text = program_source(made.tables.spec.for_device(4, ("wave",)))
        assert ("stokes" in text) == scene.run.polarisation
        assert ("polarisation" in str(scene.to_dict()["run"])) == scene.run.polarisation


@pytest.mark.slow  # seven programs each
@pytest.mark.parametrize(("precision", "close"), [("mixed", 3e-6), ("fp32", 3e-6)])
def test_other_precisions(precision, close):
    for seed in (0, 1, 4):
        scene = chain(seed, 6, TOLD)
        wanted = arriving(scene)
        found = float(trace(scene, precision=precision).detector("end").power)
        assert found == pytest.approx(wanted, abs=close)
    # squarely, and then at Brewster's angle in the plane of the field
    square, crossed = Step(0.0, X, glass(1.5)), Step(56.309932474020215, X, glass(1.5))
    scene = bench([square, crossed], {"angle_deg": 0.0})
    assert float(trace(scene, precision=precision).detector("end").power) < 1e-10
    whole = trace(pile(1, 1.52, 60.0, TOLD, **ON), precision=precision)
    assert max(map(abs, whole.closures())) <= (1e-14 if precision == "mixed" else 1e-6)


def test_reciprocity():
    """Of unpolarised light a row of faces passes as much in either direction."""
    scene = chain(3, 6, None)
    forward = arriving(scene)
    end = scene.element["end"]
    lamp = {"kind": "collimated-disk", "flux": 1.0, "position": list(end.position), "radius": 1e-9}
    lamp |= {"axis": end.axis, "tilt_deg": list(end.tilt_deg)}
    tables = scene.to_dict()
    tables["source"] = [{"name": "back", **lamp}]
    faces = [row for row in tables["element"] if row["name"] != "end"]
    tables["element"] = [*faces, {"name": "end", **wall((0, 0, 0), "+z", 0.1), **BLACK,
                                  "detector": {}}]  # fmt: skip
    assert abs(arriving(pz.load(tables)) - forward) < CLOSE
    assert forward > 1e-4


def test_batches_in_two_pieces_are_those_in_one():
    made = busy()
    whole = trace_compiled(made, 3)
    parts = [trace_compiled(made, 1, first=0), trace_compiled(made, 2, first=1)]
    cells = [c.tobytes() for part in parts for c in part.batches]
    assert cells == [c.tobytes() for c in whole.batches]


def test_brewster_in_one_lane_and_in_eight():
    scene = brewster.pile(1, 1.52, 60.0, TOLD, **ON)
    runs = {trace_compiled(compiled(scene), plan=PLAN.with_(lanes=n)).digest for n in (1, 8)}
    assert len(runs) == 1
