"""One setting of a cost study under way: its batches, their times, what they gave."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.tally import exact, whole_of
from hostcode.run.usual import usual_plan
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.quantities import quantity_of
from photizon_cl.result.cost import ROUNDING, TARGETS, CostSetting, TargetTime
from photizon_cl.result.ledger import closure_of, watts
from photizon_cl.result.statistics import complete
from photizon_cl.result.stopping import LEAST_BATCHES
from photizon_cl.run.distribution import compute, make_engine, open_chosen
from photizon_cl.run.memory import check_memory

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from photizon_cl.studies.knobs import Option

__all__ = ["Trial"]

_POINTS: Final = 24
"""Points of a curve of σ over seconds."""


class Trial:
    """A setting that is being tried.

    Parameters
    ----------
    option : Option
        The setting.
    quantity : str
        What is looked at.
    device : DeviceRecord, str or None
        Where.

    Raises
    ------
    ArgumentError, RunError
        Where the setting cannot be traced.
    """

    def __init__(self, option: Option, quantity: str, device: DeviceRecord | str | None) -> None:
        self.option = option
        self.compiled = compile_scene(option.scene, option.scene.run)
        tables = self.compiled.tables
        self.cell = quantity_of(quantity, option.scene, self.compiled.layout).first
        record = open_chosen(device).record
        plan = check_memory(self.compiled, record, usual_plan(record, tables), saved=False)
        self.engine = make_engine(device, tables, plan)
        self.totals: list[int] = []
        """Of the quantity in each batch, in units of 2^-95 launched weights."""
        self.times: list[float] = []
        """Seconds of tracing behind each batch."""
        self.interactions = 0
        self.worst = 0

    @property
    def batches(self) -> int:
        """Batches so far."""
        return len(self.totals)

    @property
    def seconds(self) -> float:
        """Seconds of tracing so far."""
        return self.times[-1] if self.times else 0.0

    @property
    def pace(self) -> float:
        """Seconds a batch."""
        return self.seconds / self.batches if self.batches else math.inf

    def advance(self, n: int, give_up: Callable[[], bool]) -> None:
        """Trace so many batches more.

        Raises
        ------
        Abandoned
            Where `give_up` said so; none of them counts then.
        RunError
            Where the device fails.
        """
        self.engine.give_up = give_up
        start = time.perf_counter()
        chunk = compute(self.engine, self.batches, n)
        took = time.perf_counter() - start
        before = self.seconds
        for number, cells in enumerate(chunk.cells):
            whole = complete(self.compiled.layout, cells)
            self.worst = max(self.worst, closure_of(self.compiled, whole))
            (total,) = exact(whole_of(whole, self.cell, 1))
            self.totals.append(total)
            layout = self.compiled.layout
            self.interactions += int(whole_of(whole, layout.interactions, 1)[0, 3])
            self.times.append(before + took * (number + 1) / n)

    def values(self) -> NDArray[np.float64]:
        """Return what each batch gave of the quantity, in watts, shape (batches,)."""
        return np.array([watts(self.compiled, total, 1) for total in self.totals])

    def row(self, reference: Trial) -> CostSetting:
        """Return what it gave."""
        n, values = self.batches, self.values()
        mean = watts(self.compiled, sum(self.totals), n)
        sigma = _error(values) if n > 1 else None
        bias, bias_sigma, paired = self._bias(reference)
        relative = _relative_sigmas(values, mean)
        return CostSetting(
            name=self.option.name,
            knob=self.option.knob,
            value=self.option.value,
            written=self.option.written,
            batches=n,
            rays=n * self.compiled.settings.rays_per_batch,
            seconds=self.seconds,
            build_seconds=self.engine.build_seconds,
            interactions_per_s=self.interactions / self.seconds,
            estimate=mean,
            sigma=sigma,
            bias=bias,
            bias_sigma=bias_sigma,
            paired=paired,
            closure=float(self.worst / self.compiled.emitted),
            targets=tuple(self._to(target, relative) for target in TARGETS),
            points=self._points(relative),
        )

    def _bias(self, reference: Trial) -> tuple[float | None, float | None, bool]:
        """Return the difference from the reference, its σ, and whether it is of pairs."""
        one, other = self.compiled.settings, reference.compiled.settings
        common = min(self.batches, reference.batches)
        x, y = self.values(), reference.values()
        if common < 2:
            return None, None, False
        if (one.seed, one.rays_per_batch) == (other.seed, other.rays_per_batch):
            apart = x[:common] - y[:common]
            return float(apart.mean()), _error(apart), True
        return float(x.mean() - y.mean()), math.hypot(_error(x), _error(y)), False

    def _to(self, target: float, relative: NDArray[np.float64]) -> TargetTime:
        """Return the seconds to a target, measured and predicted."""
        n, times = self.batches, self.times
        met = np.flatnonzero(relative[LEAST_BATCHES - 1 :] <= target)
        measured, half = None, n
        if len(met):
            reached = int(met[0]) + LEAST_BATCHES
            measured, half = times[reached - 1], max(reached // 2, LEAST_BATCHES)
        if n < LEAST_BATCHES or not math.isfinite(relative[half - 1]):
            return TargetTime(target, None, measured)
        needed = max(half * (relative[half - 1] / target) ** 2, float(LEAST_BATCHES))
        return TargetTime(target, times[half - 1] / half * needed, measured)

    def _points(self, relative: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
        n = self.batches
        at = np.unique(np.geomspace(min(LEAST_BATCHES, n), n, _POINTS).astype(int))
        found = [(self.times[k - 1], float(relative[k - 1])) for k in at]
        return tuple((t, s) for t, s in found if math.isfinite(s) and s > ROUNDING)


def _error(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1)) / math.sqrt(len(values))


def _relative_sigmas(values: NDArray[np.float64], value: float) -> NDArray[np.float64]:
    """Return the standard error behind each batch over the final value; not finite where none is.

    Over the final value, and not that of so far: else a curve of few arrivals would begin low.
    """
    n = np.arange(1, len(values) + 1)
    shifted = values - values[0]  # what all have in common has no scatter, and no rounding
    mean = np.cumsum(shifted) / n
    square = np.maximum(np.cumsum(shifted * shifted) / n - mean * mean, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        sigma = np.sqrt(square / (n - 1))
        found: NDArray[np.float64] = sigma / abs(value)
    found[0] = np.inf
    return found
