"""Ghosts of a window and a lens against a sequential trace of its own, written for this test.

Each ghost is a fixed sequence of faces, so that a dense regular bundle, refracted and reflected
face by face with vectors and both polarisations of Fresnel, gives its power without chance.
"""

from __future__ import annotations

import numpy as np
import pytest

import photizon_cl as pz

RADIUS, CURVATURE, APERTURE = 0.004, 0.05, 0.01
N_WINDOW, N_LENS = 1.5, 1.5168
SAG = CURVATURE - np.sqrt(CURVATURE**2 - APERTURE**2)
HALF = (0.004, 0.003)
# coordinate along the beam, centre of the sphere, index before and behind
FACES = {
    "window front": (0.0, None, 1.0, N_WINDOW),
    "window back": (0.003, None, N_WINDOW, 1.0),
    "curved": (0.02 - SAG, 0.02 - SAG + CURVATURE, 1.0, N_LENS),
    "flat": (0.02, None, N_LENS, 1.0),
}
GHOSTS = [
    ("window back", "window front"), ("flat", "window back"), ("flat", "window front"),
    ("curved", "window back"), ("curved", "window front"), ("flat", "curved"),
]  # fmt: skip


def ghosts(sensor):
    def sheet(name, z, axis):
        return {
            "name": name, "kind": "disk", "position": [0, 0, z], "axis": axis, "radius": 0.02,
            "surface": {"kind": "fresnel", "index": N_WINDOW},
        }  # fmt: skip

    return {
        "schema": "photizon/1", "name": "ghosts",
        "run": {"rays_per_batch": 1024, "roulette_floor": 1e-6},
        "source": [{
            "name": "sun", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -0.05],
            "axis": "+z", "radius": RADIUS,
        }],
        "element": [
            sheet("window front", 0.0, "-z"), sheet("window back", 0.003, "+z"),
            {
                "name": "lens", "kind": "plano-convex", "position": [0, 0, 0.02], "axis": "-z",
                "curvature_radius": CURVATURE, "aperture_radius": APERTURE,
                "surface": {"kind": "fresnel", "index": N_LENS},
            },
            {
                "name": "sensor", "kind": "rectangle", "position": [0, 0, 0.1], "axis": "-z",
                "half_width": sensor[0], "half_height": sensor[1],
                "surface": {"kind": "absorber"}, "detector": {"paths": 20},
            },
        ],
    }  # fmt: skip


def bundle(n):
    """Return a sunflower of rays over the beam."""
    k = np.arange(n) + 0.5
    r, phi = RADIUS * np.sqrt(k / n), k * np.pi * (3.0 - np.sqrt(5.0))
    start = np.stack([r * np.cos(phi), r * np.sin(phi), np.full(n, -0.05)], axis=1)
    return start, np.tile([0.0, 0.0, 1.0], (n, 1)), np.full(n, 1.0 / n)


def meet(name, at, d, w, *, reflects):
    """Return rays behind a face."""
    z, centre, before, behind = FACES[name]
    if centre is None:
        t = (z - at[:, 2]) / d[:, 2]
        normal = np.tile([0.0, 0.0, -1.0], (len(at), 1))
    else:
        f = at - np.array([0.0, 0.0, centre])
        b, c = np.sum(f * d, axis=1), np.sum(f * f, axis=1) - CURVATURE**2
        roots = np.sqrt(b * b - c)
        # the face is the part of the sphere on the side of its vertex
        near, far = -b - roots, -b + roots
        t = np.where(at[:, 2] + near * d[:, 2] <= 0.02 + 1e-12, near, far)
        t = np.where(near <= 1e-12, far, t)
        normal = (at + t[:, None] * d - np.array([0.0, 0.0, centre])) / CURVATURE
    at = at + t[:, None] * d
    forward = d[0, 2] > 0.0
    n1, n2 = (before, behind) if forward else (behind, before)
    normal = normal if forward else -normal
    ci = -np.sum(d * normal, axis=1)
    ct = np.sqrt(1.0 - (n1 / n2) ** 2 * (1.0 - ci**2))
    rs = (n1 * ci - n2 * ct) / (n1 * ci + n2 * ct)
    rp = (n2 * ci - n1 * ct) / (n2 * ci + n1 * ct)
    part = 0.5 * (rs**2 + rp**2)
    if reflects:
        return at, d + 2.0 * ci[:, None] * normal, w * part
    m = n1 / n2
    return at, m * d + (m * ci - ct)[:, None] * normal, w * (1.0 - part)


def expected(first, second, sensor, n=200_000):
    """Return the power of a ghost on the sensor."""
    order = list(FACES)
    last, turn = order.index(first), order.index(second)
    steps = [(name, False) for name in order[:last]] + [(first, True)]
    steps += [(name, False) for name in reversed(order[turn + 1 : last])] + [(second, True)]
    steps += [(name, False) for name in order[turn + 1 :]]
    at, d, w = bundle(n)
    for name, reflects in steps:
        at, d, w = meet(name, at, d, w, reflects=reflects)
    at = at + ((0.1 - at[:, 2]) / d[:, 2])[:, None] * d
    lands = (np.abs(at[:, 0]) <= sensor[0]) & (np.abs(at[:, 1]) <= sensor[1])
    return float(w[lands].sum())


@pytest.mark.parametrize(
    "sensor", [HALF, pytest.param((0.02, 0.02), marks=pytest.mark.slow)], ids=["small", "large"]
)
def test_six_ghosts_are_those_of_a_sequential_trace(sensor):
    """False alarms: 6 comparisons at 5 σ with 15 degrees of freedom, 1e-3."""
    table = pz.trace(ghosts(sensor), batches=16).detectors["sensor"].paths
    pairs = {
        (pair.first.replace('"', "").removesuffix(".face").removeprefix("lens."),
         pair.second.replace('"', "").removesuffix(".face").removeprefix("lens.")): pair
        for pair in table.ghosts().pairs()
    }  # fmt: skip
    assert pairs.keys() == set(GHOSTS)
    for ghost in GHOSTS:
        value = expected(*ghost, sensor)
        # the bundle's own error: rays at the sensor's edge
        assert abs(pairs[ghost].power - value) <= 5.0 * pairs[ghost].sigma + 2e-4 * value
    assert table[0].events == "tttt"
    assert table[0].power == pytest.approx(0.8455, abs=5e-5)
