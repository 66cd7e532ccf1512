"""Maps on curved and round elements, traced: which bins are masked, and what the others show."""

from __future__ import annotations

import math

import numpy as np

import photizon_cl as pz


def test_disk_map_masks_what_lies_outside():
    disk = {
        "name": "d", "kind": "disk", "position": [0, 0, 0], "axis": "+z", "radius": 1.0,
        "surface": {"kind": "absorber"}, "detector": {"map": [32, 32]},
    }  # fmt: skip
    tables = {**pz.load("cosine-fourth").to_dict(), "element": [disk]}
    m = pz.trace(tables, batches=4, rays_per_batch=16384).detectors["d"].map
    assert m.masked.sum() == 168
    assert np.isnan(m.irradiance[m.masked]).all()
    assert (m.area[m.masked] == 0.0).all()
    assert not m.count[m.masked].any()
    assert not (m.hatched & m.masked).any()
    assert np.isfinite(m.irradiance[~m.masked]).all()


def test_sphere_map_masks_the_port():
    ball = {
        "name": "b", "kind": "sphere", "position": [0, 0, 1], "axis": "+z", "radius": 0.5,
        "port_fraction": 0.1, "surface": {"kind": "absorber"}, "detector": {"map": [8, 20]},
    }  # fmt: skip
    lamp = {"name": "l", "kind": "isotropic-point", "flux": 2.0, "position": [0, 0, 1]}
    tables = {"schema": "photizon/1", "name": "b", "source": [lamp], "element": [ball]}
    result = pz.trace(tables, batches=8, rays_per_batch=16384)
    m = result.detectors["b"].map
    assert m.masked[-2:].all()
    assert not m.masked[:-2].any()
    expected = 2.0 / (4.0 * math.pi * 0.25)
    z = (m.irradiance - expected)[~m.masked] / m.sigma[~m.masked]
    assert abs(z).max() < 15.0  # 144 bins of Student's t with 7 degrees of freedom
    assert abs(z.mean()) < 0.5
