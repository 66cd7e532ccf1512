"""Frames: the contract's table exactly, tilts, and sines and cosines that are rounded once."""

import math
import random

import mpmath
import pytest

from photizon_cl.scene.frames import AXES, axis_index, frame, sincos_deg, to_local

TABLE = {
    "+x": ("+y", "+z"),
    "+y": ("+z", "+x"),
    "+z": ("+x", "+y"),
    "-x": ("+z", "+y"),
    "-y": ("+x", "+z"),
    "-z": ("+y", "+x"),
}


def unit(axis):
    return tuple((1.0 if axis[0] == "+" else -1.0) * (axis[1] == c) + 0.0 for c in "xyz")


def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def no_negative_zero(rows):
    return all(math.copysign(1.0, x) > 0 for row in rows for x in row if x == 0.0)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (-0.0, 0.0), (-0.0, -0.0), (0, 0)])
def test_table_of_the_contract(axis, tilt):
    rows = frame(axis, tilt)
    u, v = TABLE[axis]
    assert rows == (unit(u), unit(v), unit(axis))
    assert rows is frame(axis)
    assert no_negative_zero(rows)
    assert cross(rows[0], rows[1]) == rows[2]


def test_axis_index():
    assert [axis_index(axis) for axis in ("+x", "-x", "+y", "-y", "+z", "-z")] == list(range(6))
    with pytest.raises(ValueError, match="not in"):
        axis_index("x")
    with pytest.raises(ValueError, match="expected one of"):
        frame("z")


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("a", [-270, -180, -90, 0, 90, 180, 270, 360])
@pytest.mark.parametrize("b", [-180, -90, 0, 90, 180, 360])
def test_quarter_turns_are_exact(axis, a, b):
    rows = frame(axis, (float(a), float(b)))
    assert {abs(x) for row in rows for x in row} == {0.0, 1.0}
    assert no_negative_zero(rows)
    assert cross(rows[0], rows[1]) == rows[2]


def test_sense_of_the_turns():
    # A right-handed turn about u takes v to w and w to -v; about v, w to u and u to -w.
    assert frame("+z", (90.0, 0.0)) == ((1, 0, 0), (0, 0, 1), (0, -1, 0))
    assert frame("+z", (0.0, 90.0)) == ((0, 0, -1), (0, 1, 0), (1, 0, 0))
    # First about u, then about the untilted v: w → -v, which the second turn leaves.
    assert frame("+z", (90.0, 90.0)) == ((0, 0, -1), (1, 0, 0), (0, -1, 0))
    # A small tilt of a downlight: u = +y, v = +x, w = -z; about u by a, w leans towards -v = -x.
    w = frame("-z", (10.0, 0.0))[2]
    assert w == pytest.approx((-math.sin(math.radians(10)), 0.0, -math.cos(math.radians(10))))


def test_against_a_product_of_matrices():
    rng = random.Random(1)
    for _ in range(200):
        axis, a, b = rng.choice(AXES), rng.uniform(-360, 360), rng.uniform(-360, 360)
        u, v, _ = frame(axis)
        with mpmath.workdps(40):
            turned = [_turn(v, _turn(u, row, a), b) for row in frame(axis)]
            for row, exact in zip(frame(axis, (a, b)), turned, strict=True):
                for x, y in zip(row, exact, strict=True):
                    assert abs(x - y) <= 3e-16


def _turn(about, vector, degrees):
    """Rodrigues' formula."""
    angle = mpmath.mpf(degrees) * mpmath.pi / 180
    sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
    along = sum(p * q for p, q in zip(about, vector, strict=True))
    side = cross(about, vector)
    return [vector[i] * cosine + side[i] * sine + about[i] * along * (1 - cosine) for i in range(3)]


def test_sines_and_cosines_are_correctly_rounded():
    rng = random.Random(2)
    angles = [rng.uniform(-360, 360) for _ in range(300)]
    angles += [30.0, 45.0, 60.0, 1e-300, -1e-9, 89.99999999999999, 90.00000000000001, 5e-324]
    with mpmath.workdps(400):
        for angle in angles:
            exact = mpmath.mpf(angle) * mpmath.pi / 180
            assert sincos_deg(angle) == (float(mpmath.sin(exact)), float(mpmath.cos(exact)))


def test_sines_and_cosines_of_round_angles():
    assert sincos_deg(30.0)[0] == 0.5
    assert sincos_deg(-60.0)[1] == 0.5
    assert sincos_deg(1e6 * 360.0 + 90.0) == (1.0, 0.0)
    for angle in range(-720, 721, 90):
        assert math.copysign(1.0, min(map(abs, sincos_deg(angle)))) == 1.0


def test_sines_do_not_depend_on_the_callers_decimal_context():
    import decimal

    expected = sincos_deg(123.456)
    with decimal.localcontext(decimal.Context(prec=3)):
        assert sincos_deg(123.456) == expected


def test_to_local():
    assert to_local(frame("-x"), (1.0, 2.0, 3.0)) == (3.0, 2.0, -1.0)
