"""Whether a standard error can be believed: statistical checks of a scalar.

σ from batches is an estimate itself. Where a path is bright and rare, most batches lack it, and σ
comes out too small until it was seen often enough. So beside σ stand the variance of the variance
(the relative variance of σ², S. Pederson, R. A. Forster and T. E. Booth, Nucl. Sci. Eng. 127, 54,
1997), which falls as 1/n for any well-behaved quantity and is about 1/k where k events make up the
scatter; the part of the total that a single arrival may have, from the heaviest that a ray can be
and from the largest batch: where rare arrivals with the weight of launched rays stand beside many
weak ones, and where all weigh the same, that is the largest's exactly;
and, of detectors, how many equal arrivals would have such a σ, beside how many there were. Where
those are few of very many, few arrivals carry what makes σ, and more of their kind may not have
been seen. Where rays split, of which many arrivals may be of one ray, at most all rays count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from photizon_cl.result.ledger import Estimate
from photizon_cl.result.stopping import LEAST_BATCHES

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Checks", "Scalar"]

_GOOD_SIGMA: Final = 0.1
"""Relative standard error up to which an estimate is good (MCNP's limit)."""
_GOOD_VARIANCE: Final = 0.1
"""Variance of the variance up to which σ is known well enough (MCNP's limit)."""
_GOOD_SHARE: Final = 0.1
"""Part of the total that the largest batch may have, or two batches' worth where they are few."""
_EVEN: Final = 0.01
"""Part of the arrivals that at least make up σ where their weights are even enough."""
_MANY: Final = 1000.0
"""Effective arrivals from which on σ is known well, however uneven their weights are.

By a σ that is as large as it may well be: that of few batches comes out too small by chance.
"""
_ONE_IN_20: Final = -1.6449
"""Of normal deviates one in 20 is smaller."""
_OF_NORMAL: Final = (
    (2, 8, 10, 12, 16, 20, 24, 32, 40, 50, 64),
    (1.0, 0.543, 0.516, 0.474, 0.382, 0.310, 0.258, 0.185, 0.142, 0.107, 0.078),
)
"""Batches, and the variance of the variance that normal ones exceed once in a thousand times.

By 1.6 million draws of each; few batches have a large one whatever they are of.
"""


@dataclass(frozen=True)
class Checks:
    """Statistical checks of a scalar.

    Parameters
    ----------
    batches : int
        At least two.
    relative_sigma : float
        σ over the value; infinite where that is 0.
    variance_of_variance : float
        Relative variance of σ²: Σd⁴/(Σd²)² − 1/n over the batches' deviations d from their mean.
    largest_share : float
        Part of the total that a single arrival may have: no arrival has more.
    largest_batch : float
        Part of the total that the largest batch has.
    count : int or None
        Independent arrivals, of rays that split at most as many as rays; None where they are not
        counted.
    """

    batches: int
    relative_sigma: float
    variance_of_variance: float
    largest_share: float
    count: int | None = None
    largest_batch: float = 1.0

    @classmethod
    def of(
        cls,
        values: NDArray[np.float64],
        count: int | None = None,
        heaviest: float = math.inf,
    ) -> Checks | None:
        """Return the checks of what each batch gave; None of fewer than two, or of zeros alone.

        `heaviest` is what a single arrival can give at most, in the unit of the values.
        """
        n = len(values)
        if n < 2 or not values.any():
            return None
        total, apart = float(values.sum()), values - values.mean()
        # to 1 at most, so that no power of them over- or underflows
        largest = float(np.abs(apart).max())
        scaled = apart / largest if largest else apart
        square = float((scaled**2).sum())
        fourth = float((scaled**4).sum())
        sigma = largest * math.sqrt(square / (n - 1) / n)
        # what comes and goes may have no total to speak of
        batch = min(float(np.abs(values).max()) / abs(total), 1.0) if total else 1.0
        return cls(
            n,
            sigma * n / abs(total) if total else math.inf,
            max(fourth / square**2 - 1.0 / n, 0.0) if square else 0.0,
            min(batch, heaviest / abs(total)) if total else 1.0,
            count,
            batch,
        )

    @property
    def effective_arrivals(self) -> float | None:
        """Equal, independent arrivals that have this σ, (value/σ)²; None where it is 0."""
        return 1.0 / self.relative_sigma**2 if self.relative_sigma > 0.0 else None

    @property
    def limit(self) -> float:
        """Largest variance of the variance that is good, of so many batches."""
        return max(_GOOD_VARIANCE, float(np.interp(self.batches, *_OF_NORMAL, right=0.0)))

    @property
    def good(self) -> dict[str, bool]:
        """Which of them are good, by name."""
        return {
            "relative_sigma": self.relative_sigma <= _GOOD_SIGMA,
            "variance_of_variance": self.variance_of_variance <= self.limit,
            "largest_share": self.largest_share <= max(_GOOD_SHARE, 2.0 / self.batches),
            "effective_arrivals": self._even,
        }

    @property
    def _even(self) -> bool:
        effective = self.effective_arrivals
        if self.count is None or effective is None:
            return True
        return effective >= min(_EVEN * self.count, _MANY / _least_variance(self.batches))

    @property
    def believable(self) -> bool:
        """Whether σ says how far off the value may be, large as it may be; not of few batches."""
        good = self.good
        return (
            self.batches >= LEAST_BATCHES
            and good["variance_of_variance"]
            and good["effective_arrivals"]
        )

    def reason(self) -> str:
        """Say what is not good, as what follows the quantity's σ."""
        advice = (
            "more that is rare and bright may not have been seen: run longer before relying on it"
        )
        effective = self.effective_arrivals
        if not self.good["effective_arrivals"] and effective is not None:
            return (
                f"is made by few of its {self.count} arrivals, as large as {effective:.3g} equal "
                f"ones would have it; {advice}"
            )
        if self.believable and not self.good["relative_sigma"]:
            return (
                f"is {100.0 * self.relative_sigma:.2g} % of it, and an error of more than "
                f"{100.0 * _GOOD_SIGMA:.0f} % is poorly known itself; run longer"
            )
        return (
            f"is made by few of {self.batches} batches (variance of the variance "
            f"{self.variance_of_variance:.2g}, good up to {self.limit:.2g}; the largest batch has "
            f"{100.0 * self.largest_batch:.2g} % of the total); {advice}"
        )

    def summary(self) -> dict[str, Any]:
        """Return the checks as the summary holds them."""
        return {
            "relative_sigma": self.relative_sigma if math.isfinite(self.relative_sigma) else None,
            "variance_of_variance": self.variance_of_variance,
            "largest_share": self.largest_share,
            "effective_arrivals": self.effective_arrivals,
            "good": self.good,
            "believable": self.believable,
        }


def _least_variance(batches: int) -> float:
    """Return what normal batches show of their variance, but in one of 20 cases.

    The 5 % point of χ² over its degrees of freedom (E. B. Wilson and M. M. Hilferty, Proc. Natl.
    Acad. Sci. 17, 684, 1931); good to 1 % from 8 batches on.
    """
    part = 2.0 / (9.0 * (batches - 1))
    return max(1.0 - part + _ONE_IN_20 * math.sqrt(part), 0.1) ** 3


class Scalar(Estimate):
    """An estimate that has a name, and checks of its standard error."""

    __slots__ = ("_checks", "_name")
    _name: str
    _checks: Checks | None

    @classmethod
    def of(
        cls, name: str, checks: Checks | None, value: float, sigma: float | None, count: int | None
    ) -> Self:
        """Return a scalar."""
        made = cls(value, sigma, count)
        made._name, made._checks = name, checks
        return made

    @property
    def name(self) -> str:
        """Its name."""
        return self._name

    @property
    def checks(self) -> Checks | None:
        """Checks of its σ; None with a single batch, of 0, or where batches were not kept."""
        return self._checks

    def __reduce__(self) -> tuple[Any, ...]:
        return Scalar.of, (self._name, self._checks, float(self), self.sigma, self.count)
