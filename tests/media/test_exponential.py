"""The exponential of the kernels: below 1 ulp of the exact one, and the host's to the last bit."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from oracles.engine import open_device
from oracles.kernels import LIBRARIES, run_text

from photizon_cl.scene.exponential import exponential, fused
from photizon_cl.scene.media.medium import Medium

BODY = """
__kernel void test(__global const double *x, __global const double *rest, __global double *e) {
    const size_t i = get_global_id(0);
    STORE(twofold_exp(LOAD(x, i), LOAD(rest, i)), e, i);
}
"""
ENDS = (
    0.0, -0.0, 5e-324, -5e-324, 1e-300, -1e-300, 1e-17, -1e-17, 1.0, -1.0, -700.0, -708.3, -708.4,
    -709.0, -710.0, -744.4, -745.0, -745.13, -745.14, -746.0, -750.0, -999.9, -1000.0, -1000.1,
    -1e4, -1e300, 700.0, 709.0, 709.78, -math.inf,
)  # fmt: skip


def arguments() -> tuple[np.ndarray, np.ndarray]:
    """Return what the exponential is asked, over all its range, and what that was rounded by."""
    r = np.random.default_rng(7)
    x = np.concatenate([
        ENDS, -r.uniform(0.0, 1.0, 512), -r.uniform(0.0, 40.0, 512), -r.uniform(700.0, 746.0, 512),
        -(10.0 ** r.uniform(-320.0, 3.0, 256)), r.uniform(0.0, 709.0, 128),
    ])  # fmt: skip
    x = np.concatenate([x, np.zeros(-len(x) % 16)])
    rest = r.uniform(-0.5, 0.5, len(x)) * np.spacing(np.where(np.isfinite(x), np.abs(x), 0.0))
    return x, rest


def device(lanes: int = 1, origin: str = "") -> np.ndarray:
    x, rest = arguments()
    found = run_text(
        BODY, [x, rest, np.zeros(len(x))], len(x), lanes=lanes,
        libraries=(*LIBRARIES, "lib/powers"), device=open_device(origin),
    )  # fmt: skip
    return found[2]


def test_it_is_within_an_ulp_down_to_the_last_subnormal():
    found = device()
    x, rest = arguments()
    with mpmath.workdps(60):
        worst, least = mpmath.mpf(0), 0
        for got, a, b in zip(found.tolist(), x.tolist(), rest.tolist(), strict=True):
            exact = mpmath.exp(mpmath.mpf(a) + mpmath.mpf(b)) if a > -1100.0 else mpmath.mpf(0)
            ulp = math.ulp(min(max(float(exact), 0.0), 1.7e308))  # of a subnormal one 2^-1074
            worst = max(worst, abs(mpmath.mpf(got) - exact) / ulp)
            least += 0.0 < got < 2.0**-1022
        assert worst < 1.0
        assert least > 100  # subnormal results were among them


def test_its_ends():
    x, _ = arguments()
    found = dict(zip(x.tolist(), device().tolist(), strict=True))
    assert found[0.0] == found[5e-324] == found[-1e-300] == 1.0
    assert found[-746.0] == found[-1e300] == found[-math.inf] == 0.0
    assert found[-745.13] == 5e-324


@pytest.mark.parametrize(("origin", "lanes"), [
    ("", 1), ("", 8), ("debian", 4), ("pypi", 4), ("intel", 4),
])  # fmt: skip
def test_the_host_has_the_same_bits(origin, lanes):
    found = device(lanes, origin)
    x, rest = arguments()
    host = [exponential(a, b) for a, b in zip(x.tolist(), rest.tolist(), strict=True)]
    assert np.array(host).tobytes() == found.tobytes()


def test_a_product_and_sum_are_rounded_once():
    a = 1.0 + 2.0**-30
    assert fused(a, a, -1.0) == 2.0**-29 + 2.0**-60
    assert a * a - 1.0 == 2.0**-29


@pytest.mark.parametrize(("alpha", "length"), [(0.3, 0.7), (1e-9, 1e-9), (51.7, 14.1), (3e5, 2.0)])
def test_the_transmittance_is_that_of_the_exact_product(alpha, length):
    found = Medium("glass", 1.5, alpha).transmittance(length)
    with mpmath.workdps(60):
        exact = mpmath.exp(-mpmath.mpf(alpha) * mpmath.mpf(length))
        assert abs(found - exact) < max(math.ulp(found), 5e-324)


def test_the_transmittance_at_its_ends():
    assert Medium("air", 1.0).transmittance(math.inf) == 1.0
    assert Medium("fog", 1.0, 1.0).transmittance(math.inf) == 0.0
    assert Medium("fog", 1.0, 1.0).transmittance(0.0) == 1.0
