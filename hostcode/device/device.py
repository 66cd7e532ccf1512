"""Which device runs the kernels, and opening it.

Devices are chosen by capability, never by being on the first platform. Precedence: the argument
(``--device``), the environment variable ``PHOTIZON_DEVICE``, the best device that qualifies.

A selector is one of

``3``
    the device's number in `survey`, as ``photizon devices`` lists it;
``0:1``
    platform and device number;
``cpu``, ``gpu``, ``accelerator``
    the best device of that type;
any other text
    looked for, ignoring case, in *platform/version/device/driver/vendor*, with ``debian`` or
    ``pypi`` standing for who packaged a PoCL: ``pocl``, ``debian``, ``pypi``, ``nvidia``, ``h200``;
    ``intel`` is a runtime of Intel's where there is one, whoever made the processor.

To give a process one platform only, or to limit a CPU's threads, see
`hostcode.device.pocl_environment`.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hostcode.device import selftest
from hostcode.device.capability import INSTALL_HINT, DeviceRecord, Survey, find_device, survey
from hostcode.device.opened import OpenDevice, preferred_lanes
from hostcode.errors import DeviceError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = [
    "ENVIRONMENT_VARIABLE",
    "INSTALL_HINT",
    "Choice",
    "DeviceRecord",
    "OpenDevice",
    "Survey",
    "choose",
    "enumerate_devices",
    "explain_choice",
    "open_device",
    "preferred_lanes",
    "qualify",
    "survey",
]

ENVIRONMENT_VARIABLE: Final = "PHOTIZON_DEVICE"

MIN_GLOBAL_MEMORY: Final = 256 << 20
"""Bytes of device memory below which not even a small wave and its tallies fit in comfort."""

MIN_ALLOCATION: Final = 64 << 20
"""Bytes that one buffer must be allowed to have."""

_TYPES: Final = ("cpu", "gpu", "accelerator")

# The promises that the bits of a result rest on, and how to say that one is missing. OpenCL has no
# flag for division and square root in fp64: where fp64 is there at all they must be correctly
# rounded, and the self-test checks it.
_NEEDED_FP64: Final = {
    "round_to_nearest": "its doubles do not round to nearest",
    "fma": "its doubles have no fused multiply-add",
    "inf_nan": "its doubles have no infinities and NaNs",
    "denorm": "its doubles flush subnormal numbers to zero",
}


@dataclass(frozen=True, slots=True)
class Choice:
    """A chosen device and why it was this one.

    Parameters
    ----------
    record : DeviceRecord
        The device.
    reason : str
        One line; says so where a selector matched several devices and the best was taken.
    """

    record: DeviceRecord
    reason: str


def enumerate_devices() -> list[DeviceRecord]:
    """Return the capability record of every device of every platform; creates no context."""
    return list(survey().records)


def qualify(record: DeviceRecord, *, self_test: bool = False) -> list[str]:
    """Return the reasons why a device cannot be used; none means that it qualifies.

    Parameters
    ----------
    record : DeviceRecord
        The device.
    self_test : bool
        Also run the known-answer self-test (about a second, unless it is known to have passed).

    Returns
    -------
    list of str
        Reasons, each a clause that completes "refused: …".
    """
    reasons = []
    if not record.available:
        reasons.append("the runtime says that it is not available")
    if not record.compiler_available:
        reasons.append("it has no compiler for kernels")
    if not record.fp64:
        reasons.append("no fp64 (cl_khr_fp64)")
    else:
        reasons += [text for flag, text in _NEEDED_FP64.items() if flag not in record.fp64_flags]
    if not record.int64_atomics:
        reasons.append("no 64-bit integer atomics (cl_khr_int64_base_atomics)")
    if record.global_memory < MIN_GLOBAL_MEMORY:
        reasons.append(
            f"{record.global_memory >> 20} MiB of memory "
            f"(at least {MIN_GLOBAL_MEMORY >> 20} needed)"
        )
    elif record.max_allocation < MIN_ALLOCATION:
        reasons.append(
            f"buffers of at most {record.max_allocation >> 20} MiB "
            f"(at least {MIN_ALLOCATION >> 20} needed)"
        )
    if not reasons and self_test:
        try:
            open_device(record)
        except DeviceError as error:
            reasons.append(error.reason)
    return reasons


def choose(selector: str | None = None) -> DeviceRecord:
    """Return the device to use, as `explain_choice` does, without the reason."""
    return explain_choice(selector).record


def explain_choice(
    selector: str | None = None, *, records: Iterable[DeviceRecord] | None = None
) -> Choice:
    """Choose a device by capability, or by a selector.

    Parameters
    ----------
    selector : str, optional
        See the module; None (or empty) looks at the environment variable ``PHOTIZON_DEVICE``, and
        where that is not set takes the best device that qualifies and passes its self-test.
    records : iterable of DeviceRecord, optional
        Choose among these by capability alone, running nothing on them; default every device of
        this machine, with the self-test.

    Returns
    -------
    Choice
        The device and why.

    Raises
    ------
    DeviceError
        If there is no device, none matches the selector, or those that match do not qualify.
    """
    found = survey() if records is None else Survey(tuple(records), ())
    run_tests = records is None
    said_by = "the argument"
    if not selector:
        selector, said_by = os.environ.get(ENVIRONMENT_VARIABLE, "").strip(), ENVIRONMENT_VARIABLE
    if not found.records:
        trouble = f" ({'; '.join(found.problems)})" if found.problems else ""
        raise DeviceError(f"no OpenCL device found{trouble}: {INSTALL_HINT}")

    candidates = _matching(selector, found.records) if selector else list(found.records)
    if not candidates:
        listing = "\n".join(f"  {_line(record)}" for record in found.records)
        raise DeviceError(
            f"no device matches {selector!r} (from {said_by}); give a number, a platform:device, "
            f"cpu, gpu or part of a name of one of these:\n{listing}"
        )
    candidates.sort(key=_rank)
    refused: list[tuple[DeviceRecord, list[str]]] = []
    for record in candidates:
        reasons = qualify(record, self_test=run_tests)
        if not reasons:
            return Choice(record, _reason(record, selector, said_by, candidates, refused))
        refused.append((record, reasons))
    listing = "\n".join(f"  {_line(record)}: {'; '.join(why)}" for record, why in refused)
    asked = f" that matches {selector!r} (from {said_by})" if selector else ""
    raise DeviceError(f"no usable OpenCL device{asked}; {INSTALL_HINT}. Refused:\n{listing}")


def open_device(
    record: DeviceRecord,
    *,
    profiling: bool = False,
    self_test: bool = True,
    compute_units: int | None = None,
) -> OpenDevice:
    """Open a device: a context of its own and an in-order queue.

    Parameters
    ----------
    record : DeviceRecord
        Of this machine, or of an equal device in another process.
    profiling : bool
        Record times of events.
    self_test : bool
        Refuse a device that does not know the answers. A pass is remembered per device, driver and
        version of the test, so that this costs time once.
    compute_units : int, optional
        Use a sub-device of so many compute units (threads, on a CPU).

    Returns
    -------
    OpenDevice
        Ready to build programs for.

    Raises
    ------
    DeviceError
        If the device is not here, cannot be opened or partitioned, or fails its self-test.
    """
    import pyopencl as cl

    device = find_device(record)
    if compute_units is not None and compute_units != record.compute_units:
        # The stubs ask for a list of properties; OpenCL's own form is property, value, ….
        counts: list[Any] = [cl.device_partition_property.BY_COUNTS, compute_units]
        try:
            device = device.create_sub_devices(counts)[0]
        except cl.Error as error:
            raise DeviceError(
                f"device {record.label} gives no part of {compute_units} compute units ({error}): "
                f"ask for 1 to {record.compute_units}, on a device that can be divided"
            ) from error
    try:
        context = cl.Context([device])
        if profiling:
            timed = cl.command_queue_properties.PROFILING_ENABLE
            queue = cl.CommandQueue(context, device, timed)
        else:
            queue = cl.CommandQueue(context, device)
    except cl.Error as error:
        raise DeviceError(
            f"device {record.label} cannot be opened: {error}; {INSTALL_HINT}", str(error)
        ) from error
    opened = OpenDevice(record, device, context, queue, profiling)
    if self_test:
        report = selftest.passed_before_or_run(opened)
        if not report.passed:
            reason = f"self-test failed: {'; '.join(report.failures)}"
            raise DeviceError(f"device {record.label} is refused: {reason}", reason)
    return opened


def _matching(selector: str, records: tuple[DeviceRecord, ...]) -> list[DeviceRecord]:
    text = selector.strip().lower()
    if text.isascii() and text.isdigit():
        return [record for record in records if record.index == int(text)]
    pair = re.fullmatch(r"(\d+):(\d+)", text, re.ASCII)
    if pair:
        position = (int(pair[1]), int(pair[2]))
        return [rec for rec in records if (rec.platform_index, rec.device_index) == position]
    if text in _TYPES:
        return [record for record in records if record.type == text]
    by_origin = [record for record in records if text == record.origin]
    return by_origin or [record for record in records if text in record.search_text]


_OTHER_CPU: Final = 0.1
"""What the rate of a CPU counts under another runtime: PoCL's, whatever clock each tells, is more.
Which is faster only a measurement tells."""


def _rank(record: DeviceRecord) -> tuple[float, int]:
    other = record.type == "cpu" and not record.is_pocl
    return (-record.fp64_gflops * (_OTHER_CPU if other else 1.0), record.index)


def _line(record: DeviceRecord) -> str:
    position = f"{record.index} ({record.platform_index}:{record.device_index})"
    return f"{position} {record.type} {record.name} [{record.platform}, {record.driver}]"


def _reason(
    record: DeviceRecord,
    selector: str,
    said_by: str,
    candidates: list[DeviceRecord],
    refused: list[tuple[DeviceRecord, list[str]]],
) -> str:
    if not selector:
        reason = "the best of " if len(candidates) > 1 else "the only one of "
        reason += f"{len(candidates)} by capability" if len(candidates) > 1 else "this machine"
    elif len(candidates) > 1:
        reason = f"the best of {len(candidates)} that match {selector!r} (from {said_by})"
    else:
        reason = f"matches {selector!r} (from {said_by})"
    if refused:
        passed_over = "; ".join(f"{other.label}: {', '.join(why)}" for other, why in refused)
        reason += f"; passed over {passed_over}"
    return reason
