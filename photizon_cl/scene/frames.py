"""Local frames: the six exact axis frames of the contract, and their tilts.

A frame is three unit rows (u, v, w) in world coordinates, right-handed, with w the axis. Untilted
frames are permutations of the world axes and hold only 0.0 and ±1.0. A tilt ``(a, b)`` in degrees
turns the frame by a about the untilted u, then by b about the untilted v, R = R_v(b)·R_u(a).

Sines and cosines of degrees are computed here in whole numbers and rounded once. The C
library's differ in the last place from machine to machine, and a frame is part of what the same
seed must reproduce bit for bit; whole quarter turns also come out exact.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import Final

Vec3 = tuple[float, float, float]
Frame = tuple[Vec3, Vec3, Vec3]

_X: Final = (1.0, 0.0, 0.0)
_Y: Final = (0.0, 1.0, 0.0)
_Z: Final = (0.0, 0.0, 1.0)
_MINUS_X: Final = (-1.0, 0.0, 0.0)
_MINUS_Y: Final = (0.0, -1.0, 0.0)
_MINUS_Z: Final = (0.0, 0.0, -1.0)

AXES: Final[tuple[str, ...]] = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Axis names in the order of `axis_index`."""

_FRAMES: Final[dict[str, Frame]] = {
    "+x": (_Y, _Z, _X),
    "-x": (_Z, _Y, _MINUS_X),
    "+y": (_Z, _X, _Y),
    "-y": (_X, _Z, _MINUS_Y),
    "+z": (_X, _Y, _Z),
    "-z": (_Y, _X, _MINUS_Z),
}

_PI_PLACES: Final = 256
_PI: Final = 0x3243F6A8885A308D313198A2E03707344A4093822299F31D0082EFA98EC4E6C89
"""π in units of 2^-256."""


def axis_index(axis: str) -> int:
    """Return 0 … 5 for ``+x -x +y -y +z -z``.

    Raises
    ------
    ValueError
        If `axis` is none of the six.
    """
    return AXES.index(axis)


@lru_cache(maxsize=4096)
def sincos_deg(angle: float) -> tuple[float, float]:
    """Return the sine and cosine of an angle in degrees, correctly rounded.

    Parameters
    ----------
    angle : float
        Degrees, finite. Reduced by whole quarter turns without rounding, so that multiples of
        90° give 0.0 and ±1.0 exactly.

    Returns
    -------
    tuple of float
        ``(sin, cos)``; never -0.0.
    """
    turned = math.fmod(angle, 360.0)  # exact
    quarter = round(turned / 90.0)
    above, below = (Fraction(turned) - 90 * quarter).as_integer_ratio()
    # 200 places behind the first digit of the angle, however small it is
    places = 200 + max(below.bit_length() - abs(above).bit_length(), 0)
    sine, cosine = _series(above * (_PI << places) // (180 * below << _PI_PLACES), places)
    for _ in range(quarter % 4):
        sine, cosine = cosine, -sine
    one = 1 << places
    return sine / one + 0.0, cosine / one + 0.0  # a quotient of whole numbers is rounded once


def _series(x: int, places: int) -> tuple[int, int]:
    """Sum the Taylor series of sine and cosine for |x| ≤ π/4, in units of 2^-places."""
    sums = [0, 1 << places]  # odd powers, even powers
    term, power = 1 << places, 0
    while term:
        power += 1
        # toward zero, so that the terms of a negative angle end as well
        size = abs(term * x) // (power << places)
        term = size if (term < 0) == (x < 0) else -size
        sums[1 - power % 2] += -term if (power // 2) % 2 else term
    return sums[0], sums[1]


@lru_cache(maxsize=4096)
def frame(axis: str, tilt_deg: tuple[float, float] = (0.0, 0.0)) -> Frame:
    """Return the rows (u, v, w) of a local frame in world coordinates.

    Parameters
    ----------
    axis : str
        One of ``+x -x +y -y +z -z``.
    tilt_deg : tuple of float
        ``(a, b)`` in degrees. With zero tilt, of either sign, the exact table is returned itself.

    Returns
    -------
    tuple of tuple of float
        Three unit rows, right-handed; no entry is -0.0.

    Raises
    ------
    ValueError
        If `axis` is none of the six.
    """
    if axis not in _FRAMES:
        raise ValueError(f"found axis {axis!r}, expected one of {' '.join(AXES)}")
    exact = _FRAMES[axis]
    a, b = tilt_deg
    if a == 0.0 and b == 0.0:
        return exact
    sa, ca = sincos_deg(a)
    sb, cb = sincos_deg(b)
    # Rows of R_v(b)·R_u(a) applied to u, v, w, in the untilted basis.
    return (
        _combine(exact, (cb, 0.0, -sb)),
        _combine(exact, (sa * sb, ca, sa * cb)),
        _combine(exact, (ca * sb, -sa, ca * cb)),
    )


def _combine(basis: Frame, local: Vec3) -> Vec3:
    # The basis is a signed permutation: every sum has one term that is not zero, so it is exact.
    # Adding 0.0 turns -0.0 into 0.0.
    x, y, z = (sum(local[i] * basis[i][k] for i in range(3)) + 0.0 for k in range(3))
    return (x, y, z)


def to_local(rows: Frame, offset: Vec3) -> Vec3:
    """Return the components of a world vector in a frame."""
    x, y, z = offset
    u, v, w = (row[0] * x + row[1] * y + row[2] * z for row in rows)
    return (u, v, w)


def direction_words(vector: Vec3) -> str:
    """Return a unit vector as people write it: an axis name where it is one, else its components.

    Components are rounded to three digits; one that is 0 to that many is written so.
    """
    for name in AXES:
        if vector == _FRAMES[name][2]:
            return name
    return "(" + ", ".join(f"{round(x, 3) + 0.0:g}" for x in vector) + ")"
