"""What the rows of the registry must hold on average: areas, densities, reciprocity.

The gates are one family: with a right engine the chance that any of them fails is `FALSE_ALARM`
for the whole file, shared among them by Šidák's formula (`LEVEL` each). Limits are exact quantiles
of the law that each has: the normal one for means of thousands of bounded numbers, Student's for
differences between batches. Seeds are fixed, nothing is run again. No gate rests on few counts:
each says how many it has at least.
"""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from contract import of_kind, surface, turned
from oracles.engine import PLAN, compiled, open_device, scene_of, trace
from oracles.scenes import wall
from oracles.statistics import batch_values, sidak, z_limit
from photizon_docs.examples import guess

import photizon_cl as pz
from hostcode.run.probe import LEFT_PLUS, NO_FACE, element_of, probe_faces
from photizon_cl.scene.registry import ELEMENTS, SOURCES, SURFACES

FALSE_ALARM = 1e-6
UNIT_ROUNDOFF = 2.0**-53
REFLECTORS = [kind for kind, cls in SURFACES.items() if cls.reflects and cls.reciprocal]
LOW, HIGH = (-0.6, 0.0, 0.15), (0.3, 0.1, 0.9)
"""Over a plate: seen from its middle, one is near grazing and one near the normal."""
MOMENTS_EACH = 7
RAYS = 1 << 15
GATES = len(ELEMENTS) + MOMENTS_EACH * len(SOURCES) + len(REFLECTORS)
LEVEL = sidak(FALSE_ALARM, GATES)
Z = -NormalDist().inv_cdf(LEVEL / 2.0)


def has_mean(sample: np.ndarray, wanted: float, rounding: float = 0.0) -> None:
    """Assert that numbers have a mean, as far as chance at `LEVEL` and their rounding go."""
    slack = Z * float(sample.std(ddof=1)) / math.sqrt(len(sample)) + rounding
    found = float(sample.mean())
    assert abs(found - wanted) <= slack, f"{found} is not {wanted} ± {slack}"


def test_the_level_of_a_gate():
    assert pytest.approx(FALSE_ALARM, rel=1e-6) == 1.0 - (1.0 - LEVEL) ** GATES
    assert pytest.approx(z_limit(LEVEL), rel=1e-9) == Z
    has_mean(np.array([1.0, 3.0]), 2.0)
    for off in (-1.01, 1.01):
        with pytest.raises(AssertionError):
            has_mean(np.array([1.0, 3.0]), 2.0 + off * Z)


# -- areas -----------------------------------------------------------------------------------------


def crossings(scene: pz.Scene, starts: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return how often each line meets a surface: rays that go through all that they hit."""
    made = compiled(scene)
    rays, count = np.hstack([starts - made.shift, along]), np.zeros(len(starts), np.int64)
    left, on = np.full(len(rays), NO_FACE, np.int64), np.arange(len(rays))
    while len(on):
        hits, faces = probe_faces(open_device(), made.tables, rays[on], 1, left[on])
        met = element_of(faces) >= 0
        on = on[met]
        count[on] += 1
        rays[on, :3], left[on] = hits[met, 1:4], faces[met] ^ LEFT_PLUS
    return count


def has_area(element: Any, area: float, lines: int = 1 << 18) -> None:
    """Assert an area of one side by the lines that cross it (Cauchy and Crofton).

    Of lines of one direction d, spread evenly over a disc of radius R across d, a surface within
    the ball of radius R is crossed ∫ |n·d| dA / πR² times on average. Over all directions the mean
    of |n·d| is 1/2: A / 2πR². For the ball itself that is 2, and whichever side a line comes from
    it counts once. L. A. Santaló, Integral Geometry and Geometric Probability (1976), 14.7.
    """
    low, high = (np.array(corner) for corner in element.local_box)
    radius = 0.5 * float(np.linalg.norm(high - low))
    centre = element.position + 0.5 * (low + high) @ np.array(element.frame)
    random = np.random.default_rng(11)
    along = random.normal(size=(lines, 3))
    along /= np.linalg.norm(along, axis=1)[:, None]
    # a point of the disc: across a second direction, at a distance of the square root of a chance
    aside = np.cross(along, random.normal(size=(lines, 3)))
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    starts = centre + radius * (np.sqrt(random.random((lines, 1))) * aside - 2.0 * along)
    lamp = pz.IsotropicPoint(name="s", flux=1.0, position=(9.0, 9.0, 9.0))
    count = crossings(pz.Scene(name="lines", source=(lamp,), element=(element,)), starts, along)
    assert np.count_nonzero(count) > 1000  # enough for the normal law
    has_mean(count * (2.0 * math.pi * radius**2 / area), 1.0)


@pytest.mark.parametrize("kind", ELEMENTS)
def test_the_area_of_an_element_is_what_lines_cross(kind):
    element = turned(kind)
    has_area(element, element.area)


def test_a_wrong_area_is_caught():
    element = turned("sphere")
    for wrong in (0.98, 1.02):
        with pytest.raises(AssertionError):
            has_area(element, wrong * element.area)


# -- sources ---------------------------------------------------------------------------------------

_C = math.cos(math.radians(30.0))
MOMENTS: dict[str, tuple[float, float, float]] = {
    # mean cosine about the axis, its mean square, mean squared distance of the start in `reach`²
    "isotropic-point": (0.0, 1 / 3, 0.0),
    "cosine-point": (2 / 3, 1 / 2, 0.0),
    "lambertian-disk": (2 / 3, 1 / 2, 1 / 2),
    "lambertian-sphere": (0.0, 1 / 3, 1.0),
    "collimated-disk": (1.0, 1.0, 1 / 2),
    "cone-point": ((1 + _C) / 2, (1 + _C + _C**2) / 3, 0.0),
    "lambertian-rectangle": (2 / 3, 1 / 2, 1 / 3),
}


@pytest.fixture(scope="session")
def launched() -> tuple[pz.Scene, np.ndarray, np.ndarray]:
    """Rays of all sources, which stand 1 m apart: scene, starts, unit directions."""
    sources = []
    for n, cls in enumerate(SOURCES.values()):
        values = {**guess(cls), "name": f"{n}", "flux": 1.0, "position": (float(n), 0.2, 0.3)}
        turn = {"axis": "-y", "tilt_deg": (20.0, 30.0)} if cls.directed else {}
        sources.append(cls(**(values | turn)))
    scene = pz.Scene(name="sources", source=tuple(sources))
    found = pz.paths(scene, rays=RAYS * len(sources), max_segments=1)
    along = found.end - found.start
    return scene, found.start, along / np.linalg.norm(along, axis=1)[:, None]


@pytest.mark.parametrize("kind", SOURCES)
def test_a_source_has_the_moments_of_its_density(kind, launched):
    assert kind in MOMENTS, "give the moments of the new source here"
    scene, starts, along = launched
    source = of_kind(scene, "source", kind)
    own = np.rint(starts[:, 0]) == source.position[0]
    assert own.sum() == RAYS
    size = source.reach or 1.0
    rounding = 64.0 * UNIT_ROUNDOFF * max(map(abs, source.position)) / size
    du, dv, mu = (along[own] @ np.array(axis) for axis in source.frame)
    places = (starts[own] - source.position) / size
    pu, pv, _ = (places @ np.array(axis) for axis in source.frame)
    away = (places**2).sum(axis=1)
    mean, square, spread = MOMENTS[kind]
    wanted = (
        (mu, mean),
        (mu**2, square),
        (du, 0.0),
        (dv, 0.0),
        (away, spread),
        (pu, 0.0),
        (pv, 0.0),
    )
    assert len(wanted) == MOMENTS_EACH
    for sample, value in wanted:
        has_mean(sample, value, rounding)
    assert away.max() <= (1.0 if source.reach else 0.0) + rounding
    assert source.draws_position == bool(source.reach)


# -- surfaces --------------------------------------------------------------------------------------


def received(surface: Any, here: Any, there: Any) -> np.ndarray:
    """Return what a target gets of a lamp by way of a plate, in launched weights by batch.

    Light passes the target, as it passes a lamp: neither shadows what the other does not.
    """
    disk = {"axis": "-z", "radius": 0.2}
    lamp = {"kind": "lambertian-disk", "flux": 1.0, "position": list(here), **disk}
    black, clear = ({"surface": {"kind": kind}} for kind in ("absorber", "clear"))
    target = {"kind": "disk", "position": list(there), **disk, **clear, "detector": {}}
    scene = scene_of([lamp], [{**wall((0, 0, 0), "+z", 3.0), **black}, target])
    board = replace(scene.element[0], surface=surface)
    scene = replace(scene, element=(board, scene.element[1]))
    plan = PLAN.with_(lanes=1)
    found = trace(scene, batches=64, rays_per_batch=1 << 14, plan=plan)
    assert found.detector("element 1").count > 1000
    return batch_values(found)[:, found.compiled.layout.detectors[0].power]


def reciprocal(there: np.ndarray, back: np.ndarray) -> None:
    """Assert that two ways bring the same, by Student's t of the batches' differences."""
    assert min(there.sum(), back.sum()) > 0.0
    off = there - back
    t = float(off.mean() / (off.std(ddof=1) / math.sqrt(len(off))))
    assert abs(t) < z_limit(LEVEL, len(off) - 1), f"t = {t}"


@pytest.mark.parametrize("kind", REFLECTORS)
def test_a_reflector_is_reciprocal(kind):
    """A small lamp and a small target, of one size, change places."""
    reciprocal(received(surface(kind), LOW, HIGH), received(surface(kind), HIGH, LOW))


def test_what_is_not_reciprocal_is_caught():
    dim = pz.Lambertian(reflectance=0.7)
    with pytest.raises(AssertionError):
        reciprocal(received(surface("lambertian"), LOW, HIGH), received(dim, HIGH, LOW))
