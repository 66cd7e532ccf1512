"""What every OpenCL device of this machine is able to do, as plain records.

Reading capabilities creates no context and compiles nothing. Records are immutable, comparable and
pickle, so that a worker process can be told which device to open.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import re
import threading
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

from hostcode.device import intel_runtime
from hostcode.device.kernel_cache import provide_cache
from hostcode.device.pocl_mend import mend_pypi_pocl
from hostcode.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

__all__ = ["FP32_EXACT", "INSTALL_HINT", "DeviceRecord", "Survey", "survey"]

INSTALL_HINT: Final = (
    "install a CPU device with `sudo apt install pocl-opencl-icd` (Debian, Ubuntu) "
    "or `pip install 'pyopencl[pocl]'` (no root needed), or a GPU vendor's OpenCL driver"
)
"""The one line that tells a person without a usable device what to do."""

FP32_EXACT: Final = frozenset(
    {"correctly_rounded_divide_sqrt", "denorm", "fma", "inf_nan", "round_to_nearest"}
)
"""What a device must promise of its floats for them to have the bits that IEEE 754 fixes."""
_FP_FLAGS: Final = (
    "correctly_rounded_divide_sqrt",
    "denorm",
    "fma",
    "inf_nan",
    "round_to_inf",
    "round_to_nearest",
    "round_to_zero",
    "soft_float",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceRecord:
    """Capability record of one OpenCL device.

    Parameters
    ----------
    index : int
        Number of the device over all platforms, from 0, in the order of the ICD loader.
    platform_index, device_index : int
        The same position as platform and device within it (the ``0:1`` of a selector).
    name, vendor, platform, platform_version, driver : str
        As the runtime reports them, outer blanks removed.
    opencl_version, opencl_c_version : str
        For example ``OpenCL 3.0 PoCL HSTR: …`` and ``OpenCL C 1.2 PoCL``.
    type : str
        ``cpu``, ``gpu``, ``accelerator`` or ``other``.
    available, compiler_available : bool
        Whether the device can be used at all, and whether it can compile kernels.
    fp64_flags : tuple of str
        What the device promises of its doubles: ``denorm``, ``fma``, ``inf_nan``,
        ``round_to_inf``, ``round_to_nearest``, ``round_to_zero``, ``soft_float``; empty without
        fp64.
    fp32_flags : tuple of str
        What it promises of its floats: the same, and ``correctly_rounded_divide_sqrt``.
    int64_atomics : bool
        Whether ``cl_khr_int64_base_atomics`` is there.
    preferred_vector_width_double, native_vector_width_double : int
        Lanes; 0 without fp64.
    compute_units : int
        Cores (threads) of a CPU, multiprocessors of a GPU.
    clock_mhz : int
        Highest clock in MHz, 0 where the runtime does not know.
    global_memory, local_memory, max_allocation : int
        Bytes.
    max_work_group_size : int
        Work-items.
    is_pocl : bool
        Whether the runtime is PoCL.
    pocl_version : tuple of int
        For example ``(3, 1)``; empty for other runtimes.
    origin : str
        Who packaged a PoCL, ``debian`` or ``pypi``; ``intel`` for a runtime of Intel's; ``""`` for
        any other.
    fp64_per_cycle : float
        Estimate of fused multiply-adds per compute unit and cycle; only ever used to rank devices.
    """

    index: int
    platform_index: int
    device_index: int
    name: str
    vendor: str
    platform: str
    platform_version: str
    driver: str
    opencl_version: str
    opencl_c_version: str
    type: str
    available: bool
    compiler_available: bool
    fp64_flags: tuple[str, ...]
    fp32_flags: tuple[str, ...]
    int64_atomics: bool
    preferred_vector_width_double: int
    native_vector_width_double: int
    compute_units: int
    clock_mhz: int
    global_memory: int
    local_memory: int
    max_allocation: int
    max_work_group_size: int
    is_pocl: bool
    pocl_version: tuple[int, ...]
    origin: str
    fp64_per_cycle: float

    @property
    def fp64(self) -> bool:
        """Whether the device computes in double precision at all."""
        return bool(self.fp64_flags)

    @property
    def fp32_exact(self) -> bool:
        """Whether single precision is fixed to the bit: no flush to zero, quotients and roots too.

        `FP32_EXACT` names the flags, of CL_DEVICE_SINGLE_FP_CONFIG.
        """
        return set(self.fp32_flags) >= FP32_EXACT

    def promises(self, real: str) -> bool:
        """Say whether programs in a C type give the bits that every such device gives.

        Parameters
        ----------
        real : str
            ``double``, which OpenCL fixes, or ``float``.
        """
        return real == "double" or self.fp32_exact

    @property
    def key(self) -> str:
        """Stable identity for caches: changes with the device, its driver and its compiler."""
        return f"{self.platform} {self.platform_version}|{self.name}|{self.driver}"

    @property
    def label(self) -> str:
        """One line for people and for result files."""
        return f"{self.name} ({self.platform}, {self.driver})"

    @property
    def search_text(self) -> str:
        """Text that a selector is looked for in, lower case."""
        parts = (self.platform, self.platform_version, self.name, self.driver)
        text = "/".join((*parts, self.vendor, self.origin))
        # PoCL calls its platform by its long name, and people call it PoCL.
        return ("pocl/" + text if self.is_pocl else text).lower()

    @property
    def fp64_gflops(self) -> float:
        """Estimated fp64 rate in Gflop/s, for ranking only."""
        # 1 GHz where the clock is unknown: the order among unknowns is then that of the widths.
        return 2.0 * self.compute_units * self.fp64_per_cycle * (self.clock_mhz or 1000) * 1e-3


@dataclass(frozen=True, slots=True)
class Survey:
    """Every device found, and every platform or device that could not be read.

    Parameters
    ----------
    records : tuple of DeviceRecord
        In the order of the ICD loader.
    problems : tuple of str
        One line for each platform or device that failed to enumerate, with the reason.
    """

    records: tuple[DeviceRecord, ...]
    problems: tuple[str, ...]


@cache
def survey() -> Survey:
    """Read the capabilities of every device of every platform; creates no context.

    Returns
    -------
    Survey
        Records and problems. A platform that fails is a problem, never an exception; so is an
        OpenCL loader that cannot be loaded. Looked up once per process.
    """
    with _first:  # threads that call it at once: PoCL stays with the cache it was first given
        return _survey()


_first: Final = threading.Lock()


@cache
def _survey() -> Survey:
    try:
        provide_cache()
        import pyopencl  # noqa: F401  (whether it can be)
    except OSError as error:
        return Survey((), (str(error),))
    except ImportError as error:  # a wheel for the wrong system, a missing libOpenCL
        return Survey((), (f"pyopencl cannot be imported: {error}",))
    # Both before the loader first looks at its platforms; mostly they do nothing.
    mend_pypi_pocl()
    return _read_platforms()


def _read_platforms() -> Survey:
    import pyopencl as cl

    try:
        with intel_runtime.registered():
            platforms = cl.get_platforms()
    except cl.Error as error:
        # The ICD loader reports "no platform" as an error of its own.
        if "PLATFORM_NOT_FOUND" not in str(error):
            return Survey((), (f"the OpenCL loader cannot list its platforms: {error}",))
        platforms = []

    records: list[DeviceRecord] = []
    problems: list[str] = []
    listed: list[str] = []
    for platform_index, platform in enumerate(platforms):
        try:
            name = platform.name.strip()
            listed.append(name)
            devices = platform.get_devices()
        except cl.Error as error:
            if "DEVICE_NOT_FOUND" not in str(error):
                problems.append(f"platform {platform_index} cannot list its devices: {error}")
            continue
        for device_index, device in enumerate(devices):
            try:
                record = _record(device, len(records), platform_index, device_index)
            except (cl.Error, AttributeError, ValueError) as error:
                problems.append(f"device {platform_index}:{device_index} of {name}: {error}")
            else:
                records.append(record)
    missing = intel_runtime.trouble(listed)
    if missing:
        problems.append(missing)
    return Survey(tuple(records), tuple(problems))


def is_nvidia(vendor: str) -> bool:
    """Return whether a device is NVIDIA's, as its runtime names the vendor."""
    return "nvidia" in vendor.lower()


def find_device(record: DeviceRecord) -> cl.Device:
    """Return the runtime's own object for a record, also in another process than it came from.

    Parameters
    ----------
    record : DeviceRecord
        A record of this machine.

    Returns
    -------
    pyopencl.Device
        The device at the record's position if it is the same one, else one with the same key.

    Raises
    ------
    DeviceError
        If no device here has the record's key.
    """
    import pyopencl as cl

    here = survey().records
    for candidate in sorted(here, key=lambda other: other.index != record.index):
        if candidate.key == record.key:
            platform = cl.get_platforms()[candidate.platform_index]
            return platform.get_devices()[candidate.device_index]
    known = "; ".join(other.key for other in here) or "none"
    raise DeviceError(f"device {record.key!r} is not here (devices here: {known})")


def _record(device: cl.Device, index: int, platform_index: int, device_index: int) -> DeviceRecord:
    platform = device.platform
    extensions = device.extensions.split()
    flags = _fp64_flags(device, extensions)
    is_pocl = "pocl" in f"{platform.version} {platform.name}".lower()
    pocl_version = _pocl_version(platform.version) if is_pocl else ()
    kind = _type_name(device)
    native = _width(device, "native_vector_width_double") if flags else 0
    return DeviceRecord(
        index=index,
        platform_index=platform_index,
        device_index=device_index,
        name=device.name.strip(),
        vendor=device.vendor.strip(),
        platform=platform.name.strip(),
        platform_version=platform.version.strip(),
        driver=device.driver_version.strip(),
        opencl_version=device.version.strip(),
        opencl_c_version=device.opencl_c_version.strip(),
        type=kind,
        available=bool(device.available),
        compiler_available=bool(device.compiler_available),
        fp64_flags=flags,
        fp32_flags=_flags(int(device.single_fp_config)),
        int64_atomics="cl_khr_int64_base_atomics" in extensions,
        preferred_vector_width_double=(
            _width(device, "preferred_vector_width_double") if flags else 0
        ),
        native_vector_width_double=native,
        compute_units=int(device.max_compute_units),
        clock_mhz=int(device.max_clock_frequency),
        global_memory=int(device.global_mem_size),
        local_memory=int(device.local_mem_size),
        max_allocation=int(device.max_mem_alloc_size),
        max_work_group_size=int(device.max_work_group_size),
        is_pocl=is_pocl,
        pocl_version=pocl_version,
        origin=_origin(platform.version, pocl_version) if is_pocl else _maker(platform.name),
        fp64_per_cycle=_fp64_per_cycle(device, kind, native, is_pocl, pocl_version),
    )


def _fp64_flags(device: cl.Device, extensions: list[str]) -> tuple[str, ...]:
    import pyopencl as cl

    try:
        config = int(device.double_fp_config)
    except cl.Error:  # allowed before OpenCL 1.2 where the extension is missing
        config = 0
    if not config and "cl_khr_fp64" not in extensions:
        return ()
    return _flags(config, _FP_FLAGS[1:])


def _flags(config: int, names: tuple[str, ...] = _FP_FLAGS) -> tuple[str, ...]:
    import pyopencl as cl

    bits = cl.device_fp_config
    return tuple(name for name in names if config & int(getattr(bits, name.upper())))


def _type_name(device: cl.Device) -> str:
    import pyopencl as cl

    for name in ("gpu", "accelerator", "cpu"):
        if int(device.type) & int(getattr(cl.device_type, name.upper())):
            return name
    return "other"


def _width(device: cl.Device, attribute: str) -> int:
    return max(1, int(getattr(device, attribute)))


def _pocl_version(version: str) -> tuple[int, ...]:
    found = re.search(r"pocl\s+v?(\d+(?:\.\d+)*)", version, re.IGNORECASE)
    return tuple(int(part) for part in found[1].split(".")) if found else ()


def _maker(platform: str) -> str:
    return "intel" if platform.startswith(intel_runtime.PLATFORM) else ""


def _origin(version: str, pocl_version: tuple[int, ...]) -> str:
    if "debian" in version.lower():
        return "debian"
    # The PyPI build does not name itself. It is the one whose version is that of the installed
    # distribution; a mistake here changes a label and a selector's match, nothing else.
    try:
        packaged = importlib.metadata.version("pocl-binary-distribution")
    except importlib.metadata.PackageNotFoundError:
        return ""
    mine = ".".join(str(part) for part in pocl_version)
    return "pypi" if (packaged + ".").startswith(mine + ".") else ""


# Fused multiply-adds in fp64 per multiprocessor and cycle, of the GPUs made for it; consumer parts
# run fp64 at 1/32 or 1/64 of fp32, which leaves two.
_NVIDIA_FP64: Final = {(6, 0): 32, (7, 0): 32, (8, 0): 32, (9, 0): 64, (10, 0): 64}
_AMD_FP64: Final = {"gfx906": 32, "gfx908": 32, "gfx90a": 64, "gfx940": 64, "gfx942": 64}
_CONSUMER_FP64: Final = 2.0


def _fp64_per_cycle(
    device: cl.Device, kind: str, native: int, is_pocl: bool, pocl_version: tuple[int, ...]
) -> float:
    if kind == "gpu":
        rate = float(_AMD_FP64.get(device.name.split(":")[0].strip(), _CONSUMER_FP64))
        # A query of its own, which PoCL on such a GPU may not know and fails in its own way.
        if is_nvidia(device.vendor):
            with contextlib.suppress(Exception):
                major, minor = (
                    device.compute_capability_major_nv,
                    device.compute_capability_minor_nv,
                )
                rate = float(_NVIDIA_FP64.get((int(major), int(minor)), _CONSUMER_FP64))
        # The vendor's own runtime ahead of PoCL's on the same GPU.
        return 0.5 * rate if is_pocl else rate
    if is_pocl:
        # Measured: PoCL 3.1 and later vectorise over work-items by themselves, earlier ones do not.
        return native * (1.0 if pocl_version >= (3, 1) else 0.4)
    return native * 0.7
