"""The known answers that a device is asked before its single precision is trusted."""

from __future__ import annotations

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

import photizon_cl as pz
from hostcode import templates
from hostcode.device import known_passes, single
from hostcode.device.device import choose, open_device
from hostcode.errors import DeviceError


@pytest.fixture(scope="module")
def opened():
    return open_device(choose())


@pytest.fixture
def asked_anew(monkeypatch, tmp_path):
    """Have nothing remembered, and nothing rendered before."""
    monkeypatch.setattr(single, "_trusted", set())
    monkeypatch.setattr(known_passes, "cache_file", lambda: tmp_path / "selftest.json")
    single.source.cache_clear()
    yield
    single.source.cache_clear()


def test_fused_answers_are_rounded_once():
    a, b, c = (np.float32(x) for x in (1 + 2.0**-15, 1 - 2.0**-15, -1.0))
    assert single._rounded(a, b, c) == -(2.0**-30)  # apart it is 0
    # halfway between two floats but for what a double loses
    x, y, z = (np.float32(v) for v in (1 + 2.0**-12, 1 + 2.0**-12, 2.0**-100))
    exact = Fraction(float(x)) * Fraction(float(y)) + Fraction(float(z))
    assert single._rounded(x, y, z) == 1 + 2.0**-11 + 2.0**-23
    assert Fraction(1 + 2.0**-11 + 2.0**-24) < exact


def test_a_device_passes_and_is_remembered(opened, asked_anew, monkeypatch):
    single.trust(opened)
    monkeypatch.setattr(single, "_trusted", set())
    monkeypatch.setattr(single, "failures", lambda *_: pytest.fail("was asked again"))
    single.trust(opened)


FAULTS = {
    "a draw that may be 1": {"philox.low_word": "TO_REAL(lo >> 3)"},
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_library_is_found(opened, asked_anew, monkeypatch, fault):
    monkeypatch.setattr(templates, "MUTATIONS", FAULTS[fault])
    with pytest.raises(DeviceError, match="random words to float is wrong"):
        single.trust(opened)


def test_fused_products_are_found(opened, asked_anew, monkeypatch):
    render = single.render
    monkeypatch.setattr(
        single, "render", lambda *a, **k: render(*a, **k).replace("a * b + c,", "fma(a, b, c),")
        .replace("= a * b + c;", "= fma(a, b, c);")
    )  # fmt: skip
    with pytest.raises(DeviceError, match=r"a \* b \+ c is wrong"):
        single.trust(opened)


def test_a_run_is_refused_where_it_fails(monkeypatch, asked_anew):
    monkeypatch.setattr(single, "failures", lambda *_: ["1 lanes: a / b is wrong"])
    with pytest.raises(pz.PhotizonError, match="run in fp64, or on another device"):
        pz.trace("cosine-fourth", precision="fp32", batches=1, rays_per_batch=77)


def test_what_a_device_does_not_promise_is_not_asked(opened, asked_anew, monkeypatch):
    flags = tuple(f for f in opened.record.fp32_flags if f != "correctly_rounded_divide_sqrt")
    other = dataclasses.replace(opened, record=dataclasses.replace(opened.record, fp32_flags=flags))
    assert single.options_of(opened, "float")[-1] == single.EXACT_FLOATS
    assert single.EXACT_FLOATS not in single.options_of(other, "float")
    assert single.EXACT_FLOATS not in single.options_of(opened, "double")
    wanted = single.answers()
    off = (*wanted[:3], np.nextafter(wanted[3], np.float32(9.0)), *wanted[4:])
    monkeypatch.setattr(single, "answers", lambda: off)
    assert any("a / b is wrong" in text for text in single.failures(opened, 1))
    assert single.failures(other, 1) == []
