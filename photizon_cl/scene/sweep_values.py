"""The values of a sweep's axes: lists, even and logarithmic steps.

Steps are part of the bits: each value is the double next to the exact one, of the ends as they are
written in decimals, whatever the machine's mathematics library says of powers.
"""

from __future__ import annotations

import json
import math
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any, Final

from photizon_cl.errors import Problem, show

__all__ = ["MOST_POINTS", "SPACINGS", "is_numeric", "plain_value", "read_spacing", "value_text"]

MOST_POINTS: Final = 10_000
"""Points of a sweep: each is a run, with a directory of its own."""
SPACINGS: Final = ("linspace", "logspace")
_DIGITS: Final = Context(prec=60)
_INTERVAL: Final = "[from, to, n]: two numbers, and an integer from 2 on"


def read_spacing(key: str, found: object, path: str, problems: list[Problem]) -> list[Any] | None:
    """Return the values of ``linspace`` or ``logspace``; None, and a problem, where it is none.

    Parameters
    ----------
    key : str
        Which of the two.
    found : object
        What stands there: both ends belong to the values.
    path : str
        For the problem.
    problems : list of Problem
        What is wrong is added.
    """

    def refuse(what: str, expected: str, hint: str = "") -> None:
        problems.append(Problem(path, what, expected, hint=hint))

    if not (isinstance(found, list | tuple) and len(found) == 3 and all(map(_number, found))):
        refuse(show(found), _INTERVAL)
        return None
    first, last, n = found
    if isinstance(n, float) or n < 1:
        empty = "the axis would be empty" if not isinstance(n, float) else ""
        refuse(show(found), _INTERVAL, empty)
        return None
    if n == 1:
        refuse(show(found), _INTERVAL, "a single value is values = [x]")
        return None
    if n > MOST_POINTS:
        refuse(f"{n} values", f"at most {MOST_POINTS} points: each is a run of its own")
        return None
    if first == last:
        refuse(show(found), _INTERVAL, "both ends are the same")
        return None
    if key == "linspace":
        return _even(first, last, n)
    if first <= 0.0 or last <= 0.0:
        refuse(show(found), "two numbers above 0", "its steps are equal factors")
        return None
    return _logarithmic(first, last, n)


def _number(value: object) -> bool:
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and abs(value) < 1e300
        and math.isfinite(value)
    )


def _even(first: float, last: float, n: int) -> list[Any]:
    """Return n values in equal steps; between integers, those that are whole are integers."""
    low, high = (Fraction(repr(end)) for end in (first, last))  # the decimals that were written
    step = (high - low) / (n - 1)
    values = [low + i * step for i in range(n)]
    whole = isinstance(first, int) and isinstance(last, int)
    return [int(v) if whole and v.denominator == 1 else float(v) for v in values]


def _logarithmic(first: float, last: float, n: int) -> list[float]:
    """Return n values in equal factors."""
    a, b = (_DIGITS.ln(Decimal(repr(end))) for end in (first, last))
    step = _DIGITS.divide(_DIGITS.subtract(b, a), Decimal(n - 1))
    inner = [
        float(_DIGITS.exp(_DIGITS.add(a, _DIGITS.multiply(step, Decimal(i)))))
        for i in range(1, n - 1)
    ]
    return [float(first), *inner, float(last)]


def is_numeric(values: list[Any]) -> bool:
    """Say whether all values are numbers, so that an axis can be drawn to scale."""
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def value_text(value: Any) -> str:
    """Return a value as it stands in tables: numbers and words as they are, else as JSON."""
    if isinstance(value, str):
        return value
    return json.dumps(plain_value(value), ensure_ascii=False, sort_keys=True, default=str)


def plain_value(value: Any) -> Any:
    """Return a value as JSON can hold it, infinity as the text that scene files have for it."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, list | tuple):
        return [plain_value(item) for item in value]
    if isinstance(value, dict):
        return {str(key): plain_value(item) for key, item in value.items()}
    if hasattr(value, "to_table"):
        return plain_value(value.to_table())
    if hasattr(value, "tolist"):  # of numpy
        return plain_value(value.tolist())
    return value
