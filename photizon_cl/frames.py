"""Local frames: the six exact axis frames of the contract, and their tilts.

A frame is three unit rows (u, v, w) in world coordinates, right-handed, with w the axis. Untilted
frames are permutations of the world axes and hold only 0.0 and ±1.0. A tilt ``(a, b)`` in degrees
turns the frame by a about the untilted u, then by b about the untilted v, R = R_v(b)·R_u(a).

Sines and cosines of degrees are computed here in decimal arithmetic and rounded once. The C
library's differ in the last place from machine to machine, and a frame is part of what the same
seed must reproduce bit for bit; whole quarter turns also come out exact.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal
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

_CONTEXT: Final = Context(prec=60)
_RADIANS_PER_DEGREE: Final = _CONTEXT.divide(
    Decimal("3.14159265358979323846264338327950288419716939937510582097494459"), Decimal(180)
)


def axis_index(axis: str) -> int:
    """Return 0 … 5 for ``+x -x +y -y +z -z``.

    Raises
    ------
    ValueError
        If `axis` is none of the six.
    """
    return AXES.index(axis)


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
    rest = _CONTEXT.subtract(Decimal(turned), Decimal(90 * quarter))
    sine, cosine = _series(_CONTEXT.multiply(rest, _RADIANS_PER_DEGREE))
    for _ in range(quarter % 4):
        sine, cosine = cosine, sine.copy_negate()
    return float(sine) + 0.0, float(cosine) + 0.0


def _series(x: Decimal) -> tuple[Decimal, Decimal]:
    """Sum the Taylor series of sine and cosine for |x| ≤ π/4 to 60 digits."""
    sums = [Decimal(0), Decimal(1)]  # odd powers, even powers
    term = Decimal(1)
    for power in range(1, 60):
        term = _CONTEXT.divide(_CONTEXT.multiply(term, x), Decimal(power))
        if not term:
            break
        odd = power % 2
        signed = term.copy_negate() if (power // 2) % 2 else term
        sums[1 - odd] = _CONTEXT.add(sums[1 - odd], signed)
    return sums[0], sums[1]


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
