"""Bins that a few heavy rays make are told; those of rays alike are not."""

from __future__ import annotations

import pytest

import photizon_cl as pz


def lamps(heavy):
    """Two lamps in one place: most rays are of the first, and nearly all light of the second.

    Where `heavy` is False both have rays for their light.
    """
    black = {"name": "speck", "kind": "disk", "position": [0.0, 0.0, 1.0], "axis": "-z",
             "radius": 1e-3, "surface": {"kind": "absorber"}}  # fmt: skip
    point = {"kind": "isotropic-point", "position": [0.0, 0.0, 0.0]}
    weak, bright = {**point, "name": "weak", "flux": 1.0}, {**point, "name": "bright", "flux": 1.0}
    if heavy:
        weak |= {"flux": 1e-6, "share": 0.999}
        bright |= {"share": 0.001}
    return {
        "schema": "photizon/1", "name": "lamps", "far_field": {"n_mu": 20, "n_phi": 16},
        "run": {"rays_per_batch": 8192}, "source": [weak, bright], "element": [black],
    }  # fmt: skip


@pytest.mark.usefixtures("one_lane")
def test_few_heavy_rays_in_many_are_told():
    # 8 bright rays a batch among 25 weak ones in each of 320 bins: at most 64 bins have any
    found = pz.trace(lamps(heavy=True), batches=8)
    said = [text for text in found.advisories if "a few heavy rays make the value" in text]
    assert len(said) == 1
    numbers = [int(word) for word in said[0].split() if word.isdigit()]
    bright = int((found.far_field.intensity > 1e-4).sum())
    assert numbers[:2] == [bright, 320]
    assert 32 < bright <= 64
    assert "of the far field" in said[0]


@pytest.mark.usefixtures("one_lane")
def test_rays_alike_are_not():
    # 205 in each of 320 bins; by chance one bin in 5000 would be, and four are needed: 1e-6
    found = pz.trace(lamps(heavy=False), batches=8)
    assert not any("heavy" in text for text in found.advisories)
