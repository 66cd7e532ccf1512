from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from hostcode.device import known_answers as known

N = 768


@pytest.mark.parametrize(("counter", "key", "output"), known.PHILOX_VECTORS)
def test_independent_philox_gives_the_published_vectors(counter, key, output):
    assert known.philox4x32_10(counter, key) == output


def test_exact_rounding_agrees_with_this_machine():
    a, b, c = known.arithmetic_operands(N)
    answers = known.arithmetic_answers(N)
    with np.errstate(all="ignore"):
        here = {
            "a + b": a + b,
            "a - b": a - b,
            "a * b": a * b,
            "a / b": a / b,
            "sqrt(|a|)": np.sqrt(np.abs(a)),
            "a * b + c (not fused)": a * b + c,
            "a * b - c (not fused)": a * b - c,
            "c - a * b (not fused)": c - a * b,
            "copysign(a, b)": np.copysign(a, b),
        }
    for name, values in here.items():
        same = answers[name].view(np.uint64) == values.view(np.uint64)
        assert np.all(same | (np.isnan(values) & np.isnan(answers[name]))), name


def test_operands_tell_fused_from_unfused_and_reach_subnormals():
    answers = known.arithmetic_answers(N)
    fused, unfused = answers["fma(a, b, c)"], answers["a * b + c (not fused)"]
    assert np.count_nonzero(fused != unfused) > 100
    for name in ("a * b", "a / b", "a + b", "fma(a, b, c)"):
        values = np.abs(answers[name])
        assert np.any((values > 0) & (values < 2.0**-1022)), name
    a, b, _ = known.arithmetic_operands(N)
    halfway = [
        Fraction(x) + Fraction(y)
        for x, y in zip(a.tolist(), b.tolist(), strict=True)
        if 0 < abs(Fraction(x) + Fraction(y) - Fraction(x)) == Fraction(math.ulp(x)) / 2
    ]
    assert halfway


def test_integer_answers_agree_with_numpy():
    x, u = known.integer_operands(N)
    answers = known.integer_answers(N)
    assert np.all(answers["double of ulong"] == u.astype(np.float64).view(np.uint64))
    assert np.all(answers["double of long"] == u.view(np.int64).astype(np.float64).view(np.uint64))
    assert np.all(answers["long of double"] == x.astype(np.int64).view(np.uint64))
    assert np.all(answers["floor"] == np.floor(x).view(np.uint64))
    assert np.all(answers["rint"] == np.rint(x).view(np.uint64))


def test_weights_fit_three_limbs():
    weights = known.limb_weights(N)
    assert weights.min() >= 2.0**-42
    assert weights.max() < 4
    assert known.exact_cell(np.array([1.0, 2.0**-42 * (1 + 2.0**-52)])) == 2**95 + 2**53 + 2
    with pytest.raises(ValueError, match="below"):
        known.exact_cell(np.array([2.0**-96]))


def test_recorded_sines_are_true():
    with mpmath.workdps(60):
        for turns, sine, cosine in (tuple(map(float.fromhex, row)) for row in known.SINCOS):
            angle = 2 * mpmath.pi * mpmath.mpf(turns)
            for exact, recorded in ((mpmath.sin(angle), sine), (mpmath.cos(angle), cosine)):
                if 4 * turns == round(4 * turns):
                    assert recorded == round(float(exact))
                else:
                    assert abs(exact - mpmath.mpf(recorded)) < 0.6 * math.ulp(recorded)


def test_words_are_the_same_for_ever():
    assert known.random_words(2, 0).tolist() == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4]
