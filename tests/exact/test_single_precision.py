"""The modes ``mixed`` and ``fp32``: draws, closure, and one set of bits however it is computed."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from oracles import gates
from oracles.engine import Traced, compiled, open_device, trace, trace_compiled
from oracles.kernels import run_text
from oracles.scenes import everything

from hostcode.program.plan import ExecutionPlan
from hostcode.program.precision import PRECISIONS
from photizon_cl.scene.files import load

MODES = ("mixed", "fp32")
U = 2.0**-24
LANES = [1, pytest.param(8, marks=pytest.mark.slow)]

UNIFORMS = """
__kernel void test(__global const uint *hi, __global const uint *lo, __global float *out) {
    const size_t i = get_global_id(0);
    STORE(u01_closed_open(LOAD(hi, i), LOAD(lo, i)), out, i);
}
"""
SINCOS = """
__kernel void test(__global const float *turns, __global float *out, uint n) {
    const size_t i = get_global_id(0);
    real s, c;
    sincos_turns(LOAD(turns, i), &s, &c);
    STORE(s, out, i); STORE(c, out + n, i);
}
"""


def words() -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of random words: the ends of every binade, and some between."""
    r = np.random.default_rng(3)
    ends = [2**k + d for k in range(33) for d in (-1, 0, 1) if 0 <= 2**k + d < 2**32]
    half = [0x7FFFFFFF, 0x80000000, 0xFFFFFF7F, 0xFFFFFF80, 0xFFFFFFFF]
    hi = np.array([*ends, *half, *r.integers(0, 2**32, 400)], np.uint32)
    hi = np.resize(hi, 512)
    lo = np.resize(np.array([0, 0xFFFFFFFF, 0x80000000, 12345], np.uint32), 512)
    return hi, r.permutation(lo)


@pytest.mark.parametrize("lanes", LANES)
def test_draws_are_those_of_doubles_cut_short(lanes: int) -> None:
    hi, lo = words()
    got = run_text(UNIFORMS, [hi, lo, np.zeros(512, np.float32)], 512, lanes=lanes, real="float")[2]
    assert got.max() == 1.0 - U  # no draw is 1
    assert got.min() >= 0.0
    for h, low, u in zip(hi.tolist(), lo.tolist(), got.tolist(), strict=True):
        double = Fraction(h, 2**32) + Fraction(low >> 11, 2**53)
        if h >= 2**24:  # cut to 24 bits
            unit = Fraction(2) ** (h.bit_length() - 24 - 32)
            assert Fraction(u) == double // unit * unit
        else:
            assert Fraction(u) == Fraction(float(np.float32(float(double))))
        # a chance of one half decides as in double precision
        assert (u < 0.5) == (double < Fraction(1, 2))


@pytest.mark.parametrize("lanes", LANES)
def test_sines_and_cosines_of_turns_keep_their_last_place(lanes: int) -> None:
    r = np.random.default_rng(4)
    turns = np.concatenate([r.uniform(0.0, 1.0, 1000), np.arange(9) / 8.0, 2.0 ** -np.arange(15)])
    turns = turns.astype(np.float32)
    n = len(turns)
    out = np.zeros((2, n), np.float32)
    got = run_text(SINCOS, [turns, out, np.uint32(n)], n, lanes=lanes, real="float")[1]
    exact = turns.astype(np.float64) * (2.0 * math.pi)
    for found, wanted in zip(got, (np.sin(exact), np.cos(exact)), strict=True):
        off = np.abs(found - wanted) / np.spacing(np.abs(wanted).astype(np.float32))
        away = np.abs(wanted) > 1e-15  # double precision's own sine of a whole turn is none
        assert off[away].max() < 1.0
        assert (found[~away] == 0.0).all()  # exact quarter turns
        # 2 pi is taken in two parts: rounded to one it would be off by 0.47 u in each of them
        assert abs(np.mean(found[away] / wanted[away] - 1.0)) < 0.1 * U


@cache
def base(name: str, mode: str) -> Traced:
    """Return the run that all others must equal."""
    return trace_compiled(scene(name, mode), 3, plan=BASE)


@cache
def scene(name: str, mode: str):
    """Return a compiled scene."""
    found = load(everything()) if name == "everything" else name
    return compiled(found, precision=mode, rays_per_batch=2048)


BASE = ExecutionPlan(lanes=4, items=8, wave_rays=1 << 16, refill=1, stack_rays=64)
CHOICES = {
    "one bounce a launch": {"max_bounces": 1},
    "small segments": {"stack_rays": 1, "items": 3, "wave_rays": 1 << 10, "tally_copies": 1},
    "8 lanes": {"lanes": 8, "refill": 2},
    "1 lane": {"lanes": 1},
    "16 lanes": {"lanes": 16},
    "classical": {"composition": "classical"},
    "whole path": {"composition": "whole-path", "lanes": 1, "stack_rays": 2},
}
FAST = {("ghost-ladder", "mixed", "8 lanes"), ("ghost-ladder", "fp32", "classical")}
"""Each other one makes a program as well."""


@pytest.mark.parametrize(
    ("name", "mode", "choice"),
    [
        pytest.param(
            name, mode, choice, marks=() if (name, mode, choice) in FAST else pytest.mark.slow
        )
        for name in ("integrating-sphere", "ghost-ladder", "box-room", "everything")
        for mode in MODES
        for choice in CHOICES
    ],
)
def test_one_set_of_bits_however_it_is_computed(name: str, mode: str, choice: str) -> None:
    want = base(name, mode)
    run = trace_compiled(scene(name, mode), 3, plan=BASE.with_(**CHOICES[choice]))
    assert [c.tobytes() for c in run.batches] == [c.tobytes() for c in want.batches]
    assert run.interactions == want.interactions


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        pytest.param(
            name, mode, marks=() if (name, mode) == ("ghost-ladder", "fp32") else pytest.mark.slow
        )
        for name in ("ghost-ladder", "everything", "integrating-sphere")
        for mode in MODES
    ],
)
@pytest.mark.parametrize("origin", ["debian", "pypi"])
def test_both_pocls(name: str, mode: str, origin: str) -> None:
    device = open_device(origin)
    assert device.record.promises(PRECISIONS[mode].real)
    run = trace_compiled(scene(name, mode), 3, device=device, plan=BASE.with_(lanes=8))
    assert run.digest == base(name, mode).digest


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box-room", "integrating-sphere", "ghost-ladder"])
@pytest.mark.parametrize("effect", ["tilt", "contact", "acceleration", "coincidence"])
def test_forcing_an_effect_changes_no_bit(name: str, effect: str) -> None:
    made = compiled(name, frozenset({effect}), "fp32", rays_per_batch=2048)
    assert trace_compiled(made, 3, plan=BASE).digest == base(name, "fp32").digest


@pytest.mark.parametrize(
    "name", ["ghost-ladder", pytest.param("everything", marks=pytest.mark.slow)]
)
def test_mixed_closes_as_double_precision_does(name: str) -> None:
    gates.closes(base(name, "mixed"))
    # and single precision does not, by the rounding of its splits, but sums exactly all the same
    off = [abs(closure) for closure in base(name, "fp32").closures()]
    assert Fraction(1, 10**12) < max(off) < Fraction(2) ** -22


def test_the_modes_differ_in_bits_and_agree_in_numbers() -> None:
    found = {mode: base("ghost-ladder", mode) for mode in MODES}
    found["fp64"] = trace("ghost-ladder", batches=3, plan=BASE, rays_per_batch=2048)
    assert len({one.digest for one in found.values()}) == 3
    ladders = {
        mode: [float(power) for power in one.detector("transmitted").ladder]
        for mode, one in found.items()
    }
    for mode in MODES:
        # its geometry is single: a reflectance is off by some roundings, a path by as many of them
        assert ladders[mode] == pytest.approx(ladders["fp64"], rel=64 * U)
