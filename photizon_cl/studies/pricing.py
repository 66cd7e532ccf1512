"""What more or less in a program costs: two programs of a scene, run in turn.

Each program is compiled as if none had been kept. Then both trace the same batches in turn, in an
order that changes from round to round, so that a slow moment of the machine meets both; what is
reported is the median of the rounds' ratios with its quartiles. All cells that both programs have
must be the same bits.
"""

from __future__ import annotations

import hashlib
import math
import statistics
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hostcode.errors import Abandoned
from hostcode.run.tally import SparseTally
from photizon_cl.errors import NoRoomError, RunError
from photizon_cl.result.effects import Price, ProgramCost, Ratio
from photizon_cl.result.statistics import complete
from photizon_cl.run.distribution import device_failures, make_engine, open_chosen

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from hostcode.device.device import DeviceRecord
    from hostcode.program.plan import ExecutionPlan
    from hostcode.run.wavefront import Engine
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import TallyLayout

__all__ = ["BUILDS", "ROUNDS", "ROUND_SECONDS", "Pair", "Pricing"]

ROUNDS: Final = 7
"""Rounds of a pair, where time allows."""
ROUND_SECONDS: Final = 0.3
"""Time of a program in a round, at least."""
BUILDS: Final = 3
"""How often each program is compiled, where time allows."""
_LEAST_ROUNDS: Final = 2


class _Program:
    """A program, its engine, and what was measured of it."""

    def __init__(self, compiled: CompiledScene, engine: Engine) -> None:
        self.compiled = compiled
        self.engine = engine
        self.builds = [engine.build_seconds]
        self.sizes = engine.program_sizes

    def trace(self, batches: int) -> tuple[float, int]:
        """Return seconds and interactions of the first batches."""
        before, started = self.engine.statistics.interactions, time.perf_counter()
        with device_failures(self.engine.device.record.label):
            for _ in self.engine.run(0, batches):
                pass
        return (
            time.perf_counter() - started,
            self.engine.statistics.interactions - before,
        )

    def bits(self, batches: int) -> dict[str, str]:
        """Return a digest of the first batches for each piece of the tally."""
        layout = self.compiled.layout
        states = {name: hashlib.sha256() for name in layout.pieces}
        with device_failures(self.engine.device.record.label):
            for batch in self.engine.run(0, batches):
                for name, piece in _pieces(layout, complete(layout, batch.cells)).items():
                    states[name].update(piece.numbers.tobytes() + piece.rows.tobytes())
        return {name: state.hexdigest() for name, state in states.items()}

    def cost(self, rates: list[float]) -> ProgramCost:
        """Return what it takes, at the rates of some rounds."""
        return ProgramCost(statistics.median(rates), statistics.median(self.builds), *self.sizes)


def _pieces(layout: TallyLayout, cells: NDArray[np.int64] | SparseTally) -> dict[str, SparseTally]:
    """Return the pieces of a tally without the cells that are zero, from 0 on each."""
    return {
        name: (
            cells.within(first, n)
            if isinstance(cells, SparseTally)
            else SparseTally.of(cells[first : first + n])
        )
        for name, (first, n) in layout.pieces.items()
    }


class Pair:
    """The scene's own program and another one, as they were measured.

    Parameters
    ----------
    own, other : _Program
        The programs.
    more : bool
        Whether the other one has more in it.
    same_bits : bool
        Whether all cells that both have are the same.
    """

    def __init__(self, own: _Program, other: _Program, *, more: bool, same_bits: bool) -> None:
        self.own, self.other, self.more, self.same_bits = own, other, more, same_bits
        self.ratios: list[float] = []
        self.rates: tuple[list[float], list[float]] = ([], [])

    def add_round(self, batches: int, *, own_first: bool) -> None:
        """Have both trace the same batches."""
        order = (0, 1) if own_first else (1, 0)
        seconds = [0.0, 0.0]
        made = [0, 0]
        for k in order:
            seconds[k], made[k] = (self.own, self.other)[k].trace(batches)
        for k in order:
            self.rates[k].append(made[k] / seconds[k])
        self.ratios.append(seconds[1] / seconds[0] if self.more else seconds[0] / seconds[1])

    def price(self) -> Price:
        """Return what was measured; of at least one round."""
        own, other = self.own.cost(self.rates[0]), self.other.cost(self.rates[1])
        more, less = (other, own) if self.more else (own, other)
        return Price(more, less, Ratio.of(self.ratios), self.same_bits)


class Pricing:
    """Measures programs of a scene beside its own, within a time.

    Parameters
    ----------
    own : CompiledScene
        What the scene compiles.
    n : int
        How many other programs there will be, which share the time.
    device, plan
        As in `photizon_cl.trace`.
    max_seconds : float
        Within which everything ends, but for a program that is being compiled.
    rounds : int
        Rounds of a pair.

    Raises
    ------
    ArgumentError, RunError
        Where there is no usable device, it fails, or not even the scene's own program traces some
        batches in the time.
    """

    def __init__(
        self,
        own: CompiledScene,
        n: int,
        device: DeviceRecord | str | None = None,
        plan: ExecutionPlan | None = None,
        *,
        max_seconds: float,
        rounds: int = ROUNDS,
    ) -> None:
        self.started = time.monotonic()
        self.max_seconds, self.rounds, self.left = max_seconds, rounds, n
        self._ends = self.started + max_seconds
        self._share_ends = self._ends
        self._where = device, plan
        self.label = open_chosen(device).record.label
        self.pairs: list[Pair] = []
        self._engine(own)  # the first one of a process pays for loading the compiler
        self.own = _Program(own, self._engine(own))
        self.batches = self._step = self.own.engine.batches_at_once
        try:
            self.bits = self.own.bits(self._step)
            seconds, _ = self.own.trace(self._step)
        except Abandoned:
            seconds = math.inf
        if self.seconds > max_seconds or seconds == math.inf:
            raise RunError(
                f"nothing was measured: compiling and {self._step} batches of the scene take "
                f"longer than {max_seconds:g} s (max_seconds); give it more, or take fewer "
                "rays_per_batch"
            )
        self.batches *= max(math.ceil(ROUND_SECONDS / seconds), 1)

    @property
    def seconds(self) -> float:
        """Seconds since the beginning."""
        return time.monotonic() - self.started

    def _engine(self, compiled: CompiledScene) -> Engine:
        device, plan = self._where
        engine = make_engine(device, compiled.tables, plan, anew=True)
        engine.give_up = lambda: time.monotonic() > self._share_ends
        return engine

    def measure(self, other: CompiledScene, *, more: bool = True) -> Pair | str:
        """Measure a program beside the scene's own; return both, or why that was not done.

        Parameters
        ----------
        other : CompiledScene
            The same scene and settings, with more in its program, or less.
        more : bool
            Which of that.
        """
        now = time.monotonic()
        share = (self._ends - now) / max(self.left, 1)
        self.left -= 1
        if share <= 0.0:
            return f"the {self.max_seconds:g} s were over (max_seconds)"
        try:
            program = _Program(other, self._engine(other))
        except NoRoomError as error:
            return f"there is no room for it: {error}"
        # one that is far slower leaves half of the time to the others
        self._share_ends = max(now + share, 0.5 * (time.monotonic() + self._ends))
        pair = None
        try:
            bits = program.bits(self._step)
            common = self.bits.keys() & bits.keys()
            same = all(bits[name] == self.bits[name] for name in common)
            pair = Pair(self.own, program, more=more, same_bits=same)
            if not same:  # that is told in any case
                self._share_ends = math.inf
            for n in range(self.rounds):
                if n >= _LEAST_ROUNDS and time.monotonic() > now + share:
                    break
                pair.add_round(self.batches, own_first=n % 2 == 0)
        except Abandoned:
            if pair is None or len(pair.ratios) < _LEAST_ROUNDS:
                return f"it takes longer than was left of the {self.max_seconds:g} s (max_seconds)"
        finally:
            self._share_ends = self._ends
            del program.engine  # its buffers are not needed to compile it again
        self.pairs.append(pair)
        return pair

    def build_again(self) -> None:
        """Compile every program again, in turn, while the time lasts."""
        programs = [self.own, *(pair.other for pair in self.pairs)]
        for _ in range(BUILDS - 1):
            if time.monotonic() + sum(program.builds[-1] for program in programs) > self._ends:
                return
            for program in programs:
                with suppress(NoRoomError):
                    program.builds.append(self._engine(program.compiled).build_seconds)

    def cost(self) -> ProgramCost | None:
        """Return what the scene's own program takes, over the rounds of all pairs."""
        rates = [rate for pair in self.pairs for rate in pair.rates[0]]
        return self.own.cost(rates) if rates else None
