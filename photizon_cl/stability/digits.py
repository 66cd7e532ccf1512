"""Arithmetic of 60 digits, loaded where it is wanted."""

from __future__ import annotations

import importlib
import math
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import RunError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["DIGITS", "UNIT", "Vector", "add", "dot", "load_digits", "norm", "scaled", "vector"]

DIGITS: Final = 60
UNIT: Final = 2.0**-53
"""Unit roundoff of a double."""

Vector = list[Any]


class _Mpfr:
    """The part of mpmath that is made use of, by gmpy2's MPFR: ten times as fast."""

    def __init__(self, gmpy2: Any) -> None:
        self._gmpy2 = gmpy2
        self.mpf = gmpy2.mpfr
        self.sqrt, self.sin, self.cos, self.asin = gmpy2.sqrt, gmpy2.sin, gmpy2.cos, gmpy2.asin
        self.inf = gmpy2.inf()

    @property
    def pi(self) -> Any:
        return self._gmpy2.const_pi()

    def workdps(self, digits: int) -> Any:
        """Return a context in which numbers have so many digits, as mpmath counts them."""
        bits = round((digits + 1) * math.log2(10.0))
        # as with mpmath: roots of negative numbers are complex, and what is no number is an error
        return self._gmpy2.context(
            self._gmpy2.get_context(),
            precision=bits,
            allow_complex=True,
            trap_invalid=True,
            trap_divzero=True,
        )


@cache
def load_digits() -> Any:
    """Return what computes with many digits: gmpy2 where it is installed, else mpmath.

    Raises
    ------
    RunError
        Where neither is installed.
    """
    with suppress(ImportError):
        return _Mpfr(importlib.import_module("gmpy2"))
    try:
        return importlib.import_module("mpmath")
    except ImportError:
        raise RunError(
            "the stability report compares with 60-digit arithmetic and needs mpmath, which is not "
            "installed; install it with: pip install mpmath"
        ) from None


def vector(values: Iterable[float]) -> Vector:
    """Return doubles as many-digit numbers, exactly."""
    mpf = load_digits().mpf
    return [mpf(float(x)) for x in values]


def dot(a: Vector, b: Vector) -> Any:
    """Return a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Vector) -> Any:
    """Return |a|."""
    return load_digits().sqrt(dot(a, a))


def add(a: Vector, k: Any, b: Vector) -> Vector:
    """Return a + k b."""
    return [x + k * y for x, y in zip(a, b, strict=True)]


def scaled(k: Any, a: Vector) -> Vector:
    """Return k a."""
    return [k * x for x in a]
