"""Edges of bins, each rounded once, the same on every machine.

The C library's sin and cos differ in the last place between machines; a bin's edge must not.
"""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction
from functools import cache
from typing import Final

__all__ = ["azimuth_edges", "even_edges"]

_CONTEXT: Final = Context(prec=50)
_PI: Final = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


@cache
def _cos_sin(numerator: int, denominator: int) -> tuple[float, float]:
    """Return cos and sin of 2π·numerator/denominator by exact quarter turns and Taylor series."""
    quarter, rest = divmod(4 * numerator, denominator)
    context = _CONTEXT
    x = context.divide(context.multiply(_PI, Decimal(rest)), Decimal(2 * denominator))
    square = context.multiply(x, x)
    cosine, sine = Decimal(0), Decimal(0)
    term, n = Decimal(1), 0
    while abs(term) > Decimal("1e-45"):
        cosine += term
        odd = context.divide(context.multiply(term, x), Decimal(n + 1))
        sine += odd
        n += 2
        term = -context.divide(context.multiply(term, square), Decimal(n * (n - 1)))
    c, s = float(cosine), float(sine)
    if rest == 0:
        c, s = 1.0, 0.0
    return ((c, s), (-s, c), (-c, -s), (s, -c))[quarter % 4]


def azimuth_edges(n: int) -> list[float]:
    """Return cosine and sine of k/n turns for k = 0 … n − 1, one after the other."""
    return [value + 0.0 for k in range(n) for value in _cos_sin(k, n)]


def even_edges(low: float, high: float, n: int) -> list[float]:
    """Return the n + 1 edges of equal bins from `low` to `high`."""
    start, width = Fraction(low), Fraction(high) - Fraction(low)
    return [float(start + width * k / n) for k in range(n + 1)]
