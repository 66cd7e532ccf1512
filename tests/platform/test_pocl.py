"""Debian's PoCL and that of PyPI: one at a time, both together, one thread and two."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hostcode.device import device as dev
from hostcode.device import pocl_mend, selftest
from hostcode.device.pocl_environment import (
    only_platform_environment,
    pocl_icd_files,
    pocl_thread_environment,
)

SURVEY = """
from hostcode.device.device import survey, qualify
for record in survey().records:
    print(record.origin, record.compute_units, qualify(record, self_test=True))
"""


def test_each_pocl_passes_at_both_widths_in_one_process(pocl):
    assert selftest.run(dev.open_device(pocl), (1, 8, 16)).failures == ()


def test_each_pocl_alone_in_a_process(pocl, run_python):
    icd = pocl_icd_files()[pocl.origin]
    said = run_python(SURVEY, only_platform_environment(icd))
    assert said == f"{pocl.origin} {pocl.compute_units} []\n"


def test_threads_can_be_limited_from_outside(pocl, run_python):
    icd = pocl_icd_files()[pocl.origin]
    environment = only_platform_environment(icd) | pocl_thread_environment(1)
    assert run_python(SURVEY, environment) == f"{pocl.origin} 1 []\n"


def test_threads_can_be_limited_from_inside(pocl):
    if pocl.compute_units < 2:
        pytest.skip("one core only")
    part = dev.open_device(pocl, compute_units=1)
    assert part.device.max_compute_units == 1
    assert selftest.run(part, (8,)).failures == ()


def test_debian_is_preferred_to_pypi(usable_devices):
    origins = {record.origin: record for record in usable_devices}
    if not {"debian", "pypi"} <= set(origins):
        pytest.skip("both PoCLs are needed")
    assert dev.choose("pocl") == origins["debian"]


def test_icd_files_exist_and_name_a_library():
    for path in pocl_icd_files().values():
        assert path.suffix == ".icd"
        assert re.search(r"pocl", path.read_text(), re.IGNORECASE)


class _Mended:
    """The conditions for the mend, all true; nothing real is touched."""

    def __init__(self, monkeypatch, tmp_path, *, cpu=b"generic", flags="avx512f", version="3.0"):
        self.calls = []
        self.cpu = cpu
        (tmp_path / "pocl.icd").write_text("libpocl.so")
        monkeypatch.setattr(pocl_mend, "pypi_pocl_icd", lambda: tmp_path / "pocl.icd")
        monkeypatch.setattr(pocl_mend.importlib.metadata, "version", lambda name: version)
        monkeypatch.setattr(pocl_mend.ctypes, "CDLL", lambda path: self)
        monkeypatch.setattr(pocl_mend, "_library_cpu", lambda: flags)
        monkeypatch.setattr(
            pocl_mend, "_replace", lambda function, name: self.calls.append(name) or 1
        )
        monkeypatch.delenv("OCL_ICD_VENDORS", raising=False)

    def __getattr__(self, name):
        assert name == "pocl_get_llvm_cpu_name"

        def function():
            return self.cpu

        return function


@pytest.mark.skipif(
    pocl_mend.platform.machine() != "x86_64" or pocl_mend.sys.platform != "linux",
    reason="the mend is for Linux on x86-64",
)
class TestMend:
    @pytest.mark.parametrize(
        ("cpu", "flags"),
        [
            (b"generic", "haswell"),
            # what LLVM 14 takes Zen 4 for knows no AVX-512, with which the library is linked
            (b"znver3", "skylake-avx512"),
        ],
    )
    def test_replaces_a_cpu_that_is_not_the_library_s(self, monkeypatch, tmp_path, cpu, flags):
        mended = _Mended(monkeypatch, tmp_path, cpu=cpu, flags=flags)
        assert pocl_mend.mend_pypi_pocl.__wrapped__() == flags
        assert mended.calls == [flags]

    @pytest.mark.parametrize(
        "condition",
        [
            {"cpu": b"znver3", "flags": "haswell"},
            {"cpu": b"icelake-server"},
            {"flags": ""},
            {"version": "4.0"},
            {"version": "1.3.post1"},
        ],
    )
    def test_leaves_everything_else_alone(self, monkeypatch, tmp_path, condition):
        mended = _Mended(monkeypatch, tmp_path, **condition)
        assert pocl_mend.mend_pypi_pocl.__wrapped__() == ""
        assert mended.calls == []

    def test_does_not_load_a_library_that_is_not_asked_for(self, monkeypatch, tmp_path):
        mended = _Mended(monkeypatch, tmp_path)
        monkeypatch.setenv("OCL_ICD_VENDORS", "/etc/OpenCL/vendors/pocl.icd")
        assert pocl_mend.mend_pypi_pocl.__wrapped__() == ""
        assert mended.calls == []
        monkeypatch.setenv("OCL_ICD_VENDORS", str(tmp_path / "pocl.icd"))
        assert pocl_mend.mend_pypi_pocl.__wrapped__() == "avx512f"


@pytest.mark.parametrize(
    ("flags", "cpu"),
    [
        (pocl_mend._AVX512 | pocl_mend._AVX2, "skylake-avx512"),
        (pocl_mend._AVX2, "haswell"),
        # PoCL would take its AVX-512 library, which no Haswell code can call
        ({"avx512f"} | pocl_mend._AVX2, ""),
        ({"sse2"}, ""),
    ],
)
def test_the_cpu_is_that_of_the_library_pocl_takes(monkeypatch, flags, cpu):
    text = "processor : 0\nflags\t\t: fpu " + " ".join(sorted(flags)) + "\n"
    monkeypatch.setattr(Path, "read_text", lambda self, encoding=None: text)
    assert pocl_mend._library_cpu() == cpu
