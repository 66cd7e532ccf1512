"""`paths`: the segments of a few rays, and the ledger of the trace that they are part of."""

from __future__ import annotations

import numpy as np
import pytest

import photizon_cl as pz
from hostcode.device.device import choose, open_device
from hostcode.program.plan import ExecutionPlan
from hostcode.run.paths import trace_paths
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.result.paths import ENDINGS

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

RAYS = 40
GOES_ON, ABSORBED, ESCAPED, CAPPED, KILLED, NOT_FOLLOWED = range(len(ENDINGS))


def played(name, **run):
    scene = pz.load(name).to_dict()
    scene["run"] |= run
    return pz.load(scene)


def busy():
    """Return a scene with splitting, roulette, shares, tilts, contact and more than 8 elements."""
    scene = played("ghost-ladder", roulette_floor=1e-3, generation_cap=20).to_dict()
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 3.0, "position": [0.0, 0.0, 0.05]}
    scene["source"].append(lamp)
    ball = {
        "name": "ball", "kind": "sphere", "position": [0.0, 0.0, 0.0], "axis": "+x",
        "radius": 0.2, "port_fraction": 0.1, "tilt_deg": [10.0, 20.0],
        "surface": {"kind": "lambertian", "reflectance": 0.7},
    }  # fmt: skip
    scene["element"].append(ball)
    return pz.load(scene)


def named(scene):
    return scene if isinstance(scene, str) else "busy"


@pytest.mark.parametrize(
    "scene", ["cpc-concentrator", "plano-convex-condenser", "box-room", busy()], ids=named
)
def test_the_ledger_is_that_of_a_trace_bit_for_bit(scene):
    loaded = pz.load(scene)
    compiled = compile_scene(
        loaded, pz.RunSettings(rays_per_batch=RAYS, seed=5, generation_cap=12, roulette_floor=1e-3)
    )
    device = open_device(choose())
    engine = Engine(device, compiled.tables, ExecutionPlan(lanes=4, items=2, local_size=1))
    (batch,) = engine.run(0, 1)
    raw = trace_paths(device, compiled.tables, 4096)
    rows = compiled.layout.n_rows
    assert raw.cells[:rows].tolist() == batch.cells[:rows].tolist()
    assert not raw.cut.any()


@pytest.mark.parametrize("scene", ["ghost-ladder", "integrating-sphere", busy()], ids=named)
def test_segments_add_up_to_the_ledger(scene):
    found = pz.paths(scene, RAYS, seed=2)
    result = pz.trace(scene, seed=2, batches=1, rays_per_batch=RAYS)
    emitted = result.ledger.emitted.value
    assert found.power[found.parent < 0].sum() == pytest.approx(emitted, rel=1e-14)
    assert found.power[found.escaped].sum() == pytest.approx(
        result.ledger.escaped.value, rel=1e-13, abs=1e-18
    )
    black = {n: e.name for n, e in enumerate(found.scene.element) if e.surface.kind == "absorber"}
    for number, name in black.items():
        ends = (found.ending == ABSORBED) & (found.element == number)
        want = result.ledger.absorbed[name].value
        assert found.power[ends].sum() == pytest.approx(want, rel=1e-13)
        assert found.ledger[f"absorbed by {name}"] == pytest.approx(want, rel=1e-15)
        detector = result.detectors[name]
        for rung in detector.ladder[:-1]:
            here = ends & (found.generation == rung.generation)
            # one-sided: what the busy scene's wall sends to a detector's back is not counted
            assert found.power[here].sum() >= rung.value * (1.0 - 1e-13)
    rows = dict.fromkeys(result.ledger.absorbed)
    assert [f"absorbed by {name}" for name in rows] == list(found.ledger)[: len(rows)]


def test_segments_hang_together():
    found = pz.paths(busy(), RAYS)
    child = np.flatnonzero(found.parent >= 0)
    parent = found.parent[child]
    assert (parent < child).all()
    assert (found.start[child] == found.end[parent]).all()
    assert (found.ray[child] == found.ray[parent]).all()
    assert (found.generation[child] == found.generation[parent] + 1).all()
    splits = found.path[child] >> np.uint64(1) == found.path[parent]
    assert (splits | (found.path[child] == found.path[parent])).all()
    assert (found.path[child][found.begins[child]] & np.uint64(1) == 1).all()
    assert (found.begins[found.parent < 0]).all()
    assert set(found.ray[found.parent < 0]) == set(range(RAYS))
    assert ((found.element == -1) == found.escaped).all()
    assert (found.ending[found.parent[~found.begins]] == GOES_ON).all()
    assert (np.bincount(found.ending, minlength=6)[[GOES_ON, ABSORBED, ESCAPED, KILLED]] > 0).all()
    # what the probe says of the launched rays is where their first segments end
    first = found.parent < 0
    hits = pz.probe(busy(), found.start[first], (found.end - found.start)[first])
    assert hits.element.tolist() == found.element[first].tolist()


def test_polylines():
    found = pz.paths("ghost-ladder", 3, generation_cap=4)
    lines = list(found)
    assert sum(len(line.weight) for line in lines) == len(found)
    assert [line.ray for line in lines if line.parent < 0] == [0, 1, 2]
    whole = next(line for line in lines if line.ray == 1)
    assert whole.points.shape == (4, 3)
    assert whole.points[:, 2].tolist() == [-0.05, 0.0, 0.01, 0.1]
    assert whole.generation.tolist() == [0, 1, 2]
    assert whole.weight == pytest.approx([1.0, 0.96, 0.9216], rel=1e-15)
    assert whole.element.tolist() == [0, 1, 2]
    assert whole.ending == "absorbed"
    (reflected,) = (line for line in lines if line.ray == 1 and line.generation[0] == 1)
    assert reflected.weight[0] == pytest.approx(0.04, rel=1e-14)
    assert found.parent[np.flatnonzero(found.begins)[1]] == reflected.parent or reflected.parent > 0


def test_same_rays_in_a_longer_batch():
    few, many = pz.paths("box-room", 5, seed=9), pz.paths("box-room", 50, seed=9)
    n = len(few)
    assert (few.end == many.end[:n]).all()
    assert (few.weight == many.weight[:n]).all()
    assert few.power[0] == pytest.approx(10.0 * many.power[0], rel=1e-15)


def test_escaping_segments_have_a_length():
    found = pz.paths("cosine-fourth", 20, escape_length=0.25)
    out = found.escaped
    assert out.any()
    assert np.linalg.norm((found.end - found.start)[out], axis=1) == pytest.approx(0.25)
    assert found.escape_length == 0.25
    alone = {**pz.load("cosine-fourth").to_dict(), "element": []}
    assert np.linalg.norm(pz.paths(alone, 3).end - [0.0, 0.0, 1.0], axis=1) == pytest.approx(0.5)


def test_a_scene_far_away():
    tables = pz.load("ghost-ladder").to_dict()
    for item in (*tables["source"], *tables["element"]):
        item["position"] = (np.array(item["position"]) + 2.0**20).tolist()
    near, far = pz.paths("ghost-ladder", 4), pz.paths(tables, 4)
    assert (near.weight == far.weight).all()
    assert far.start - 2.0**20 == pytest.approx(near.start, abs=1e-9)


def test_what_is_cut_is_said():
    short = pz.paths("ghost-ladder", 6, max_segments=5)
    assert short.cut.tolist() == list(range(6))
    assert np.bincount(short.ray).tolist() == [5] * 6
    assert "6 of 6 rays" in short.advisories[0]
    assert "max_segments" in short.advisories[0]
    endings = {line.ending for line in pz.paths("integrating-sphere", 20, max_segments=2)}
    assert endings == {"escaped", "not followed"}
    capped = pz.paths("box-room", 20, generation_cap=2)
    assert capped.generation.max() == 1
    assert (capped.ending == CAPPED).any()
    assert "generation cap of 2" in capped.advisories[-1]
    assert pz.paths("box-room", 4).advisories == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rays": 0}, "rays: found 0, expected an integer from 1"),
        ({"rays": 2.5}, "rays: found 2.5"),
        ({"rays": True}, "rays: found true"),
        ({"seed": -1}, "seed: found -1"),
        ({"generation_cap": 0}, "generation_cap: found 0"),
        ({"max_segments": 0}, "max_segments: found 0"),
        ({"escape_length": 0.0}, "escape_length: found 0.0"),
        ({"escape_length": "far"}, "escape_length: found"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(pz.ArgumentError, match=message):
        pz.paths("box-room", **arguments)


def test_of_more_lines_than_rays_some_launch_one():
    """Two sources of eight lines: a batch has 16 rays at least, of which every third is drawn."""
    lines = [400.0 + 50.0 * n for n in range(8)]
    scene = pz.load("baffled-tube").replace({"spectrum": pz.Spectrum(wavelengths_nm=lines)})
    every = pz.paths(scene, 16, seed=4)
    some = pz.paths(scene, 5, seed=4)
    numbers = sorted(set(some.ray.tolist()))
    assert numbers == [0, 3, 6, 9, 12]
    assert len({line.wavelength_nm for line in some}) > 2
    assert some.ledger == {}
    picked = np.isin(every.ray, numbers)
    assert np.array_equal(some.end, every.end[picked])
    assert np.array_equal(some.weight, every.weight[picked])
