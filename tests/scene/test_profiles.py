"""Profiles of surfaces of revolution: they end at their rims and lie on their surfaces."""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.wedges import edge_factors
from photizon_cl.scene.elements.sheets import equator
from photizon_cl.scene.faces import Revolved

WHERE: dict[str, Any] = {"name": "one", "position": (0.0, 0.0, 0.0), "axis": "+z"}
WHERE["surface"] = pz.Mirror(1.0)
SHEETS = [
    (0.1, -1.5, 1.0), (0.01, -2.0, 1.0), (1e-6, -5.0, 1.0), (0.01, -100.0, 1.0),
    (1e-6, -1e4, 1.0), (1e-9, -1e6, 1.0), (1e-3, -1.0 - 1e-9, 1.0), (1e-3, -1.0 - 2.0**-52, 1.0),
    (1e-3, -1.0, 1.0), (1e6, -1.0, 1.0), (1e-3, -1.0 + 1e-9, 1.0), (2.0, -0.64, 0.0),
    (1.0, 0.0, 0.0), (1.0, 0.0, 1e-5), (0.7, 3.7, 0.0), (1e3, 1e6, 0.0), (1e-90, -3.0, 1e60),
    (1e-60, -1.0, 1e40),
]  # fmt: skip
"""Curvature, constant and aperture in metres, 0 for the equator."""


def sheet(radius: float, k: float, aperture: float, inner: float = 0.0) -> pz.Conic:
    """Return a sheet, inner given as a part of the aperture."""
    rim = aperture or equator(radius, k)
    return pz.Conic(
        **WHERE, curvature_radius=radius, conic_constant=k, aperture_radius=rim,
        inner_radius=inner * rim,
    )  # fmt: skip


def walls() -> list[Any]:
    """Return elements with faces of revolution, of proportions near and far from 1."""
    return [
        *(sheet(*numbers, inner) for numbers in SHEETS for inner in (0.0, 0.3, 1.0 - 1e-9)),
        pz.Cylinder(**WHERE, radius=0.3, length=1e9),
        pz.Cone(**WHERE, entrance_radius=1e20, exit_radius=1.0, length=3.0),
        pz.Cone(**WHERE, entrance_radius=0.3, exit_radius=0.7, length=1e-9),
        pz.Cpc(**WHERE, exit_radius=0.1, acceptance_deg=0.01),
        pz.Cpc(**WHERE, exit_radius=0.1, acceptance_deg=89.99),
        pz.Biconvex(**WHERE, front_radius=1.0, back_radius=3.0, aperture_radius=1.0),
    ]


def ends(wall: Any, n: int) -> list[tuple[float, float]]:
    """Return radius and height of the rims of a face as the element states them."""
    if isinstance(wall, pz.Biconvex):
        low, high = wall.local_box[0][2], wall.local_box[1][2]
        return [(0.0, low if n else high), (wall.aperture_radius, 0.0)]
    if isinstance(wall, pz.Cpc):
        return [(wall.exit_radius, 0.0), (wall.entrance_radius, wall.length)]
    radii = {
        pz.Cylinder: ("radius", "radius"), pz.Cone: ("entrance_radius", "exit_radius"),
        pz.Conic: ("inner_radius", "aperture_radius"),
    }[type(wall)]  # fmt: skip
    return [(getattr(wall, r), h) for r, h in zip(radii, wall.heights, strict=True)]


@pytest.mark.parametrize("wall", walls(), ids=lambda w: f"{w.kind}")
def test_profiles_begin_and_end_at_the_rims(wall: Any) -> None:
    exact = isinstance(wall, pz.Conic | pz.Cone | pz.Cylinder)
    for n, face in enumerate(wall.faces):
        assert isinstance(face, Revolved)
        r, w = face.profile(np.array([0.0, 1.0]))
        for got, (radius, height) in zip(zip(r, w, strict=True), ends(wall, n), strict=True):
            slack = 0.0 if exact else 1e-14 * wall.reach
            assert abs(got[0] - radius) <= slack
            assert abs(got[1] - height) <= slack


@pytest.mark.parametrize("numbers", SHEETS, ids=str)
@pytest.mark.parametrize("inner", [0.0, 0.3])
def test_a_conics_profile_lies_on_it(numbers: Any, inner: float) -> None:
    one = sheet(*numbers, inner)
    (face,) = one.faces
    r, w = face.profile(np.linspace(0.0, 1.0, 101))
    assert (np.diff(r) > 0.0).all()
    assert (np.diff(w) > 0.0).all()
    with mp.workdps(60):
        big, kappa = mp.mpf(one.curvature_radius), 1 + mp.mpf(one.conic_constant)
        for x, y in zip(r.tolist(), w.tolist(), strict=True):
            f = mp.mpf(x) ** 2 - y * (2 * big - kappa * y)
            off = abs(f) / (2 * mp.hypot(x, big - kappa * y))
            assert off <= 1e-15 * (x + y)
    for x in (inner + (1 - inner) * np.array([1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999])) * r[-1]:
        at = one.sag(float(x))
        assert one.holds((float(x), 0.0, at))
        assert not face.touches((float(x) * 1.01, 0.0, at), 1e-4 * face.sine_at(x, at, 0.0) * x)
    # a place by its height, the slope there an absolute rounding of the place
    for s in (0.0, 0.25, 0.5, 1.0):
        height = float(face.profile(np.array([s]))[1][0])
        assert face.place_at(height) == pytest.approx(s, abs=1e-6)


@pytest.mark.parametrize(("radius", "k"), [(0.01, -100.0), (1e-6, -1e4), (1e-6, -5.0), (0.1, -1.5)])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (33.0, -71.0)])
def test_a_lid_on_a_hyperboloid_knows_its_angle(radius: float, k: float, tilt: Any) -> None:
    one = pz.Conic(
        **WHERE, tilt_deg=tilt, curvature_radius=radius, conic_constant=k, aperture_radius=1.0
    )
    at = one.heights[1] * np.array(one.frame[2])
    lid = pz.Disk(**{**WHERE, "position": tuple(at.tolist())}, tilt_deg=tilt, radius=1.0)
    with mp.workdps(40):
        slope = 1 / (mp.sqrt(mp.mpf(radius) ** 2 - (1 + mp.mpf(k))))  # dw/dr = r/sqrt(R² − κr²)
        want = float(mp.sqrt(1 + slope**2) / slope)
    found = edge_factors(Neighbours([one, lid]))[1]
    assert found == pytest.approx(want if want > 2.0 else 1.0, rel=1e-9)


def test_a_small_disk_at_a_vertex_or_a_pole_does_not_outgrow_its_rounding() -> None:
    ball = pz.Sphere(**{**WHERE, "position": (0.0, 0.0, 1.0)}, radius=1.0)
    for curved in (ball, sheet(1.0, -1.0, 0.5), sheet(1.0, 0.0, 0.5)):
        for radius in (1e-3, 1e-9, 1e-150):
            height = radius * radius / 2.0
            lid = pz.Disk(**{**WHERE, "position": (0.0, 0.0, height)}, radius=radius)
            near = Neighbours([curved, lid])
            largest = max(radius, math.sqrt(float(near.rooms.max())))
            assert (edge_factors(near)[1] <= 1.001 / largest).all()
