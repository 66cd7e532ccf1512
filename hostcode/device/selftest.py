"""Known-answer self-test: what a device must prove at its first use, before results rest on it.

Asked are the operations that IEEE 754 and OpenCL fix exactly (arithmetic, fused multiply-add where
it is written and only there, conversions, integers), Philox's published vectors, the sine and
cosine of the kernels, and sums by integer atomics over many work-items; each with the production
library sources, as scalars and at the lane width that the device will run, in work-groups of one
and of many. A pass is kept, by `known_passes`, with the digests of the very binaries that passed:
where they are gone, or are others, the test runs again.
"""

from __future__ import annotations

import hashlib
import time
import warnings
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode.device import kept_kernels, known_answers, known_passes
from hostcode.device.opened import preferred_lanes
from hostcode.errors import KernelBuildError
from hostcode.templates import lane, render

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import pyopencl as cl
    from numpy.typing import NDArray

    from hostcode.device.opened import OpenDevice

__all__ = [
    "BUILD_OPTIONS",
    "SelfTestReport",
    "passed_before_or_run",
    "run",
    "source",
]

BUILD_OPTIONS: Final = ("-cl-std=CL1.2",)
"""No option that lets a compiler trade bits for speed, ever."""

SOURCES: Final = (
    "prelude.mako",
    "lib/philox.mako",
    "lib/elementary.mako",
    "lib/limbs.mako",
    "lib/cells.mako",
    "stages/selftest.mako",
)
"""Templates of the test's program, in order."""

ELEMENTS: Final = 768
"""Operands per operation; a multiple of every lane width and group size that is used."""

GROUP_SIZES: Final = (1, 16)
"""Work-items in a group: one, and enough for the compiler to vectorise over them."""


@dataclass(frozen=True, slots=True)
class SelfTestReport:
    """Outcome of the self-test of one device.

    Parameters
    ----------
    failures : tuple of str
        One line for each operation that gave a wrong answer; empty for a pass.
    seconds : float
        How long it took, compiling included; 0 where a pass was known.
    known : bool
        Whether the pass was remembered and nothing ran.
    """

    failures: tuple[str, ...]
    seconds: float = 0.0
    known: bool = False

    @property
    def passed(self) -> bool:
        """Whether every answer was right."""
        return not self.failures


def passed_before_or_run(opened: OpenDevice) -> SelfTestReport:
    """Return a remembered pass, or run the test and remember it if it passes.

    A failure is not remembered: what is wrong may be mended, and a refused device is rare.

    Parameters
    ----------
    opened : OpenDevice
        The device, opened without its self-test.

    Returns
    -------
    SelfTestReport
        Pass or failures.
    """
    key = opened.record.key
    lanes = _lane_widths(opened)
    try:
        digest = _digest(lanes)
    except KernelBuildError as error:
        return SelfTestReport((str(error),))
    before = known_passes.of(key)
    if (key, digest) in _passed or (before and before == _verdict(opened, lanes, digest)):
        _passed.add((key, digest))
        return SelfTestReport((), known=True)
    report = run(opened, lanes)
    if report.passed:
        _passed.add((key, digest))
        verdict = _verdict(opened, lanes, digest)
        if verdict:
            known_passes.remember(key, verdict)
    return report


def _verdict(opened: OpenDevice, lanes: tuple[int, ...], digest: str) -> str:
    """Return what a pass is about: the test, and the very binaries that passed and are kept.

    Empty where they could not be kept: what runs in the next process is not what passed.
    """
    kept = [kept_kernels.digest_of(_program(opened, width)) for width in lanes]
    if kept_kernels.are_kept(opened) and not all(kept):
        return ""
    return " ".join((digest, *(found or "-" for found in kept)))


def run(opened: OpenDevice, lanes: tuple[int, ...] | None = None) -> SelfTestReport:
    """Run the test, whatever is remembered.

    Parameters
    ----------
    opened : OpenDevice
        The device.
    lanes : tuple of int, optional
        Lane widths to test; default 1 and the device's preferred width.

    Returns
    -------
    SelfTestReport
        Pass or failures. A program that does not build or run is a failure, not an exception.
    """
    import pyopencl as cl

    start = time.perf_counter()
    failures: list[str] = []
    for width in lanes if lanes is not None else _lane_widths(opened):
        try:
            found = _run_width(opened, width)
        except KernelBuildError as error:
            found = [str(error)]
        except cl.Error as error:
            # The first lines are the chain of pyopencl's own wrappers around what was said.
            lines = [line.strip() for line in str(error).splitlines() if line.strip()]
            said = [line for line in lines if "error:" in line] or lines
            found = [f"its program does not build or run: {' / '.join(said[:3])}"]
        failures += [f"{width} lanes: {failure}" for failure in found]
    return SelfTestReport(tuple(failures), time.perf_counter() - start)


@cache
def source(lanes: int) -> str:
    """Return the OpenCL source of the test at one lane width, production libraries included."""
    # No effect is in use: what the libraries define for some of them is not tested here.
    one_lane = partial(lane, lanes=lanes)
    return "\n".join(
        render(
            name,
            real="double",
            weight="double",
            lanes=lanes,
            lane=one_lane,
            effects=frozenset(),
            private_tallies=False,
        )
        for name in SOURCES
    )


_passed: set[tuple[str, str]] = set()  # what passed in this process, for where no file can be kept


def _lane_widths(opened: OpenDevice) -> tuple[int, ...]:
    return tuple(sorted({1, preferred_lanes(opened.record)}))


@cache
def _digest(lanes: tuple[int, ...]) -> str:
    text = "\n".join(source(width) for width in lanes)
    # The questions and their answers are part of what a pass means.
    questions = Path(known_answers.__file__).read_bytes() + Path(__file__).read_bytes()
    return hashlib.sha256(text.encode() + questions).hexdigest()


def _run_width(opened: OpenDevice, lanes: int) -> list[str]:
    import pyopencl as cl

    with warnings.catch_warnings():
        # A compiler that has something to say about a correct program is not a failure.
        warnings.simplefilter("ignore", cl.CompilerWarning)
        program = kept_kernels.build(opened, _program(opened, lanes), source(lanes), BUILD_OPTIONS)
    failures: dict[str, None] = {}  # a set in order: both group sizes mostly fail alike
    try:
        kernels = _Kernels(opened, program, lanes)
    except AttributeError:
        # PoCL 3.0 says that it built a program whose code it could not make
        return ["the program was built, but has none of its kernels"]
    for group in GROUP_SIZES:
        if group <= opened.record.max_work_group_size:
            for failure in (
                *_arithmetic(kernels, group),
                *_integers(kernels, group),
                *_philox(kernels, group),
                *_sincos(kernels, group),
                *_limbs(kernels, group),
            ):
                failures[failure] = None
    if not failures:
        kept_kernels.keep(_program(opened, lanes))
    return list(failures)


def _program(opened: OpenDevice, lanes: int) -> str:
    return kept_kernels.program_key(opened, source(lanes), BUILD_OPTIONS)


class _Kernels:
    """The built program, and a way to call its kernels with arrays."""

    def __init__(self, opened: OpenDevice, program: cl.Program, lanes: int) -> None:
        self.opened = opened
        self.lanes = lanes
        names = ("arithmetic", "integers", "philox", "sincos", "limbs")
        # Each is taken out once: pyopencl warns about looking a kernel up again and again.
        self.kernels: dict[str, Any] = {
            name: getattr(program, f"selftest_{name}") for name in names
        }

    def __call__(
        self, name: str, group: int, elements: int, *arguments: NDArray[Any] | np.generic
    ) -> list[NDArray[Any]]:
        """Run a kernel; return every array argument as it is afterwards."""
        import pyopencl as cl

        flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
        passed: list[cl.Buffer | np.generic] = []
        arrays: list[tuple[cl.Buffer, NDArray[Any]]] = []
        for argument in arguments:
            if isinstance(argument, np.ndarray):
                content = np.ascontiguousarray(argument)
                buffer = cl.Buffer(self.opened.context, flags, hostbuf=content)
                arrays.append((buffer, np.empty_like(content)))
                passed.append(buffer)
            else:
                passed.append(argument)
        items = elements // self.lanes
        self.kernels[name](self.opened.queue, (items,), (min(group, items),), *passed)
        for buffer, result in arrays:
            cl.enqueue_copy(self.opened.queue, result, buffer)
        return [result for _, result in arrays]


def _wrong(
    wanted: Mapping[str, NDArray[Any]], got: NDArray[Any], *operands: NDArray[Any]
) -> Iterator[str]:
    """Yield a line for each operation of which some bits differ, with its first case."""
    for (name, answer), result in zip(wanted.items(), got, strict=True):
        bits = f"u{answer.itemsize}"
        differ = answer.view(bits) != result.view(bits)
        if answer.dtype.kind == "f":
            differ &= ~(np.isnan(answer) & np.isnan(result))  # one NaN is as good as another
        if differ.any():
            first = int(np.argmax(differ))
            case = ", ".join(_text(operand[first]) for operand in operands)
            yield (
                f"{name} is wrong in {int(differ.sum())} of {differ.size} cases; "
                f"of ({case}) it gives {_text(result[first])}, not {_text(answer[first])}"
            )


def _text(value: Any) -> str:
    return float(value).hex() if np.asarray(value).dtype.kind == "f" else f"{int(value):#x}"


def _arithmetic(kernels: _Kernels, group: int) -> Iterator[str]:
    operands = known_answers.arithmetic_operands(ELEMENTS)
    wanted = known_answers.arithmetic_answers(ELEMENTS)
    out = np.zeros((len(wanted), ELEMENTS))
    *_, got = kernels("arithmetic", group, ELEMENTS, *operands, out, np.uint32(ELEMENTS))
    yield from _wrong(wanted, got, *operands)


def _integers(kernels: _Kernels, group: int) -> Iterator[str]:
    x, u = known_answers.integer_operands(ELEMENTS)
    wanted = known_answers.integer_answers(ELEMENTS)
    out = np.zeros((len(wanted), ELEMENTS), dtype=np.uint64)
    *_, got = kernels("integers", group, ELEMENTS, x, u, out, np.uint32(ELEMENTS))
    yield from _wrong(wanted, got, x, u)


def _philox(kernels: _Kernels, group: int) -> Iterator[str]:
    n = 64
    halves = known_answers.random_words(2 * n, 21).view(np.uint32).reshape(4, n)
    for counter, key, published in known_answers.PHILOX_VECTORS:
        counters = halves.copy()
        counters[:, 5] = counter
        blocks = [known_answers.philox4x32_10(tuple(column), key) for column in counters.T.tolist()]
        answers = np.array(blocks, dtype=np.uint32).T
        if tuple(answers[:, 5].tolist()) != published:
            yield "the host's own Philox4x32-10 misses the published vector"
        uniforms = [((w0 << 21) | (w1 >> 11)) * 2.0**-53 for w0, w1, _, _ in blocks]
        words = np.zeros((4, n), dtype=np.uint32)
        _, got, uniform = kernels(
            "philox",
            group,
            n,
            counters,
            np.uint32(key[0]),
            np.uint32(key[1]),
            words,
            np.zeros(n),
            np.uint32(n),
        )
        names = (f"Philox4x32-10 word {word}" for word in range(4))
        yield from _wrong(dict(zip(names, answers, strict=True)), got, *counters)
        wanted = {"Philox word to double": np.array(uniforms)}
        yield from _wrong(wanted, uniform[np.newaxis], *answers[:2])


def _sincos(kernels: _Kernels, group: int) -> Iterator[str]:
    table = np.array([[float.fromhex(text) for text in row] for row in known_answers.SINCOS])
    n = 64
    turns, sines, cosines = np.resize(table, (n, 3)).T.copy()
    _, got = kernels("sincos", group, n, turns, np.zeros((2, n)), np.uint32(n))
    yield from _wrong({"sine of turns": sines, "cosine of turns": cosines}, got, turns)


def _limbs(kernels: _Kernels, group: int) -> Iterator[str]:
    repeat = 16
    weights = known_answers.limb_weights(ELEMENTS)
    raw, cell = np.zeros(2, dtype=np.int64), np.zeros(4, dtype=np.int64)
    _, raw, cell = kernels("limbs", group, ELEMENTS, weights, raw, cell, np.uint32(repeat))
    words: list[int] = weights.view(np.uint64).tolist()
    low, high = sum(w & 0xFFFFFFFF for w in words), sum(w >> 32 for w in words)
    if raw.tolist() != [repeat * low, repeat * high]:
        yield "a sum of 32-bit pieces by 64-bit atomics is not exact"
    p0, p1, p2, count = (int(limb) for limb in cell)
    total = (p0 << 64) + (p1 << 32) + p2
    wanted = repeat * known_answers.exact_cell(weights)
    if total != wanted or count != repeat * ELEMENTS:
        excess = float(Fraction(total - wanted, 2**95))
        yield f"an exact tally is off by {excess:g} and {count - repeat * ELEMENTS} counts"
