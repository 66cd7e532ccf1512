"""Intel's CPU runtime: found where pip put it, never the default, told of where it is faster."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from hostcode.device import device as dev
from hostcode.device import intel_runtime, known_passes, selftest
from photizon_cl.cli.main import main
from photizon_cl.run import speed

VENDORS = "OCL_ICD_VENDORS"


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """Have a library that pip installed, and a machine that registers one other runtime."""
    for name in (VENDORS, "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES"):
        monkeypatch.delenv(name, raising=False)
    library = tmp_path / "libintelocl.so"
    library.write_text("no library")
    system = tmp_path / "vendors"
    system.mkdir()
    (system / "other.icd").write_text("libother.so\n")
    (system / "README").write_text("no registration")
    monkeypatch.setattr(intel_runtime, "intel_library", lambda: library)
    monkeypatch.setattr(intel_runtime, "_SYSTEM", system)
    monkeypatch.setattr(intel_runtime, "_unwritable", [])
    return library, system


def test_the_loader_is_given_what_the_system_has_and_intels(installed):
    library, _ = installed
    with intel_runtime.registered():
        folder = Path(os.environ[VENDORS])
        read = {file.name: file.read_text() for file in folder.iterdir()}
    assert read == {"other.icd": "libother.so\n", "photizon-intel.icd": f"{library}\n"}
    assert VENDORS not in os.environ
    assert not folder.exists()


def test_what_raises_while_platforms_are_listed_leaves_nothing(installed):
    with pytest.raises(KeyError), intel_runtime.registered():
        raise KeyError
    assert VENDORS not in os.environ


@pytest.mark.parametrize("name", [VENDORS, "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES"])
def test_a_loader_that_is_told_where_to_look_is_left_alone(installed, monkeypatch, name):
    monkeypatch.setenv(name, "/somewhere/some.icd")
    before = dict(os.environ)
    with intel_runtime.registered():
        assert dict(os.environ) == before
    assert dict(os.environ) == before


def test_a_runtime_that_the_system_registers_is_the_one(installed):
    (installed[1] / "intel64.icd").write_text("/opt/intel/lib/libintelocl.so\n")
    with intel_runtime.registered():
        assert VENDORS not in os.environ


def test_without_the_package_or_a_place_to_write_nothing_is_done(installed, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(intel_runtime, "intel_library", lambda: None)
        with intel_runtime.registered():
            assert VENDORS not in os.environ

    def full(**_):
        raise OSError("no space")

    monkeypatch.setattr(intel_runtime.tempfile, "TemporaryDirectory", full)
    with intel_runtime.registered():
        assert VENDORS not in os.environ


def test_a_package_whose_files_are_gone_is_none(monkeypatch):
    monkeypatch.setattr(intel_runtime.importlib.metadata, "files", lambda _: None)
    assert intel_runtime.intel_library() is None


@pytest.mark.parametrize("name", [VENDORS, "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES"])
def test_nothing_is_said_where_the_environment_names_registrations(installed, monkeypatch, name):
    monkeypatch.setattr(intel_runtime.ctypes, "CDLL", lambda _: None)
    assert intel_runtime.trouble([])
    monkeypatch.setenv(name, "some.icd")
    assert intel_runtime.trouble([]) == ""


def test_that_there_is_no_place_to_register_it_is_said(installed, monkeypatch, tmp_path):
    monkeypatch.setattr(intel_runtime, "_unwritable", [])
    monkeypatch.setattr(intel_runtime.ctypes, "CDLL", lambda _: None)
    monkeypatch.setattr(intel_runtime.tempfile, "tempdir", str(tmp_path / "none"))
    with intel_runtime.registered():
        assert VENDORS not in os.environ
    assert "set TMPDIR" in intel_runtime.trouble([])


def test_why_it_is_not_listed_is_said(installed, monkeypatch):
    assert intel_runtime.trouble(["PoCL", intel_runtime.PLATFORM]) == ""
    said = intel_runtime.trouble(["PoCL"])
    assert "does not load" in said
    assert "pip install intel-opencl-rt intel-cmplr-lib-rt" in said
    monkeypatch.setattr(intel_runtime.ctypes, "CDLL", lambda _: None)
    assert "had listed its platforms before" in intel_runtime.trouble([])
    monkeypatch.setattr(intel_runtime, "_system_has_one", lambda: True)
    assert "what the system registers does not load" in intel_runtime.trouble([])


# -- where it is installed -------------------------------------------------------------------------

SURVEY = """
from hostcode.device.device import survey, explain_choice
print(*(r.origin for r in survey().records), *survey().problems, explain_choice().record.origin)
"""


@pytest.fixture
def intel(usable_devices):
    for record in usable_devices:
        if record.origin == "intel":
            return record
    pytest.skip("Intel's OpenCL runtime is not here (pip install 'photizon-cl[intel]')")


def test_it_is_found_beside_the_others_and_is_not_the_default(intel, run_python, usable_devices):
    *found, default = run_python(SURVEY).split()
    assert found == [record.origin for record in dev.enumerate_devices()]
    if any(record.is_pocl for record in usable_devices):
        assert default in ("debian", "pypi")


def test_it_knows_the_answers_at_every_width(intel):
    assert selftest.run(dev.open_device(intel), (1, 2, 4, 8, 16)).failures == ()


def test_it_compiles_without_a_word(intel, recwarn):
    from oracles.engine import trace

    trace("cosine-fourth", device=dev.open_device(intel), rays_per_batch=64)
    assert not recwarn.list


# -- what check says -------------------------------------------------------------------------------


@pytest.fixture
def both(monkeypatch, device):
    """Have a default of PoCL and Intel's runtime, neither of which is asked anything."""
    pocl = replace(device.record, type="cpu", is_pocl=True, origin="debian")
    other = replace(
        pocl, index=1, is_pocl=False, origin="intel", platform=intel_runtime.PLATFORM, driver="1"
    )
    monkeypatch.delenv("PHOTIZON_DEVICE", raising=False)
    monkeypatch.setattr(speed.intel_runtime, "intel_is_installed", lambda: True)
    monkeypatch.setattr(speed, "survey", lambda: dev.Survey((pocl, other), ()))
    monkeypatch.setattr(known_passes, "_read", lambda part: {})
    return pocl, other


@pytest.mark.parametrize(("times", "told"), [(0.7, False), (1.1, False), (1.5, True)])
def test_check_tells_where_it_is_faster(both, monkeypatch, capsys, times, told):
    rates = {both[0].key: 2e7, both[1].key: times * 2e7}
    monkeypatch.setattr(known_passes, "rate_of", lambda key, test: rates[key])
    assert main(["check", "cosine-fourth"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    line = "device: Intel(R) OpenCL traces 1.5 times as fast as PoCL on this machine, measured on "
    assert (line in text) == told
    assert ("--device intel" in text) == told


def test_nothing_is_asked_where_it_is_not_installed(monkeypatch):
    monkeypatch.setattr(speed.intel_runtime, "intel_is_installed", lambda: False)
    monkeypatch.setattr(speed, "survey", lambda: pytest.fail("OpenCL was asked"))
    assert speed.faster_runtime() == ""


def test_it_is_said_before_it_is_timed(both, monkeypatch, capsys):
    said = []

    def measured(records):
        said.append(capsys.readouterr().err)
        return [2e7, 2e7]

    monkeypatch.setattr(speed, "_measured", measured)
    monkeypatch.setattr(known_passes, "remember_rate", lambda *_: None)
    assert main(["check", "cosine-fourth"]) == 0
    (text,) = said
    assert text.startswith(f"timing {both[0].platform} and {both[1].platform} on box-room, once")
    assert text.count("\n") == 1
    monkeypatch.setattr(known_passes, "rate_of", lambda *_: 2e7)
    assert main(["check", "cosine-fourth"]) == 0
    assert capsys.readouterr().err == ""


def test_who_chose_it_is_not_told(both, monkeypatch):
    monkeypatch.setenv("PHOTIZON_DEVICE", "intel")
    monkeypatch.setattr(speed, "rates", lambda records: pytest.fail("measured"))
    assert speed.faster_runtime() == ""


def test_a_device_that_fails_is_not_told(both, monkeypatch):
    def fail(*_):
        raise speed.PhotizonError("refused")

    monkeypatch.setattr(speed, "make_engine", fail)
    assert speed.faster_runtime() == ""


def test_rates_are_measured_once(device, monkeypatch, tmp_path):
    monkeypatch.setattr(known_passes, "cache_file", lambda: tmp_path / "selftest.json")
    known_passes.remember("a device", "its verdict")
    (rate,) = speed.rates([device.record])
    assert rate > 0
    monkeypatch.setattr(speed, "make_engine", lambda *_: pytest.fail("measured again"))
    assert speed.rates([device.record]) == [rate]
    assert known_passes.of("a device") == "its verdict"
    assert known_passes.rate_of(device.record.key, "another test") is None
    known_passes.remember("a device", "another verdict")
    assert speed.rates([device.record]) == [rate]
    assert known_passes.count() == 1
