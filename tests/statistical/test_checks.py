"""Whether σ can be believed: rare bright paths are flagged, healthy runs are not."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import photizon_cl as pz
from benchmarks.believing import LAMP, interval, rare, rays_for
from photizon_cl.result.checks import Checks, _least_variance

NAME = "detectors.plate.power"


def run(seed, batches, *, glass):
    """Trace a scene of which one arrival in 10^5 carries a third; nine of them are expected."""
    rays = rays_for(9) // batches
    return pz.trace(rare(glass=glass), seed=seed, batches=batches, rays_per_batch=rays)


def test_the_rare_path_is_what_it_is_said_to_be():
    scene = rare(glass=False)
    far = scene.source["lamp"].position[2]
    assert 0.5 * (1.0 - far / math.hypot(far, 1.0)) == pytest.approx(LAMP, rel=1e-4)
    bright = scene.source["lamp"].flux * LAMP
    dim = scene.source["beam"].flux / 1.5**2
    assert bright / (bright + dim) == pytest.approx(1.0 / 3.0)
    arrives = 1.0 / 1.5**2
    assert arrives / LAMP == pytest.approx(1e5)


@pytest.mark.parametrize(
    ("batches", "glass"),
    [
        (8, True),
        pytest.param(40, False, marks=pytest.mark.slow),
        pytest.param(8, False, marks=pytest.mark.slow),
        pytest.param(40, True, marks=pytest.mark.slow),
    ],
)
def test_a_rare_bright_path_is_flagged(batches, glass):
    """All of 6 seeds, whether rays split or not."""
    for seed in range(6):
        found = run(seed, batches, glass=glass)
        checks = found.quantity(NAME).checks
        assert not checks.believable
        assert not checks.good["effective_arrivals"]
        (said,) = [text for text in found.advisories if "arrivals" in text]
        assert f"the σ of {NAME}" in said


@pytest.mark.slow
def test_of_many_runs_with_a_rare_bright_path_nearly_all_are_flagged():
    flagged = 0
    for seed in range(200):
        found = run(1000 + seed, 20, glass=bool(seed % 2))
        flagged += not found.quantity(NAME).checks.believable
    assert flagged >= 190, flagged


def doubtful(found):
    return [text for text in found.advisories if text.startswith("the σ of")]


@pytest.mark.parametrize("batches", [8, 30])
def test_healthy_runs_are_not(batches):
    """A scalar of normal batches has too large a variance of the variance once in 1000 times."""
    for name in ("box-room", "baffled-tube", "cosine-fourth"):
        for seed in range(6):
            found = pz.trace(name, seed=seed, batches=batches, rays_per_batch=512)
            assert not doubtful(found), (name, seed)


@pytest.mark.slow
def test_of_many_healthy_runs_next_to_none_is_flagged():
    flagged = runs = 0
    for name in pz.presets():
        for seed in range(60):
            for batches, rays in ((8, 4096), (30, 512)):
                runs += 1
                found = pz.trace(name, seed=seed, batches=batches, rays_per_batch=rays)
                flagged += bool(doubtful(found))
    assert flagged <= 0.02 * runs, f"{flagged} of {runs}"


# -- exactly -------------------------------------------------------------------------------------


def test_one_batch_of_many_that_has_all():
    values = np.zeros(20)
    values[7] = 3.0
    checks = Checks.of(values)
    assert not checks.good["largest_share"]
    assert checks.relative_sigma == pytest.approx(1.0)
    n = 20.0
    apart = ((n - 1) ** 4 + (n - 1)) / n**4 / ((n - 1) / n) ** 2 - 1 / n
    assert checks.variance_of_variance == pytest.approx(apart)
    assert checks.largest_share == 1.0
    assert not checks.believable


def test_scale_changes_nothing_however_large_or_small():
    values = np.random.default_rng(1).exponential(size=40)
    want = Checks.of(values)
    for scale in (1e-150, 1e-300, 1e150, 2.0**-40):
        found = Checks.of(values * scale)
        for name in ("relative_sigma", "variance_of_variance", "largest_share"):
            assert getattr(found, name) == pytest.approx(getattr(want, name), rel=1e-12)


def test_the_largest_arrival_is_bounded_by_the_heaviest_ray_and_by_the_largest_batch():
    values = np.array([3.0, 4.0, 5.0])
    assert Checks.of(values, 12, 1.0).largest_share == pytest.approx(1 / 12)
    assert Checks.of(values, 12, 100.0).largest_share == pytest.approx(5 / 12)
    assert Checks.of(-values, 12, 1.0).largest_share == pytest.approx(1 / 12)
    assert Checks.of(np.array([1.0, -1.0]), 2, 1.0).largest_share == 1.0


def test_of_equal_arrivals_each_has_its_part():
    scene = pz.load("cosine-fourth")
    result = pz.trace(scene, batches=8, rays_per_batch=256)
    name = next(n for n in result.quantity_names if n.startswith("detectors."))
    found = result.quantity(name)
    assert found.count
    assert found.checks.largest_share == pytest.approx(1 / found.count, rel=1e-12)


def test_what_has_no_scatter_is_believed():
    checks = Checks.of(np.full(9, 0.25), 900)
    assert (checks.relative_sigma, checks.variance_of_variance) == (0, 0)
    assert checks.largest_share == pytest.approx(1 / 9)
    assert all(checks.good.values())
    assert checks.believable
    assert checks.effective_arrivals is None
    assert Checks.of(np.zeros(9)) is None
    assert Checks.of(np.ones(1)) is None


def test_few_batches_may_have_a_larger_variance_of_the_variance():
    limits = [Checks(n, 0.01, 0.0, 0.0).limit for n in (2, 8, 12, 20, 40, 64, 100, 10**6)]
    assert limits == sorted(limits, reverse=True)
    assert limits[1] == 0.543
    assert limits[-3:] == [0.1, 0.1, 0.1]


def test_few_batches_want_more_effective_arrivals():
    """A σ of 8 batches is too small by half once in 20 times; the χ² are those of tables."""
    for free, chi2 in ((7, 2.16735), (19, 10.1170), (59, 42.3393)):
        assert _least_variance(free + 1) == pytest.approx(chi2 / free, rel=0.01)
    even = 1.0 / math.sqrt(2000.0)
    for batches, good in ((2, False), (8, False), (20, True), (200, True)):
        checks = Checks(batches, even, 0.0, 1.0 / batches, 10**6)
        assert checks.good["effective_arrivals"] == good
    # one in a hundred is enough of any number of batches
    assert Checks(8, even, 0.0, 0.125, 199_999).good["effective_arrivals"]


def test_the_interval_of_a_share():
    """As tables of Clopper and Pearson's have it."""
    assert interval(0, 10) == pytest.approx((0.0, 0.30850), abs=1e-5)
    assert interval(10, 10) == pytest.approx((0.69150, 1.0), abs=1e-5)
    assert interval(3, 20) == pytest.approx((0.03207, 0.37893), abs=1e-5)


def test_the_summary_has_the_checks_of_every_scalar_that_is_not_0():
    found = pz.trace("box-room", batches=9, rays_per_batch=512)
    checks = found.summary()["checks"]
    for name in found.quantity_names:
        quantity = found.quantity(name)
        assert (name in checks) == (quantity.value != 0.0)
        if name in checks:
            assert quantity.checks.summary() == checks[name]
            relative = quantity.sigma / quantity.value
            assert checks[name]["relative_sigma"] == pytest.approx(relative, rel=1e-9)
    again = pickle.loads(pickle.dumps(quantity := found.quantity("detectors.floor.power")))
    assert (again, again.checks, again.name) == (quantity, quantity.checks, quantity.name)


def test_a_target_that_is_met_by_an_error_that_is_poorly_known_is_told():
    found = pz.trace("box-room", target=0.9, target_on=["detectors.floor.ladder[9]"],
                     rays_per_batch=128)  # fmt: skip
    quantity = found.quantity("detectors.floor.ladder[9]")
    assert found.converged
    assert quantity.checks.relative_sigma > 0.1
    (said,) = doubtful(found)
    assert "is poorly known itself" in said
    few = pz.trace("box-room", batches=8, rays_per_batch=128,
                   target_on=["detectors.floor.ladder[9]"])  # fmt: skip
    assert not doubtful(few)  # a number of batches was asked for


def lenses_face_to_face():
    """Two lenses and a disk at their focus: hundreds of ghosts arrive of each ray."""
    glass = pz.Fresnel(1.5)
    lens = {"curvature_radius": 0.1, "aperture_radius": 0.03, "surface": glass}
    first = pz.PlanoConvex(name="first", position=(0, 0, 0), axis="+z", **lens)
    second = pz.PlanoConvex(name="second", position=(0, 0, 0.03), axis="-z", **lens)
    focus = pz.Disk(name="focus", position=(0, 0, 0.12), axis="-z", radius=0.004,
                    surface=pz.Absorber(), detector=pz.Detector())  # fmt: skip
    lamp = pz.CollimatedDisk(name="lamp", flux=1, position=(0, 0, -0.1), axis="+z", radius=0.03)
    return pz.Scene("lenses", (lamp,), (first, second, focus))


def test_ghosts_of_one_ray_are_no_arrivals_of_their_own():
    for seed in range(3):
        found = pz.trace(lenses_face_to_face(), seed=seed, batches=8, rays_per_batch=256)
        assert found.quantity("detectors.focus.power").count > 8 * 256
        assert not doubtful(found), seed


def test_few_batches_make_nothing_believable():
    values = np.zeros(7)
    values[2] = 1.0
    assert not Checks.of(values).believable
    assert not Checks.of(np.ones(7)).believable
    assert Checks.of(np.ones(8)).believable


def test_long_runs_say_that_nothing_is_checked(monkeypatch):
    monkeypatch.setattr("photizon_cl.result.batch_values.MOST_VALUES", 200)
    found = pz.trace("cosine-fourth", batches=60, rays_per_batch=64)
    assert any("cannot be checked" in text for text in found.advisories)
    assert found.summary()["checks"] == {}


def test_a_detector_that_saw_nothing_where_a_map_met_the_target_is_told():
    scene = pz.load("box-room").to_dict()
    diodes = [
        {"name": f"diode {n}", "kind": "disk", "position": [0.01 * n, 0.2, 0.5], "axis": "+z",
         "radius": 1e-6, "surface": {"kind": "absorber"}, "detector": {}}
        for n in range(5)
    ]  # fmt: skip
    scene["element"] += diodes
    found = pz.trace(scene, target=0.3, rays_per_batch=2048)
    assert found.converged
    said = [text for text in found.advisories if "was met by the median" in text]
    assert len(said) == 3
    assert all("is 0, nothing having arrived" in text for text in said)
    assert "2 more detectors stand as far from the target" in found.advisories
