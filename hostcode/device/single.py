"""What a device must prove before results rest on its single precision.

As `hostcode.device.selftest` for doubles, with the production libraries, at the lane widths that
the device will run: sums, products, fused multiply-adds where they are written and only there,
conversions, and the draws; quotients and roots, and numbers below the normal ones, of a device that
promises them. It is asked at the first program in single precision; a pass is remembered.
"""

from __future__ import annotations

import hashlib
import warnings
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.device import kept_kernels, known_passes
from hostcode.device.known_answers import random_words
from hostcode.device.opened import preferred_lanes
from hostcode.errors import DeviceError, KernelBuildError
from hostcode.templates import lane, render

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from hostcode.device.opened import OpenDevice

__all__ = ["EXACT_FLOATS", "failures", "options_of", "trust"]

EXACT_FLOATS: Final = "-cl-fp32-correctly-rounded-divide-sqrt"
"""Build option of programs in single precision, where the device knows it: without it a quotient
may be off by 2.5 units in the last place."""

_OPTIONS: Final = ("-cl-std=CL1.2",)
_SOURCES: Final = ("prelude", "lib/philox", "lib/elementary", "stages/selftest_single")
_N: Final = 1024
_NAMES: Final = (
    "a + b", "a - b", "a * b", "a / b", "sqrt |a|", "fma(a, b, c)", "a * b + c", "c - a * b",
    "double to float", "random words to float",
)  # fmt: skip
_PROMISED: Final = frozenset({"a / b", "sqrt |a|"})
_LEAST: Final = 2.0**-126

_trusted: set[str] = set()


def options_of(opened: OpenDevice, real: str) -> tuple[str, ...]:
    """Return the build options of programs in a C type."""
    exact = "correctly_rounded_divide_sqrt" in opened.record.fp32_flags
    return (*_OPTIONS, EXACT_FLOATS) if real == "float" and exact else _OPTIONS


def trust(opened: OpenDevice) -> None:
    """See that a device has passed the test, or run it.

    Raises
    ------
    DeviceError
        Where it fails.
    """
    key = opened.record.key
    if key in _trusted:
        return
    widths = tuple(sorted({1, preferred_lanes(opened.record)}))
    verdict = _verdict(opened, widths)
    if not verdict or known_passes.of(key, single=True) != verdict:
        found = [text for width in widths for text in failures(opened, width)]
        if found:
            raise DeviceError(
                f"{opened.record.label}: its single precision gives wrong answers, so that no run "
                f"in fp32 or mixed can be trusted: {'; '.join(found[:3])}; run in fp64, or on "
                "another device"
            )
        verdict = _verdict(opened, widths)
        if verdict:
            known_passes.remember(key, verdict, single=True)
    _trusted.add(key)


def _verdict(opened: OpenDevice, widths: tuple[int, ...]) -> str:
    """Return what a pass is about, empty where its programs are not kept."""
    kept = [kept_kernels.digest_of(_program(opened, width)) for width in widths]
    if kept_kernels.are_kept(opened) and not all(kept):
        return ""
    asked = Path(__file__).read_bytes() + "".join(map(source, widths)).encode()
    return " ".join((hashlib.sha256(asked).hexdigest(), *(found or "-" for found in kept)))


@cache
def source(lanes: int) -> str:
    """Return the OpenCL source of the test at one lane width."""
    context: dict[str, Any] = {
        "real": "float",
        "weight": "double",
        "lanes": lanes,
        "lane": partial(lane, lanes=lanes),
    }
    return "".join(render(f"{name}.mako", **context) for name in _SOURCES)


def _program(opened: OpenDevice, lanes: int) -> str:
    return kept_kernels.program_key(opened, source(lanes), options_of(opened, "float"))


def failures(opened: OpenDevice, lanes: int) -> list[str]:
    """Run the test at a lane width; return a line for each operation that gives a wrong answer."""
    import pyopencl as cl

    key, options = _program(opened, lanes), options_of(opened, "float")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", cl.CompilerWarning)
            program = kept_kernels.build(opened, key, source(lanes), options)
        kernel = cl.Kernel(program, "selftest_single")
        found = list(_compare(opened, kernel, lanes))
    except (cl.Error, KernelBuildError) as error:
        first = next((line for line in str(error).splitlines() if line.strip()), "no reason given")
        return [f"{lanes} lanes: its program does not build or run: {first}"]
    if not found:
        kept_kernels.keep(key)
    return found


def _compare(opened: OpenDevice, kernel: Any, lanes: int) -> Iterator[str]:
    import pyopencl as cl

    operands = [*_operands(), *_words()]
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    buffers = [cl.Buffer(opened.context, flags, hostbuf=array) for array in operands]
    out = np.zeros((len(_NAMES), _N), np.float32)
    result = cl.Buffer(opened.context, flags, hostbuf=out)
    kernel(opened.queue, (_N // lanes,), (1,), *buffers, result, np.uint32(_N))
    cl.enqueue_copy(opened.queue, out, result)
    a, b, c = operands[:3]
    # numbers that a device may flush to 0, unless it promises to keep them
    keeps = "denorm" in opened.record.fp32_flags
    exact = "correctly_rounded_divide_sqrt" in opened.record.fp32_flags
    for name, wanted, got in zip(_NAMES, answers(), out, strict=True):
        if name in _PROMISED and not exact:
            continue
        differ = (wanted.view(np.uint32) != got.view(np.uint32)) & ~(
            np.isnan(wanted) & np.isnan(got)
        )
        if not keeps:
            tiny = [(np.abs(x) < _LEAST) & (x != 0.0) for x in (a, b, c, wanted)]
            differ &= ~np.any(tiny, axis=0)
        if differ.any():
            first = int(np.argmax(differ))
            case = ", ".join(float(x[first]).hex() for x in (a, b, c))
            yield (
                f"{lanes} lanes: {name} is wrong in {int(differ.sum())} of {_N} cases; of ({case}) "
                f"it gives {float(got[first]).hex()}, not {float(wanted[first]).hex()}"
            )


@cache
def _operands() -> tuple[NDArray[np.float32], ...]:
    """Return a, b, c: cases known to go wrong first, then random bits of finite numbers."""
    least, above, below = 2.0**-149, 1 + 2.0**-23, 1 - 2.0**-24
    hard = np.array(
        [
            (1 + 2.0**-15, 1 - 2.0**-15, -1.0),
            (above, above, -(1 + 2.0**-22)),
            (0.1, 10.0, -1.0),
            (1 / 3, 3.0, -1.0),
            (1.0, 2.0**-24, 2.0**-48),
            (above, 2.0**-24, -(2.0**-24)),
            (1.0, 3.0, 0.0),
            (2.0, 3.0, 0.0),
            (1.0, below, 0.0),
            (above, below, 0.0),
            (4 * below, 1.0, 0.0),
            (least, 0.5, least),
            (3 * least, 0.5, 0.0),
            (_LEAST, below, 0.0),
            (_LEAST - least, least, least),
            (0.0, -1.0, -0.0),
            (-1.0, 0.0, 1.0),
        ],
        np.float32,
    )
    columns = []
    for k in range(3):
        words = (random_words(_N, 31 + k) & np.uint64(0xFFFFFFFF)).astype(np.uint32)
        near = np.uint32(127 - 12) + (words >> np.uint32(23)) % np.uint32(24)
        anywhere = (words >> np.uint32(23)) % np.uint32(255)
        exponent = np.where(np.arange(_N) % 2 == 0, near, anywhere).astype(np.uint32)
        kept = words & np.uint32(0x807FFFFF)
        column = (kept | exponent << np.uint32(23)).view(np.float32).copy()
        column[: len(hard)] = hard[:, k]
        columns.append(column)
    return tuple(columns)


@cache
def _words() -> tuple[NDArray[np.uint32], ...]:
    words = random_words(_N, 41)
    hi, lo = (words >> np.uint64(32)).astype(np.uint32), words.astype(np.uint32)
    hi[: 3 * 32] = [max(0, min(2**k + d, 2**32 - 1)) for k in range(1, 33) for d in (-1, 0, 1)]
    return hi, lo


@cache
def answers() -> tuple[NDArray[np.float32], ...]:
    """Return what the kernel must give, by operation: NumPy's, which IEEE 754 fixes, or exact."""
    a, b, c = _operands()
    hi, lo = _words()
    with np.errstate(all="ignore"):
        fused = [_rounded(x, y, z) for x, y, z in zip(a, b, c, strict=True)]
        wide = a.astype(np.float64) * b.astype(np.float64) + c.astype(np.float64)
        plain = (a + b, a - b, a * b, a / b, np.sqrt(np.abs(a)))
        apart = (a * b + c, c - a * b)
        draws = [_draw(h, low) for h, low in zip(hi.tolist(), lo.tolist(), strict=True)]
        return (
            *plain, np.array(fused, np.float32), *apart, wide.astype(np.float32),
            np.array(draws, np.float32),
        )  # fmt: skip


def _rounded(x: Any, y: Any, z: Any) -> float:
    """Return x y + z rounded once to single precision."""
    if not all(map(np.isfinite, (x, y, z))):
        return float(np.float32(x) * np.float32(y) + np.float32(z))
    exact = Fraction(float(x)) * Fraction(float(y)) + Fraction(float(z))
    if exact == 0:  # the sign of a zero sum is that of the terms
        return float(np.float64(x) * np.float64(y) + np.float64(z))
    double = np.float64(float(exact))
    # rounded to odd first, a double is rounded again as the exact number would be
    if Fraction(float(double)) != exact and not int(double.view(np.uint64)) & 1:
        away = Fraction(float(double)) < exact
        double = np.nextafter(double, np.inf if away else -np.inf)
    return float(np.float32(double))


def _draw(hi: int, lo: int) -> float:
    """Return the draw of two words, see kernels/lib/philox.mako."""
    exact = Fraction(hi, 2**32) + Fraction(lo >> 11, 2**53)
    if hi < 2**24:
        return float(np.float32(float(exact)))
    unit = Fraction(2) ** (hi.bit_length() - 24 - 32)
    return float(exact // unit * unit)
