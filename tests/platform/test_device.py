from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from hostcode.device import capability, pocl_environment, selftest
from hostcode.device import device as dev
from hostcode.device.device import DeviceRecord
from hostcode.errors import DeviceError

ALL_FP64 = ("denorm", "fma", "inf_nan", "round_to_inf", "round_to_nearest", "round_to_zero")
DEBIAN = DeviceRecord(
    index=0,
    platform_index=0,
    device_index=0,
    name="pthread-skylake-avx512-Some CPU",
    vendor="GenuineIntel",
    platform="Portable Computing Language",
    platform_version="OpenCL 3.0 PoCL 3.1+debian  Linux, LLVM 15.0.6",
    driver="3.1+debian",
    opencl_version="OpenCL 3.0 PoCL HSTR: pthread-x86_64-pc-linux-gnu-skylake-avx512",
    opencl_c_version="OpenCL C 1.2 PoCL",
    type="cpu",
    available=True,
    compiler_available=True,
    fp64_flags=ALL_FP64,
    fp32_flags=("correctly_rounded_divide_sqrt", *ALL_FP64),
    int64_atomics=True,
    preferred_vector_width_double=8,
    native_vector_width_double=8,
    compute_units=8,
    clock_mhz=3000,
    global_memory=16 << 30,
    local_memory=1 << 20,
    max_allocation=4 << 30,
    max_work_group_size=4096,
    is_pocl=True,
    pocl_version=(3, 1),
    origin="debian",
    fp64_per_cycle=8.0,
)
PYPI = replace(
    DEBIAN,
    index=1,
    platform_index=1,
    name="pthread-Some CPU",
    platform_version="OpenCL 3.0 PoCL 3.0-rc2  Linux, LLVM 14.0.6",
    driver="3.0-rc2",
    pocl_version=(3, 0),
    origin="pypi",
    fp64_per_cycle=3.2,
)
H200 = replace(
    DEBIAN,
    index=2,
    platform_index=2,
    name="NVIDIA H200",
    vendor="NVIDIA Corporation",
    platform="NVIDIA CUDA",
    platform_version="OpenCL 3.0 CUDA 12.8.0",
    driver="570.00",
    type="gpu",
    native_vector_width_double=1,
    preferred_vector_width_double=1,
    compute_units=132,
    clock_mhz=1980,
    is_pocl=False,
    pocl_version=(),
    origin="",
    fp64_per_cycle=64.0,
)
INTEL = replace(
    DEBIAN,
    index=4,
    platform_index=3,
    name="AMD EPYC",
    platform="Intel(R) OpenCL",
    driver="2026.22",
    vendor="Intel(R) Corporation",
    clock_mhz=2 * DEBIAN.clock_mhz,
    is_pocl=False,
    pocl_version=(),
    origin="intel",
    fp64_per_cycle=5.6,
)
OLD_GPU = replace(H200, index=3, device_index=1, name="Old GPU", fp64_flags=(), fp64_per_cycle=2.0)


def pick(selector, *records):
    return dev.explain_choice(selector, records=records)


@pytest.fixture(autouse=True)
def _no_selector(monkeypatch):
    monkeypatch.delenv("PHOTIZON_DEVICE", raising=False)


@pytest.mark.parametrize(
    ("records", "best"),
    [
        ((PYPI, DEBIAN), DEBIAN),
        ((DEBIAN, PYPI, H200), H200),
        ((OLD_GPU, PYPI), PYPI),
        ((PYPI,), PYPI),
        # PoCL is the default, whatever clock and width another runtime tells
        ((INTEL, PYPI), PYPI),
        ((INTEL, DEBIAN), DEBIAN),
        ((INTEL,), INTEL),
        ((INTEL, H200), H200),
        # a display adapter with a token fp64 does not beat a CPU of eight wide cores
        ((replace(H200, compute_units=16, fp64_per_cycle=2.0), DEBIAN), DEBIAN),
        ((replace(DEBIAN, index=4), DEBIAN), DEBIAN),
    ],
)
def test_best_by_capability_whatever_the_order(records, best):
    assert pick(None, *records).record == best
    assert pick(None, *reversed(records)).record == best


@pytest.mark.parametrize(
    ("selector", "wanted"),
    [
        ("0", DEBIAN),
        ("1", PYPI),
        ("2", H200),
        ("0:0", DEBIAN),
        ("2:0", H200),
        (" 1:0 ", PYPI),
        ("cpu", DEBIAN),
        ("GPU", H200),
        ("pocl", DEBIAN),
        ("PoCL", DEBIAN),
        ("debian", DEBIAN),
        ("pypi", PYPI),
        ("3.0-rc2", PYPI),
        ("nvidia", H200),
        ("h200", H200),
        ("portable computing", DEBIAN),
    ],
)
def test_selectors(selector, wanted):
    assert pick(selector, PYPI, OLD_GPU, H200, DEBIAN).record == wanted


def test_intel_is_the_runtime_and_not_the_maker_of_a_processor():
    xeon = replace(DEBIAN, name="pthread-Intel(R) Xeon(R)")
    assert pick("intel", xeon, INTEL).record == INTEL
    assert pick("cpu", xeon, INTEL).record == xeon
    assert pick("intel", xeon, PYPI).record == xeon


def test_the_reason_says_when_several_matched():
    choice = pick("pocl", PYPI, DEBIAN)
    assert choice.reason == "the best of 2 that match 'pocl' (from the argument)"
    assert "from" in pick("pypi", PYPI, DEBIAN).reason
    assert pick(None, PYPI, DEBIAN).reason == "the best of 2 by capability"
    assert "passed over Old GPU" in pick("gpu", OLD_GPU, replace(H200, fp64_per_cycle=0.5)).reason


def test_argument_before_environment_before_capability(monkeypatch):
    monkeypatch.setenv("PHOTIZON_DEVICE", "pypi")
    assert pick(None, DEBIAN, PYPI, H200).record == PYPI
    assert "PHOTIZON_DEVICE" in pick(None, DEBIAN, PYPI, H200).reason
    assert pick("debian", DEBIAN, PYPI, H200).record == DEBIAN
    monkeypatch.setenv("PHOTIZON_DEVICE", "  ")
    assert pick(None, DEBIAN, PYPI, H200).record == H200


@pytest.mark.parametrize("selector", ["9", "7:1", "fpga", "accelerator", "²"])
def test_no_match_lists_every_device(selector):
    with pytest.raises(DeviceError) as caught:
        pick(selector, DEBIAN, H200)
    assert repr(selector) in str(caught.value)
    assert DEBIAN.name in str(caught.value)
    assert "2 (2:0) gpu NVIDIA H200" in str(caught.value)


def test_a_chosen_device_that_does_not_qualify_is_refused_with_the_reason():
    with pytest.raises(DeviceError, match=r"Old GPU.*: no fp64"):
        pick("old", OLD_GPU, DEBIAN)


def test_no_device_says_what_to_install_in_one_line():
    with pytest.raises(DeviceError) as caught:
        pick(None)
    assert "\n" not in str(caught.value)
    assert "apt install pocl-opencl-icd" in str(caught.value)
    assert "pip install 'pyopencl[pocl]'" in str(caught.value)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"fp64_flags": ()}, "no fp64"),
        ({"fp64_flags": ALL_FP64[1:]}, "flush subnormal"),
        ({"fp64_flags": ("denorm", "inf_nan", "round_to_nearest")}, "fused multiply-add"),
        ({"fp64_flags": ("denorm", "fma", "round_to_nearest")}, "infinities"),
        ({"fp64_flags": ("denorm", "fma", "inf_nan")}, "round to nearest"),
        ({"int64_atomics": False}, "64-bit integer atomics"),
        ({"global_memory": 100 << 20}, "100 MiB of memory"),
        ({"max_allocation": 16 << 20}, "buffers of at most 16 MiB"),
        ({"compiler_available": False}, "no compiler"),
        ({"available": False}, "not available"),
    ],
)
def test_reasons_for_refusal(change, reason):
    assert dev.qualify(DEBIAN) == []
    (said,) = dev.qualify(replace(DEBIAN, **change))
    assert reason in said


def test_preferred_lanes():
    assert dev.preferred_lanes(DEBIAN) == 16
    assert dev.preferred_lanes(replace(DEBIAN, native_vector_width_double=4)) == 8
    assert dev.preferred_lanes(PYPI) == 8
    assert dev.preferred_lanes(H200) == 1
    assert dev.preferred_lanes(INTEL) == 8


def test_records_pickle_and_keys_tell_devices_apart():
    for record in (DEBIAN, PYPI, H200):
        assert pickle.loads(pickle.dumps(record)) == record
    assert len({DEBIAN.key, PYPI.key, H200.key, replace(DEBIAN, driver="3.2").key}) == 4
    assert replace(DEBIAN, index=5, platform_index=3).key == DEBIAN.key


def test_pocl_versions_and_origins(monkeypatch):
    version = "OpenCL 3.0 PoCL 3.0-rc2  Linux, Release, RELOC, LLVM 14.0.6"
    assert capability._pocl_version(version) == (3, 0)
    assert capability._pocl_version("OpenCL 3.0 PoCL 3.1+debian  Linux") == (3, 1)
    assert capability._pocl_version("OpenCL 3.0 PoCL 6.0") == (6, 0)
    assert capability._pocl_version("OpenCL 3.0 CUDA 12.8") == ()
    monkeypatch.setattr(capability.importlib.metadata, "version", lambda name: "3.0")
    assert capability._origin(version, (3, 0)) == "pypi"
    assert capability._origin("OpenCL 3.0 PoCL 3.1+debian", (3, 1)) == "debian"
    assert capability._origin("OpenCL 3.0 PoCL 3.1", (3, 1)) == ""


def test_thread_environment():
    assert pocl_environment.pocl_thread_environment(2) == {
        "POCL_MAX_PTHREAD_COUNT": "2",
        "POCL_CPU_MAX_CU_COUNT": "2",
    }
    with pytest.raises(ValueError, match="at least 1, not 0"):
        pocl_environment.pocl_thread_environment(0)


class _BrokenPlatform:
    name = "Broken"

    def get_devices(self):
        import pyopencl as cl

        raise cl.RuntimeError("clGetDeviceIDs failed: OUT_OF_HOST_MEMORY")


def test_a_platform_that_fails_is_reported_and_not_fatal(monkeypatch):
    import pyopencl as cl

    usual, real = dev.enumerate_devices(), cl.get_platforms()
    monkeypatch.setattr(cl, "get_platforms", lambda: [_BrokenPlatform(), *real])
    found = capability._read_platforms()
    assert len(found.problems) == 1
    assert "OUT_OF_HOST_MEMORY" in found.problems[0]
    assert [record.platform_index for record in found.records] == [
        record.platform_index + 1 for record in usual
    ]


def test_threads_that_ask_at_once_have_one_cache(run_python):
    run_python("""
import time
from concurrent.futures import ThreadPoolExecutor
from hostcode.device import capability
calls = []
capability.provide_cache = lambda: (calls.append(1), time.sleep(0.2))
with ThreadPoolExecutor(4) as pool:
    found = list(pool.map(lambda _: capability.survey(), range(4)))
assert calls == [1], calls
assert all(one is found[0] for one in found)
""")


def test_no_platform_at_all_is_an_empty_survey(run_python, tmp_path):
    empty = tmp_path / "none.icd"
    empty.write_text("")
    code = """
from hostcode.device.device import choose, survey
from hostcode.errors import DeviceError
assert survey().records == ()
try:
    choose()
except DeviceError as error:
    print(error)
"""
    said = run_python(code, {"OCL_ICD_VENDORS": str(empty)})
    assert said.startswith("no OpenCL device found")
    assert "apt install" in said


def test_importing_and_surveying_creates_no_context(run_python):
    code = """
import sys
import hostcode.device.device
assert "pyopencl" not in sys.modules
import pyopencl
def refuse(*args, **kwargs):
    raise AssertionError("a context was created")
pyopencl.Context = refuse
hostcode.device.device.survey()
hostcode.device.device.enumerate_devices()
"""
    run_python(code)


def test_this_machine_has_a_device_that_qualifies(device):
    record = device.record
    assert dev.qualify(record, self_test=True) == []
    assert record in dev.enumerate_devices()
    assert record.compute_units >= 1
    assert device.context.devices == [device.device]


def test_indices_count_over_all_platforms():
    records = dev.enumerate_devices()
    assert [record.index for record in records] == list(range(len(records)))
    for record in records:
        assert dev.choose(f"{record.platform_index}:{record.device_index}") == record


def test_profiling_is_off_unless_asked_for(device):
    import pyopencl as cl

    timed = dev.open_device(device.record, profiling=True)
    flag = cl.command_queue_properties.PROFILING_ENABLE
    assert timed.profiling
    assert timed.queue.properties & flag
    assert not device.queue.properties & flag


def test_a_record_that_is_not_here_is_named():
    with pytest.raises(DeviceError, match=r"No such thing.* is not here"):
        dev.open_device(replace(DEBIAN, name="No such thing"))


def test_a_device_is_found_again_under_another_index(device):
    moved = replace(device.record, index=17, platform_index=9)
    assert dev.open_device(moved).device == device.device


def test_a_failed_selftest_refuses_the_device_and_another_is_taken(monkeypatch, device):
    refused = device.record.key

    def fail(opened):
        failures = ("sqrt is wrong",) if opened.record.key == refused else ()
        return selftest.SelfTestReport(failures)

    monkeypatch.setattr(selftest, "passed_before_or_run", fail)
    assert dev.qualify(device.record, self_test=True) == ["self-test failed: sqrt is wrong"]
    with pytest.raises(DeviceError, match="refused: self-test failed: sqrt is wrong") as caught:
        dev.open_device(device.record)
    assert caught.value.reason == "self-test failed: sqrt is wrong"
    with pytest.raises(DeviceError, match="sqrt is wrong"):
        dev.choose(str(device.record.index))
    records = sorted(dev.enumerate_devices(), key=dev._rank)
    if any(other.key != refused for other in records):
        choice = dev.explain_choice()
        assert choice.record.key != refused
        assert ("passed over" in choice.reason) == (records[0].key == refused)
    dev.open_device(device.record, self_test=False)


def test_too_many_compute_units_are_refused(device):
    with pytest.raises(DeviceError, match=r"no part of 100000 compute units"):
        dev.open_device(device.record, compute_units=100000)
