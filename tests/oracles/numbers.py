"""Exact and many-digit references for numbers."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import mpmath

if TYPE_CHECKING:
    from collections.abc import Iterable

UNIT = Fraction(1, 2**95)
"""Unit of an exact tally's last limb, in launched weights."""


def fma(a: float, b: float, c: float) -> float:
    """Return a·b + c rounded once."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    return exact.numerator / exact.denominator  # Python rounds this quotient correctly


def image(weight: float) -> int:
    """Return a weight in units of 2^-95, rounded to nearest (ties cannot matter below 2^-42)."""
    return round(Fraction(weight) / UNIT)


def total(weights: Iterable[float]) -> int:
    """Return the exact sum of weights' images."""
    return sum(map(image, weights))


def ulp_error(value: float, truth: mpmath.mpf) -> float:
    """Return |value − truth| in units in the last place of the truth."""
    if truth == 0:
        return 0.0 if value == 0.0 else math.inf
    unit = mpmath.mpf(math.ulp(float(truth)))
    return float(abs(mpmath.mpf(value) - truth) / unit)


def mp_vector(values: Iterable[float]) -> list[mpmath.mpf]:
    """Return doubles as many-digit numbers, exactly."""
    return [mpmath.mpf(float(v)) for v in values]


def mp_dot(a: Iterable[mpmath.mpf], b: Iterable[mpmath.mpf]) -> mpmath.mpf:
    """Return the scalar product."""
    return mpmath.fsum(x * y for x, y in zip(a, b, strict=True))
