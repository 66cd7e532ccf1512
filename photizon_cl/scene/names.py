"""What is found by its name: a scene's objects, a result's detectors and rows.

A name that is not there is told with those that are, and with the one that was probably meant.
"""

from __future__ import annotations

import difflib
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol, SupportsIndex, TypeVar, overload

from photizon_cl.errors import UnknownNameError, show
from photizon_cl.scene.limits import MOST_CHARACTERS

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

__all__ = ["ByName", "Table", "similar", "unknown_name"]

_MOST_NAMES = 12  # that a message lists


class HasName(Protocol):
    """An object of a scene."""

    @property
    def name(self) -> str:
        """Its name."""


_N = TypeVar("_N", bound=HasName, covariant=True)
_V = TypeVar("_V")


def similar(word: object, known: Iterable[str]) -> list[str]:
    """Return the known word that another one was probably meant for; long ones are not read."""
    text = str(word)
    if len(text) > MOST_CHARACTERS:
        return []
    names, low = list(known), text.lower()
    same = [name for name in names if name.lower() == low]
    return same[:1] or difflib.get_close_matches(low, names, 1)


def unknown_name(
    what: str, name: object, names: Collection[str], more: str = ""
) -> UnknownNameError:
    """Return the error that a name is not there.

    Parameters
    ----------
    what : str
        What has names, for example ``detectors``.
    name : object
        What was asked for.
    names : collection of str
        What there is.
    more : str, optional
        Why it is not there, or what to do.
    """
    close = difflib.get_close_matches(str(name), names, 1) or difflib.get_close_matches(
        str(name).lower(), names, 1
    )
    listed = [show(one) for one in list(names)[:_MOST_NAMES]]
    left = len(names) - len(listed)
    expected = "one of " + ", ".join(listed) + (f" and {left} more" if left else "")
    hints = [more] if more else []
    hints += [f"did you mean {show(close[0])}?"] if close and not more else []
    return UnknownNameError(
        f"{what}: found {show(name)}, expected {expected if names else 'nothing: there are none'}"
        + "".join(f" ({hint})" for hint in hints)
    )


class ByName(tuple[_N, ...]):
    """A scene's objects in file order: a tuple whose items are found by name as well.

    ``scene.element["wall"]``, ``scene.element[0]``, ``"wall" in scene.element``.
    """

    @cached_property
    def _number(self) -> dict[str, int]:
        return {item.name: n for n, item in enumerate(self)}

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, in order."""
        return tuple(item.name for item in self)

    @overload
    def __getitem__(self, at: str | SupportsIndex, /) -> _N: ...

    @overload
    def __getitem__(self, at: slice, /) -> tuple[_N, ...]: ...

    def __getitem__(self, at: str | SupportsIndex | slice, /) -> Any:
        if not isinstance(at, str):
            return tuple.__getitem__(self, at)
        if at not in self._number:
            label = getattr(type(self[0]), "label", "") if self else ""
            raise unknown_name(label or "name", at, self._number)
        return tuple.__getitem__(self, self._number[at])

    def __contains__(self, item: object) -> bool:
        return item in self._number if isinstance(item, str) else tuple.__contains__(self, item)

    def __reduce__(self) -> tuple[Any, ...]:  # the numbers by name follow from the rest
        return type(self), (tuple(self),)

    def __repr__(self) -> str:
        shown = [show(name) for name in self.names[:_MOST_NAMES]]
        left = len(self) - len(shown)
        return f"<{len(self)}: {', '.join(shown)}{f' and {left} more' if left else ''}>"


class Table(dict[str, _V]):
    """A dictionary by name that says what there is where a name is not.

    Parameters
    ----------
    what : str
        What it holds, for messages.
    items : mapping or iterable of pairs
        Its items, in order.
    lacking : collection of str, optional
        Names that exist and have no entry here.
    why : str, optional
        What is then said.
    """

    def __init__(
        self,
        what: str,
        items: Mapping[str, _V] | Iterable[tuple[str, _V]],
        lacking: Collection[str] = (),
        why: str = "",
    ) -> None:
        super().__init__(items)
        self._what, self._lacking, self._why = what, lacking, why

    def __missing__(self, name: str) -> _V:
        raise unknown_name(self._what, name, self, self._why if name in self._lacking else "")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._what, dict(self), self._lacking, self._why)
