"""Thousands of bounces through the functions of the trace: invariants hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.walks import LENSES, PLACES, SILVER, U, follow, unit

from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.biconvex import Biconvex
from photizon_cl.scene.elements.cpc import Cpc
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.plano_convex import PlanoConvex
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.surfaces.fresnel import Fresnel
from photizon_cl.stability.families_mixed import room

if TYPE_CHECKING:
    from hostcode.run.probe import Followed
    from photizon_cl.scene.elements import Element


def local(element: Element, found: Followed) -> tuple[np.ndarray, np.ndarray]:
    """Return points and directions in an element's frame."""
    rows = np.array(element.frame).T
    missed = ~np.isfinite(found.distance)[..., None]
    points = np.where(missed, 0.0, found.point)
    along = np.where(missed, 0.0, found.direction)
    return (points - np.array(element.position)) @ rows, along @ rows


def off_unit(found: Followed) -> float:
    return float(np.nanmax(np.abs((found.direction**2).sum(axis=-1) - 1.0)))


@pytest.mark.parametrize("start", [0.1, 0.9, 0.999999])
def test_chords_of_a_sphere_keep_their_length(start: float) -> None:
    """Whispering gallery included: 5000 chords of one length, in one plane."""
    ball = Sphere(name="ball", position=(0.3, -0.2, 0.1), axis="+z", radius=0.7, surface=SILVER)
    origin = np.add(ball.position, (start * 0.7, 0.0, 0.0))
    along = unit(np.array([[0.0, 0.6, 0.8], [0.1, 0.9, -0.3], [0.0, 1.0, 0.0]]))
    found = follow([ball], np.tile(origin, (3, 1)), along, 5000)
    chords = found.distance[:, 1:]
    # the sine of the angle to the wall is kept to a few roundings a bounce
    relative = np.abs(chords / chords[:, :1] - 1.0).max(axis=1)
    grazing = chords[:, 0] / 1.4
    assert (relative * grazing < 4 * U * 5000).all()
    assert off_unit(found) < 8 * U
    centred = found.point - np.array(ball.position)
    assert np.abs(np.linalg.norm(centred, axis=-1) - 0.7).max() < 8 * U
    turn = np.cross(centred[:, 0], found.direction[:, 0])
    later = np.cross(centred[:, -1], found.direction[:, -1])
    assert np.abs(turn - later).max() < 4 * U * 5000


def test_a_box_of_mirrors_keeps_the_size_of_each_component() -> None:
    walls = room((-0.3, -0.5, -0.7), (0.4, 0.6, 0.9), surface=SILVER)
    along = unit(np.random.default_rng(1).normal(size=(20, 3)))
    found = follow(walls, np.zeros((20, 3)), along, 5000)
    assert (found.left >= 0).all()
    assert np.abs(np.abs(found.direction) - np.abs(along)[:, None, :]).max() < 4 * U
    assert off_unit(found) < 8 * U


@pytest.mark.parametrize(("at", "tilt"), PLACES)
def test_a_light_pipe_keeps_the_size_of_each_component(at: Any, tilt: Any) -> None:
    pipe = BaffledTube(
        name="pipe",
        position=at,
        axis="+z",
        tilt_deg=tilt,
        half_width=0.05,
        length=400.0,
        surface=SILVER,
    )
    rows = np.array(pipe.frame)
    r = np.random.default_rng(2)
    aside = unit(r.normal(size=(20, 2)))
    along = unit(np.hstack([aside, np.full((20, 1), 0.1)])) @ rows
    starts = np.array(at) + np.array([0.01, 0.02, 0.0]) @ rows
    found = follow([pipe], np.tile(starts, (20, 1)), along, 4000)
    inside = found.left >= 0
    assert inside[:, 3000].all()  # thousands of bounces
    _, d = local(pipe, found)
    start = along @ rows.T
    drift = np.abs(np.abs(d) - np.abs(start)[:, None, :])[inside]
    assert drift.max() < 1e-13
    assert off_unit(found) < 8 * U


def skew(p: np.ndarray, d: np.ndarray) -> np.ndarray:
    return p[..., 0] * d[..., 1] - p[..., 1] * d[..., 0]


@pytest.mark.parametrize(("at", "tilt"), PLACES)
@pytest.mark.parametrize("angle", [0.1, 20.0, 75.0])
def test_a_cpc_keeps_the_skew_invariant(at: Any, tilt: Any, angle: float) -> None:
    """h = x·dy − y·dx about the axis, ray by ray, to 1e-13 of the radius."""
    cpc = Cpc(
        name="cpc",
        position=at,
        axis="+z",
        tilt_deg=tilt,
        exit_radius=0.7,
        acceptance_deg=angle,
        surface=SILVER,
    )
    rows = np.array(cpc.frame)
    r = np.random.default_rng(3)
    n, wide = 300, cpc.entrance_radius
    phi, radius = 2 * math.pi * r.random(n), wide * np.sqrt(r.random(n))
    starts = np.stack([radius * np.cos(phi), radius * np.sin(phi), np.full(n, cpc.length)], axis=1)
    lean = np.radians(1.2 * angle) * r.random(n)
    psi = 2 * math.pi * r.random(n)
    along = np.stack(
        [np.sin(lean) * np.cos(psi), np.sin(lean) * np.sin(psi), -np.cos(lean)], axis=1
    )
    found = follow([cpc], starts @ rows + at, unit(along @ rows), 60)
    p, d = local(cpc, found)
    drift = np.abs(skew(p, d) - skew(starts, along)[:, None])
    hit = np.isfinite(found.distance)
    assert hit.sum() > 100
    assert np.nanmax(np.where(hit, drift, 0.0)) < 1e-13 * wide
    assert off_unit(found) < 8 * U
    assert np.isfinite(found.distance[:, :1]).any()
    assert (~(found.left[:, -1] >= 0)).all()  # every ray has left it, by one end or the other


def test_a_cpc_closed_at_both_ends_keeps_its_rays() -> None:
    """Thousands of bounces in a CPC with mirrors on both apertures: no ray is lost."""
    cpc = Cpc(
        name="cpc",
        position=(0.0, 0.0, 0.0),
        axis="+z",
        exit_radius=0.7,
        acceptance_deg=40.0,
        surface=SILVER,
    )
    ends = [
        Disk(name=name, position=(0.0, 0.0, z), axis="+z", radius=radius, surface=SILVER)
        for name, z, radius in (("exit", 0.0, 0.7), ("lid", cpc.length, cpc.entrance_radius))
    ]
    r = np.random.default_rng(4)
    along = unit(r.normal(size=(30, 3)))
    starts = np.tile([0.1, 0.2, 0.5], (30, 1))
    found = follow([cpc, *ends], starts, along, 3000)
    assert (found.left >= 0).all()
    drift = np.abs(skew(found.point, found.direction) - skew(starts, along)[:, None])
    assert drift.max() < 1e-13 * cpc.entrance_radius * 20  # 3000 bounces
    # at its rims, from inside: on the rim, and beside it by roundings
    phi = 2 * math.pi * r.random(2000)
    beside = 1 + r.choice([0.0, U, -U, 1e-15, -1e-15], 2000)
    lid = r.random(2000) < 0.5
    k = np.where(lid, cpc.entrance_radius, 0.7) * beside
    rims = np.stack([k * np.cos(phi), k * np.sin(phi), np.where(lid, cpc.length, 0.0)], axis=1)
    starts = np.array([0.1, 0.2, 0.5]) + 0.3 * r.random((2000, 3))
    found = follow([cpc, *ends], starts, unit(rims - starts), 30)
    assert (found.left >= 0).all()


@pytest.mark.parametrize(("at", "tilt"), PLACES)
def test_lenses_keep_the_skew_invariant(at: Any, tilt: Any) -> None:
    """n·h is kept from before the lens to behind it, ray by ray; so the étendue is."""
    glass = Fresnel(index=1.7)
    lenses: list[Element] = [
        Biconvex(
            name="lens",
            position=at,
            axis="+z",
            tilt_deg=tilt,
            aperture_radius=1.0,
            surface=glass,
            **shape,
        )
        for shape in LENSES
    ]
    lenses.append(
        PlanoConvex(
            name="lens",
            position=at,
            axis="+z",
            tilt_deg=tilt,
            surface=glass,
            aperture_radius=1.0,
            curvature_radius=1.5,
        )
    )
    r = np.random.default_rng(5)
    for lens in lenses:
        rows = np.array(lens.frame)
        ends = np.stack([*(0.6 * r.uniform(-1, 1, (2, 300))), np.zeros(300)], axis=1)
        starts = np.stack([*r.uniform(-1, 1, (2, 300)), np.full(300, 3.0)], axis=1)
        along = unit(ends - starts)
        found = follow([lens], starts @ rows + at, along @ rows, 2)
        p, d = local(lens, found)
        before = skew(starts, along)
        through = (found.left[:, 1] >= 0) & (found.weight[:, 1] > 0)
        assert through.sum() > 200
        for step, index in ((0, 1.7), (1, None)):
            now = skew(p[:, step], d[:, step])
            if index is None:  # behind it, or totally reflected inside
                index = np.where(found.left[:, 1] & 2, 1.0, 1.7)
            assert np.abs(now * index - before)[through].max() < 1e-13
        assert off_unit(found) < 8 * U
