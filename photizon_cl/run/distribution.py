"""Where batches are computed: on a device of this process, or on the workers of an executor.

A task is a range of batch numbers. It is a pure function of the compiled scene and that range, so
it may run anywhere, more than once, and in any order; `chunks` gives the outcome in batch order.
"""

from __future__ import annotations

import os
import pickle
import threading
from collections import OrderedDict, deque
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

from hostcode.device import capability
from hostcode.device.device import (
    ENVIRONMENT_VARIABLE,
    DeviceRecord,
    OpenDevice,
    choose,
    open_device,
    preferred_lanes,
)
from hostcode.errors import Abandoned, DeviceError, HostError, KernelBuildError
from hostcode.program.plan import ExecutionPlan, default_plan
from hostcode.run.wavefront import Engine
from photizon_cl.errors import ArgumentError, PhotizonError, RunError, show

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor, Future

    import numpy as np
    from numpy.typing import NDArray

    from hostcode.run.tables import DeviceTables

__all__ = [
    "Chunk",
    "Executed",
    "Local",
    "Runner",
    "Task",
    "device_failures",
    "open_chosen",
    "run_task",
]

_KEPT_ENGINES: Final = 2
"""Engines that a worker keeps: enough for two traces that take turns."""
_RAYS_OF_A_TASK: Final = 1 << 18
_WINDOW: Final = 2
"""Tasks under way for each worker, so that none waits for the next one."""


@dataclass(frozen=True, eq=False)
class Chunk:
    """Consecutive batches, computed.

    Parameters
    ----------
    first : int
        Number of the first batch.
    cells : tuple of ndarray, each shape (n_cells, 4), int64
        Canonical tallies in batch order.
    device : str
        Label of the device.
    build_seconds : float
        Time that the device's compiler took for the program.
    """

    first: int
    cells: tuple[NDArray[np.int64], ...]
    device: str
    build_seconds: float


@dataclass(frozen=True, eq=False)
class Task:
    """A range of batches for a worker. Pickles.

    Parameters
    ----------
    key : str
        Equal for tasks that one engine can serve.
    tables : DeviceTables
        The compiled scene.
    device : DeviceRecord, str or None
        A device, or what the worker chooses its own by.
    plan : ExecutionPlan or None
        How; None takes the worker's device's default.
    first, n : int
        The range.
    """

    key: str
    tables: DeviceTables
    device: DeviceRecord | str | None
    plan: ExecutionPlan | None
    first: int
    n: int


class Runner(Protocol):
    """Computes batches."""

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
    device: DeviceRecord | str | None, tables: DeviceTables, plan: ExecutionPlan | None
) -> Engine:
    """Return an engine on a chosen device.

    Raises
    ------
    ArgumentError, RunError
        Where there is no such device, or the program or its buffers cannot be made.
    """
    opened = open_chosen(device)
    if plan is None:
        plan = default_plan(opened.record, preferred_lanes(opened.record, tables.spec.effects))
    with device_failures(opened.record.label):
        return Engine(opened, tables, plan)


@contextmanager
def device_failures(label: str) -> Iterator[None]:
    """Turn what a device can raise into a RunError that names the device."""
    import pyopencl as cl

    try:
        yield
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
        self.engine = make_engine(device, tables, plan)

    def chunks(
        self, first: int, last: int | None, size: Callable[[], int | None]
    ) -> Iterator[Chunk]:
        """Give batches in order, see `Runner.chunks`."""
        while last is None or first < last:
            n = self.engine.batches_at_once
            limit = size()
            if limit is not None:
                n = min(n, limit)
            if last is not None:
                n = min(n, last - first)
            try:
                chunk = _compute(self.engine, first, n)
            except Abandoned:
                return
            yield chunk
            first += n


def _compute(engine: Engine, first: int, n: int) -> Chunk:
    label = engine.device.record.label
    with device_failures(label):
        cells = tuple(tally.cells for tally in engine.run(first, n))
    return Chunk(first, cells, label, engine.build_seconds)


# -- workers -----------------------------------------------------------------------------------

_mine = threading.local()


def run_task(task: Task) -> Chunk:
    """Compute a task's batches; what an executor is given.

    Opens a device in the worker at the first task and keeps it, with the last few scenes' programs.
    """
    engines: OrderedDict[str, Engine] | None = getattr(_mine, "engines", None)
    if engines is None:
        engines = _mine.engines = OrderedDict()
    if task.key not in engines:
        engines[task.key] = make_engine(task.device, task.tables, task.plan)
        while len(engines) > _KEPT_ENGINES:
            engines.popitem(last=False)
    engines.move_to_end(task.key)
    return _compute(engines[task.key], task.first, task.n)


class Executed:
    """Runs batches on the workers of an executor.

    Parameters
    ----------
    executor : Executor
        Anything with the interface of `concurrent.futures.Executor`; processes, threads, hosts.
    key : str
        Names the compiled scene, for the workers' caches.
    tables : DeviceTables
        The compiled scene.
    device : DeviceRecord, str or None
        What each worker chooses its device by.
    plan : ExecutionPlan or None
        How; changes no bit.
    """

    def __init__(
        self,
        executor: Executor,
        key: str,
        tables: DeviceTables,
        device: DeviceRecord | str | None,
        plan: ExecutionPlan | None,
    ) -> None:
        if not callable(getattr(executor, "submit", None)):
            raise ArgumentError(
                f"executor: found {show(executor)}, expected something with the interface of "
                "concurrent.futures.Executor (it has no method submit)"
            )
        self.executor, self.tables, self.device, self.plan = executor, tables, device, plan
        self.key = f"{key} {device} {plan}"
        workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
        self.window = _WINDOW * int(workers)

    def _submit(self, first: int, n: int) -> Future[Chunk]:
        task = Task(self.key, self.tables, self.device, self.plan, first, n)
        return self.executor.submit(run_task, task)

    def chunks(
        self, first: int, last: int | None, size: Callable[[], int | None]
    ) -> Iterator[Chunk]:
        """Give batches in order, see `Runner.chunks`."""
        rays = int(self.tables.launch["rays_per_batch"])
        usual = max(_RAYS_OF_A_TASK // rays, 1)
        if last is not None:
            # Shared out among the workers rather than given whole to a few of them.
            usual = max(min(usual, -(-(last - first) // self.window)), 1)
        waiting: deque[tuple[int, int, Future[Chunk]]] = deque()
        try:
            while True:
                while len(waiting) < self.window and (last is None or first < last):
                    limit = size()
                    n = usual if limit is None else min(usual, limit)
                    n = n if last is None else min(n, last - first)
                    waiting.append((first, n, self._submit(first, n)))
                    first += n
                if not waiting:
                    return
                yield self._collect(*waiting.popleft())
        finally:
            for _, _, future in waiting:
                future.cancel()

    def _collect(self, first: int, n: int, future: Future[Chunk]) -> Chunk:
        """Wait for a task; one that was lost is run again, once."""
        try:
            return future.result()
        except (PhotizonError, HostError):
            raise
        except pickle.PicklingError as error:
            raise RunError(f"the executor cannot send a task to its workers: {error}") from error
        except (Exception, CancelledError):
            try:
                return self._submit(first, n).result()
            except (PhotizonError, HostError):
                raise
            except Exception as error:
                what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
                raise RunError(
                    f"batches {first} to {first + n - 1} failed twice on the executor ({what})"
                ) from error
