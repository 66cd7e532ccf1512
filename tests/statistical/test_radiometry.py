"""Analytic radiometry: every anchor of the presets, by z-tests against σ̂ or exact binomial laws.

Seeds are fixed and nothing is rerun. The false-alarm rate of each test is 1e-6 for its whole family
of bins (Šidák), except where 4 σ̂ is the contract's own criterion (6e-5 each).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles import chance, gates
from oracles.engine import PLAN, Traced, scene_of, trace
from oracles.scenes import BLACK, beam
from oracles.statistics import batch_mean, batch_values, sidak, z_limit
from scipy import stats

from photizon_cl.scene.files import load

pytestmark = pytest.mark.statistical

FAST = PLAN.with_(wave_rays=1 << 18)
ALPHA = chance.ALPHA


def binomial_bins(counts: np.ndarray, shares: np.ndarray, rays: int) -> None:
    """Assert that every bin's count is Binomial(rays, share): max |z| within the family's limit."""
    z = (counts - rays * shares) / np.sqrt(rays * shares * (1.0 - shares))
    assert np.abs(z).max() < z_limit(sidak(ALPHA, z.size))
    # and that together they are as scattered as they should be, neither more nor less
    low, high = stats.chi2.isf([1.0 - ALPHA / 2, ALPHA / 2], z.size)
    assert low < (z * z).sum() < high


def rectangle_integral(primitive, edges_x: np.ndarray, edges_y: np.ndarray) -> np.ndarray:
    """Return the integrals over bins from a primitive F with ∂²F/∂x∂y = f, shape (ny, nx)."""
    f = primitive(edges_x[np.newaxis, :], edges_y[:, np.newaxis])
    return f[1:, 1:] - f[1:, :-1] - f[:-1, 1:] + f[:-1, :-1]


def cosine_fourth(x: np.ndarray, y: np.ndarray, h: float = 1.0) -> np.ndarray:
    """Primitive of h²/(π (x² + y² + h²)²), the configuration factor of a parallel corner."""
    a, b = np.sqrt(x * x + h * h), np.sqrt(y * y + h * h)
    return (x / a * np.arctan(y / a) + y / b * np.arctan(x / b)) / (2.0 * np.pi)


def traced(name: str, rays: int, batches: int = 1, **run: float) -> Traced:
    """Trace a preset with many rays."""
    return trace(name, rays_per_batch=rays, batches=batches, plan=FAST, **run)


def test_cosine_fourth_law_in_every_bin() -> None:
    rays, batches = 1 << 18, 8
    found = traced("cosine-fourth", rays, batches)
    edges = np.linspace(-1.0, 1.0, 33)
    shares = rectangle_integral(cosine_fourth, edges, edges)
    assert shares.sum() == pytest.approx(2 * math.sqrt(2) / math.pi * math.atan(1 / math.sqrt(2)))
    counts = found.detector("target").map_counts
    binomial_bins(counts, shares, rays * batches)
    # the anchors, from the same numbers: centre 0.3183 W/m², corner a ninth of it
    area = (2.0 / 32) ** 2
    assert shares[16, 16] / area == pytest.approx(1 / math.pi, rel=0.006)
    assert shares[0, 0] / shares[16, 16] == pytest.approx(1 / 9, rel=0.1)  # bin means
    irradiance = counts / (rays * batches * area)
    centre = irradiance[15:17, 15:17].mean()
    corner = np.mean([irradiance[j, i] for j in (0, 31) for i in (0, 31)])
    error = math.sqrt(1 / (4 * shares[16, 16] * rays * batches))
    assert centre == pytest.approx(shares[16, 16] / area, rel=5 * error)
    assert corner == pytest.approx(shares[0, 0] / area, rel=15 * error)


def test_corner_of_the_target_is_a_ninth_of_its_centre() -> None:
    """Two small detectors, centred on the axis and on the corner, against their exact integrals."""
    rays, batches, half = 1 << 18, 16, 0.02
    lamp = {"kind": "cosine-point", "flux": 1.0, "position": [0, 0, 1], "axis": "-z"}
    place = {"kind": "rectangle", "axis": "+z", "half_width": half, "half_height": half, **BLACK}
    elements = [{**place, "position": [x, x, 0.0], "detector": {}} for x in (0.0, 1.0)]
    scene = scene_of([lamp], elements)
    found = trace(scene, rays_per_batch=rays, batches=batches, plan=FAST)
    area = (2 * half) ** 2
    for n, (x, point) in enumerate(((0.0, 1 / math.pi), (1.0, 1 / (9 * math.pi)))):
        edges = np.array([x - half, x + half])
        (share,) = rectangle_integral(cosine_fourth, edges, edges).ravel()
        assert share / area == pytest.approx(point, rel=1e-3)
        count = found.detector(f"element {n}").count
        total = rays * batches
        assert abs(count - share * total) < z_limit(ALPHA) * math.sqrt(share * total)


def test_lambertian_sphere_in_every_bin() -> None:
    """E = πL R² h/r³ over each bin; 0.1257 W/m² on the axis."""
    rays, batches = 1 << 18, 8
    found = traced("lambertian-sphere", rays, batches)
    flux, radius = 4 * math.pi**2 * 0.2**2, 0.2

    def primitive(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.pi * radius**2 / flux * np.arctan(x * y / np.sqrt(x * x + y * y + 1.0))

    edges = np.linspace(-1.0, 1.0, 34)
    shares = rectangle_integral(primitive, edges, edges)
    assert shares[16, 16] * flux / (2 / 33) ** 2 == pytest.approx(0.1257, abs=2e-4)
    binomial_bins(found.detector("target").map_counts, shares, rays * batches)


def test_integrating_sphere_absorbs_and_lets_out_what_theory_says() -> None:
    chance.integrating_sphere()


def test_port_of_the_integrating_sphere_shines_into_the_right_directions() -> None:
    """Only upwards, evenly in azimuth (χ² over the sums of the far field's columns)."""
    found = traced("integrating-sphere", 1 << 17)
    counts = found.far_field_counts
    assert counts[:20].sum() == 0
    columns = counts.sum(axis=0)
    expected = columns.sum() / 32
    statistic = ((columns - expected) ** 2 / expected).sum()
    assert statistic < stats.chi2.isf(ALPHA, 31)


def test_direct_light_in_the_box_room() -> None:
    """Entry 0 of the floor's ladder is the downlight alone, exact for each number of rays."""
    rays, batches = 1 << 17, 8
    found = traced("box-room", rays, batches)
    c = 1 / 1.9
    root = math.sqrt(1 + c * c)
    direct = 4 / math.pi * c / root * math.atan(c / root)
    count = found.detector("floor").ladder_counts[0]
    total = rays * batches
    assert found.detector("floor").ladder[0] == count  # of weight 1 each
    assert abs(count - direct * total) < z_limit(ALPHA) * math.sqrt(direct * (1 - direct) * total)
    assert found.escaped == 0
    assert float(found.depth_capped / found.emitted) < 1e-14
    # the first reflection can bring to the floor at most 0.6 of what the other walls received
    assert 0 < found.detector("floor").ladder[1] < 0.6 * (total - count)


def closed_sphere_ladder(rho: float, rays: int) -> Traced:
    """Trace a sphere with a black disk inside, by generations."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0}
    ball |= {"port_fraction": 0.2, "surface": {"kind": "lambertian", "reflectance": rho}}
    lid = {"kind": "disk", "position": [0, 0, 0.6], "axis": "-z", "radius": 0.8, **BLACK}
    lid["detector"] = {"generations": 8}
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.2, 0.1, -0.3]}
    return trace(scene_of([lamp], [ball, lid]), rays_per_batch=rays, plan=FAST)


def test_every_generation_of_a_sphere_closed_by_a_black_lid() -> None:
    """Of each scatter the share f = 0.2 goes to the lid, with weight ρ^g after g of them."""
    rays, rho, f = 1 << 19, 0.75, 0.2
    detector = closed_sphere_ladder(rho, rays).detector("element 1")
    counts = np.array(detector.ladder_counts, float)
    left = rays - counts[0]
    for g in range(1, 7):
        share = f
        assert detector.ladder[g] == pytest.approx(rho**g * counts[g], rel=1e-12)
        assert abs(counts[g] - left * share) < z_limit(sidak(ALPHA, 6)) * math.sqrt(
            left * share * (1 - share)
        )
        left -= counts[g]


def test_roulette_is_unbiased() -> None:
    chance.roulette_is_unbiased()


@pytest.mark.parametrize("floor", [0.05, 0.3, 1.0])
def test_roulette_moves_no_row_of_a_room(floor: float) -> None:
    """Every ledger row against a run without roulette: z of differences, another seed each."""
    rays, batches = 4096, 40
    played = traced("box-room", rays, batches, roulette_floor=floor, seed=11)
    plain = traced("box-room", rays, batches, seed=12)
    limit = z_limit(sidak(ALPHA, 6))
    for cell in range(6):
        (a, ea), (b, eb) = (batch_mean(t, lambda x, c=cell: x[c]) for t in (played, plain))
        assert abs(a - b) < limit * math.hypot(ea, eb)
    gates.closes(played)
    assert played.killed > 0
    assert played.interactions < plain.interactions


def test_shares_are_unbiased() -> None:
    gates.shares_are_unbiased()


def test_shares_move_effort_and_no_answer() -> None:
    """A room lit by two lamps, rays shared by flux and the other way round."""
    tables = load("box-room").to_dict()
    lamp = tables["source"][0]
    results = []
    for seed, shares in ((1, (0.9, 0.1)), (2, (0.1, 0.9))):
        sources = [
            {**lamp, "name": "down", "flux": 2.0, "share": shares[0]},
            {**lamp, "name": "up", "axis": "+z", "flux": 1.0, "share": shares[1]},
        ]
        scene = scene_of(sources, tables["element"])
        run = {"rays_per_batch": 4096, "generation_cap": 64, "seed": seed}
        found = trace(scene, batches=40, plan=FAST, **run)
        unit = found.compiled.unit_power
        results.append([batch_mean(found, lambda x, c=c: x[c] * unit) for c in range(6)])  # noqa: B023
    limit = z_limit(sidak(ALPHA, 6))
    for (a, ea), (b, eb) in zip(*results, strict=True):
        assert abs(a - b) < limit * math.hypot(ea, eb)


def test_standard_errors_are_calibrated() -> None:
    """z from batch means has the variance of Student's t: over 1024 bins of known truth.

    With 40 batches t has variance 39/37; the mean of z² over 1024 nearly independent bins scatters
    by about sqrt(2/1024)·1.1 = 5 %; 25 % is five of that (1e-6). The share within ±2σ̂ is 0.9477.
    """
    rays, batches = 1 << 15, 40
    found = traced("cosine-fourth", rays, batches)
    edges = np.linspace(-1.0, 1.0, 33)
    shares = rectangle_integral(cosine_fourth, edges, edges).ravel()
    cells = found.detector("target").cells
    sample = batch_values(found)[:, cells.map : cells.map + 1024] / rays
    z = (sample.mean(axis=0) - shares) / (sample.std(axis=0, ddof=1) / math.sqrt(batches))
    assert abs((z * z).mean() - 39 / 37) < 0.25
    within = 1.0 - 2.0 * stats.t.sf(2.0, 39)
    spread = math.sqrt(within * (1 - within) / 1024)
    assert abs((np.abs(z) < 2.0).mean() - within) < 4.9 * spread


def test_batches_are_independent() -> None:
    """Neighbouring batches are uncorrelated, and so are the same batches of two seeds."""
    rays, batches = 2048, 400
    one = batch_values(traced("integrating-sphere", rays, batches))
    two = batch_values(traced("integrating-sphere", rays, batches, seed=2))
    limit = z_limit(ALPHA / 2) / math.sqrt(batches)
    assert abs(np.corrcoef(one[:-1, 0], one[1:, 0])[0, 1]) < limit
    assert abs(np.corrcoef(one[:, 0], two[:, 0])[0, 1]) < limit


def test_error_falls_as_the_root_of_the_batches() -> None:
    """σ̂ of 256 batches is a quarter of that of 16 of them, within what σ̂ itself scatters."""
    sample = batch_values(traced("integrating-sphere", 2048, 256))[:, 0]
    small = np.array([sample[k : k + 16].std(ddof=1) / 4 for k in range(0, 256, 16)])
    whole = sample.std(ddof=1) / 16
    ratio = math.sqrt((small**2).mean()) / whole
    assert ratio == pytest.approx(4.0, rel=0.2)


def test_beam_irradiance_is_flux_over_area() -> None:
    """A tilted beam keeps Φ/πr² across itself: what a small target normal to it catches."""
    rays, tilt = 1 << 18, [30.0, 40.0]
    lamp = beam((0, 0, 0), "+z", 0.5, tilt_deg=tilt)
    # the centre of the target stands on the beam's axis, 2 m on
    a, b = (math.radians(t) for t in tilt)
    w = np.array([math.cos(a) * math.sin(b), -math.sin(a), math.cos(a) * math.cos(b)])
    target = {"kind": "disk", "position": (2.0 * w).tolist(), "axis": "+z", "radius": 0.2, **BLACK}
    found = trace(scene_of([lamp], [{**target, "tilt_deg": tilt}]), rays_per_batch=rays)
    share = 0.16
    count = float(found.absorbed("element 0"))
    assert abs(count - share * rays) < z_limit(ALPHA) * math.sqrt(share * (1 - share) * rays)
