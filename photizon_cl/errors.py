"""Errors that photizon_cl raises on purpose, and the exit status that each one gives.

The tree::

    PhotizonError                       exit status 1
    ├── SceneError (also ValueError)    2   a scene, as read or as built in code, is not valid
    ├── ArgumentError (also ValueError) 2   a call's or command's argument is not valid
    │   └── UnknownNameError (also KeyError)  a name that is looked up is not there
    ├── ResultError (also ValueError)   2   a result directory or file cannot be used
    ├── RecipeError (also ValueError)   2   a recipe's token is not one, or cannot be used here
    └── RunError (also RuntimeError)    1   a run was started and failed
        └── NoRoomError                 1   it has no memory to go on

What goes wrong in a run that goes on all the same is a `RunWarning`.

The command line prints ``str(error)`` on standard error and leaves with ``exit_code``; anything
else that surfaces is a defect of the program and keeps its traceback.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

_WIDTH = 60  # characters of a found value that a message shows
MOST_PROBLEMS = 100  # of one scene that are told
_INTEGER_BITS = 256  # longer integers are described; str() of a giant one is itself an error


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a scene.

    Parameters
    ----------
    path : str
        Key path, for example ``element[2].surface.reflectance``; empty for the scene as a whole.
        Indices count from 0.
    found : str
        The value found, as text (see `show`); ``nothing`` where a required key is missing.
    expected : str
        What would have been accepted.
    file : str, optional
        File that was read; None for scenes that were built in code.
    hint : str, optional
        What to do about it, or why.
    owner : str, optional
        Name of the source or element that holds the key, for example ``element "wall"``.
    """

    path: str
    found: str
    expected: str
    file: str | None = None
    hint: str = ""
    owner: str = ""

    def __str__(self) -> str:
        """Give the problem on one line."""
        where = ": ".join(part for part in (self.file, self.path) if part)
        aside = "; ".join(
            part for part in (f"in {self.owner}" if self.owner else "", self.hint) if part
        )
        text = f"found {self.found}, expected {self.expected}"
        return (f"{where}: " if where else "") + text + (f" ({aside})" if aside else "")

    def under(self, prefix: str) -> Problem:
        """Return the same problem with `prefix` put before its path."""
        return replace(self, path=join(prefix, self.path))


def counted(n: int, what: str) -> str:
    """Return a number of things: ``one number``, ``3 numbers``."""
    return f"one {what}" if n == 1 else f"{n} {what}s"


def with_article(kind: str) -> str:
    """Return a kind with its article: ``a disk``, ``an isotropic-point``."""
    return f"{'an' if kind[:1] in 'aeiou' else 'a'} {kind}"


class PhotizonError(Exception):
    """Base of every error that photizon_cl raises on purpose."""

    exit_code: ClassVar[int] = 1


class SceneError(PhotizonError, ValueError):
    """A scene is not valid; carries the problems that were found, in reading order.

    Parameters
    ----------
    problems : iterable of Problem
        At least one. Of more than a hundred, the last one that is kept says how many there are.
    """

    exit_code: ClassVar[int] = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = _first(tuple(problems))
        super().__init__(self.problems)

    def __str__(self) -> str:
        """Give one line for each problem."""
        return "\n".join(str(problem) for problem in self.problems)


def _first(problems: tuple[Problem, ...]) -> tuple[Problem, ...]:
    """Return as many problems as anybody reads."""
    more = len(problems) - MOST_PROBLEMS + 1
    if more < 2:
        return problems
    hint = f"the first {MOST_PROBLEMS - 1} are told"
    last = Problem("", f"at least {more} more problems", "none", problems[0].file, hint)
    return (*problems[: MOST_PROBLEMS - 1], last)


class ArgumentError(PhotizonError, ValueError):
    """An argument of a call or a command is not valid."""

    exit_code: ClassVar[int] = 2


class UnknownNameError(ArgumentError, KeyError):
    """A name that is looked up is not there; says what is."""

    def __str__(self) -> str:
        """Give the message; a KeyError would quote it."""
        return str(self.args[0]) if self.args else ""


class ResultError(PhotizonError, ValueError):
    """A result directory or file is missing, damaged, or of another kind."""

    exit_code: ClassVar[int] = 2


class RecipeError(PhotizonError, ValueError):
    """A recipe is damaged, or its scene is not what it was."""

    exit_code: ClassVar[int] = 2


class RunError(PhotizonError, RuntimeError):
    """A run was started and could not be finished."""


class NoRoomError(RunError):
    """A run has no memory to go on; batches that are whole count."""


class RunWarning(UserWarning):
    """Something went wrong in a run that goes on all the same, to the same bits."""


def join(prefix: str, path: str) -> str:
    """Join two key paths; an index such as ``[1]`` follows without a dot."""
    if not prefix or not path or path.startswith("["):
        return prefix + path
    return f"{prefix}.{path}"


def key(name: object) -> str:
    """Return a key as it stands in a path: bare where TOML allows that, quoted otherwise."""
    if (
        isinstance(name, str)
        and 0 < len(name) <= _WIDTH
        and all(c.isascii() and (c.isalnum() or c in "-_") for c in name)
    ):
        return name
    return show(name)


def show(value: object) -> str:
    """Return a short, printable, one-line text of a value found in a scene.

    Values are written as in TOML; long ones are cut, and unprintable characters are escaped.
    """
    text = _text(value, 0)
    return text if len(text) <= _WIDTH else text[: _WIDTH - 1] + "…"


def _text(value: object, depth: int) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        if value.bit_length() > _INTEGER_BITS:
            return f"an integer of {value.bit_length()} bits"
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, str):
        cut = value if len(value) <= 2 * _WIDTH else value[: 2 * _WIDTH]
        return printable(json.dumps(cut, ensure_ascii=False))
    if isinstance(value, list | tuple):
        if depth > 1:
            return "[…]"
        return "[" + ", ".join(_text(item, depth + 1) for item in value[:_WIDTH]) + "]"
    if isinstance(value, Mapping):
        if depth > 1:
            return "{…}"
        items = list(value.items())[:_WIDTH]
        return "{" + ", ".join(f"{key(k)} = {_text(v, depth + 1)}" for k, v in items) + "}"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    return printable(" ".join(str(value).split())[: 2 * _WIDTH])


def printable(text: str) -> str:
    """Return a text with everything escaped that could move or hide what stands beside it.

    Control characters would act on a terminal, and marks of the direction of writing would show a
    line in another order than it has; line breaks are escaped too.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escape(ord(c)) for c in text)


def printable_lines(text: str) -> str:
    """Return a text of several lines, each as `printable` gives it."""
    return "\n".join(map(printable, text.split("\n")))


def _escape(number: int) -> str:
    return f"\\u{number:04x}" if number < 1 << 16 else f"\\U{number:08x}"
