"""The tree of boxes: the same bits as the plain scan, whatever the scene."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from oracles.engine import with_tree

import photizon_cl as pz
from benchmarks.random_scenes import elsewhere, filled_scene, random_scene, tiled_scene
from benchmarks.visits import visits
from hostcode.device.device import preferred_lanes
from hostcode.program.plan import default_plan
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.packing import code_of
from photizon_cl.compile.tree_nodes import pack_nodes, unpack_nodes
from photizon_cl.geometry.tree import BREAK_EVEN, TREE_STACK, TREE_WIDTH, build_tree, world_boxes
from photizon_cl.scene.settings import RunSettings

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

# fifty sizes from 10 to 10^4
SIZES = [round(10 ** (1.0 + 3.0 * k / 49)) for k in range(50)]
RUN = RunSettings(rays_per_batch=1024, generation_cap=40)
FEWER = RunSettings(rays_per_batch=256, generation_cap=40)


def digest(device, scene, accelerate, lanes, run=RUN, force=frozenset(), **choices):
    compiled = compile_scene(scene, run, **with_tree(accelerate, force))
    assert ("acceleration" in compiled.effects) == accelerate
    plan = default_plan(device.record, lanes).with_(lanes=lanes, **choices)
    engine = Engine(device, compiled.tables, plan)
    total = hashlib.sha256()
    for batch in engine.run(0, 1):
        total.update(batch.cells.tobytes())
    return total.hexdigest(), engine.statistics.interactions


_LARGE = 3000


@pytest.mark.parametrize(
    ("simple", "which"),
    [
        # 110 and 1207 elements, which have one program; fewer: test_trees_of_few_elements
        pytest.param(True, slice(17, None, 17), id="some, simple"),
        pytest.param(True, slice(None), id="simple", marks=pytest.mark.slow),
        pytest.param(False, slice(None), id="every kind", marks=pytest.mark.slow),
    ],
)
def test_fifty_random_scenes_have_the_bits_of_the_plain_scan(device, simple, which):
    hits = 0
    sizes = list(enumerate(SIZES))[which]
    for k, n in sizes:
        if simple and n > _LARGE:
            continue  # as a slow test
        # few elements would make many programs: one lane, or planes and spheres, build fastest;
        # beyond 2047 what a ray remembers of a face is longer, which is another program
        few = n < 130
        scene = random_scene(n, seed=k, simple=simple and n < 2048)
        run = RUN if n < 3000 else FEWER  # the plain scan takes its time
        lanes, force = (1, frozenset({"contact"})) if few and not simple else (8, frozenset())
        plain, interactions = digest(device, scene, False, lanes, run, force)
        fast, _ = digest(device, scene, True, lanes, run, force)
        assert fast == plain, f"{n} elements"
        hits += interactions
    assert len(SIZES) == 50
    assert hits > 200 * len(sizes)  # the scenes are not empty


@pytest.mark.parametrize(
    ("lanes", "simple"),
    # through a tree at 8 lanes, whatever is cached: tests/exact/test_digest_matrix.py
    [pytest.param(16, True, marks=pytest.mark.slow)]
    + [pytest.param(lanes, False, marks=pytest.mark.slow) for lanes in (1, 2, 4, 8, 16)]
    + [pytest.param(lanes, True, marks=pytest.mark.slow) for lanes in (1, 2, 4)],
)
def test_the_bits_do_not_depend_on_the_lanes(device, lanes, simple):
    scene = filled_scene(216, seed=3, simple=simple)
    assert digest(device, scene, True, lanes)[0] == digest(device, scene, False, 8)[0]


@pytest.mark.parametrize(
    ("lanes", "simple"),
    [pytest.param(lanes, True, marks=pytest.mark.slow) for lanes in (2, 8, 16)]
    + [pytest.param(lanes, False, marks=pytest.mark.slow) for lanes in (2, 8, 16)],
)
def test_the_bits_do_not_depend_on_what_is_cached(device, lanes, simple):
    # rays change places at every node and row; below the first nodes; never is the default's
    scene = filled_scene(1000, seed=4, simple=simple)
    run = RunSettings(rays_per_batch=2048, generation_cap=40)
    want = digest(device, scene, False, 8, run)
    for cached in (1, 1 << 14):
        assert digest(device, scene, True, lanes, run, cached_bytes=cached) == want


@pytest.mark.parametrize(("unit", "away"), [(1.0, 0.0), (2.0**-30, 0.0), (1e9, 0.0), (1.0, 3e5)])
def test_rays_along_the_axes_far_away_tiny_and_huge(device, unit, away):
    # a beam down an axis: two components of every direction are 0, and rays run in sides of boxes;
    # of every kind the hits: test_tree_nodes.py
    scene = tiled_scene(600, seed=4, simple=True)
    # without disks, whose every axis is text of its own
    kept = [element for element in scene.element if not isinstance(element, pz.Disk)]
    elements = elsewhere(kept, unit, away)
    beam = pz.CollimatedDisk(
        name="s", flux=1.0, position=(away, away, away), axis="+z", radius=0.9 * unit
    )
    changed = pz.Scene(name="beam", source=(beam,), element=tuple(elements))
    fast, interactions = digest(device, changed, True, 1)
    assert fast == digest(device, changed, False, 1)[0]
    assert interactions > 2000


def test_the_default_takes_eight_rays_in_turn_through_the_tree(device):
    spec = compile_scene(tiled_scene(300, seed=1), RUN).tables.spec
    assert "acceleration" in spec.effects
    lanes = preferred_lanes(device.record, spec.effects)
    made = spec.for_device(lanes, ("wave",))
    assert (made.lanes, made.packets) == ((1, 8) if device.record.type == "cpu" else (1, 1))


def reach_of(nodes, children):
    """Give every node's elements and depth, children before parents."""
    elements: dict[int, list[int]] = {}
    depth = np.zeros(len(nodes), int)
    for node in reversed(range(len(nodes))):
        elements[node] = []
        for k in np.flatnonzero(np.isfinite(nodes[node, 0])):
            link = int(children[node, k])
            assert link >= 0 or ~link > node
            elements[node] += [link] if link >= 0 else elements[~link]
            depth[node] = max(depth[node], 1 + (depth[~link] if link < 0 else 0))
    return elements, depth


def boxes_at(kind, n):
    g = np.random.default_rng(5)
    low = g.uniform(-1.0, 1.0, (n, 3))
    if kind == "random":
        return np.concatenate((low, low + g.uniform(0.0, 0.1, (n, 3))), axis=1)
    if kind == "in one place":
        return np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], (n, 1))
    if kind == "planes":
        low[:, 2] = 0.25
        return np.concatenate((low, low), axis=1)
    # each a tenth larger than the one before: the heuristic takes them off one at a time
    at = 1.1 ** np.arange(n)[:, None] * np.ones(3)
    return np.concatenate((at, 1.01 * at), axis=1)


@pytest.mark.parametrize("kind", ["random", "in one place", "planes", "growing"])
@pytest.mark.parametrize("n", [1, 2, 8, 9, 65, 3000])
def test_the_tree_holds_every_element_once_and_boxes_hold_their_children(kind, n):
    boxes = boxes_at(kind, n)
    nodes, children = build_tree(boxes)
    elements, depth = reach_of(nodes, children)
    assert sorted(elements[0]) == list(range(n))
    for node in range(len(nodes)):
        for k in range(TREE_WIDTH):
            low, high = nodes[node, :3, k], nodes[node, 3:, k]
            if not np.isfinite(low).all():
                assert (low == np.inf).all()
                assert (high == -np.inf).all()
                continue
            link = int(children[node, k])
            inside = boxes[[link] if link >= 0 else elements[~link]]
            assert (low == inside[:, :3].min(axis=0)).all()
            assert (high == inside[:, 3:].max(axis=0)).all()
    # what waits on the kernels' stack: seven at each level, and the one in hand
    assert (TREE_WIDTH - 1) * depth[0] + 1 <= TREE_STACK


def test_a_tree_too_deep_for_the_stack_cannot_be_built():
    # 8 levels by area, then the median divides by eight until one is left
    largest = 8 ** ((TREE_STACK - 1) // (TREE_WIDTH - 1) - 8)
    assert largest > 2**32


def test_both_tables_give_the_same_codes():
    scene = random_scene(200, seed=5)
    tables = [compile_scene(scene, RUN, **with_tree(tree)).tables for tree in (False, True)]
    for n in range(200):
        plain, fast = (code_of(t, n) for t in tables)
        assert plain == fast
        assert plain >> 32 == n


@pytest.mark.slow
def test_the_search_visits_few_nodes_of_many(device):
    counts = []
    for n in (64, 4096):
        compiled = compile_scene(filled_scene(n, seed=2), RUN, force=frozenset({"acceleration"}))
        boxes = world_boxes(compiled.scene.element, compiled.shift)
        tree = unpack_nodes(pack_nodes(*build_tree(boxes)))
        counts.append(visits(compiled, tree, device, 160)[0])
    assert counts[0] < 6.0
    # log n doubles; n^(1/3) grows four times
    assert counts[1] < 2.8 * counts[0]


def test_the_tree_is_used_from_the_break_even_on(device):
    few = random_scene(BREAK_EVEN - 1, 1, simple=True)
    many = random_scene(BREAK_EVEN, 1, simple=True)
    assert "acceleration" not in compile_scene(few, RUN).effects
    assert "acceleration" in compile_scene(many, RUN).effects


@pytest.mark.parametrize("n", [1, 2, pytest.param(5, marks=pytest.mark.slow)])
def test_trees_of_few_elements(device, n):
    scene = random_scene(n, seed=n, simple=True)
    assert digest(device, scene, True, 1)[0] == digest(device, scene, False, 8)[0]
