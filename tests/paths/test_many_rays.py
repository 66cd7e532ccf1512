"""Probes of many rays at once, in scenes searched through the tree."""

from __future__ import annotations

import numpy as np

import photizon_cl as pz


def test_a_hundred_thousand_rays_through_the_tree():
    # the search has a stack of its own for every ray: too many together once ended the process
    elements = tuple(
        pz.Rectangle(
            name=f"r{n}", position=(float(n % 10), float(n // 10), 0.0), axis="+z",
            half_width=0.4, half_height=0.4, surface=pz.Absorber(),
        )
        for n in range(100)
    )  # fmt: skip
    lamp = pz.IsotropicPoint(name="s", flux=1.0, position=(4.5, 4.5, 3.0))
    scene = pz.Scene(name="grid", source=(lamp,), element=elements)
    g = np.random.default_rng(1)
    start = np.column_stack([g.uniform(-0.5, 9.5, (100_000, 2)), np.full(100_000, 1.0)])
    hits = pz.probe(scene, start, np.tile([0.0, 0.0, -1.0], (100_000, 1)))
    cell = np.rint(start[:, 1]) * 10 + np.rint(start[:, 0])
    inside = (np.abs(start[:, :2] - np.rint(start[:, :2])) <= 0.4).all(axis=1)
    np.testing.assert_array_equal(hits.element, np.where(inside, cell, -1))
    assert len(pz.paths(scene, rays=20_000)) > 0
