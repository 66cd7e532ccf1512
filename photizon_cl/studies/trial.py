"""One setting of a cost study under way: its batches, their times, what they gave."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from hostcode.run.tally import exact, values, whole_of
from hostcode.run.usual import usual_plan
from photizon_cl.checks.precision import fitting_mode
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.quantities import quantity_of, scalars
from photizon_cl.result.comparison import error_of_mean
from photizon_cl.result.cost import ROUNDING, TARGETS, CostSetting, TargetTime
from photizon_cl.result.ledger import closure_of, watts
from photizon_cl.result.needed import sampling_step
from photizon_cl.result.statistics import LIT_COUNT, complete
from photizon_cl.result.stopping import LEAST_BATCHES
from photizon_cl.run.distribution import compute, make_engine, open_chosen
from photizon_cl.run.memory import check_memory

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from hostcode.run.tally import SparseTally
    from photizon_cl.compile.layout import Quantity, TallyLayout
    from photizon_cl.studies.knobs import Option

    Curve = tuple[tuple[int, float], ...]

__all__ = ["Trial"]

_POINTS: Final = 24
"""Points of a curve of σ over seconds."""
_MORE: Final = 8
"""Times as many batches as in the last turn that a turn may have."""
_BINS: Final = 4096
"""Bins of a map that are looked at: of so many the median is known to 2 %."""
_AGREES: Final = 0.5
"""Part of the σ that all batches give, below which that of the first few is not believed."""
_DENSE: Final = 1.04
"""Times as many batches behind which the σ of bins is asked for again."""


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
        fitting_mode(option.precision, option.scene)
        self.compiled = compile_scene(option.scene, option.scene.run, precision=option.precision)
        tables = self.compiled.tables
        if option.plain:
            tables = replace(tables, spec=replace(tables.spec, plain=option.plain))
        layout = self.compiled.layout
        found = quantity_of(quantity, option.scene, layout)
        self.cell = total_of(found, layout)
        self.bins = Bins(found.first, found.bins) if found.bins else None
        record = open_chosen(device).record
        plan = check_memory(self.compiled, record, usual_plan(record, tables), saved=False)
        self.engine = make_engine(device, tables, plan)
        self.totals: list[int] = []
        """Of the quantity in each batch, in units of 2^-95 launched weights."""
        self.times: list[float] = []
        """Seconds of tracing behind each batch."""
        self.turns: list[tuple[int, float]] = []
        """Batches and seconds of each turn."""
        self.seen: NDArray[np.int64] | SparseTally | None = None
        """The first batch."""
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

    def batches_in(self, seconds: float) -> int:
        """Return how many batches fit so many seconds, by the last turn.

        Few batches take as long as one: so not more than some times those of the last turn.
        """
        n, took = self.turns[-1]
        return max(min(round(seconds * n / took), _MORE * n), 1)

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
        self.turns.append((n, took))
        before = self.seconds
        layout = self.compiled.layout
        for number, cells in enumerate(chunk.cells):
            whole = complete(self.compiled.layout, cells)
            self.worst = max(self.worst, closure_of(self.compiled, whole))
            self.seen = whole if self.seen is None else self.seen
            (total,) = exact(whole_of(whole, self.cell, 1))
            self.totals.append(total)
            if self.bins is not None:
                self.bins.add(whole)
            self.interactions += int(whole_of(whole, layout.interactions, 1)[0, 3])
            self.times.append(before + took * (number + 1) / n)

    def is_same(self, other: Trial) -> bool:
        """Say whether another setting comes to the same program, of the same tables."""
        one, two = self.engine, other.engine
        return self.option.scene == other.option.scene and one.program.digest == two.program.digest

    def strongest(self) -> str | None:
        """Return the scalar that the first batch gave most to: a detector's power, else a row."""
        layout, scene = self.compiled.layout, self.option.scene
        found: dict[bool, tuple[int, str]] = {}
        for quantity in scalars(scene, layout):
            if self.seen is None or quantity.name == "ledger.depth_capped":
                continue
            (total,) = exact(whole_of(self.seen, quantity.first, 1))
            detected = quantity.name.endswith(".power")
            if total > found.get(detected, (0, ""))[0]:
                found[detected] = total, quantity.name
        return (found.get(True) or found.get(False) or (0, None))[1]

    def values(self) -> NDArray[np.float64]:
        """Return what each batch gave of the quantity, in watts, shape (batches,)."""
        return np.array([watts(self.compiled, total, 1) for total in self.totals])

    def row(self, reference: Trial) -> CostSetting:
        """Return what it gave."""
        n, each = self.batches, self.values()
        mean = watts(self.compiled, sum(self.totals), n)
        curve = firm(_curve(each, mean) if self.bins is None else self.bins.curve())
        sigma = curve[-1][1] * abs(mean) if n > 1 and math.isfinite(curve[-1][1]) else None
        bias, bias_sigma, paired = self._bias(reference)
        return CostSetting(
            name=self.option.name,
            knob=self.option.knob,
            value=self.option.value,
            written=self.option.written,
            batches=n,
            rays=n * self.compiled.settings.rays_per_batch,
            seconds=self.seconds,
            pace_error=self._pace_error(),
            build_seconds=self.engine.build_seconds,
            interactions_per_s=self.interactions / self.seconds,
            estimate=mean,
            sigma=sigma,
            bias=bias,
            bias_sigma=bias_sigma,
            paired=paired,
            bias_batches=min(self.batches, reference.batches),
            closure=float(self.worst / self.compiled.emitted),
            targets=tuple(self._to(target, curve) for target in TARGETS),
            points=self._points(curve),
        )

    def _pace_error(self) -> float:
        """Return the relative standard error of the pace, a ratio of sums over the turns.

        The first turn, a single batch that warms up, does not tell.
        """
        turns = self.turns[1:]
        if len(turns) < 2:
            return 1.0
        n, took = np.array(turns).T
        apart = took - took.sum() / n.sum() * n
        return float(apart.std(ddof=1) / math.sqrt(len(turns)) / took.mean())

    def _bias(self, reference: Trial) -> tuple[float | None, float | None, bool]:
        """Return the difference from the reference, its σ, and whether it is of pairs."""
        one, other = self.compiled.settings, reference.compiled.settings
        common = min(self.batches, reference.batches)
        x, y = self.values(), reference.values()
        if common < 2:
            return None, None, False
        if (one.seed, one.rays_per_batch) == (other.seed, other.rays_per_batch):
            apart = x[:common] - y[:common]
            return float(apart.mean()), error_of_mean(apart), True
        return float(x.mean() - y.mean()), math.hypot(error_of_mean(x), error_of_mean(y)), False

    def _to(self, target: float, curve: Curve) -> TargetTime:
        """Return the seconds to a target, measured and predicted."""
        known = [(n, sigma) for n, sigma in curve if n >= LEAST_BATCHES]
        if not known:
            return TargetTime(target, None, None)
        reached = next((n for n, sigma in known if sigma <= target), None)
        measured, half = None, known[-1]
        if reached is not None:
            measured = self.times[reached - 1]
            half = next(one for one in known if 2 * one[0] >= reached)
        n, sigma = half
        if not math.isfinite(sigma):
            return TargetTime(target, None, measured)
        needed = max(n * (sigma / target) ** 2, float(LEAST_BATCHES))
        return TargetTime(target, self.times[n - 1] / n * needed, measured)

    def _points(self, curve: Curve) -> tuple[tuple[float, float], ...]:
        """Return seconds and σ at some of the batches, evenly on a logarithmic axis."""
        known = [(n, sigma) for n, sigma in curve if n >= min(LEAST_BATCHES, self.batches)]
        wanted = np.geomspace(known[0][0], known[-1][0], _POINTS)
        at = np.unique(np.searchsorted([n for n, _ in known], np.floor(wanted)))
        found = [(self.times[n - 1], sigma) for n, sigma in (known[k] for k in at)]
        return tuple((t, s) for t, s in found if math.isfinite(s) and s > ROUNDING)


class Bins:
    """Relative σ of many bins: the median over those that are lit in the scene as it stands.

    Parameters
    ----------
    first, n : int
        First cell, and number of bins. Of very many each so-manyth is looked at.
    """

    def __init__(self, first: int, n: int) -> None:
        self.first, self.n = first, n
        self._every = sampling_step(n, _BINS)
        self._start: NDArray[np.float64] | None = None
        shape = len(range(0, n, self._every))
        self._sum, self._square = np.zeros(shape), np.zeros(shape)
        self._counts = np.zeros(shape, np.int64)
        self._batches, self._next = 0, 2
        self._curve: list[tuple[int, NDArray[np.float32]]] = []
        self._judged: NDArray[np.bool_] | None = None

    def add(self, cells: NDArray[np.int64] | SparseTally) -> None:
        """Add a batch, in canonical form."""
        found = whole_of(cells, self.first, self.n)[:: self._every]
        if self._start is None:
            self._start = values(found)
        each = values(found) - self._start  # what all have in common has no scatter
        self._sum += each
        self._square += each * each
        self._counts += found[:, 3]
        self._batches += 1
        if self._batches >= self._next:
            self._curve.append((self._batches, self._relative()))
            self._next = max(self._batches + 1, math.floor(self._batches * _DENSE))

    @property
    def lit(self) -> NDArray[np.bool_]:
        """Which of the bins that are looked at have ten arrivals."""
        return self._counts >= LIT_COUNT

    def judge(self, lit: NDArray[np.bool_]) -> None:
        """Have σ be that of some of the bins that are looked at."""
        self._judged = lit

    def curve(self) -> Curve:
        """Return batches, and the median relative σ behind them; infinite where most are dark."""
        if self._batches > 1 and (not self._curve or self._curve[-1][0] < self._batches):
            self._curve.append((self._batches, self._relative()))
        judged = self.lit if self._judged is None else self._judged
        if not judged.any() or not self._curve:
            return ((self._batches, math.inf),)
        return tuple((n, float(np.median(sigma[judged]))) for n, sigma in self._curve)

    def _relative(self) -> NDArray[np.float32]:
        """Return σ over the mean of each bin; infinite where nothing came."""
        assert self._start is not None
        n = self._batches
        mean = self._sum / n
        square = np.maximum(self._square / n - mean * mean, 0.0)
        value = self._start + mean
        found = np.full(len(value), np.inf, np.float32)
        np.divide(np.sqrt(square / (n - 1)), value, out=found, where=value > 0.0, casting="unsafe")
        return found


def firm(curve: Curve) -> Curve:
    """Return a curve without the places at which hardly anything had come that tells σ.

    Before its first arrivals a quantity has no scatter, or one far too small: σ that is less than
    half of what the whole says of so many batches is none. That of independent batches is within a
    fifth of it from eight batches on.
    """
    n, sigma = curve[-1]
    if not math.isfinite(sigma):
        return curve
    return tuple((k, s) for k, s in curve if s >= _AGREES * sigma * math.sqrt(n / k))


def total_of(quantity: Quantity, layout: TallyLayout) -> int:
    """Return the cell of a quantity, or the one that has the sum of its bins."""
    if not quantity.bins:
        return quantity.first
    for d in layout.detectors:
        if d.nx and d.map == quantity.first:
            return d.power
    return layout.escaped


def _curve(values: NDArray[np.float64], value: float) -> Curve:
    """Return batches, and the standard error behind them over the final value.

    Over the final value, and not that of so far: else a curve of few arrivals would begin low.
    """
    n = np.arange(1, len(values) + 1)
    shifted = values - values[0]  # what all have in common has no scatter, and no rounding
    mean = np.cumsum(shifted) / n
    square = np.maximum(np.cumsum(shifted * shifted) / n - mean * mean, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.sqrt(square / (n - 1)) / abs(value)
    found[0] = np.inf
    found[~np.isfinite(found)] = np.inf
    return tuple(zip(n.tolist(), found.tolist(), strict=True))
