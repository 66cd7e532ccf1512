"""Errors that photizon_cl raises on purpose, and the exit status that each one gives.

The tree::

    PhotizonError                       exit status 1
    ├── SceneError (also ValueError)    2   a scene, as read or as built in code, is not valid
    ├── ArgumentError (also ValueError) 2   a call's or command's argument is not valid
    │   └── UnknownNameError (also KeyError)  a name that is looked up is not there
    ├── ResultError (also ValueError)   2   a result directory or file cannot be used
    ├── RecipeError (also ValueError)   2   a recipe's token is not one, or cannot be used here
    └── RunError (also RuntimeError)    1   a run was started and failed

The command line prints ``str(error)`` on standard error and leaves with ``exit_code``; anything
else that surfaces is a defect of the program and keeps its traceback.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

_WIDTH = 60  # characters of a found value that a message shows
_DANGEROUS = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
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


class PhotizonError(Exception):
    """Base of every error that photizon_cl raises on purpose."""

    exit_code: ClassVar[int] = 1


class SceneError(PhotizonError, ValueError):
    """A scene is not valid; carries every problem that was found, in reading order.

    Parameters
    ----------
    problems : iterable of Problem
        At least one.
    """

    exit_code: ClassVar[int] = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        """Give one line for each problem."""
        return "\n".join(str(problem) for problem in self.problems)


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


def join(prefix: str, path: str) -> str:
    """Join two key paths; an index such as ``[1]`` follows without a dot."""
    if not prefix or not path or path.startswith("["):
        return prefix + path
    return f"{prefix}.{path}"


def key(name: object) -> str:
    """Return a key as it stands in a path: bare where TOML allows that, quoted otherwise."""
    if (
        isinstance(name, str)
        and name
        and all(c.isascii() and (c.isalnum() or c in "-_") for c in name)
    ):
        return name
    return show(name)


def plain(text: str) -> str:
    """Return text for a terminal, with control and bidirectional characters escaped.

    These move the cursor, change colours or turn the order of what is read around. Line breaks and
    tabs stay.
    """
    return _DANGEROUS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


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
        quoted = json.dumps(cut, ensure_ascii=False)
        return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in quoted)
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
    text = " ".join(str(value).split())
    return "".join(c if c.isprintable() else "?" for c in text[: 2 * _WIDTH])
