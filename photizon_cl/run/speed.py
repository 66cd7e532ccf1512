"""Which runtime of a processor is the faster one, measured once and told; it decides nothing.

PoCL is the default on a CPU. Where Intel's runtime is installed as well, both trace some batches of
a preset in turn, and the rates are kept beside the verdicts of the self-test.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

from hostcode.device import intel_runtime, known_passes
from hostcode.device.device import explain_choice, survey
from hostcode.errors import HostError
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import PhotizonError
from photizon_cl.run.distribution import make_engine
from photizon_cl.scene.files import load
from photizon_cl.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from hostcode.device.device import DeviceRecord

__all__ = ["faster_runtime", "rates"]

WORTH_TELLING: Final = 1.2
"""Times as fast as the default from which on a runtime is told of: less may be a minute's load."""

_PRESET: Final = "box-room"
_TEST: Final = f"{_PRESET}/{__version__}"
_ROUNDS: Final = 5
_BATCHES: Final = 8


def faster_runtime(tell: Callable[[str], object] = lambda _: None) -> str:
    """Return a line about a runtime that is faster than the default one; empty where there is none.

    Asks OpenCL only where Intel's runtime is installed. The first time takes some seconds, most of
    them the compilers', and later ones as long as listing the devices.

    Parameters
    ----------
    tell : callable, optional
        Given a line before that first time.
    """
    if not intel_runtime.intel_is_installed():
        return ""
    records = survey().records
    try:
        default = explain_choice(records=records).record
        others = [other for other in records if other.type == "cpu" and other.origin == "intel"]
        if not default.is_pocl or default.type != "cpu" or not others:
            return ""
        other = others[0]
        usual, found = rates((default, other), tell)
    except (HostError, PhotizonError):  # a device that is refused: `photizon devices` says why
        return ""
    if found < WORTH_TELLING * usual:
        return ""
    return (
        f"{other.platform} traces {found / usual:.1f} times as fast as PoCL on this machine, "
        f"measured on {_PRESET}, and gives the same bits: --device {other.origin}"
    )


def rates(
    records: Sequence[DeviceRecord], tell: Callable[[str], object] = lambda _: None
) -> list[float]:
    """Return interactions per second of each device, measured in turn once and then remembered.

    Parameters
    ----------
    records : sequence of DeviceRecord
        The devices.
    tell : callable, optional
        Given a line before they are measured.

    Raises
    ------
    ArgumentError, RunError
        If a device is refused, or does not trace.
    """
    known = [known_passes.rate_of(record.key, _TEST) for record in records]
    found = [rate for rate in known if rate is not None]
    if len(found) == len(records):
        return found
    names = " and ".join(record.platform for record in records)
    tell(
        f"timing {names} on {_PRESET}, once on this machine: some seconds, most to compile for them"
    )
    found = _measured(records)
    for record, rate in zip(records, found, strict=True):
        known_passes.remember_rate(record.key, _TEST, rate)
    return found


def _measured(records: Sequence[DeviceRecord]) -> list[float]:
    scene = load(_PRESET)
    tables = compile_scene(scene, scene.run).tables
    engines = [make_engine(record, tables, None) for record in records]
    # In turn, so that a slow moment meets both, and the best of each: load only ever slows.
    best = [0.0] * len(engines)
    for _ in range(_ROUNDS):
        for number, engine in enumerate(engines):
            before, start = engine.statistics.interactions, time.perf_counter()
            list(engine.run(0, _BATCHES))
            made = engine.statistics.interactions - before
            best[number] = max(best[number], made / (time.perf_counter() - start))
    return best
