"""Two runs side by side: differences and ratios of every quantity, with their standard errors.

Two runs of the same seed and rays per batch launch the same random numbers: ray n of one and ray n
of the other start alike and part where the scenes differ. What they have in common cancels in the
difference of a batch and its counterpart (common random numbers; Glasserman, Monte Carlo Methods in
Financial Engineering, 2003, § 4.3 and 7.1), so the scatter of those differences is what the
difference is known by. Of other runs the errors are taken as independent and add in quadrature.

Where one of two such runs has more batches, what is beyond the common ones may tell more than
pairing does. All batches of both give the difference too, with
σ² = σ_a² + σ_b² − 2 n cov/(n_a n_b), where n batches are common and cov is that of a pair of them;
each quantity is told by whichever of the two has the smaller σ.
"""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.compile.quantities import BY_LINE, scalars
from photizon_cl.errors import ArgumentError
from photizon_cl.result.ledger import Estimate
from photizon_cl.scene.names import unknown_name
from photizon_cl.scene.parameter_paths import path_parts

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator

    from numpy.typing import NDArray

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.scene.model import Scene

    _Pair = tuple[NDArray[np.float64], NDArray[np.float64]]

__all__ = [
    "COMPARISON_SCHEMA",
    "Comparison",
    "Difference",
    "compared",
    "difference_of",
    "error_of_mean",
]

COMPARISON_SCHEMA: Final = "photizon-comparison/1"
_OF_LINE: Final = re.compile(rf"(.*\.{BY_LINE})\[(\d+)\]", re.DOTALL)
"""A quantity of one line or band; names with such an end in them stand in quotes."""


@dataclass(frozen=True)
class Difference:
    """A quantity of two runs, `b` against `a`.

    Parameters
    ----------
    name : str
        The quantity's; of a line or band whose number differs between the two, that in the first.
    a, b : Estimate
        What each run says in watts, of the batches that were compared: all, or where they are
        paired and one run has more, those that both have.
    difference : float
        b − a in watts. Paired, of the batches that both have.
    sigma : float or None
        Its standard error; None where fewer than two batches tell.
    ratio : float or None
        b/a; None where a is 0. Paired, of the batches that both have.
    ratio_sigma : float or None
        Its standard error, to first order in the errors of both.
    paired : bool
        Whether batch was held against batch; else the errors were added in quadrature.
    whole : bool
        Whether it is of all batches of two runs of which a part pairs, since that has the smaller
        error: the errors in quadrature, less what the pairs have in common.
    """

    name: str
    a: Estimate
    b: Estimate
    difference: float
    sigma: float | None
    ratio: float | None
    ratio_sigma: float | None
    paired: bool
    whole: bool = False

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "name": self.name,
            "a": self.a.summary(),
            "b": self.b.summary(),
            "difference": self.difference,
            "sigma": self.sigma,
            "ratio": self.ratio,
            "ratio_sigma": self.ratio_sigma,
            "paired": self.paired,
            "whole": self.whole,
        }


@dataclass(frozen=True)
class Comparison:
    """Every quantity that two runs have in common.

    Iterating gives a `Difference` for each; ``comparison["detectors.floor.power"]`` gives one.

    Parameters
    ----------
    a, b : str
        Names of the scenes.
    rows : tuple of Difference
        In the order of the first run.
    only_a, only_b : tuple of str
        Quantities that one run alone has, by its own names: what a line or band of the spectrum
        brings is the same quantity only at the same wavelength, or between the same edges.
    batches : int
        Batches that were held against each other; 0 where none were.
    why : str
        Why batches were paired, or were not.
    lines : tuple of str
        What the lines or bands of the first run are called; empty without a spectrum.
    """

    a: str
    b: str
    rows: tuple[Difference, ...]
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    batches: int
    why: str
    lines: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Difference]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Difference:
        found = None
        with suppress(ArgumentError):
            parts = path_parts(name)
            found = next((row for row in self.rows if path_parts(row.name) == parts), None)
        if found is None:
            raise unknown_name("comparison", name, [row.name for row in self.rows])
        return found

    def parts_of(self, name: str) -> tuple[str, str]:
        """Return the quantity that a name is of, and the line or band, empty where of all."""
        of_line = _OF_LINE.fullmatch(name)
        if of_line is None or int(of_line[2]) >= len(self.lines):
            return name, ""
        return of_line[1].removesuffix(f".{BY_LINE}"), self.lines[int(of_line[2])]

    def summary(self) -> dict[str, Any]:
        """Return the comparison as plain values that JSON can hold."""
        return {
            "schema": COMPARISON_SCHEMA,
            "a": self.a,
            "b": self.b,
            "paired_batches": self.batches,
            "why": self.why,
            "quantities": [row.summary() for row in self.rows],
            "only_a": list(self.only_a),
            "only_b": list(self.only_b),
        }


def compared(a: Estimates, b: Estimates) -> Comparison:
    """Compare two runs, the second against the first.

    Parameters
    ----------
    a, b : Estimates
        At least one batch each.
    """
    of_a, of_b = ({q.name: q for q in scalars(r.scene, r.compiled.layout)} for r in (a, b))
    partner = _partners(a.scene, b.scene, of_a, of_b)
    common, why = _pairs(a, b)
    if a.scene.spectrum and b.scene.spectrum and a.scene.spectrum != b.scene.spectrum:
        why += "; their spectra differ: lines and bands are matched by wavelength, not by number"
    rows = []
    for name, other in partner.items():
        both = None
        if common:
            x = a.tally.batch_values.of(of_a[name].first)
            y = b.tally.batch_values.of(of_b[other].first)
            if x is not None and y is not None:
                both = (
                    x[:common] * a.compiled.unit_power,
                    y[:common] * b.compiled.unit_power,
                )
        one, two = a.quantity(name), b.quantity(other)
        pairs = _of(one, a.batches, both, 0), _of(two, b.batches, both, 1)
        row = difference_of(name, *pairs, both)
        if both is not None and a.batches != b.batches:
            every = _of_all(name, one, two, both, (a.batches, b.batches))
            row = min(row, every, key=lambda d: math.inf if d.sigma is None else d.sigma)
        rows.append(row)
    matched = set(partner.values())
    return Comparison(
        a.scene.name,
        b.scene.name,
        tuple(rows),
        tuple(name for name in of_a if name not in partner),
        tuple(name for name in of_b if name not in matched),
        common,
        why,
        a.scene.spectrum.names if a.scene.spectrum is not None else (),
    )


def _partners(a: Scene, b: Scene, of_a: Iterable[str], of_b: Container[str]) -> dict[str, str]:
    """Return which quantity of the second scene is which of the first, by name.

    What a line or band brings is that of the same wavelength or edges, whatever its number.
    """
    lines: dict[int, int] | None = None
    if a.spectrum is not None and b.spectrum is not None and a.spectrum != b.spectrum:
        there = {line: number for number, line in enumerate(b.spectrum.lines_nm)}
        lines = {n: there[line] for n, line in enumerate(a.spectrum.lines_nm) if line in there}
    found = {}
    for name in of_a:
        other: str | None = name
        of_line = _OF_LINE.fullmatch(name)
        if lines is not None and of_line is not None:
            number = lines.get(int(of_line[2]))
            other = None if number is None else f"{of_line[1]}[{number}]"
        if other is not None and other in of_b:
            found[name] = other
    return found


def _pairs(a: Estimates, b: Estimates) -> tuple[int, str]:
    """Return how many batches pair, and why, or why none do."""
    one, other = a.scene.run, b.scene.run
    if one.seed != other.seed:
        return 0, f"the seeds differ ({one.seed} and {other.seed})"
    if one.rays_per_batch != other.rays_per_batch:
        return 0, f"the rays per batch differ ({one.rays_per_batch} and {other.rays_per_batch})"
    if not (a.tally.batch_values.kept and b.tally.batch_values.kept):
        return 0, "single batches were not kept, as in very long runs and by earlier versions"
    if a.info.engine != b.info.engine:
        return 0, "other versions of the engine made them"
    n = min(a.batches, b.batches)
    if n < 2:
        return 0, "a single batch has no scatter"
    first = "" if a.batches == b.batches else f", and the first {n} batches"
    modes = a.info.precision, b.info.precision
    apart = ""
    if modes[0] != modes[1]:  # the same random words, cut to what each computes in
        apart = (
            f"; they are in {modes[0]} and {modes[1]}, whose draws are the same but for rounding"
        )
    return n, f"both have the seed {one.seed} and {one.rays_per_batch} rays per batch{first}{apart}"


def _of(quantity: Estimate, batches: int, both: _Pair | None, which: int) -> Estimate:
    """Return what the batches say that are compared."""
    if both is None or len(both[which]) == batches:
        return quantity
    return Estimate(float(both[which].mean()), error_of_mean(both[which]))


def difference_of(
    name: str,
    a: Estimate,
    b: Estimate,
    both: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
) -> Difference:
    """Return how a quantity differs between two runs.

    Parameters
    ----------
    name : str
        The quantity's.
    a, b : Estimate
        What each run says.
    both : (ndarray, ndarray) or None
        What each batch of either gave, as many of one as of the other; None where they do not pair.
    """
    if both is None:
        known = a.sigma is not None and b.sigma is not None
        sigma = math.hypot(a.sigma or 0.0, b.sigma or 0.0) if known else None
        ratio = b.value / a.value if a.value else None
        ratio_sigma = None
        if known and ratio is not None:
            ratio_sigma = math.hypot(b.sigma or 0.0, ratio * (a.sigma or 0.0)) / abs(a.value)
        return Difference(name, a, b, b.value - a.value, sigma, ratio, ratio_sigma, paired=False)
    x, y = both
    base = float(x.mean())
    ratio = float(y.mean()) / base if base else None
    ratio_sigma = None if ratio is None else error_of_mean(y - ratio * x) / abs(base)
    apart = y - x
    return Difference(
        name, a, b, float(apart.mean()), error_of_mean(apart), ratio, ratio_sigma, paired=True
    )


def _of_all(
    name: str, a: Estimate, b: Estimate, both: _Pair, batches: tuple[int, int]
) -> Difference:
    """Return how a quantity differs between two runs, of all batches, of which some pair."""
    x, y = both
    alone = difference_of(name, a, b, None)
    if a.sigma is None or b.sigma is None or alone.sigma is None:
        return alone
    covariance = float(np.cov(x, y)[0, 1])
    most = math.sqrt(batches[0] * batches[1]) * a.sigma * b.sigma  # no correlation is above 1
    shared = max(min(covariance, most), -most) * len(x) / (batches[0] * batches[1])
    sigma = math.sqrt(a.sigma**2 + b.sigma**2 - 2.0 * shared)
    ratio_sigma = None
    if alone.ratio is not None:
        square = b.sigma**2 + (alone.ratio * a.sigma) ** 2 - 2.0 * alone.ratio * shared
        ratio_sigma = math.sqrt(max(square, 0.0)) / abs(a.value)
    return replace(alone, sigma=sigma, ratio_sigma=ratio_sigma, whole=True)


def error_of_mean(values: NDArray[np.float64]) -> float:
    """Return the standard error of the mean of at least two numbers."""
    return float(values.std(ddof=1)) / math.sqrt(len(values))
