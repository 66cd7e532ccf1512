"""Exponential, logarithm and power of arrays, from operations that IEEE 754 fixes.

What the host tabulates goes into results, so that it must be the same bits on every machine.
Mathematics libraries differ in the last place; sums, products, quotients and roots of arrays do
not, as long as no array operation adds up elements. All here are good to a few units in the last
place.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["exp_of", "gauss_nodes", "log_of", "polynomial", "power_of"]

_LOG_TWO_HI: Final = float.fromhex("0x1.62e42fefa38p-1")
_LOG_TWO_LO: Final = float.fromhex("0x1.ef35793c7673p-45")
_ONE_BY_LOG_TWO: Final = float.fromhex("0x1.71547652b82fep+0")
_ROOT_HALF: Final = float.fromhex("0x1.6a09e667f3bcdp-1")
_TAYLOR: Final = tuple(1.0 / math.factorial(k) for k in range(14))
_TAIL: Final = tuple(2.0 / (2 * k + 1) for k in range(12))
_FARTHEST: Final = 700.0


def polynomial(
    coefficients: Sequence[NDArray[np.float64] | float], x: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the sum of c[k] x^k by Horner's rule."""
    total = coefficients[-1] + np.zeros_like(x)
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def exp_of(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return exp(x), with x taken to lie in [−700, 700]."""
    y = np.clip(x, -_FARTHEST, _FARTHEST)
    n = np.rint(y * _ONE_BY_LOG_TWO)
    r = (y - n * _LOG_TWO_HI) - n * _LOG_TWO_LO
    return np.ldexp(polynomial(_TAYLOR, r), n.astype(np.int64))


def log_of(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the natural logarithm of positive normal numbers."""
    m, k = np.frexp(x)
    low = m < _ROOT_HALF
    m = np.where(low, 2.0 * m, m)
    n = k.astype(np.float64) - low
    s = (m - 1.0) / (m + 1.0)
    return n * _LOG_TWO_HI + (s * polynomial(_TAIL, s * s) + n * _LOG_TWO_LO)


def power_of(x: NDArray[np.float64], y: float) -> NDArray[np.float64]:
    """Return x^y of positive normal numbers; the relative error grows with |y log x|."""
    return exp_of(y * log_of(x))


def gauss_nodes(n: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return nodes and weights of the Gauss–Legendre rule of n points on [−1, 1].

    Newton's iteration on Legendre's recurrence from rational first guesses: M. Abramowitz and I. A.
    Stegun, Handbook of Mathematical Functions, 22.7.10 and 25.4.29.
    """
    nodes, weights = [], []
    for k in range(n):
        x = _root(n, k)
        value, slope = _legendre(n, x)
        for _ in range(4):
            x -= value / slope
            value, slope = _legendre(n, x)
        nodes.append(x)
        weights.append(2.0 / ((1.0 - x * x) * slope * slope))
    return tuple(nodes), tuple(weights)


def _legendre(n: int, x: float) -> tuple[float, float]:
    before, value = 1.0, x
    for k in range(2, n + 1):
        before, value = value, ((2 * k - 1) * x * value - (k - 1) * before) / k
    return value, n * (x * value - before) / (x * x - 1.0)


def _root(n: int, number: int, steps: int = 1024) -> float:
    """Return the middle of the step of [−1, 1] in which the polynomial changes its sign."""
    seen = -1
    left = _legendre(n, -1.0 + 1.0 / (2 * steps))[0]
    for k in range(steps):
        x = -1.0 + (2 * k + 1) / steps
        right = _legendre(n, x)[0] if abs(x) < 1.0 else left
        if left * right < 0.0:
            seen += 1
            if seen == number:
                return x - 1.0 / steps
        left = right
    raise ValueError(f"no root {number} of the Legendre polynomial of degree {n}")
