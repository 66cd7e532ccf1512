"""What its coordinates cannot carry: told where the error is real, by a bound that is not loose."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.checks.coarse import _EDGES, _extents, relative_error
from photizon_cl.scene.elements.flat import EDGES_TILTED
from photizon_cl.scene.faces import Ball, Revolved, Straight

ROOT = Path(__file__).resolve().parents[2]
BLACK = pz.Absorber()
LAMP = pz.IsotropicPoint(name="lamp", flux=1, position=(0, 0, 0))


def advice(element, source=LAMP):
    scene = pz.Scene(name="far", source=(source,), element=(element,))
    return [text for text in pz.advisories(scene) if "distance from the origin" in text]


def made(kind, far, tilt=(0.0, 0.0), **parameters):
    at = (far, far, far)
    return kind(name="e", position=at, axis="+z", tilt_deg=tilt, surface=BLACK, **parameters)


def rims(element, radius):
    """Return where an element begins or ends around its axis, in four directions, relative."""
    origin = pz.Disk(name="o", position=(0, 0, 0), axis="+z", radius=1e-3, surface=BLACK)
    scene = pz.Scene(name="rim", source=(LAMP,), element=(element, origin))
    rows, at = np.array(element.frame), np.array(element.position)
    found = []
    for along in (rows[0], -rows[0], rows[1], -rows[1]):
        low, high = 0.5 * radius, 1.5 * radius
        for _ in range(4):
            places = np.linspace(low, high, 257)
            start = at + places[:, None] * along + 5.0 * rows[2]
            hits = pz.probe(scene, start, np.tile(-rows[2], (len(places), 1)))
            near = (hits.element == 0) & (hits.distance < 5.5)
            (change, *_) = np.flatnonzero(near[1:] != near[:-1])
            low, high = places[change], places[change + 1]
        found.append(0.5 * (low + high) / radius - 1.0)
    return np.array(found)


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (30.0, -50.0)])
@pytest.mark.parametrize(
    ("kind", "radius", "parameters"),
    [
        (pz.Disk, 1e-3, {"radius": 1e-3}),
        (pz.Disk, 1e-3, {"radius": 1.0, "inner_radius": 1e-3}),
        (pz.Sphere, 1e-3, {"radius": 1.0, "port_radius": 1e-3}),
        (pz.Sphere, 1e-2, {"radius": 1.0, "port_radius": 1e-2}),
        (pz.PlanoConvex, 1e-3, {"curvature_radius": 1.0, "aperture_radius": 1e-3}),
    ],
    ids=["disk", "hole", "small port", "port", "lens"],
)
def test_the_error_is_within_its_bound_and_near_it(kind, radius, parameters, tilt):
    element = made(kind, 1e7, tilt, **parameters)
    measured = 2.0 * np.abs(rims(element, radius)).max()  # of an area
    bound, _ = relative_error(element)
    assert bound / 5.0 < measured <= bound
    assert len(advice(element)) == 1


def test_it_names_the_numbers_and_what_to_do():
    (text,) = advice(made(pz.Disk, 1e6, radius=1e-4))
    assert 'element "e"' in text
    assert "0.0002 m across at 1e+06 m" in text
    assert f"{math.ulp(1e6):.1e} m apart" in text
    assert "up to 2.2e-05" in text
    assert "relative to a point near it" in text


def test_the_threshold():
    far, error = 1e3, 1e-6
    radius = 20.0 * 2.0**-53 * far / error
    assert advice(made(pz.Disk, far, radius=1.01 * radius)) == []
    assert len(advice(made(pz.Disk, far, radius=0.99 * radius))) == 1
    assert advice(made(pz.Disk, 0.0, radius=1e-100)) == []  # at the origin anything is carried


def test_a_narrow_face_of_little_area_is_no_fault_and_a_narrow_opening_is():
    edged = made(pz.Biconvex, 1.0, front_radius=1.0, back_radius=1.0, aperture_radius=1e-2)
    assert advice(edged) == []
    tip = made(pz.Cone, 1e3, entrance_radius=1.0, exit_radius=0.0, length=1.0)
    assert advice(tip) == []
    hole = made(pz.Cone, 1e3, entrance_radius=1.0, exit_radius=1e-7, length=1.0)
    assert len(advice(hole)) == 1
    shut = made(pz.BaffledTube, 1e3, half_width=1.0, length=2.0, baffles=1, clear_half_width=0.0)
    assert advice(shut) == []
    pinhole = made(
        pz.BaffledTube, 1e3, half_width=1.0, length=2.0, baffles=1, clear_half_width=1e-7
    )
    assert len(advice(pinhole)) == 1


def test_sources_too():
    disk = made(pz.Disk, 1e6, radius=1.0)
    near = pz.LambertianDisk(name="s", flux=1, position=(1e6, 0, 0), axis="+z", radius=1e-5)
    (text,) = advice(disk, near)
    assert 'source "s"' in text
    assert f"{math.ulp(max(map(abs, near.position))):.1e} m apart" in text
    assert advice(disk, pz.IsotropicPoint(name="s", flux=1, position=(1e6, 0, 0))) == []


def test_many_are_told_in_a_few_lines():
    many = tuple(
        pz.Disk(name=f"e{n}", position=(1e6 + n, 0, 0), axis="+z", radius=1e-6, surface=BLACK)
        for n in range(500)
    )
    scene = pz.Scene(name="many", source=(LAMP,), element=many)
    found = [text for text in pz.advisories(scene) if "origin" in text or "distances" in text]
    assert len(found) == 21
    assert found[-1].startswith("480 more elements")


@pytest.mark.parametrize(
    "face",
    [
        Straight(name="f", radii=(0.3, 1.0), length=2.0),
        Straight(name="f", radii=(1e-8, 1e-8), length=5.0),
        Ball(name="f", radius=2.0),
        Ball(name="f", radius=2.0, polar=(0.0, 1e-6)),
        Ball(name="f", radius=2.0, polar=(1e-7, 3.0)),
        Ball(name="f", radius=2.0, polar=(0.2, 0.9), pole=-1.0),
        Ball(name="f", radius=2.0, polar=(2.0, math.pi)),
    ],
    ids=str,
)
def test_extents_from_parameters_are_those_of_the_profile(face):
    class Other(Revolved):
        def profile(self, s):
            return face.profile(s)

    sizes, openings = _extents(face)
    profile, rims = _extents(Other(name="f"))
    assert sizes == pytest.approx(profile, rel=2e-3)  # a polyline of 32 parts is shorter
    assert openings == pytest.approx(rims, rel=1e-12)


def test_thousands_of_elements_cost_no_profile_each(monkeypatch):
    """What is needed of a ball or a straight profile follows from its parameters."""
    for kind in (Ball, Straight):
        monkeypatch.setattr(kind, "profile", lambda *_: pytest.fail("a profile"))
    elements = [
        made(pz.Sphere, 1.0, radius=1.0, port_radius=0.1),
        made(pz.Cone, 1.0, entrance_radius=1.0, exit_radius=0.1, length=1.0),
        made(pz.Cylinder, 1.0, radius=1.0, length=1.0),
        made(pz.Biconvex, 1.0, front_radius=1.0, back_radius=1.0, aperture_radius=0.1),
    ]
    assert all(0.0 < relative_error(element)[0] < 1e-12 for element in elements)


def test_as_many_roundings_are_told_as_are_documented():
    text = " ".join((ROOT / "docs" / "conventions.md").read_text(encoding="utf-8").split())
    assert f"a hit counts up to {EDGES_TILTED[0]:.0f} roundings (2⁻⁵³)" in text
    assert f"reckons with {_EDGES:.0f}, the hit being rounded too" in text
