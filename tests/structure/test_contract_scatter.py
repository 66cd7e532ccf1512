"""What importance sampling rests on: each surface's density, and what is aimed at.

A surface that sends rays in directions drawn at random says so (`Surface.scatters`), and its
kernel gives the density of them. That is asked for of every surface of the registry by what it
does to a beam. Directions are compared with the density by χ², at a level of `ALPHA` a surface;
seeds are fixed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from contract import surface, turned
from oracles.engine import compiled, scene_of
from oracles.kernels import run_text
from oracles.scenes import beam, wall
from oracles.statistics import chi_square

import photizon_cl as pz
from hostcode.assets import kernels_dir
from photizon_cl.geometry.targets import BALL, SQUARE, target_of
from photizon_cl.scene.registry import ELEMENTS, SURFACES

ALPHA = 1e-6
RAYS = 1 << 14
FEW = 256
"""As many rays as show whether any two went on in directions of their own."""
N_MU, N_PHI, FINE = 8, 12, 24
SCATTERING = [kind for kind, cls in SURFACES.items() if cls.scatters]


def plate(optics, **parts):
    """A slanting beam onto a plate of some surface, and a target far aside."""
    lamp = {**beam((0.0, 0, 0.5), "-z", 1e-9), "tilt_deg": [20.0, 0.0]}
    board = {**wall((0, 0, 0), "+z", 50.0), "surface": {"kind": "absorber"}}
    scene = scene_of([lamp], [board], **parts)
    return replace(scene, element=(replace(scene.element[0], surface=optics),))


def drawn_directions(optics, rays=RAYS) -> np.ndarray:
    """Return the directions of rays that left the plate each in its own, shape (n, 3)."""
    found = pz.paths(plate(optics), rays=rays)
    left = found.generation == 1
    along = found.end[left] - found.start[left]
    along /= np.linalg.norm(along, axis=1)[:, None]
    _, number, times = np.unique(
        np.round(along, 12), axis=0, return_inverse=True, return_counts=True
    )
    return along[times[np.ravel(number)] == 1]


def says_what_it_draws(optics) -> None:
    """Assert that a surface scatters where its class says so, and has the density of it."""
    cls = type(optics)
    assert cls.scatters == bool(len(drawn_directions(optics, FEW))), (
        "what draws directions sets `scatters`, calls scattered() and has density_<kernel>()"
    )
    text = (kernels_dir() / "surfaces" / f"{cls.kernel}.mako").read_text("utf-8")
    assert cls.scatters == (f"FN real density_{cls.kernel}(" in text)
    assert cls.scatters == ("scattered(outcome, " in text)
    assert cls.draws or not cls.scatters


@pytest.mark.parametrize("kind", SURFACES)
def test_a_surface_that_draws_directions_has_a_density(kind):
    says_what_it_draws(surface(kind))


def test_a_surface_that_hides_what_it_draws_is_caught():
    silent = type("Silent", (pz.Lambertian,), {"scatters": False})
    loud = type("Loud", (pz.Mirror,), {"scatters": True})
    for wrong in (silent(0.5), loud(0.5)):
        with pytest.raises(AssertionError):
            says_what_it_draws(wrong)


_BODY = """
__kernel void test(__global const double *materials, __global const double *ways,
                   __global double *out) {
    const size_t i = get_global_id(0);
    packet_t p = {0};
    p.dx = ways[0]; p.dy = ways[1]; p.dz = ways[2];
    p.w = 1.0;
    contact_t c = no_contact(&p, splat(0.0));
    c.nx = splat(0.0); c.ny = splat(0.0); c.nz = splat(1.0);
    c.came_plus = ALL_LANES;
    const material_t material = {materials, lsplat(0L), 0L};
    const encounter_t event = {ALL_LANES, &p, &c, 1UL};
    out[i] = density_KERNEL(&event, &material, ways[3 * i + 3], ways[3 * i + 4], ways[3 * i + 5]);
}
"""


def density(optics, ways) -> np.ndarray:
    """Return what the kernel gives for directions, shape (n, 3), after the slanting beam."""
    element = plate(optics).element[0]
    made = compiled(replace(plate(optics), importance=pz.Importance(toward=[element.name]))).tables
    body = _BODY.replace("KERNEL", type(optics).kernel)
    given = np.vstack([plate(optics).source[0].frame[2], ways])
    materials = np.ascontiguousarray(made.materials)
    *_, found = run_text(body, [materials, given, np.zeros(len(ways))], len(ways), spec=made.spec)
    return found


def by_bin(optics) -> np.ndarray:
    """Return the density's integrals over bins of cos θ and φ, by the midpoint rule."""
    mu = (np.arange(N_MU * FINE) + 0.5) * (2.0 / (N_MU * FINE)) - 1.0
    phi = (np.arange(N_PHI * FINE) + 0.5) * (2.0 * math.pi / (N_PHI * FINE))
    mu, phi = (grid.ravel() for grid in np.meshgrid(mu, phi, indexing="ij"))
    sine = np.sqrt(1.0 - mu * mu)
    found = density(optics, np.column_stack([sine * np.cos(phi), sine * np.sin(phi), mu]))
    cells = found.reshape(N_MU, FINE, N_PHI, FINE).sum(axis=(1, 3))
    return cells * (2.0 / (N_MU * FINE)) * (2.0 * math.pi / (N_PHI * FINE))


def has_its_density(optics) -> None:
    """Assert that directions follow the density; what that lacks of 1 goes nowhere."""
    shares = by_bin(optics)
    total = shares.sum()
    assert 0.0 < total < 1.0 + 1e-3
    way = drawn_directions(optics)
    assert abs(len(way) / RAYS - total) < 1e-3 + 5.0 * math.sqrt(total * abs(1.0 - total) / RAYS)
    turn = np.arctan2(way[:, 1], way[:, 0]) % (2.0 * math.pi)
    counts, *_ = np.histogram2d(
        way[:, 2], turn, bins=(N_MU, N_PHI), range=((-1.0, 1.0), (0.0, 2.0 * math.pi))
    )
    chi_square(counts.astype(np.int64), shares / total, ALPHA)


@pytest.mark.parametrize("kind", SCATTERING)
def test_directions_have_the_density_of_the_kernel(kind):
    has_its_density(surface(kind))


# -- what is aimed at ------------------------------------------------------------------------------

LAMP_AT = {"name": "s", "flux": 1.0, "position": (9.0, 9.0, 9.0)}


@pytest.mark.parametrize("kind", ELEMENTS)
def test_every_element_lies_within_its_target(kind):
    """By the points where lines from all around meet it."""
    element = turned(kind)
    scene = pz.Scene(name="one", source=(pz.IsotropicPoint(**LAMP_AT),), element=(element,))
    random = np.random.default_rng(5)
    starts = np.array(element.position) + 3.0 * element.reach * random.normal(size=(4000, 3))
    along = np.array(element.position) + element.reach * random.normal(size=(4000, 3)) - starts
    hits = pz.probe(scene, starts, along / np.linalg.norm(along, axis=1)[:, None], lanes=1)
    points = hits.point[hits.element >= 0]
    assert len(points) > 100
    target = target_of(element)
    u, v, w = np.array(target.frame) @ (points - target.centre).T
    if target.shape == BALL:
        assert (u**2 + v**2 + w**2 <= (target.a * (1 + 1e-12)) ** 2).all()
    else:
        assert np.abs(w).max() < 1e-12
        r = np.hypot(u, v)
        inside = (target.b - 1e-12 <= r) & (r <= target.a + 1e-12)
        if target.shape == SQUARE:
            inside = (np.abs(u) <= target.a + 1e-12) & (np.abs(v) <= target.b + 1e-12)
        assert inside.all()
        assert target.area == pytest.approx(element.area)
