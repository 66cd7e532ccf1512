"""One engine, timed: what a cell of the tables is measured with."""

from __future__ import annotations

import time
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import CompiledScene, compile_scene
from photizon_cl.result.statistics import Accumulator, complete
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hostcode.device.device import OpenDevice
    from hostcode.program.plan import ExecutionPlan


@dataclass(frozen=True)
class Timing:
    """One timed stretch.

    Parameters
    ----------
    seconds : float
        On the wall's clock, from asking for the first batch to holding the last one's tally.
    interactions : int
        Surface interactions made.
    enqueue_seconds : float
        Host time in the runtime's enqueue calls, as the engine counts it.
    cpu_seconds : float
        Processor time of the process: over `seconds`, the cores that were really used.
    digest : str
        Of the tallies; equal for equal batches, however they were computed.
    """

    seconds: float
    interactions: int
    enqueue_seconds: float
    cpu_seconds: float
    digest: str

    @property
    def rate(self) -> float:
        """Millions of interactions per second."""
        return self.interactions / self.seconds / 1e6


def compiled_preset(
    name: str, rays_per_batch: int | None = None, precision: str = "fp64"
) -> CompiledScene:
    """Return a preset, compiled as its file says unless other rays per batch are asked for."""
    scene = load(name)
    run = scene.run
    if rays_per_batch is not None:
        run = replace(run, rays_per_batch=rays_per_batch)
    return compile_scene(replace(scene, run=run), run, precision=precision)


class Runner:
    """Traces the same batches again and again, from batch 0 on.

    Parameters
    ----------
    device : OpenDevice
        Where.
    compiled : CompiledScene
        What.
    plan : ExecutionPlan
        How.
    batches : int, optional
        How many; default as many as the plan has in flight at once.
    """

    def __init__(
        self,
        device: OpenDevice,
        compiled: CompiledScene,
        plan: ExecutionPlan,
        batches: int | None = None,
    ) -> None:
        self.compiled = compiled
        self.engine = Engine(device, compiled.tables, plan)
        self.batches = self.engine.batches_at_once if batches is None else batches
        self.repeats = 1

    def time(self) -> Timing:
        """Trace the batches `repeats` times.

        Raises
        ------
        AssertionError
            If two repetitions gave other bits.
        """
        statistics = self.engine.statistics
        interactions, enqueue = statistics.interactions, statistics.enqueue_seconds
        digests = set()
        tallies: list[Any] = []
        cpu, started = time.process_time(), time.perf_counter()
        for _ in range(self.repeats):
            tallies.append(list(self.engine.run(0, self.batches)))
        seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
        for batches in tallies:
            tally = Accumulator.of(self.compiled.layout)
            for batch in batches:
                tally.add(complete(self.compiled.layout, batch.cells))
            digests.add(tally.digest)
        if len(digests) != 1:
            raise AssertionError(f"{self.engine.plan}: the same batches gave {sorted(digests)}")
        return Timing(
            seconds,
            statistics.interactions - interactions,
            statistics.enqueue_seconds - enqueue,
            cpu,
            digests.pop(),
        )

    def digest(self) -> str:
        """Return the digest of the batches."""
        return self.time().digest

    def warm_up(self, seconds: float) -> Timing:
        """Compile, let queues grow, and set `repeats` so that `time` takes so many seconds."""
        self.repeats = 1
        self.time()
        timing = self.time()
        self.repeats = max(1, round(seconds / timing.seconds))
        return timing


@dataclass
class KernelSeconds:
    """What `kernel_seconds` finds, filled when its block ends.

    Parameters
    ----------
    by_kernel : dict
        Device seconds by kernel's name.
    launches : int
        How many.
    enqueue_cpu : float
        Processor seconds of the calling thread inside the launch calls.
    """

    by_kernel: dict[str, float]
    launches: int = 0
    enqueue_cpu: float = 0.0

    @property
    def total(self) -> float:
        """All kernels together."""
        return sum(self.by_kernel.values())


@contextmanager
def kernel_seconds() -> Iterator[KernelSeconds]:
    """Collect the device time of every kernel that is launched in the block.

    The queue must be one with profiling. pyopencl's launch function is wrapped for the time of the
    block, so that the engine under test is the engine as it is.
    """
    import pyopencl as cl

    events: list[tuple[str, Any]] = []
    launch = cl.enqueue_nd_range_kernel

    def recorded(queue: Any, kernel: Any, *arguments: Any, **options: Any) -> Any:
        started = time.thread_time()
        event = launch(queue, kernel, *arguments, **options)
        found.enqueue_cpu += time.thread_time() - started
        events.append((kernel.function_name, event))
        return event

    found = KernelSeconds({})
    cl.enqueue_nd_range_kernel = recorded
    try:
        yield found
    finally:
        cl.enqueue_nd_range_kernel = launch
    for name, event in events:
        event.wait()
        spent = (event.profile.end - event.profile.start) * 1e-9
        found.by_kernel[name] = found.by_kernel.get(name, 0.0) + spent
    found.launches = len(events)
