"""Logarithm, exponential and power against 60 digits, at their ends, and at every lane width."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from oracles.kernels import LIBRARIES, run_text

BODY = """
__kernel void test(__global const double *x, __global const double *y,
                   __global double *l, __global double *e, __global double *p) {
    const size_t i = get_global_id(0);
    const real a = LOAD(x, i), b = LOAD(y, i);
    STORE(natural_log(a), l, i);
    STORE(exponential(b), e, i);
    STORE(power(a, b), p, i);
}
"""


def device(x, y, lanes=1):
    """Return log x, exp y and x^y of the device."""
    out = [np.zeros(len(x)) for _ in range(3)]
    libraries = (*LIBRARIES, "lib/powers")
    return run_text(BODY, [x, y, *out], len(x), lanes=lanes, libraries=libraries)[2:]


def hard_arguments(n=1 << 13):
    """Random numbers of every size, near 1, and exponents up to the ends of the range."""
    r = np.random.default_rng(1)
    x = np.exp(r.uniform(-744.0, 709.0, n))
    x[: n // 2] = r.random(n // 2)
    x[: n // 8] = np.abs(1.0 + r.normal(size=n // 8) * 10.0 ** r.uniform(-16.0, -1.0, n // 8))
    log = np.log(x)
    y = r.uniform(-744.0, 709.0, n) / np.where(log == 0.0, 1.0, log)
    y[: n // 4] = r.uniform(-700.0, 700.0, n // 4)
    y[-n // 8 :] = r.normal(size=n // 8) * 10.0 ** r.uniform(-20.0, 2.0, n // 8)
    return x, y


def worst_ulps(found, exact):
    """Return the largest error in ulps of results that do not overflow or vanish.

    One ulp more is allowed to subnormal ones, which are rounded twice.
    """
    worst, used = 0.0, 0
    for got, want in zip(found.tolist(), exact, strict=True):
        if not mpmath.mpf(2) ** -1074 <= abs(want) < mpmath.mpf(2) ** 1024:
            continue
        used += 1
        if abs(want) < mpmath.mpf(2) ** -1022:
            assert abs(got - want) < mpmath.mpf(2) ** -1073
            continue
        worst = max(worst, float(abs(got - want) / math.ulp(float(want))))
    assert used > len(found) // 2
    return worst


def test_errors_are_below_the_stated_bounds():
    x, y = hard_arguments()
    log, exponential, power = device(x, y)
    with mpmath.workdps(60):
        pairs = [
            (mpmath.mpf(a), mpmath.mpf(b)) for a, b in zip(x.tolist(), y.tolist(), strict=True)
        ]
        assert worst_ulps(log, [mpmath.log(a) for a, _ in pairs]) < 0.51
        bounded = [mpmath.exp(b) if abs(b) < 800 else mpmath.mpf(0) for _, b in pairs]
        assert worst_ulps(exponential, bounded) < 0.6
        assert worst_ulps(power, [a**b for a, b in pairs]) < 1.0


@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
def test_the_bits_are_the_same_at_every_width(lanes):
    x, y = hard_arguments()
    for narrow, wide in zip(device(x, y), device(x, y, lanes), strict=True):
        assert narrow.tobytes() == wide.tobytes()


def test_what_is_no_number_stays_none():
    nan, inf = math.nan, math.inf
    x = np.array([-1.0, -1e-17, -inf, nan, nan, 2.0, 0.0, 0.5])
    y = np.array([0.5, 2.0, 3.0, 0.0, 2.0, nan, nan, inf])
    log, exponential, power = device(x, y)
    assert np.isnan(log[:5]).all()
    assert np.isnan(power).all()
    assert np.isnan(exponential[5:7]).all()


def test_ends_and_exact_results():
    inf, least = math.inf, 5e-324
    x = np.array([0.0, 0.0, 0.0, inf, inf, inf, 1.0, least])
    y = np.array([0.0, 2.0, -1.0, 0.0, 2.0, -3.0, 3e300, 1.0])
    log, _, power = device(x, y)
    assert log.tolist() == [-inf] * 3 + [inf] * 3 + [0.0, math.log(least)]
    assert power.tolist() == [1.0, 0.0, inf, 1.0, inf, 0.0, 1.0, least]
    y = np.array([0.0, -0.0, 709.0, 710.0, -744.0, -746.0, inf, -inf])
    assert device(np.ones(8), y)[1].tolist() == [
        1.0, 1.0, math.exp(709.0), inf, math.exp(-744.0), 0.0, inf, 0.0,
    ]  # fmt: skip
    assert device(np.full(8, 4.0), np.full(8, 0.5))[2].tolist() == [2.0] * 8
