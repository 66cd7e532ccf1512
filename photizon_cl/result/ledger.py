"""The energy ledger: every watt that the sources emit, in the row where it ended.

Balances are taken in exact integers, batch by batch, and turned into watts at the very end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final, Self

from hostcode.program.precision import FP64
from hostcode.run.tally import UNIT_EXPONENT, exact, some_of, whole_of
from photizon_cl.compile.layout import ABSORBED_IN, ROWS
from photizon_cl.errors import RunError
from photizon_cl.result.statistics import exact_sum
from photizon_cl.result.text import with_error
from photizon_cl.scene.names import Table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from hostcode.run.tally import SparseTally
    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.result.statistics import Accumulator

__all__ = ["CLOSURE_LIMIT", "Estimate", "Ledger", "Roulette", "check_batch", "closure_limit"]

CLOSURE_LIMIT: Final = Fraction(1, 10**12)
"""Part of the emitted power that a batch's ledger may miss by; more is a defect of the engine.

What a split loses is the rounding of the weights: with weights in single precision the limit is as
many of their roundings."""

_ROUNDINGS: Final = 64
"""Roundings of single weights that a ledger of them may miss by; a few are seen."""
_UNIT: Final = Fraction(1, 1 << -UNIT_EXPONENT)
_DEFECT: Final = "this is a defect of the engine; please report it with the scene file"


class Estimate(float):
    """A quantity with its standard error: a number, its value, that knows how sure it is.

    ``f"{power:.3f}"``, ``float(power)``, sums and comparisons are those of the value and give plain
    numbers: rows of a run are correlated, so that no standard error of a sum follows from theirs.
    Two estimates are equal where value, standard error and count are.

    Parameters
    ----------
    value : float
        Mean over batches, in watts.
    sigma : float or None
        Standard error of the mean, in watts; None with a single batch.
    count : int or None
        Arrivals, where they are counted.
    by_wavelength : sequence of Estimate
        What each line or band of the spectrum brings; empty where that is not told. Exact totals
        add up to this one's.
    """

    __slots__ = ("_by_wavelength", "_count", "_sigma")
    _sigma: float | None
    _count: int | None
    _by_wavelength: tuple[Estimate, ...]

    def __new__(
        cls,
        value: float,
        sigma: float | None,
        count: int | None = None,
        by_wavelength: Sequence[Estimate] = (),
    ) -> Self:
        """Make an estimate."""
        made = super().__new__(cls, value)
        made._sigma, made._count = sigma, count
        made._by_wavelength = tuple(by_wavelength)
        return made

    @property
    def value(self) -> float:
        """Mean over batches."""
        return float(self)

    @property
    def sigma(self) -> float | None:
        """Standard error of the mean; None with a single batch."""
        return self._sigma

    @property
    def count(self) -> int | None:
        """Arrivals, where they are counted."""
        return self._count

    @property
    def by_wavelength(self) -> tuple[Estimate, ...]:
        """What each line or band of the spectrum brings, in order; empty where it is not told."""
        return self._by_wavelength

    def summary(self) -> dict[str, Any]:
        """Return the estimate as the summary holds it."""
        out: dict[str, Any] = {"value": self.value, "sigma": self.sigma}
        if self.count is not None:
            out["count"] = self.count
        if self.by_wavelength:
            out["by_wavelength"] = [part.summary() for part in self.by_wavelength]
        return out

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Estimate):
            return self.__getnewargs__() == other.__getnewargs__()
        return float.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = float.__hash__

    def __getnewargs__(self) -> tuple[Any, ...]:
        return float(self), self._sigma, self._count, self._by_wavelength

    def __str__(self) -> str:
        value, sigma = with_error(self.value, self.sigma)
        return f"{value} ± {sigma}"

    def __repr__(self) -> str:
        count = "" if self.count is None else f", count={self.count}"
        return f"{type(self).__name__}(value={self.value!r}, sigma={self.sigma!r}{count})"

    def __format__(self, how: str) -> str:
        return format(self.value, how) if how else str(self)


class Group(Table[Estimate]):
    """Rows of the ledger that belong together, by name, as items and as attributes."""

    def __getattr__(self, name: str) -> Estimate:
        if name.startswith("_") or name not in self:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return self[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name in self if name.isidentifier())]


@dataclass(frozen=True)
class Roulette:
    """What roulette took and gave.

    Parameters
    ----------
    killed : Estimate
        Power of the rays that it ended.
    boosted : Estimate
        Power that it added to those that went on.
    balance : Estimate
        killed − boosted; zero on average. Its σ comes from the batches' own balances.
    """

    killed: Estimate
    boosted: Estimate
    balance: Estimate


@dataclass(frozen=True, repr=False)
class Ledger:
    """Where the power went.

    Parameters
    ----------
    emitted : Estimate
        Power launched; its σ is exactly 0.
    absorbed : mapping of str to Estimate
        By element, in the order of the scene; both sides of each.
    escaped : Estimate
        What left the scene; equal to the far field's total.
    roulette : Roulette
        Killed, boosted, and their balance.
    depth_capped : Estimate
        Power still under way at the generation cap.
    closure : float
        emitted − absorbed − escaped − balance − depth_capped − others, in watts, exact until the
        one rounding to a float.
    worst_closure : float
        The batches' largest |closure|, in watts.
    others : mapping of str to Estimate
        Rows that effects of the scene bring, by title; negative where weight was added.
    names : mapping of str to str
        Of those the ones whose names have parts (``group.row``), by title: the summary has them in
        tables of their own, as it has what roulette took.
    """

    emitted: Estimate
    absorbed: Mapping[str, Estimate]
    escaped: Estimate
    roulette: Roulette
    depth_capped: Estimate
    closure: float
    worst_closure: float
    others: Mapping[str, Estimate] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        inside = math.fsum(self.absorbed_in.values())
        media = f"{inside:.6g} W in media, " if inside else ""
        return (
            f"<Ledger of {self.emitted:.6g} W: {math.fsum(self.absorbed.values()):.6g} W absorbed "
            f"by {len(self.absorbed)}, {media}{self.escaped:.6g} W escaped, "
            f"closure {self.closure:.1e} W>"
        )

    @classmethod
    def of(cls, compiled: CompiledScene, tally: Accumulator, worst: int) -> Ledger:
        """Return the ledger of accumulated batches.

        Parameters
        ----------
        compiled : CompiledScene
            What the cells mean and are worth.
        tally : Accumulator
            At least one batch, with the difference (killed, boosted) behind its cells.
        worst : int
            The batches' largest |closure|, in units of 2^-95 launched weights.
        """
        layout = compiled.layout
        totals = [tally.exact(cell) for cell in range(layout.n_rows)]
        known, lines = tally.batches > 1, range(layout.parts)

        def errors(first: int, n: int) -> list[float | None]:
            if not known:
                return [None] * n
            return [*(tally.standard_error(first, n) * compiled.unit_power).tolist()]

        sigmas = errors(0, layout.n_rows)
        of_parts = errors(layout.divided, layout.n_rows * layout.parts)
        # behind the cells, of all and then of each line
        of_balance = errors(layout.n_cells, 1 + layout.parts)

        def made(total: int, sigma: float | None, parts: Sequence[Estimate] = ()) -> Estimate:
            return Estimate(watts(compiled, total, tally.batches), sigma, None, parts)

        def row(cell: int, sign: int = 1) -> Estimate:
            parts = [
                made(sign * tally.exact(layout.part(cell, k)), of_parts[cell * layout.parts + k])
                for k in lines
            ]
            return made(sign * totals[cell], sigmas[cell], parts)

        elements = enumerate(compiled.scene.element)
        absorbed = Table("ledger.absorbed", ((e.name, row(n)) for n, e in elements))
        balances = [
            made(
                tally.exact(layout.part(layout.killed, k))
                - tally.exact(layout.part(layout.boosted, k)),
                of_balance[1 + k],
            )
            for k in lines
        ]
        balance = totals[layout.killed] - totals[layout.boosted]
        emitted = compiled.emitted * tally.batches
        exactly = 0.0 if known else None
        launched = [made(compiled.emitted_parts[k] * tally.batches, exactly) for k in lines]
        n = layout.n_elements
        accounted = _accounted(layout, sum(totals[:n]), totals[n:])
        return cls(
            emitted=made(emitted, exactly, launched),
            absorbed=absorbed,
            escaped=row(layout.escaped),
            roulette=Roulette(
                row(layout.killed), row(layout.boosted), made(balance, of_balance[0], balances)
            ),
            depth_capped=row(layout.depth_capped),
            closure=watts(compiled, emitted - accounted, tally.batches),
            worst_closure=watts(compiled, worst, 1),
            others=Table(
                "ledger.others",
                (
                    (item.title, row(cell, item.sign))
                    for cell, item in enumerate(layout.rows, n)
                    if item not in ROWS
                ),
            ),
            names={item.title: item.name for item in layout.rows if "." in item.name},
        )

    @property
    def absorbed_in(self) -> Group:
        """What media absorbed, by their names, in the order of the scene."""
        return self._group(ABSORBED_IN)

    def __getattr__(self, name: str) -> Group:
        """Give the rows of a group that an effect brings: ``ledger.importance.balance``.

        Raises
        ------
        AttributeError
            Where no effect of the scene brings it.
        """
        # while it is unpickled there is nothing to look into
        found = None if name.startswith("_") or "names" not in self.__dict__ else self._group(name)
        if not found:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return found

    def __dir__(self) -> list[str]:
        groups = {name.partition(".")[0] for name in self.names.values()}
        return [*super().__dir__(), *groups]

    def _group(self, group: str) -> Group:
        rows = {
            name.removeprefix(f"{group}."): self.others[title]
            for title, name in self.names.items()
            if name.startswith(f"{group}.")
        }
        return Group(f"ledger.{group}", rows)

    def summary(self) -> dict[str, Any]:
        """Return the ledger as the summary holds it."""
        roulette = self.roulette
        others, grouped = {}, dict[str, dict[str, Any]]()
        for title, row in self.others.items():
            group, _, name = self.names.get(title, "").partition(".")
            if name:
                grouped.setdefault(group, {})[name] = row.summary()
            else:
                others[title] = row.summary()
        return {
            "emitted": self.emitted.summary(),
            "absorbed": {name: row.summary() for name, row in self.absorbed.items()},
            "escaped": self.escaped.summary(),
            "roulette": {
                "killed": roulette.killed.summary(),
                "boosted": roulette.boosted.summary(),
                "balance": roulette.balance.summary(),
            },
            "depth_capped": self.depth_capped.summary(),
            **grouped,
            "closure": self.closure,
            **({"others": others} if others else {}),
        }

    def labelled_rows(self) -> list[tuple[str, Estimate]]:
        """Return every row with its name, as files and data frames name them."""
        return [
            ("emitted", self.emitted),
            *((f"absorbed: {name}", row) for name, row in self.absorbed.items()),
            ("escaped", self.escaped),
            ("roulette killed", self.roulette.killed),
            ("roulette boosted", self.roulette.boosted),
            ("roulette balance", self.roulette.balance),
            ("depth-capped", self.depth_capped),
            *self.others.items(),
        ]

    def rows(self) -> list[tuple[str, Estimate]]:
        """Return every row behind `emitted` with its title, in the order in which it is shown."""
        rows = [(name, row) for name, row in self.absorbed.items()]
        rows.append(("escaped", self.escaped))
        rows.append(("roulette balance", self.roulette.balance))
        rows.append(("depth-capped", self.depth_capped))
        return rows + list(self.others.items())


def watts(compiled: CompiledScene, total: int, batches: int) -> float:
    """Return the mean over batches of a total in units of 2^-95, in watts, rounded once."""
    return float(Fraction(total, batches) * _UNIT * Fraction(compiled.unit_power))


def _accounted(layout: TallyLayout, absorbed: int, others: Sequence[int]) -> int:
    """Return where all launched weight went; `others`: the rows behind the elements'."""
    pairs = zip(layout.rows, others, strict=True)
    return absorbed + sum(row.sign * amount for row, amount in pairs)


def closure_of(compiled: CompiledScene, cells: NDArray[np.int64] | SparseTally) -> int:
    """Return |closure| of a batch in units of 2^-95 launched weights."""
    layout = compiled.layout
    n = layout.n_elements
    absorbed, _ = exact_sum(some_of(cells, 0, n))
    others = exact(whole_of(cells, n, layout.n_rows - n))
    return abs(compiled.emitted - _accounted(layout, absorbed, others))


def closure_limit(compiled: CompiledScene) -> Fraction:
    """Return the part of the emitted power that a batch's ledger may miss by."""
    if compiled.precision.weight_roundoff == FP64.weight_roundoff:
        return CLOSURE_LIMIT
    return _ROUNDINGS * Fraction(compiled.precision.weight_roundoff)


def check_batch(compiled: CompiledScene, batch: int, cells: NDArray[np.int64] | SparseTally) -> int:
    """Check a batch's ledger and return |closure| in units of 2^-95 launched weights.

    Parameters
    ----------
    compiled : CompiledScene
        What the cells mean.
    batch : int
        Number of the batch, for the message.
    cells : ndarray, shape (n_cells, 4), int64, or SparseTally
        Its completed tally.

    Raises
    ------
    RunError
        Where the ledger does not close to `closure_limit`, the far field's total is not exactly
        what escaped (where it leaves directions out: is more), or a detector shows more than its
        element absorbed.
    """
    layout = compiled.layout
    closure = closure_of(compiled, cells)
    limit = closure_limit(compiled)
    if closure > limit * compiled.emitted:
        part = float(Fraction(closure, compiled.emitted))
        raise RunError(
            f"batch {batch}: the ledger misses {part:.3e} of the emitted power (at most "
            f"{float(limit):.0e} is rounding): {_DEFECT}"
        )
    n_bins = layout.n_mu * layout.n_phi
    if n_bins:
        bins, _ = exact_sum(some_of(cells, layout.far_field, n_bins))
        (escaped,) = exact(whole_of(cells, layout.escaped, 1))
        far = compiled.scene.far_field
        if bins > escaped or (bins != escaped and (far is None or far.whole)):
            part = float(Fraction(bins - escaped, compiled.emitted))
            raise RunError(
                f"batch {batch}: the far field's total is not what escaped (it differs by "
                f"{part:.3e} of the emitted power): {_DEFECT}"
            )
    for d in layout.detectors:
        (power,), (taken,) = (exact(whole_of(cells, at, 1)) for at in (d.power, d.element))
        element = compiled.scene.element[d.element]
        # what passes is not taken, and passes as often as it comes
        if power < 0 or (all(s.counts for s in element.surfaces) and power > taken):
            name = element.name
            raise RunError(
                f"batch {batch}: the detector on {name!r} shows more than the element absorbed: "
                f"{_DEFECT}"
            )
    return closure
