"""Total integrated scatter: closed forms, quadrature by other routes, and what a trace scatters."""

from __future__ import annotations

import itertools
import math

import mpmath
import numpy as np
import pytest
from oracles.engine import scene_of, trace
from oracles.lobes import LOBES
from oracles.scenes import beam, wall
from scipy import integrate, special

import photizon_cl as pz
from photizon_cl.errors import ArgumentError
from photizon_cl.scene.scatters.functions import exp_of, gauss_nodes, log_of, power_of
from photizon_cl.scene.scatters.total import total_at

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

ANGLES = np.arange(0.0, 81.0, 10.0)


def exactly(lobe, angle_deg):
    """Return TIS by quadrature, before anything is cut into pieces."""
    sine = math.sin(math.radians(angle_deg))
    return float(total_at(lobe, np.array([1.0 - sine]))[0])


def test_abg_of_g_2_has_the_closed_form():
    a, b = 1e-3, 1e-2
    lobe = pz.AbgScatter(A=a, B=b, g=2.0)
    assert lobe.total(0.0) == pytest.approx(0.0144988, abs=5e-8)
    square = np.sin(np.radians(ANGLES)) ** 2
    part = 1.0 - square + b
    closed = math.pi * a * np.log((part + np.sqrt(part**2 + 4.0 * b * square)) / (2.0 * b))
    assert lobe.total(ANGLES) == pytest.approx(closed, rel=1e-8)
    assert [exactly(lobe, angle) for angle in ANGLES] == pytest.approx(closed, rel=1e-9)


def test_a_gaussian_has_marcums_integral():
    """The part of a two-dimensional normal law within a disc: χ² of two degrees, off centre."""
    lobe = pz.GaussianScatter(sigma=0.3, tis=0.9)
    sine = np.sin(np.radians(ANGLES))
    closed = 0.9 * special.chndtr(1.0 / 0.09, 2, sine**2 / 0.09)
    assert lobe.total(ANGLES) == pytest.approx(closed, rel=1e-8)


def test_harvey_shack_of_slope_minus_2_is_an_abg():
    ours = pz.HarveyShackScatter(b0=0.1, L=0.1, S=-2.0)
    assert ours.total(ANGLES) == pytest.approx(pz.AbgScatter(1e-3, 1e-2, 2.0).total(ANGLES), 1e-8)


def by_radius(lobe, angle_deg):
    """Return TIS as ∫ BSDF r arc(r) dr: another way round the disc, by adaptive quadrature."""
    b = math.sin(math.radians(angle_deg))

    def arc(r):
        if r <= 1.0 - b:
            return 2.0 * math.pi
        cosine = (r * r + b * b - 1.0) / (2.0 * r * b)
        return 2.0 * math.acos(min(max(cosine, -1.0), 1.0))

    edges = {0.0, 1.0 - b, 1.0 + b, *(k for k in lobe.kinks if k < 1.0 + b)}
    edges |= {w for k in range(-2, 12) if (w := lobe.width * 2.0**k) < 1.0 + b}
    edges = sorted(edges)
    parts = [
        integrate.quad(
            lambda r: float(lobe.bsdf(r)) * r * arc(r), low, high, epsabs=0, epsrel=1e-11, limit=200
        )[0]
        for low, high in itertools.pairwise(edges)
    ]
    return math.fsum(parts)


@pytest.mark.filterwarnings("ignore::scipy.integrate.IntegrationWarning")
@pytest.mark.parametrize("name", LOBES)
def test_every_model_against_quadrature_by_radius(name):
    lobe = LOBES[name]
    greatest, at = lobe.greatest_tis()
    assert greatest >= lobe.total(ANGLES).max() * (1.0 - 1e-8)
    assert lobe.total(at) == pytest.approx(greatest, rel=1e-8)
    for angle in (0.0, 50.0, 80.0):
        wanted = by_radius(lobe, angle)
        assert exactly(lobe, angle) == pytest.approx(wanted, rel=1e-8)
        assert abs(float(lobe.total(angle)) - wanted) <= 1e-8 * greatest


def test_pieces_are_within_what_they_promise_where_they_were_not_asked():
    random = np.random.default_rng(3)
    depth = np.concatenate((random.random(400), 10.0 ** random.uniform(-14.0, 0.0, 400), [0.0]))
    for name, lobe in LOBES.items():
        off = np.abs(lobe.pieces(depth) - total_at(lobe, depth)).max()
        assert off <= 1e-8 * lobe.greatest_tis()[0], name


@pytest.mark.parametrize("least", [5e-324, 1e-310, 1e-100])
def test_a_first_node_that_is_all_but_0_is_one_at_0(least):
    """A piece as narrow as that would have the inverse of a subnormal number in its row."""
    near, at_0 = (
        pz.TableScatter(delta=(first, 0.2, 0.4, 1.3), bsdf_per_sr=(0.05, 0.3, 0.02, 0.1))
        for first in (least, 0.0)
    )
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        pieces = near.pieces
    assert np.isfinite(2.0 / np.diff(pieces.edges)).all()
    assert np.array_equal(pieces.edges, at_0.pieces.edges)
    assert near.total(ANGLES) == pytest.approx(at_0.total(ANGLES), rel=1e-12)


def test_what_is_not_sent_on_scatters():
    """A beam on black paint: the share that escapes is TIS, for every ray alike."""
    for angle in (0.0, 33.0, 80.0):
        for name in ("abg", "gaussian", "harvey-shack, steep"):
            lobe = LOBES[name]
            lamp = {**beam((0.0, 0.0, 0.5), "-z", 1e-3), "tilt_deg": [angle, 0.0]}
            board = {**wall((0, 0, 0), "+z", 50.0), "surface": {"kind": "absorber"}}
            board["surface"]["scatter"] = lobe.to_table()
            found = trace(scene_of([lamp], [board]), rays_per_batch=256)
            share = float(found.escaped / found.emitted)
            assert share == pytest.approx(exactly(lobe, angle), rel=1e-8)
            assert found.escaped + found.absorbed("element 0") == found.emitted


def test_roughness_is_told_by_the_total():
    """4πσ/λ of 2 nm at 633 nm, as a mirror of R = 0.9 scatters it."""
    lobe = pz.HarveyShackScatter.from_roughness(2e-9, 633.0, L=0.02, S=-1.6, reflectance=0.9)
    assert lobe.total(0.0) == pytest.approx(0.9 * (4.0 * math.pi * 2.0 / 633.0) ** 2, rel=1e-8)
    with pytest.raises(ArgumentError, match="rms: found 1e-07"):
        pz.HarveyShackScatter.from_roughness(1e-7, 633.0, L=0.02, S=-1.6)


def test_functions_of_arrays_are_good_to_a_few_units_in_the_last_place():
    random = np.random.default_rng(2)
    x = 10.0 ** random.uniform(-12.0, 6.0, 400)
    for found, function, limit in (
        (exp_of(-np.log(1.0 + x)), lambda v: mpmath.exp(-math.log(1.0 + v)), 4.0),
        (log_of(x), lambda v: mpmath.log(v), 4.0),
        (power_of(x, 1.7), lambda v: mpmath.power(v, mpmath.mpf(1.7)), 200.0),
    ):
        with mpmath.workdps(40):
            off = [
                abs(mpmath.mpf(got) / function(mpmath.mpf(float(v))) - 1)
                for got, v in zip(found.tolist(), x, strict=True)
            ]
        assert max(off) < limit * 2.0**-53
    nodes, weights = gauss_nodes(12)
    assert sum(weights) == pytest.approx(2.0, rel=1e-15)
    for k in range(0, 24, 2):
        powers = sum(w * t**k for t, w in zip(nodes, weights, strict=True))
        assert powers == pytest.approx(2.0 / (k + 1), rel=1e-14)
