"""Nodes of 128 bytes: boxes on a grid never smaller than what they stand for."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from oracles.engine import with_tree

import photizon_cl as pz
from benchmarks.random_scenes import AXES, elsewhere, filled_scene, tiled_scene
from hostcode import templates
from hostcode.program import build, source
from hostcode.run.probe import probe_rays
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.tree_nodes import TREE_NODE, pack_nodes, unpack_nodes
from photizon_cl.geometry.tree import TREE_WIDTH, build_tree
from photizon_cl.scene.settings import RunSettings

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


def boxes_of(kind, n=300):
    g = np.random.default_rng(8)
    low = g.uniform(-1.0, 1.0, (n, 3))
    size = g.uniform(0.0, 0.1, (n, 3))
    if kind == "flat":
        low[:, 1], size[:, 1] = 0.3, 0.0
    if kind == "one point":
        low[:], size[:] = 0.7, 0.0
    if kind == "far away":
        low, size = 1e9 + 1e-9 * low, 1e-9 * size
    if kind == "all sizes":
        size = 10.0 ** g.uniform(-12.0, 0.0, (n, 3))
    if kind == "tiny":
        low, size = 1e-250 * low, 1e-250 * size
    if kind == "huge":
        low, size = 1e12 * low, 1e12 * size
    return np.concatenate((low, low + size), axis=1)


KINDS = ("random", "flat", "one point", "far away", "all sizes", "tiny", "huge")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [1, 5, 300])
def test_a_packed_box_holds_its_box_and_little_more(kind, n):
    nodes, children = build_tree(boxes_of(kind, n))
    rows = pack_nodes(nodes, children)
    assert rows.shape == (len(nodes), TREE_NODE)
    _, links = unpack_nodes(rows)
    grid = np.ascontiguousarray(rows[:, 6:12]).view(np.uint8).reshape(-1, 6, TREE_WIDTH)
    for node, row, steps, link, child in zip(nodes, rows, grid, links, children, strict=True):
        used = np.isfinite(node[0])
        assert (link[used] == child[used]).all()
        # a place without a child: inside out, and a child that does no harm
        assert (steps[:3, ~used] == 255).all()
        assert (steps[3:, ~used] == 0).all()
        assert (link[~used] == child[0]).all()
        for k in np.flatnonzero(used):
            for axis in range(3):
                # in whole numbers: the kernels' own rounding has room elsewhere
                corner, step = Fraction(row[axis]), Fraction(row[3 + axis])
                low, high = Fraction(node[axis, k]), Fraction(node[3 + axis, k])
                below = corner + int(steps[axis, k]) * step
                above = corner + int(steps[3 + axis, k]) * step
                assert below <= low
                assert high <= above
                ends = node[[axis, 3 + axis]][:, used]
                extent = Fraction(ends.max()) - Fraction(ends.min())
                assert max(low - below, above - high) <= max(extent / 64, Fraction(2) ** -999)


def test_unpacked_boxes_are_those_of_the_grid():
    nodes, children = build_tree(boxes_of("random"))
    found, links = unpack_nodes(pack_nodes(nodes, children))
    used = np.isfinite(nodes[:, 0])
    assert (links[used] == children[used]).all()
    low, high = np.moveaxis(found[:, :3], 2, 1)[used], np.moveaxis(found[:, 3:], 2, 1)[used]
    assert (low <= np.moveaxis(nodes[:, :3], 2, 1)[used]).all()
    assert (high >= np.moveaxis(nodes[:, 3:], 2, 1)[used]).all()


def steep_rays():
    """Return rays along the axes, nearly so down to 1e-300, and in sides of the cells' boxes."""
    g = np.random.default_rng(2)
    least = [0.0, -0.0, 5e-324, 1e-300, 1e-170, 1e-150, -1e-100, 1e-30, 1e-16]
    rays = []
    for _ in range(600):
        along = g.choice(least, 3)
        along[g.integers(3)] = g.choice([-1.0, 1.0])
        start = g.uniform(-0.99, 0.99, 3)
        start[g.integers(3)] = g.choice([0.0, -0.5, 0.25, 1e-17])
        rays.append([*start, *along])
    return np.array(rays)


@pytest.mark.parametrize(
    ("make", "n", "unit", "away", "simple"),
    [
        pytest.param(tiled_scene, 1000, 1.0, 0.0, False, marks=pytest.mark.slow),
        pytest.param(filled_scene, 1000, 1.0, 0.0, False, marks=pytest.mark.slow),
        pytest.param(filled_scene, 512, 1.0, 0.0, False, marks=pytest.mark.slow),
        pytest.param(filled_scene, 216, 2.0**-30, 0.0, False, marks=pytest.mark.slow),
        # planes and spheres: what is in a box is nothing to the boxes
        (filled_scene, 216, 1e9, 0.0, True),
        (filled_scene, 216, 1.0, 3e5, True),
    ],
)
def test_rays_all_but_along_the_axes_hit_what_the_plain_scan_hits(
    device, make, n, unit, away, simple
):
    run = RunSettings(rays_per_batch=1024)
    scene, rays = make(n, 6, simple), steep_rays()
    scene = pz.Scene(
        name="elsewhere", source=scene.source, element=tuple(elsewhere(scene.element, unit, away))
    )
    rays[:, :3] = unit * rays[:, :3] + away - compile_scene(scene, run).shift
    found = [
        probe_rays(device, compile_scene(scene, run, **with_tree(tree)).tables, rays, 1)
        for tree in (False, True)
    ]
    (hits, element), (hits_too, element_too) = found
    assert (element >= 0).mean() > 0.9
    np.testing.assert_array_equal(element_too, element)
    np.testing.assert_array_equal(hits_too, hits)


def edges_around_the_origin():
    """Return plates and disks around the origin, where their boxes have no slack, and rays at them.

    The rays end at rims and corners, or an ulp or a few beside them.
    """
    g = np.random.default_rng(7)
    elements = []
    for k in range(64):
        tilt = (0.0, 0.0) if k % 3 else tuple(g.uniform(-80.0, 80.0, 2).tolist())
        size = 1.0 + 0.1 * (k // 6)
        common = {"name": f"e{k}", "position": (0.0, 0.0, 0.0), "axis": AXES[k % 6],
                  "tilt_deg": tilt, "surface": pz.Absorber()}  # fmt: skip
        elements.append(
            pz.Rectangle(half_width=size, half_height=0.5 * size, **common)
            if k % 2
            else pz.Disk(radius=size, **common)
        )
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.0, 0.0, 0.0))
    n = 20_000
    which = g.integers(64, size=n)
    frames = np.array([e.frame for e in elements])[which]
    sizes = np.array([e.half_sizes for e in elements])[which]
    angle, corner = g.uniform(0.0, 2.0 * np.pi, n), g.choice([-1.0, 0.0, 1.0], (n, 2))
    round_ = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    at = sizes * np.where((g.random(n) < 0.5)[:, None], round_, corner)
    end = frames[:, 0] * at[:, :1] + frames[:, 1] * at[:, 1:]
    end *= 1.0 + g.choice([0.0, 1e-16, 3e-16, 1e-15, -1e-15, 1e-13], (n, 1))
    start = end + 10.0 ** g.uniform(-15.0, 3.0, (n, 1)) * g.normal(size=(n, 3))
    upright, axis = g.random(n) < 0.4, g.integers(3, size=n)
    start[upright] = end[upright]
    start[np.flatnonzero(upright), axis[upright]] += g.choice([-3.0, 3.0, -1e5], upright.sum())
    along = end - start
    length = np.linalg.norm(along, axis=1)
    keep = length > 0.0
    rays = np.hstack([start, along / np.where(keep, length, 1.0)[:, None]])[keep]
    return pz.Scene(name="edges", source=(source,), element=tuple(elements)), rays


def differing(device):
    """Return how many rays at edges hit something else through the tree than by the plain scan."""
    scene, rays = edges_around_the_origin()
    run = RunSettings(rays_per_batch=1024)
    (hits, _), (hits_too, _) = (
        probe_rays(device, compile_scene(scene, run, **with_tree(tree)).tables, rays, 1)
        for tree in (False, True)
    )
    same = (hits == hits_too) | (np.isnan(hits) & np.isnan(hits_too))
    return int((~same).any(axis=1).sum())


def test_boxes_have_room_for_the_rounding_of_rays_at_edges(device, monkeypatch):
    assert differing(device) == 0
    # without it
    render = templates.render

    def tight(name, **context):
        text = render(name, **context)
        return (
            text.replace("* (0x1p11 * UNIT_ROUNDOFF);", "* 0.0;")
            if "acceleration" in name
            else text
        )

    monkeypatch.setattr(source, "render", tight)
    monkeypatch.setattr(build, "_CACHE", {})
    assert differing(device) > 0
