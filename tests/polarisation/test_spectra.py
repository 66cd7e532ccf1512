"""Polarised sources whose rays are of several lines or bands: each has its own source's light."""

from __future__ import annotations

import pytest
from oracles import brewster
from oracles.engine import compiled

import photizon_cl as pz

LIGHTS = ({"wavelengths_nm": [450.0, 550.0, 650.0]}, {"edges_nm": [400.0, 500.0, 600.0]})


@pytest.mark.parametrize("light", LIGHTS)
def test_each_ray_has_its_own_sources_light(light):
    brewster.two_sources(light)


def test_there_is_a_row_for_every_beam():
    scene = brewster.of_two_sources(LIGHTS[0], ([1.0, 0.0, 2.0], [1.0, 1.0, 1.0]))
    tables = compiled(scene, rays_per_batch=64).tables
    counts = dict(item for part in tables.spec.parts for item in part.parameters)
    behind = len(tables.geometry) - tables.launch["polarisation"]
    assert tables.launch["n_sources"] == 5  # one line has none of a source's power
    assert behind == 5 * counts["polarised_numbers"]


def test_glass_that_is_alike_for_s_and_p_is_told():
    fixed = pz.FixedCoating(reflectance=0.3, transmittance=0.6)
    films = pz.StackCoating(layers=[pz.Layer(index=1.38, thickness_nm=99.6)])
    for coating, polarises in ((None, True), (fixed, False), (films, True)):
        surface = pz.Fresnel(index=1.5, coating=coating)
        assert surface.polarises == polarises
