"""Who computes batches: a device of this process here, an executor in `photizon_cl.run.workers`."""

from __future__ import annotations

import os
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, Protocol

from hostcode.device import capability
from hostcode.device.device import (
    ENVIRONMENT_VARIABLE,
    DeviceRecord,
    OpenDevice,
    choose,
    open_device,
)
from hostcode.device.memory import room
from hostcode.errors import Abandoned, DeviceError, HostError, KernelBuildError, QueueFull
from hostcode.run.sizes import Sizes
from hostcode.run.usual import usual_plan
from hostcode.run.wavefront import Engine
from photizon_cl.errors import ArgumentError, NoRoomError, RunError, show
from photizon_cl.run.chunks import Chunk
from photizon_cl.run.memory import too_large

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.tables import DeviceTables
    from photizon_cl.run.progress import Clock

__all__ = [
    "Local",
    "Runner",
    "compute",
    "device_failures",
    "make_engine",
    "open_chosen",
]

_NOTHING: Final = 1 << 26
"""Bytes of buffers that are not worth a look at what is left."""


class Runner(Protocol):
    """Computes batches."""

    def watch(self, clock: Clock, interrupted: Callable[[], bool]) -> None:
        """Be told the call's clock, and where to ask whether Ctrl-C was pressed."""
        ...

    def complaint(self) -> str:
        """Say why there is no batch, where that is not the scene's doing; else nothing."""
        ...

    def full(self) -> bool:
        """Say whether batches ended because there was no room for the rays that wait."""
        ...

    def chunks(
        self, first: int, last: int | None, size: Callable[[], int | None]
    ) -> Iterator[Chunk]:
        """Give the batches from `first` up to `last` (endlessly where None) in order.

        Parameters
        ----------
        first : int
            Number of the first batch.
        last : int or None
            Number behind the last one.
        size : callable
            Asked before each chunk: how many batches it may have at most, None for no limit.
        """
        ...


# -- devices -----------------------------------------------------------------------------------

_opened: dict[tuple[DeviceRecord, int], OpenDevice] = {}
_forked_with_opencl = False


def _note_fork() -> None:
    global _forked_with_opencl
    _forked_with_opencl = capability.survey.cache_info().currsize > 0


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def open_chosen(device: DeviceRecord | str | None) -> OpenDevice:
    """Return an open device, the same one to every caller of a thread.

    Parameters
    ----------
    device : DeviceRecord, str or None
        A device's record, a selector of `hostcode.device.device`, or None for the best.

    Raises
    ------
    ArgumentError
        Where devices are there and the selector matches none that can be used.
    RunError
        Where there is no usable device, or this process was forked off one that had used OpenCL.
    """
    if _forked_with_opencl:
        raise RunError(
            "this worker process was forked from one that had used OpenCL, whose threads do not "
            "survive that: start workers with multiprocessing.get_context('spawn') "
            "(ProcessPoolExecutor(mp_context=…))"
        )
    if not (device is None or isinstance(device, DeviceRecord | str)):
        raise ArgumentError(
            f"device: found {show(device)}, expected a number, type or part of a name (see "
            "`photizon devices`), or a DeviceRecord"
        )
    try:
        record = device if isinstance(device, DeviceRecord) else choose(device)
        key = (record, threading.get_ident())
        if key not in _opened:
            _opened[key] = open_device(record)
    except DeviceError as error:
        asked = device is not None or os.environ.get(ENVIRONMENT_VARIABLE)
        if asked and capability.survey().records:
            raise ArgumentError(f"device: {error}") from error
        raise RunError(str(error)) from error
    return _opened[key]


def make_engine(
    device: DeviceRecord | str | None,
    tables: DeviceTables,
    plan: ExecutionPlan | None,
    *,
    anew: bool = False,
) -> Engine:
    """Return an engine on a chosen device; `anew` compiles its programs whatever is kept of them.

    Raises
    ------
    ArgumentError, RunError
        Where there is no such device, or the program or its buffers cannot be made.
    """
    opened = open_chosen(device)
    record = opened.record
    plan = plan or usual_plan(record, tables)
    _check_buffers(record, Sizes.of(tables, plan))
    with device_failures(record.label):
        return Engine(opened, tables, plan, anew=anew)


def _check_buffers(record: DeviceRecord, sizes: Sizes) -> None:
    """Refuse what a device cannot hold: some runtimes end the process when they find out.

    In a worker that is all that is looked at; elsewhere a run was looked at as a whole.

    Raises
    ------
    NoRoomError
        Where a buffer, or all of them, are too large.
    """
    left = room() if record.type == "cpu" and sizes.total() > _NOTHING else None
    parts = {name: sizes.total(name) for name in sizes.buffers}
    why, _ = too_large(record, parts, sizes.largest, left)
    if why:
        raise NoRoomError(f"{why}: `photizon check` says what the scene takes")


@contextmanager
def device_failures(label: str) -> Iterator[None]:
    """Turn what a device can raise into a RunError that names the device."""
    import pyopencl as cl

    try:
        yield
    except QueueFull as error:
        raise NoRoomError(str(error)) from error
    except (cl.MemoryError, MemoryError) as error:
        raise NoRoomError(
            f"device {label} has no memory for the run: take fewer rays_per_batch, or fewer bins "
            f"in maps and far field; `photizon check` says what takes how much ({error})"
        ) from error
    except cl.Error as error:
        raise RunError(
            f"device {label} failed: {error}; try fewer rays_per_batch, or another device"
        ) from error
    except KernelBuildError as error:
        raise RunError(f"device {label} could not build the scene's {error}") from error
    except HostError as error:
        raise RunError(str(error)) from error


# -- this process ------------------------------------------------------------------------------


class Local:
    """Runs batches on a device of this process.

    Parameters
    ----------
    tables : DeviceTables
        The compiled scene.
    device : DeviceRecord, str or None
        Where.
    plan : ExecutionPlan or None
        How; changes no bit.
    """

    def __init__(
        self,
        tables: DeviceTables,
        device: DeviceRecord | str | None,
        plan: ExecutionPlan | None,
    ) -> None:
        self._what = device, tables, plan
        self.engine = make_engine(*self._what)
        self._full = ""

    def watch(self, clock: Clock, interrupted: Callable[[], bool]) -> None:
        """Give batches in flight up when the clock or Ctrl-C says so."""
        self.engine.give_up = lambda: clock.must_stop(interrupted=interrupted())

    def complaint(self) -> str:
        """Say where there is no room for the rays that wait; what takes long is the scene."""
        return self._full

    def full(self) -> bool:
        """Say whether batches ended because there was no room."""
        return bool(self._full)

    def chunks(
        self, first: int, last: int | None, size: Callable[[], int | None]
    ) -> Iterator[Chunk]:
        """Give batches in order, see `Runner.chunks`."""
        alone = False
        while last is None or first < last:
            n = 1 if alone else self.engine.batches_at_once
            limit = size()
            if limit is not None:
                n = min(n, limit)
            if last is not None:
                n = min(n, last - first)
            why = ""
            try:
                chunk = compute(self.engine, first, n)
            except Abandoned:
                return
            except NoRoomError as error:
                why = str(error)
            # from here on no traceback holds the engine
            if not why:
                yield chunk
                del chunk  # the next one is computed before the caller lets go of this one
                first += n
            elif n > 1 and self._made_anew():
                alone = True  # those that there is room for one at a time count
            else:
                self._full = self._full or why
                return

    def _made_anew(self) -> bool:
        """Make the engine again, whose queue is of no more use; say whether there was room."""
        give_up = self.engine.give_up
        del self.engine  # before the other takes as much
        try:
            self.engine = make_engine(*self._what)
        except NoRoomError as error:
            self._full = str(error)
            return False
        self.engine.give_up = give_up
        return True


def compute(engine: Engine, first: int, n: int) -> Chunk:
    """Compute batches.

    Raises
    ------
    Abandoned
        Where the engine's `give_up` said so.
    RunError
        Where the device fails.
    """
    record = engine.device.record
    with device_failures(record.label):
        tallies = tuple(engine.run(first, n))
    portable = record.promises(engine.tables.spec.real)
    cells = tuple(tally.cells for tally in tallies)
    keyed = tuple(tally.keyed for tally in tallies if tally.keyed is not None)
    return Chunk(first, cells, record.label, engine.build_seconds, portable, keyed=keyed)
