"""Parameters that are lists of numbers of any length, and lists of one length."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from photizon_cl.errors import Problem, counted, show
from photizon_cl.scene.parameters import BAD, Number, Parameter

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known

__all__ = ["Ascending", "lengths_agree"]


class Ascending(Parameter):
    """Ascending numbers in a closed interval, read as a tuple of floats.

    Parameters
    ----------
    what : str
        What they are, in the plural: "angles in degrees".
    low, high : float
        The interval.
    least, most : int
        How many there may be.
    closest : float
        How far one must lie above the one before at least.
    meaning, unit : str
        For documentation.
    hint : str
        What to know of the interval.
    """

    def __init__(
        self,
        what: str,
        low: float,
        high: float,
        *,
        least: int,
        most: int,
        closest: float,
        meaning: str,
        unit: str = "",
        hint: str = "",
    ) -> None:
        super().__init__(meaning, unit)
        self._range = f"from {low:g} to {high:g}"
        self._what, self._least, self._most, self._closest = what, least, most, closest
        self._item = Number(f"a number {self._range}", low, high, hint=hint)

    @property
    def expected(self) -> str:  # noqa: D102
        number = f"{self._least} to {self._most}" if self._least < self._most else f"{self._least}"
        return f"{number} ascending {self._what}, {self._range}"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        to_list = getattr(value, "tolist", None)  # a numpy array
        listed = to_list() if callable(to_list) else value
        if isinstance(listed, str | bytes) or not isinstance(listed, Sequence):
            return self.refuse(value, path, problems, "write them in brackets")
        if not self._least <= len(listed) <= self._most:
            there = f"{len(listed)} number" + "s" * (len(listed) != 1)
            problems.append(Problem(path, there, self.expected))
            return BAD
        found: list[float] = []
        for i, item in enumerate(listed):
            number = self._item.read(item, f"{path}[{i}]", problems)
            if number is BAD:
                return BAD
            if found and number - found[-1] < self._closest:
                return self._out_of_order(path, i, found[-1], number, problems)
            found.append(number)
        return tuple(found)

    def _out_of_order(
        self, path: str, i: int, before: float, number: float, problems: list[Problem]
    ) -> Any:
        hint = "they ascend, and none stands twice"
        if number > before:
            hint = f"closer than {self._closest:g} they are not told apart"
        expected = f"a number above {show(before)}, which stands before it"
        problems.append(Problem(f"{path}[{i}]", show(number), expected, hint=hint))
        return BAD


def lengths_agree(known: Known, nodes: str, each: str, *items: str) -> list[Problem]:
    """Return the problems of a table that has not one value for each node.

    Parameters
    ----------
    known : Known
        The table; what was refused of it has no length.
    nodes : str
        Its key of nodes.
    each : str
        What each node is: "angle".
    *items : str
        Its keys of values.
    """
    at = known.get(nodes)
    if at is None:
        return []
    expected = f"{counted(len(at), 'number')}, one for each {each}"
    return [
        Problem(item, f"{len(values)} of them", expected)
        for item in items
        if (values := known.get(item)) is not None and len(values) != len(at)
    ]
