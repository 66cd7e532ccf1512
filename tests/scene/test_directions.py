"""Single precision has 2^24 polar angles from a point, and a detector far off sees few of them."""

from __future__ import annotations

import math

import pytest

import photizon_cl as pz


def scene(radius, kind=pz.IsotropicPoint, away=1.0):
    lamp = {"name": "lamp", "position": [0, 0, 0], "flux": 1.0}
    if kind is pz.CollimatedDisk:
        lamp |= {"axis": "+z", "radius": 0.1}
    disk = pz.Disk(
        name="disk", position=[0, 0, away], axis="-z", radius=radius, surface=pz.Absorber(),
        detector=pz.Detector(),
    )  # fmt: skip
    return pz.Scene(name="s", source=[kind(**lamp)], element=[disk])


def found(*args, precision="fp32", **more):
    return [t for t in pz.advisories(scene(*args, **more), precision) if "polar angles" in t]


@pytest.mark.parametrize("precision", ["mixed", "fp32"])
def test_what_is_seen_under_few_directions_is_told_with_the_numbers(precision):
    (text,) = found(6.5e-4, precision=precision)
    part = 0.5 * (1.0 - math.cos(math.asin(6.5e-4)))
    assert f"under a part {part:.1e} of all directions" in text
    assert f"may be wrong by {2.0**-24 / part:.1e}" in text


def test_what_is_large_or_in_double_precision_is_not():
    assert not found(6.5e-4, precision="fp64")
    assert not found(0.1)
    assert found(0.1, away=10.0)


def test_rays_that_start_anywhere_on_a_disk_even_it_out():
    assert not found(6.5e-4, kind=pz.CollimatedDisk)


def test_bins_narrow_beside_a_directions_rounding_are_told():
    lamp = pz.IsotropicPoint(name="lamp", position=[0, 0, 0], flux=1.0)
    for edges, told in (([0.0, 0.01, 90.0], True), ([0.0, 1.0, 90.0], False)):
        far = pz.FarField(theta_edges_deg=edges, n_phi=1)
        made = pz.Scene(name="s", source=[lamp], far_field=far)
        texts = [t for t in pz.advisories(made, "fp32") if "far_field has bins of 0.01" in t]
        assert bool(texts) == told
        assert not pz.advisories(made, "fp64")


def test_a_lobe_narrow_beside_a_directions_rounding_is_told():
    lamp = pz.IsotropicPoint(name="lamp", position=[0, 0, 1], flux=1.0)
    for sigma, told in ((1e-5, True), (1e-3, False)):
        paint = pz.Absorber(pz.GaussianScatter(sigma=sigma, tis=0.1))
        disk = pz.Disk(name="disk", position=[0, 0, 0], axis="+z", radius=1.0, surface=paint)
        made = pz.Scene(name="s", source=[lamp], element=[disk])
        texts = [t for t in pz.advisories(made, "mixed") if 'the scatter of "disk" is' in t]
        assert bool(texts) == told
        assert not pz.advisories(made, "fp64")
