from __future__ import annotations

import json
import os
import re

import pytest

from hostcode.device import kept_kernels, known_passes, selftest
from hostcode.device.device import open_device
from hostcode.errors import CacheWarning


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(selftest, "_passed", set())
    return known_passes.cache_file()


@pytest.mark.parametrize(
    "lanes", [1, 8, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 4, 16))]
)
def test_every_device_knows_the_answers_at_every_width(usable_devices, lanes):
    assert usable_devices
    for record in usable_devices:
        report = selftest.run(open_device(record), (lanes,))
        assert report.failures == (), record.label


MUTANTS = {
    "= a + b;|= b + b;": r"a \+ b",
    "a / b|a * (1.0 / b)": "a / b",
    "sqrt(fabs(a))|fabs(a) * rsqrt(fabs(a))": "sqrt",
    "fma(a, b, c)|a * b + c": r"fma\(a, b, c\)",
    "a * b + c|fma(a, b, c)": "not fused",
    "a * b - c|fma(a, b, -c)": "not fused",
    "c - a * b|fma(-a, b, c)": "not fused",
    "SEL(LT(a, b), a, b)|SEL(LE(b, a), a, b)": "a < b",
    "floor(x)|trunc(x)": "floor",
    "rint(x)|round(x)": "rint",
    "AS_LUINT(TO_REAL(u))|AS_LUINT(TO_REAL(u >> 1) * 2.0)": "double of ulong",
    "mul_hi(low, high)|mul_hi(low, high) - 1u": "mul_hi",
    "0xD2511F53u|0xD2511F57u": "Philox4x32-10 word",
    "lo >> 11|lo >> 10": "Philox word to double",
    "splat(TO_INTEGER)|splat(0x1.9p52)": "of turns",
    "atom_add(cell + 1, image.p1)|atom_add(cell + 1, image.p1 + 1)": "tally is off",
    "atom_add(cell, image.p0)|cell[0] = image.p0": "tally is off",
    "(long)(bits & 0xFFFFFFFFUL)|(long)bits": "32-bit pieces",
    "const size_t item|const nonsense item": "does not build",
}


# what is wrong stands in the text, whatever an optimiser makes of it
@pytest.mark.usefixtures("itself_built_quickly")
@pytest.mark.parametrize(
    "mutant",
    [pytest.param(m, marks=pytest.mark.slow if n % 2 else ()) for n, m in enumerate(MUTANTS)],
)
def test_a_device_that_gets_one_thing_wrong_fails_and_says_what(monkeypatch, device, mutant):
    sound = selftest.source(1)
    before, after = mutant.split("|")
    assert before in sound
    monkeypatch.setattr(selftest, "source", lambda lanes: sound.replace(before, after))
    report = selftest.run(device, (1,))
    assert not report.passed
    assert any(re.search(MUTANTS[mutant], text) for text in report.failures)


def test_a_failure_shows_operands_and_both_answers(monkeypatch, device):
    sound = selftest.source(1)
    broken = sound.replace("a / b", "a * (1.0 / b)")
    monkeypatch.setattr(selftest, "source", lambda lanes: broken)
    (failure,) = selftest.run(device, (1,)).failures
    assert failure.startswith("1 lanes: a / b is wrong in ")
    assert "of (" in failure
    assert "it gives " in failure
    assert ", not " in failure


def test_a_program_without_its_kernels_is_a_failure(monkeypatch, device):
    monkeypatch.setattr(selftest, "source", lambda lanes: "__kernel void another(void) {}")
    (failure,) = selftest.run(device, (1,)).failures
    assert failure == "1 lanes: the program was built, but has none of its kernels"


def test_source_begins_with_no_contraction_and_has_the_production_libraries():
    for lanes in (1, 8):
        text = selftest.source(lanes)
        code = [line for line in text.splitlines() if line and not line.startswith(("//", "#line"))]
        assert code[0] == "#pragma OPENCL FP_CONTRACT OFF"
        for name in ("void philox4x32_10", "void sincos_turns", "image_t image_of"):
            assert f"FN {name}(" in text
    assert not any("math" in option for option in selftest.BUILD_OPTIONS)


def test_a_pass_is_remembered_and_not_run_again(fresh, monkeypatch, device):
    assert not selftest.passed_before_or_run(device).known
    content = json.loads(fresh.read_text())
    assert device.record.key in content["passed"]
    assert os.listdir(fresh.parent) == [fresh.name]
    monkeypatch.setattr(selftest, "_passed", set())  # as in another process
    monkeypatch.setattr(selftest, "run", lambda *_: pytest.fail("ran again"))
    report = selftest.passed_before_or_run(device)
    assert report.known
    assert report.passed


def test_another_version_of_the_test_runs_again(fresh, monkeypatch, device):
    selftest.passed_before_or_run(device)
    monkeypatch.setattr(selftest, "_digest", lambda lanes: "another")
    assert not selftest.passed_before_or_run(device).known
    assert json.loads(fresh.read_text())["passed"][device.record.key].startswith("another ")


def test_a_pass_is_about_the_very_binaries_that_passed(fresh, monkeypatch, device):
    selftest.passed_before_or_run(device)
    keys = [selftest._program(device, width) for width in selftest._lane_widths(device)]
    digests = [kept_kernels.digest_of(key) for key in keys]
    passed = json.loads(fresh.read_text())["passed"][device.record.key].split()
    assert passed[1:] == [digest or "-" for digest in digests]
    if not all(digests):
        pytest.skip("the driver keeps its binaries itself")
    file = kept_kernels._file(keys[0])
    data = file.read_bytes()
    file.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
    monkeypatch.setattr(selftest, "_passed", set())  # as in another process
    with pytest.warns(CacheWarning, match="are damaged"):
        assert not selftest.passed_before_or_run(device).known
    monkeypatch.setattr(selftest, "_passed", set())
    file.write_bytes(data)


def test_a_pass_is_not_about_what_the_environment_has_built(fresh, monkeypatch, device):
    """PoCL would add these options, such as those of inexact mathematics, to every program."""
    if not device.record.is_pocl:
        pytest.skip("the driver adds nothing")
    selftest.passed_before_or_run(device)
    monkeypatch.setattr(selftest, "_passed", set())  # as in another process
    assert selftest.passed_before_or_run(device).known
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable")
    monkeypatch.setattr(selftest, "_passed", set())
    assert not selftest.passed_before_or_run(device).known


def test_a_pass_of_binaries_that_could_not_be_kept_is_not_remembered(fresh, monkeypatch, device):
    monkeypatch.setattr(kept_kernels, "digest_of", lambda _: "")
    monkeypatch.setattr(kept_kernels, "are_kept", lambda _: True)
    monkeypatch.setattr(selftest, "run", lambda *_: selftest.SelfTestReport(()))
    lanes = selftest._lane_widths(device)
    verdict = " ".join([selftest._digest(lanes), *"-" * len(lanes)])
    assert not selftest.passed_before_or_run(device).known
    assert not fresh.exists()
    known_passes.remember(device.record.key, verdict)
    monkeypatch.setattr(selftest, "_passed", set())  # as in another process
    assert not selftest.passed_before_or_run(device).known
    monkeypatch.setattr(selftest, "_passed", set())
    monkeypatch.setattr(kept_kernels, "are_kept", lambda _: False)  # a driver keeps its own
    assert selftest.passed_before_or_run(device).known


def test_a_failure_is_not_remembered(fresh, monkeypatch, device):
    failed = selftest.SelfTestReport(("wrong",))
    monkeypatch.setattr(selftest, "run", lambda *_: failed)
    assert selftest.passed_before_or_run(device) == failed
    assert not fresh.exists()
    monkeypatch.undo()
    assert selftest.passed_before_or_run(device).passed


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"passed": 3}', '{"passed": null}', "\udcff"])
def test_a_damaged_cache_is_overwritten(fresh, device, damage):
    fresh.parent.mkdir(parents=True)
    fresh.write_bytes(damage.encode("utf-8", "surrogateescape"))
    assert not selftest.passed_before_or_run(device).known
    assert device.record.key in json.loads(fresh.read_text())["passed"]


def test_an_unwritable_cache_is_no_error(monkeypatch, tmp_path, device):
    blocked = tmp_path / "file"
    blocked.write_text("not a directory")  # holds for root as well, whom no permission stops
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    monkeypatch.setattr(selftest, "_passed", set())
    assert selftest.passed_before_or_run(device).passed
    assert selftest.passed_before_or_run(device).known  # kept for this process at least


def test_cache_file_follows_the_xdg_rules(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    for value in ("", "relative/path"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert known_passes.cache_file() == tmp_path / ".cache" / "photizon_cl" / "selftest.json"
