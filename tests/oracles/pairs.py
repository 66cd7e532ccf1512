"""Which pairs of two choices are tried unless slow tests are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


def alternately(first: Iterable[Any], second: Mapping[str, Any], every: int = 1) -> list[Any]:
    """Return parameters of all pairs, of which one for each first value is not slow, in turn.

    Parameters
    ----------
    first : iterable
        Values of the first parameter, whose ids are their texts.
    second : mapping of str to object
        Values of the second one by id.
    every : int, optional
        All others of the first values are slow.
    """
    pairs = []
    for n, one in enumerate(first):
        for k, (name, other) in enumerate(second.items()):
            marks = [pytest.mark.slow] if (n // every + k) % len(second) or n % every else []
            pairs.append(pytest.param(one, other, id=f"{one}-{name}", marks=marks))
    return pairs
