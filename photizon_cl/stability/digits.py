"""Arithmetic of 60 digits, loaded where it is wanted."""

from __future__ import annotations

import importlib
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import RunError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["DIGITS", "UNIT", "Vector", "add", "dot", "load_mpmath", "norm", "scaled", "vector"]

DIGITS: Final = 60
UNIT: Final = 2.0**-53
"""Unit roundoff of a double."""

Vector = list[Any]


@cache
def load_mpmath() -> Any:
    """Return the module mpmath.

    Raises
    ------
    RunError
        Where it is not installed.
    """
    try:
        return importlib.import_module("mpmath")
    except ImportError:
        raise RunError(
            "the stability report compares with 60-digit arithmetic and needs mpmath, which is not "
            "installed; install it with: pip install mpmath"
        ) from None


def vector(values: Iterable[float]) -> Vector:
    """Return doubles as many-digit numbers, exactly."""
    mpf = load_mpmath().mpf
    return [mpf(float(x)) for x in values]


def dot(a: Vector, b: Vector) -> Any:
    """Return a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Vector) -> Any:
    """Return |a|."""
    return load_mpmath().sqrt(dot(a, a))


def add(a: Vector, k: Any, b: Vector) -> Vector:
    """Return a + k b."""
    return [x + k * y for x, y in zip(a, b, strict=True)]


def scaled(k: Any, a: Vector) -> Vector:
    """Return k a."""
    return [k * x for x in a]
