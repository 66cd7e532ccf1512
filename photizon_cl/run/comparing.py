"""Comparing two results, in memory or on disk."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.errors import ResultError
from photizon_cl.result.comparison import Comparison, compared
from photizon_cl.result.estimates import Estimates
from photizon_cl.run.result import open_result

if TYPE_CHECKING:
    import os

__all__ = ["compare"]


def compare(
    a: Estimates | str | os.PathLike[str], b: Estimates | str | os.PathLike[str]
) -> Comparison:
    """Compare two runs, the second against the first: difference and ratio of every quantity.

    Where both runs have the same seed and rays per batch, batch is held against batch: what they
    have in common cancels, and a small difference shows with far fewer rays. Else their standard
    errors are added in quadrature; which of the two is said in each row.

    Parameters
    ----------
    a, b : Result, str or path
        Results, or directories or files of some.

    Returns
    -------
    Comparison
        A `Difference` for each quantity that both have, by iteration and by name.

    Raises
    ------
    ResultError
        Where a path holds no result; of both paths, where neither does.

    Examples
    --------
    >>> import photizon_cl as pz
    >>> runs = [pz.trace("integrating-sphere", batches=8, rays_per_batch=256) for _ in range(2)]
    >>> pz.compare(*runs)["ledger.escaped"].difference
    0.0
    """
    found: list[Estimates] = []
    problems: list[str] = []
    for given in (a, b):
        try:
            found.append(given if isinstance(given, Estimates) else open_result(given))
        except ResultError as error:
            if str(error) not in problems:
                problems.append(str(error))
    if problems:
        raise ResultError("\n".join(problems))
    return compared(*found)
