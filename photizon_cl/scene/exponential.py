"""The kernels' exponential on the host: the same operations in the same order, so the same bits.

``twofold_exp`` of ``kernels/lib/powers.mako`` says how it works. Mathematics libraries differ in
the last place between machines, and what goes into a result must not.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Final

__all__ = ["exponential", "fused"]

_FARTHEST: Final = 1000.0
_TO_INTEGER: Final = float.fromhex("0x1.8p52")
_ONE_BY_LOG_TWO: Final = float.fromhex("0x1.71547652b82fep+0")
_LOG_TWO_HI: Final = float.fromhex("0x1.62e42fefa38p-1")
_LOG_TWO_LO: Final = float.fromhex("0x1.ef35793c7673p-45")
_TAYLOR: Final = tuple(1 / math.factorial(k) for k in range(14, 1, -1))


def fused(a: float, b: float, c: float) -> float:
    """Return a·b + c of finite numbers, rounded once."""
    return float(Fraction(a) * Fraction(b) + Fraction(c))


def exponential(x: float, rest: float = 0.0) -> float:
    """Return exp(x + rest), with an error below 0.6 ulp; below 1 ulp where it is subnormal.

    Parameters
    ----------
    x : float
        Any number; from −746 down the result is 0, from 710 up infinite.
    rest : float, optional
        What `x` was rounded by, at most half an ulp of it.
    """
    if math.isnan(x):
        return x
    y, below = x, rest
    if abs(x) > _FARTHEST:
        y, below = math.copysign(_FARTHEST, x), 0.0
    shifted = fused(y, _ONE_BY_LOG_TWO, _TO_INTEGER)
    n = shifted - _TO_INTEGER
    near, off = fused(-n, _LOG_TWO_HI, y), fused(-n, _LOG_TWO_LO, below)
    r = near + off
    r_lo = (near - r) + off
    series = _TAYLOR[0]
    for c in _TAYLOR[1:]:
        series = fused(series, r, c)
    one = r + 1.0
    one_lo = (1.0 - one) + r
    e = one + (one_lo + fused(r * r, series, fused(r_lo, r, r_lo)))
    k = int(n)
    low = k >> 1
    return e * math.ldexp(1.0, low) * math.ldexp(1.0, k - low)
