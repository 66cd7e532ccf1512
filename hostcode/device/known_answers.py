"""Operands for the self-test of a device, and what IEEE 754 says must come out.

The answers are computed with exact rationals, in Python, so that neither this machine's floating
point nor any library stands between the standard and the device.
"""

from __future__ import annotations

import math
import struct
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

__all__ = [
    "PHILOX_VECTORS",
    "SINCOS",
    "arithmetic_answers",
    "arithmetic_operands",
    "exact_cell",
    "integer_answers",
    "integer_operands",
    "limb_weights",
    "philox4x32_10",
    "random_words",
    "round_exactly",
]

PHILOX_VECTORS: Final = (
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    (
        (0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF),
        (0xFFFFFFFF, 0xFFFFFFFF),
        (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD),
    ),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
)
"""Counter, key and output of Philox4x32-10, from Random123's published ``kat_vectors``."""


def philox4x32_10(counter: tuple[int, ...], key: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return one block of Philox4x32-10, written from the paper, apart from the kernels.

    Parameters
    ----------
    counter : tuple of int
        Four 32-bit words.
    key : tuple of int
        Two 32-bit words.

    Returns
    -------
    tuple of int
        Four 32-bit words.
    """
    c0, c1, c2, c3 = counter
    k0, k1 = key
    for _ in range(10):
        p0, p1 = 0xD2511F53 * c0, 0xCD9E8D57 * c2
        c0, c1, c2, c3 = (
            (p1 >> 32) ^ c1 ^ k0,
            p1 & 0xFFFFFFFF,
            (p0 >> 32) ^ c3 ^ k1,
            p0 & 0xFFFFFFFF,
        )
        k0, k1 = (k0 + 0x9E3779B9) & 0xFFFFFFFF, (k1 + 0xBB67AE85) & 0xFFFFFFFF
    return c0, c1, c2, c3


def random_words(n: int, stream: int) -> NDArray[np.uint64]:
    """Return n 64-bit words that are the same for ever (SplitMix64), shape (n,)."""
    steps = np.arange(1, n + 1, dtype=np.uint64) + np.uint64(stream << 32)
    z = steps * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: NDArray[np.uint64] = z ^ (z >> np.uint64(31))
    return mixed


def round_exactly(value: Fraction) -> float:
    """Round a rational that is not zero to the nearest double, ties to even; overflow to infinity.

    An underflow keeps the sign.
    """
    try:
        # Division of Python's integers is correctly rounded, subnormals included.
        rounded = value.numerator / value.denominator
    except OverflowError:
        rounded = math.inf
    return math.copysign(rounded, 1.0 if value > 0 else -1.0)


def _sum(x: Fraction, y: Fraction, both_negative: bool) -> float:
    if x + y == 0:
        # An exact cancellation gives +0; two zeros give -0 only where both are negative.
        return -0.0 if x == 0 and both_negative else 0.0
    return round_exactly(x + y)


def _negative(x: float) -> bool:
    return math.copysign(1.0, x) < 0


def _add(a: float, b: float) -> float:
    if not (math.isfinite(a) and math.isfinite(b)):
        return a + b
    return _sum(Fraction(a), Fraction(b), _negative(a) and _negative(b))


def _multiply(a: float, b: float) -> float:
    if a == 0 or b == 0:
        return -0.0 if _negative(a) != _negative(b) else 0.0
    return round_exactly(Fraction(a) * Fraction(b))


def _divide(a: float, b: float) -> float:
    negative = _negative(a) != _negative(b)
    if a == 0 and b == 0:
        return math.nan
    if b == 0:
        return -math.inf if negative else math.inf
    if a == 0:
        return -0.0 if negative else 0.0
    return round_exactly(Fraction(a) / Fraction(b))


def _fma(a: float, b: float, c: float) -> float:
    product_negative = _negative(a) != _negative(b)
    product = Fraction(a) * Fraction(b)
    return _sum(product, Fraction(c), product_negative and _negative(c))


def _square_root(a: float) -> float:
    if a == 0:
        return a
    # Scaled so that the integer root has more than 53 bits; the last bit says "and some more".
    scale = 4**600
    scaled = Fraction(a) * scale * scale
    whole = scaled.numerator // scaled.denominator
    root = math.isqrt(whole)
    sticky = int(root * root != scaled)
    return round_exactly(Fraction(2 * root + sticky, 2 * scale))


@cache
def arithmetic_operands(n: int) -> NDArray[np.float64]:
    """Return operands a, b, c, all finite: cases known to go wrong first, then random bits.

    Returns
    -------
    ndarray of float64, shape (3, n)
        Read only.
    """
    tiny, least, most = 2.0**-1022, 2.0**-1074, math.ldexp(2 - 2**-52, 1023)
    above, below = 1 + 2.0**-52, 1 - 2.0**-53
    hard = [
        # fused and unfused differ: 1 - 2^-60 - 1, and the residual of a product
        (1 + 2.0**-30, 1 - 2.0**-30, -1.0),
        (above, above, -(1 + 2.0**-51)),
        (0.1, 10.0, -1.0),
        (1 / 3, 3.0, -1.0),
        # halfway cases of sums, products and quotients, both parities
        (1.0, 2.0**-53, 2.0**-106),
        (above, 2.0**-53, -(2.0**-53)),
        (1.0, 3 * 2.0**-53, 2.0**-54),
        (2.0**53, 1.0, 0.5),
        (2.0**53 + 2, 1.0, -0.5),
        (1 + 2.0**-26, 1 + 2.0**-27, 0.0),
        (below, below, 0.0),
        (1.0, 3.0, 0.0),
        (2.0, 3.0, 0.0),
        (1.0, below, 0.0),
        (above, below, 0.0),
        (4.195835e6, 3.145727e6, 0.0),
        # roots next to squares
        (2.0, 1.0, 0.0),
        (1 - 2.0**-52, 1.0, 0.0),
        (1 + 2.0**-51, 1.0, 0.0),
        (4 * below, 1.0, 0.0),
        # subnormals: kept, reached, left, and halfway between two of them
        (least, 1.0, 0.0),
        (least, 0.5, 0.0),
        (least, 0.5, least),
        (3 * least, 0.5, 0.0),
        (tiny, 0.5, 0.0),
        (tiny, below, 0.0),
        (tiny, above, -tiny),
        (3 * least, 2.0, -5 * least),
        (2.0**-600, 2.0**-500, 2.0**-1074),
        (-(2.0**-538), 2.0**-538, 0.0),
        (5 * least, 3.0, 0.0),
        (tiny, 2.0**52, 0.0),
        (tiny - least, least, least),
        (5 * least, -2 * least, 0.0),
        # the other end, and signed zeros
        (most, 2.0, -most),
        (most, above, 0.0),
        (most, 1.0, math.ldexp(1, 970)),
        (most, 1.0, math.ldexp(1, 969)),
        (1.0, most, 0.0),
        (0.0, -1.0, -0.0),
        (-0.0, 1.0, 0.0),
        (-0.0, 1.0, -0.0),
        (0.0, 0.0, 0.0),
        (-1.0, 0.0, 1.0),
        (1.0, -0.0, 0.0),
    ]
    operands = np.empty((3, n))
    operands[:, : len(hard)] = np.array(hard).T
    rest = n - len(hard)
    for row in range(3):
        words = random_words(rest, 1 + row)
        mantissa = words & np.uint64((1 << 52) - 1)
        # Half near one, where products and sums meet; half over all exponents, subnormals too.
        near = np.uint64(1023 - 24) + (words >> np.uint64(52)) % np.uint64(48)
        anywhere = (words >> np.uint64(52)) % np.uint64(2047)
        exponent = np.where(np.arange(rest) % 2 == 0, near, anywhere)
        sign = words & np.uint64(1 << 63)
        operands[row, len(hard) :] = (sign | exponent << np.uint64(52) | mantissa).view(np.float64)
    # Some c nearly cancel the product, which is where contraction shows.
    cancel = np.arange(len(hard), n, 4)
    with np.errstate(all="ignore"):
        product = operands[0, cancel] * operands[1, cancel]
    operands[2, cancel] = np.where(np.isfinite(product), -product, operands[2, cancel])
    operands.flags.writeable = False
    return operands


@cache
def arithmetic_answers(n: int) -> dict[str, NDArray[np.float64]]:
    """Return what ``selftest_arithmetic`` must give, by operation in the order of the kernel."""
    a, b, c = (row.tolist() for row in arithmetic_operands(n))
    products = [_multiply(x, y) for x, y in zip(a, b, strict=True)]

    def each(function: Callable[..., float], *columns: list[float]) -> NDArray[np.float64]:
        return np.array([function(*row) for row in zip(*columns, strict=True)])

    return {
        "a + b": each(_add, a, b),
        "a - b": each(lambda x, y: _add(x, -y), a, b),
        "a * b": np.array(products),
        "a / b": each(_divide, a, b),
        "sqrt(|a|)": each(lambda x: _square_root(abs(x)), a),
        "fma(a, b, c)": each(_fma, a, b, c),
        "a * b + c (not fused)": each(_add, products, c),
        "a * b - c (not fused)": each(lambda p, z: _add(p, -z), products, c),
        "c - a * b (not fused)": each(lambda p, z: _add(z, -p), products, c),
        "a < b ? a : b": each(lambda x, y: x if x < y else y, a, b),
        "a == c ? b : c": each(lambda x, y, z: y if x == z else z, a, b, c),
        "copysign(a, b)": each(math.copysign, a, b),
    }


@cache
def integer_operands(n: int) -> tuple[NDArray[np.float64], NDArray[np.uint64]]:
    """Return doubles below 2^53 in magnitude and any 64-bit words, shape (n,) each, read only."""
    hard_x = [0.5, 1.5, 2.5, -0.5, -1.5, -2.5, 0.0, -0.0, 1 - 2.0**-53, 2.0**-1074, -(2.0**-1074)]
    hard_x += [2.0**52 - 0.5, 2.0**52 - 1.5, 0.5 - 2.0**-54, 2.0**31, 2.0**32 - 0.5, -(2.0**31)]
    hard_u = [0, 1, 2**53, 2**53 + 1, 2**53 + 2, 2**53 + 3, 2**54 + 2, 2**54 + 6, 2**63 - 1, 2**63]
    hard_u += [2**63 + 1024, 2**63 + 1025, 2**63 + 3072, 2**64 - 1, 2**64 - 1024, 2**64 - 1025]
    hard_u += [2**32 - 1, 2**32]
    u = random_words(n, 7)
    # Random words of every length, not only long ones.
    u >>= random_words(n, 8) % np.uint64(64)
    u[: len(hard_u)] = hard_u
    words = random_words(n, 9)
    exponent = np.uint64(1023 - 4) + words % np.uint64(56)
    sign_and_mantissa = words & np.uint64((1 << 63) | ((1 << 52) - 1))
    x = (sign_and_mantissa | exponent << np.uint64(52)).view(np.float64)
    x[: len(hard_x)] = hard_x
    x.flags.writeable = u.flags.writeable = False
    return x, u


@cache
def integer_answers(n: int) -> dict[str, NDArray[np.uint64]]:
    """Return what ``selftest_integers`` must give, as 64-bit words, in the order of the kernel."""
    xs, us = integer_operands(n)
    x: list[float] = xs.tolist()
    u: list[int] = us.tolist()
    mask = (1 << 64) - 1

    def bits(value: float) -> int:
        return int.from_bytes(struct.pack("<d", value), "little")

    def words(values: list[int]) -> NDArray[np.uint64]:
        return np.array([value & mask for value in values], dtype=np.uint64)

    def signed(word: int) -> int:
        return word - (1 << 64) if word >> 63 else word

    def floor(value: float) -> float:
        return math.copysign(float(math.floor(value)), value)

    def rint(value: float) -> float:
        return math.copysign(float(round(value)), value)

    low, high = [v & 0xFFFFFFFF for v in u], [v >> 32 for v in u]
    pairs = list(zip(low, high, strict=True))
    return {
        # float() of a Python integer rounds to nearest, ties to even
        "double of ulong": words([bits(float(v)) for v in u]),
        "double of long": words([bits(float(signed(v))) for v in u]),
        "double of uint": words([bits(float(v)) for v in low]),
        "long of double": words([math.trunc(v) for v in x]),
        "floor": words([bits(floor(v)) for v in x]),
        "rint": words([bits(rint(v)) for v in x]),
        "mul_hi of uint": words([(p * q) >> 32 for p, q in pairs]),
        "uint product": words([(p * q) & 0xFFFFFFFF for p, q in pairs]),
        "uint product as ulong": words([p * q for p, q in pairs]),
        "ulong product": words([v * 0x9E3779B97F4A7C15 for v in u]),
        "shifts and xor": words([v ^ (v >> 29) ^ (v << 13) for v in u]),
        "arithmetic shift": words([signed(v) >> 17 for v in u]),
    }


@cache
def limb_weights(n: int) -> NDArray[np.float64]:
    """Return weights in [2^-42, 4), which three limbs hold without error, shape (n,), read only."""
    words = random_words(n, 11)
    exponent = np.uint64(1023 - 42) + (words >> np.uint64(52)) % np.uint64(44)
    weights = ((words & np.uint64((1 << 52) - 1)) | exponent << np.uint64(52)).view(np.float64)
    weights.flags.writeable = False
    return weights


def exact_cell(weights: NDArray[np.float64]) -> int:
    """Return the sum of weights in units of 2^-95, exactly."""
    total = sum((Fraction(w) for w in weights.tolist()), Fraction(0)) * 2**95
    if total.denominator != 1:
        raise ValueError("a weight has bits below 2^-95")
    return total.numerator


SINCOS: Final[tuple[tuple[str, str, str], ...]] = (
    ("0x0.0p+0", "0x0.0p+0", "0x1.0000000000000p+0"),
    ("0x1.0000000000000p-3", "0x1.6a09e667f3bccp-1", "0x1.6a09e667f3bccp-1"),
    ("0x1.0000000000000p-2", "0x1.0000000000000p+0", "-0x0.0p+0"),
    ("0x1.8000000000000p-2", "0x1.6a09e667f3bccp-1", "-0x1.6a09e667f3bccp-1"),
    ("0x1.0000000000000p-1", "-0x0.0p+0", "-0x1.0000000000000p+0"),
    ("0x1.4000000000000p-1", "-0x1.6a09e667f3bccp-1", "-0x1.6a09e667f3bccp-1"),
    ("0x1.8000000000000p-1", "-0x1.0000000000000p+0", "0x0.0p+0"),
    ("0x1.c000000000000p-1", "-0x1.6a09e667f3bccp-1", "0x1.6a09e667f3bccp-1"),
    ("0x1.0000000000000p+0", "0x0.0p+0", "0x1.0000000000000p+0"),
    ("0x1.0000000000000p-53", "0x1.921fb54442d18p-51", "0x1.0000000000000p+0"),
    ("0x1.0000000000000p-32", "0x1.921fb54442d18p-30", "0x1.0000000000000p+0"),
    ("0x1.fffffffffffffp-1", "-0x1.921fb54442d18p-51", "0x1.0000000000000p+0"),
    ("0x1.fffffffffffffp-4", "0x1.6a09e667f3bccp-1", "0x1.6a09e667f3bcdp-1"),
    ("0x1.0000000000001p-3", "0x1.6a09e667f3bcep-1", "0x1.6a09e667f3bcbp-1"),
    ("0x1.ffffffffffffep-3", "0x1.0000000000000p+0", "0x1.921fb54442d18p-52"),
    ("0x1.5555555555555p-2", "0x1.bb67ae8584cabp-1", "-0x1.ffffffffffffep-2"),
    ("0x1.5555555555555p-1", "-0x1.bb67ae8584ca9p-1", "-0x1.0000000000002p-1"),
    ("0x1.0624dd2f1a9fcp-10", "0x1.9bc5a9d91f679p-8", "0x1.fffd69aa0b99dp-1"),
    ("0x1.0000000000000p-4", "0x1.87de2a6aea963p-2", "0x1.d906bcf328d46p-1"),
    ("0x1.ccccccccccccdp-1", "-0x1.2cf2304755a5dp-1", "0x1.9e3779b97f4a9p-1"),
    ("0x1.dffeafd54fefdp-1", "-0x1.87ed693320cdap-2", "0x1.d9039495d300dp-1"),
    ("0x1.70407b536d9e8p-2", "0x1.8b47648a29a0bp-1", "-0x1.456bb0a6d2572p-1"),
    ("0x1.65467658dc3f8p-3", "0x1.c763f9e8107cbp-1", "0x1.d4082a2d0c96dp-2"),
    ("0x1.cb28c56a0e4c4p-3", "0x1.f9496f273f605p-1", "0x1.4a8e4a35d6097p-3"),
    ("0x1.0120f62d458abp-1", "-0x1.c5e2a63c1b7f4p-7", "-0x1.fff36ce8d4697p-1"),
    ("0x1.81fb590a21b8ep-2", "0x1.659c0824304cap-1", "-0x1.6e6a102cad151p-1"),
    ("0x1.34a6681ea34e8p-4", "0x1.d2ea20bb15fa6p-2", "0x1.c7ad5c120ee3ap-1"),
    ("0x1.8dac594fb0e09p-1", "-0x1.f8cf21211b7bbp-1", "0x1.56091f1b86954p-3"),
    ("0x1.16798f89279cap-1", "-0x1.16dc320bb0cb5p-2", "-0x1.eca63366e0ba4p-1"),
    ("0x1.b5feb2e314a7ap-2", "0x1.c12bf66bc999ep-2", "-0x1.cc1d44386c5a1p-1"),
    ("0x1.56449bbd6b534p-1", "-0x1.be4fe72b3dc7fp-1", "-0x1.f5cb742754d9cp-2"),
    ("0x1.63e51e304761fp-1", "-0x1.e1d90f114d42bp-1", "-0x1.5a37a4b8108c0p-2"),
)
"""Turns, and the very bits of sine and cosine that the kernels' ``sincos_turns`` gives.

These are recorded, not derived: the function is the project's own, within 0.57 units in the last
place of the truth here (a test compares with 60-digit arithmetic), and what matters is that every
device gives the same. Whoever changes the polynomials records them anew from two devices.
"""
