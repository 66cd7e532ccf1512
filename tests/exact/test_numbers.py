"""Own elementary functions, bins and exact tallies against many digits and rationals."""

from __future__ import annotations

import random
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from oracles import numbers
from oracles.kernels import LIBRARIES, run_text

from hostcode.program.plan import LANE_WIDTHS
from hostcode.run.tally import canonical, exact, image, values
from photizon_cl.scene.edges import azimuth_edges

SINCOS = """
__kernel void test(__global const double *x, __global double *s, __global double *c) {
    const size_t i = get_global_id(0);
    real a, b;
    sincos_turns(LOAD(x, i), &a, &b);
    STORE(a, s, i); STORE(b, c, i);
}
"""

RENORMALISE = """
__kernel void test(__global const double *x, __global const double *y, __global const double *z,
                   __global double *out) {
    const size_t i = get_global_id(0);
    real a = LOAD(x, i), b = LOAD(y, i), c = LOAD(z, i);
    renormalise(&a, &b, &c);
    STORE(dot3(a, b, c, a, b, c), out, i);
}
"""

BINS = """
#define CELL 4
__kernel void test(__global const double *x, __global const double *y, __global const double *edges,
                   __global int *out, int n, int azimuth) {
    const size_t i = get_global_id(0);
    out[i] = azimuth ? azimuth_bin(edges, n, x[i], y[i]) : linear_bin(edges, n, x[i]);
}
"""

CELLS = """
#define CELL 4
__kernel void test(__global const double *w, __global long *cells, __global long *images, int n) {
    const size_t i = get_global_id(0);
    const image_t m = image_of(LOAD(w, i));
    STORE(m.p0, images, i); STORE(m.p1, images + n, i); STORE(m.p2, images + 2 * n, i);
    for (int l = 0; l < LANES; l++) add_exact(cells, w[i * LANES + l]);
}
"""


def device_sincos(x: np.ndarray, lanes: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return sines and cosines of turns from the device."""
    _, s, c = run_text(SINCOS, [x, np.zeros_like(x), np.zeros_like(x)], len(x), lanes=lanes)
    return s, c


def turns() -> np.ndarray:
    """Return turns near and far from every eighth, tiny ones, and random ones; a multiple of 16."""
    r = random.Random(1)
    x = [k / 16 for k in range(17)]
    for k in range(1, 16):
        x += [np.nextafter(k / 16, 0.0), np.nextafter(k / 16, 1.0)]
        x += [k / 16 + s * 2.0**-e for e in (8, 20, 30, 40, 50) for s in (-1, 1)]
    x += [2.0**-e for e in range(1, 54)] + [1.0 - 2.0**-e for e in range(1, 54)]
    x += [r.getrandbits(53) * 2.0**-53 for _ in range(2048 - len(x))]
    return np.array(x)


def test_sincos_is_good_to_one_unit_in_the_last_place() -> None:
    x = turns()
    s, c = device_sincos(x)
    worst = square = 0.0
    with mpmath.workdps(60):
        for k, turn in enumerate(x.tolist()):
            angle = 2 * mpmath.pi * mpmath.mpf(turn)
            # mpmath's reduction of whole quarter turns is not exact: these are tested below
            if (4 * turn) % 1:
                worst = max(worst, numbers.ulp_error(s[k], mpmath.sin(angle)))
                worst = max(worst, numbers.ulp_error(c[k], mpmath.cos(angle)))
            sum_of_squares = Fraction(s[k]) ** 2 + Fraction(c[k]) ** 2
            square = max(square, abs(float(sum_of_squares - 1)))
    assert worst < 1.0
    assert square < 2.0**-51


def test_quarter_turns_are_exact() -> None:
    s, c = device_sincos(np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    assert s.tolist() == [0.0, 1.0, 0.0, -1.0, 0.0]
    assert c.tolist() == [1.0, 0.0, -1.0, 0.0, 1.0]


@pytest.mark.parametrize("lanes", LANE_WIDTHS[1:])
def test_sincos_has_the_same_bits_at_every_width(lanes: int) -> None:
    x = turns()
    for narrow, wide in zip(device_sincos(x), device_sincos(x, lanes), strict=True):
        assert narrow.tobytes() == wide.tobytes()


def test_renormalisation_squares_the_error() -> None:
    r = np.random.default_rng(2)
    d = r.normal(size=(3, 1024))
    d /= np.sqrt((d * d).sum(axis=0))
    for stretch in (1.0, 1.0 + 1e-9, 1.0 - 3e-9):
        squares = run_text(RENORMALISE, [*(d * stretch), np.zeros(1024)], 1024)[3]
        assert np.abs(squares - 1.0).max() < 2.0**-50


def device_bins(x: list[float], y: list[float], edges: list[float], n: int, azimuth: bool) -> list:
    """Return bins from the device."""
    arrays = [np.array(x), np.array(y), np.array(edges), np.zeros(len(x), np.int32)]
    body = BINS.replace("#define CELL 4\n", "")
    libraries = (*LIBRARIES, "lib/bins")
    arguments = [*arrays, np.int32(n), np.int32(azimuth)]
    return run_text(body, arguments, len(x), libraries=libraries)[3].tolist()


RANGES = [(-1, 1, 40), (-1, 1, 7), (-0.1, 0.1, 33), (-3e-7, 3e-7, 5)]


@pytest.mark.parametrize(("low", "high", "n"), RANGES)
def test_linear_bins_are_half_open_between_rounded_edges(low: float, high: float, n: int) -> None:
    exact_edges = [Fraction(low) + (Fraction(high) - Fraction(low)) * k / n for k in range(n + 1)]
    edges = [float(e) for e in exact_edges]
    x = [f for e in edges for f in (np.nextafter(e, -np.inf), e, np.nextafter(e, np.inf))]
    r = random.Random(3)
    x += [r.uniform(1.01 * low, 1.01 * high) for _ in range(500)] + [0.0, -0.0, 5 * low, 5 * high]
    want = [min(max(sum(e <= v for e in edges) - 1, 0), n - 1) for v in x]
    assert device_bins(x, x, edges, n, azimuth=False) == want


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 12, 32, 33, 360])
def test_azimuth_bins_against_sixty_digits(n: int) -> None:
    """Every direction that is not within rounding of an edge; axis directions and signed zeros."""
    edges, r = azimuth_edges(n), random.Random(4)
    points = [(r.gauss(0, 1), r.gauss(0, 1)) for _ in range(400)]
    with mpmath.workdps(60):
        for k in range(n):
            angle = 2 * mpmath.pi * k / n
            for off in (-1e-9, -1e-13, 1e-13, 1e-9):
                points.append((float(mpmath.cos(angle + off)), float(mpmath.sin(angle + off))))
        want = [int((mpmath.atan2(y, x) / (2 * mpmath.pi) % 1) * n) for x, y in points]
    axes = [(1.0, 0.0), (1.0, -0.0), (0.0, 1.0), (-0.0, 1.0), (-1.0, 0.0), (-1.0, -0.0)]
    axes += [(0.0, -1.0), (-0.0, -1.0), (0.0, 0.0), (1e-300, 0.0), (-1e-300, 0.0)]
    quarters = [0, 0, 1, 1, 2, 2, 3, 3, 0, 0, 2]
    points += axes
    want += [quarter * n // 4 for quarter in quarters]
    x, y = map(list, zip(*points, strict=True))
    assert device_bins(x, y, edges, n, azimuth=True) == want


@pytest.mark.parametrize("n", [3, 5, 8, 12, 32])
def test_an_azimuth_on_an_edge_belongs_to_the_bin_above(n: int) -> None:
    edges = azimuth_edges(n)
    x, y = edges[0::2], edges[1::2]
    assert device_bins(x, y, edges, n, azimuth=True) == list(range(n))


def test_azimuth_edges_are_correctly_rounded() -> None:
    for n in (7, 12, 32, 100):
        edges = azimuth_edges(n)
        with mpmath.workdps(60):
            for k in range(n):
                if 4 * k % n:
                    assert edges[2 * k] == float(mpmath.cos(2 * mpmath.pi * k / n))
                    assert edges[2 * k + 1] == float(mpmath.sin(2 * mpmath.pi * k / n))


def device_cell(weights: list[float], lanes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum's cell and the images of weights."""
    n = len(weights)
    libraries = (*LIBRARIES, "lib/cells")
    arguments = [np.array(weights), np.zeros(4, np.int64), np.zeros((3, n), np.int64), np.int32(n)]
    _, cell, images = run_text(CELLS, arguments, n, lanes=lanes, libraries=libraries)
    return cell, images


@pytest.mark.parametrize("lanes", LANE_WIDTHS)
def test_sums_of_weights_are_exact(lanes: int) -> None:
    r = random.Random(5)
    weights = [1.0, 2.0, 4.0, 2.0**-42, 3 * 2.0**-43, 0.1, 1.0 - 2.0**-53, 1.0 + 2.0**-52]
    weights += [0.0, 5e-324, 2.0**-1022, 2.0**-96, 2.0**-95, 2.0**-97, 1 / 3, 0.9**50, 2.0**-31]
    weights += [2.0**-32, 2.0**-63, 2.0**-64, 0.5 + 2.0**-32, 4.0 - 2.0**-51, 3 * 2.0**-33]
    weights += [r.random() * 2.0 ** -r.randrange(0, 110) for _ in range(512 - len(weights))]
    cell, images = device_cell(weights, lanes)
    found = [(int(a) << 64) + (int(b) << 32) + int(c) for a, b, c in images.T]
    assert found == [image(w) for w in weights]
    for got, weight in zip(found, weights, strict=True):
        off = abs(got - Fraction(weight) / numbers.UNIT)
        assert off <= Fraction(1, 2)
        if weight >= 2.0**-42:
            assert off == 0
    assert cell[3] == len(weights)
    one = canonical(cell.reshape(1, 4))
    assert exact(one) == [sum(found)]
    assert values(one)[0] == pytest.approx(float(sum(found) * numbers.UNIT), rel=2.0**-52)


def test_canonical_form_is_unique() -> None:
    r = random.Random(6)
    for _ in range(200):
        limbs = [r.randrange(-(2**61), 2**61) for _ in range(3)]
        shifted = [limbs[0] - 3, limbs[1] + (3 << 32) - 5, limbs[2] + (5 << 32)]
        a, b = (canonical(np.array([[*row, 9]], np.int64)) for row in (limbs, shifted))
        assert a.tobytes() == b.tobytes()
        assert exact(a) == [(limbs[0] << 64) + (limbs[1] << 32) + limbs[2]]
        assert 0 <= a[0, 1] < 2**32
        assert 0 <= a[0, 2] < 2**32
