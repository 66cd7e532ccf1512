"""The tree of boxes: the same bits as the plain scan, whatever the scene."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from benchmarks.random_scenes import random_scene
from hostcode.plan import default_plan
from hostcode.wavefront import Engine
from photizon_cl.compile import compile_scene
from photizon_cl.settings import RunSettings
from photizon_cl.tree import BREAK_EVEN, LEAF, build_tree

# fifty sizes from 10 to 10^4; those below 130 hold planes and spheres only (see random_scenes.py)
SIZES = sorted({round(10 ** (1.0 + 3.0 * k / 49)) for k in range(50)} | {10_000})
RUN = RunSettings(rays_per_batch=1024, generation_cap=40)


def digest(device, scene, accelerate, lanes=8):
    compiled = compile_scene(scene, RUN, accelerate=accelerate)
    assert ("acceleration" in compiled.effects) == accelerate
    engine = Engine(device, compiled.tables, default_plan(device.record, lanes))
    total = hashlib.sha256()
    for batch in engine.run(0, 1):
        total.update(batch.cells.tobytes())
    return total.hexdigest(), engine.statistics.interactions


def test_fifty_random_scenes_have_the_bits_of_the_plain_scan(device):
    assert len(SIZES) >= 49
    hits = 0
    for n in SIZES:
        scene = random_scene(n, seed=n, simple=n < 130)
        plain, interactions = digest(device, scene, accelerate=False)
        fast, _ = digest(device, scene, accelerate=True)
        assert fast == plain, f"{n} elements"
        hits += interactions
    assert hits > 10_000  # the scenes are not empty


def test_the_tree_holds_every_element_once_and_boxes_hold_their_children():
    g = np.random.default_rng(5)
    low = g.uniform(-1.0, 1.0, (1000, 3))
    boxes = np.concatenate((low, low + g.uniform(0.0, 0.1, (1000, 3))), axis=1)
    nodes, links, order = build_tree(boxes)
    assert sorted(order.tolist()) == list(range(1000))
    for node, (first, count) in enumerate(links.tolist()):
        if count:
            assert 1 <= count <= LEAF
            inside = boxes[order[first : first + count]]
        else:
            inside = nodes[[node + 1, first >> 2]]
            assert first & 3 in (0, 1, 2)
        assert (nodes[node, :3] == inside[:, :3].min(axis=0)).all()
        assert (nodes[node, 3:] == inside[:, 3:].max(axis=0)).all()


def test_the_tree_is_used_from_the_break_even_on(device):
    few = random_scene(BREAK_EVEN - 1, 1, simple=True)
    many = random_scene(BREAK_EVEN, 1, simple=True)
    assert "acceleration" not in compile_scene(few, RUN).effects
    assert "acceleration" in compile_scene(many, RUN).effects


@pytest.mark.parametrize("n", [1, 2, 5])
def test_trees_of_few_elements(device, n):
    scene = random_scene(n, seed=n, simple=True)
    assert digest(device, scene, True)[0] == digest(device, scene, False)[0]
