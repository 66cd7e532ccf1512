"""Curved faces that touch at a vertex: a film lies there, whatever the order in the file."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from oracles.scenes import beam

import photizon_cl as pz

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly", "one_lane")

BOTTOM = (0.0, 0.0, 0.0)


def lens(name, top, index, **shape):
    """A lens whose front vertex is at a height."""
    made = pz.Lens(name=name, position=BOTTOM, axis="+z", aperture_radius=0.2,
                   surface=pz.Fresnel(index), **shape)  # fmt: skip
    return replace(made, position=(0.0, 0.0, top - made.vertices[0]))


def below(name, top, **more):
    return lens(name, top, 2.0, front_radius=1.0, back_radius=1.0, thickness=0.2, **more)


UPPER = {"front_radius": 1.0, "back_radius": 1.0, "thickness": 0.2}
DISK = pz.Disk(name="b", position=BOTTOM, axis="+z", radius=0.3, surface=pz.Absorber())
BALL = pz.Sphere(
    name="b", position=(0.0, 0.0, -0.5), axis="+z", radius=0.5, surface=pz.Fresnel(2.0)
)
FOUND = {
    "lens on lens": (lens("a", 0.2, 1.5, **UPPER), below("b", 0.0)),
    "conics": (lens("a", 0.2, 1.5, back_conic=-0.5, **UPPER), below("b", 0.0, front_conic=0.7)),
    "lens on ball": (lens("a", 0.2, 1.5, back_conic=-2.0, **UPPER), BALL),
    "lens on disk": (lens("a", 0.2, 1.5, **UPPER), DISK),
    "conic lens on disk": (lens("a", 0.2, 1.5, back_conic=-0.5, **UPPER), DISK),
    # one in the other, of one curvature: they share no more than the vertex
    "in a hollow": (
        lens("a", 0.2, 1.5, back_conic=-0.5, **UPPER),
        lens("b", 0.0, 2.0, front_radius=-1.0, back_radius=math.inf, thickness=0.2),
    ),
}  # fmt: skip

BRIEFLY = ("lens on lens", "conic lens on disk")


@pytest.mark.parametrize(
    "name",
    # one of a pair of refracting faces, one of conics: the others are programs of their own
    [n if n in BRIEFLY else pytest.param(n, marks=pytest.mark.slow) for n in FOUND],
)
def test_an_axial_beam_passes_a_film(name):
    """Of four faces, or two before a black one: the order of the file is nothing to it."""
    one, other = FOUND[name]
    lamp = pz.load({"schema": "photizon/1", "name": "l", "element": [], "source": [
        {"name": "lamp", **beam((0.0, 0.0, 1.0), "-z", 1e-12)}]}).source  # fmt: skip
    screen = pz.Disk(name="screen", position=(0.0, 0.0, -3.0), axis="+z", radius=1.0,
                     surface=pz.Absorber())  # fmt: skip
    run = pz.RunSettings(rays_per_batch=16, generation_cap=14, roulette_floor=0.0)
    ends = []
    for elements in ((one, other), (other, one)):
        scene = pz.Scene("s", lamp, (*elements, screen), run=run)
        assert any(" touch" in text and '"a"' in text for text in pz.advisories(scene)), name
        ledger = pz.trace(scene, batches=1).ledger
        ends.append([ledger.absorbed["screen"].value, ledger.absorbed[other.name].value])
    assert ends[0] == ends[1]
    # sums of geometric series; what still travels at the cap is below 1e-6
    r = (0.5 / 2.5) ** 2
    if other is DISK:
        assert ends[0] == pytest.approx([0.0, (1 - r) / (1 + r)], abs=1e-6)
    else:
        faces = [r, r, 1.0 / 9.0, 1.0 / 9.0]
        lost = sum(f / (1.0 - f) for f in faces)
        assert ends[0] == pytest.approx([1.0 / (1.0 + lost), 0.0], abs=1e-4)


@pytest.mark.parametrize(("axis", "absorbed"), [("-z", 0.96), ("+z", 1.0)])
def test_a_paraboloid_on_a_black_disk(axis, absorbed):
    """Glass that is left is met before the disk, and turns 0.04 of the beam back; else the disk."""
    lamp = pz.CollimatedDisk(name="l", flux=1.0, position=(0, 0, 1.0), axis="-z", radius=1e-12)
    sheet = pz.Conic(name="a", position=BOTTOM, axis=axis, curvature_radius=1.0,
                     conic_constant=-1.0, aperture_radius=0.2, surface=pz.Fresnel(1.5))  # fmt: skip
    for elements in ((sheet, DISK), (DISK, sheet)):
        scene = pz.Scene("s", (lamp,), elements, run=pz.RunSettings(rays_per_batch=16))
        ledger = pz.trace(scene, batches=1).ledger
        assert ledger.absorbed["b"].value == pytest.approx(absorbed, abs=1e-15)
        assert ledger.escaped.value == pytest.approx(1.0 - absorbed, abs=1e-15)


def test_nothing_is_shared_beside_the_vertex():
    """A hole, a gap, or a vertex that is none: no contact is seen."""
    a, _ = FOUND["conic lens on disk"]
    apart = replace(a, position=(0.0, 0.0, a.position[2] + 1e-6))
    ring = pz.Disk(
        name="b", position=BOTTOM, axis="+z", radius=0.3, inner_radius=0.1, surface=pz.Absorber()
    )
    lamp = (pz.IsotropicPoint(name="l", flux=1.0, position=(0, 0, 1.0)),)
    for one, other in ((apart, DISK), (a, ring)):
        said = pz.advisories(pz.Scene("s", lamp, (one, other)))
        assert not any('"a"' in text and '"b"' in text for text in said)


@pytest.mark.parametrize("k", [0.5, 3.0, 30.0, -0.9])
@pytest.mark.parametrize("turned", [False, True])
def test_a_lens_is_held_by_its_ball(k, turned):
    """An oblate face is farthest off between vertex and rim."""
    rim = 0.999 / math.sqrt(1.0 + k) if k > -1 else 1.0
    radii = {"front_radius": 1.0, "front_conic": k, "back_radius": math.inf}
    if turned:
        radii = {"back_radius": 1.0, "back_conic": k, "front_radius": math.inf}
    made = pz.Lens(name="a", position=BOTTOM, axis="+z", aperture_radius=rim,
                   surface=pz.Fresnel(1.5), thickness=1.0 / (1.0 + k), **radii)  # fmt: skip
    face = made.faces[int(turned)]
    r, z = face.profile(np.linspace(0.0, 1.0, 4001))
    farthest = float(np.hypot(r, z).max())
    assert farthest <= made.reach <= farthest * (1.0 + 1e-6)
