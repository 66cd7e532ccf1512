"""Parameters by their path: ``element."wall -x".surface.reflectance``, ``source.sun.tilt_deg[0]``.

A path starts at the top of a scene file. Sources and elements are named, or numbered as messages
do (``element[2]``); a key in quotes may hold anything, as in TOML. What is set is checked by the
reader, as if it had stood in the file.
"""

from __future__ import annotations

import copy
import difflib
import re
import tomllib
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.described import Described, Nested, NestedList, default_of, parameters_of
from photizon_cl.scene.names import unknown_name
from photizon_cl.scene.reader import KINDS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["path_parts", "place_of", "put_values", "quoted", "read_assignment"]

_PART: Final = re.compile(
    r"""\s*(?: "(?:[^"\\]|\\.)*" | '[^']*' | \[\s*\d{1,9}\s*\]
    | [^\s."'\[\]=]+(?:\ +[^\s."'\[\]=]+)* )\s*""",
    re.VERBOSE,
)
_BARE: Final = re.compile(r"""[^\s."'\[\]=\\]+""")
_LONGEST: Final = 1000  # characters of a path: a name has 64
_FORM: Final = "a path such as element.NAME.surface.KEY, source.NAME.KEY[0] or run.KEY"


def read_assignment(text: str) -> tuple[str, Any]:
    """Return path and value of ``PATH=VALUE``.

    Parameters
    ----------
    text : str
        The value is one of TOML; what is none is a word, so that quotes may be left out.

    Raises
    ------
    ArgumentError
        Where there is no path, no value or no ``=``.
    """
    quoted = ""
    for at, character in enumerate(text):
        if character == "=" and not quoted:
            path, value = text[:at].strip(), text[at + 1 :].strip()
            break
        if character in "\"'":
            quoted = "" if quoted == character else quoted or character
    else:
        raise ArgumentError(f"found {show(text)}, expected PATH=VALUE, {_FORM} before the =")
    if not value:
        raise ArgumentError(f'{path}: found no value, expected one after the = ("" is empty text)')
    return path, _value(value)


def _value(text: str) -> Any:
    try:
        read = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        read = {}
    if set(read) == {"value"}:
        return read["value"]
    try:
        return float(text)  # such as .5, which is no TOML
    except ValueError:
        return text


def put_values(scene: type[Described], tables: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Put other values into a scene's tables.

    Parameters
    ----------
    scene : type
        The class of the scene.
    tables : dict
        As `Scene.to_dict` gives them, which are nobody else's.
    changes : mapping of str to object
        Values by path; None takes away what may be absent.

    Raises
    ------
    ArgumentError
        Where a path leads nowhere. Values and the last key are for the reader to judge.
    """
    # a name last: other paths have the one that the object has so far
    for path in sorted(changes, key=lambda path: path_parts(path)[-1] == "name"):
        _Way(path, scene, tables).put(changes[path])


def place_of(
    scene: type[Described], tables: dict[str, Any], path: str
) -> tuple[tuple[str | int, ...], str]:
    """Return the place in a scene's tables that a path names, and the unit of what stands there.

    Parameters
    ----------
    scene, tables
        As `put_values` takes them.
    path : str
        The path. Two ways to write one, by name and by number, give the same place.

    Raises
    ------
    ArgumentError
        Where it leads nowhere.
    """
    return _Way(path, scene, copy.deepcopy(tables)).place_and_unit()


def path_parts(path: str) -> list[str | int]:
    """Return keys as text and places in brackets as numbers."""
    if not isinstance(path, str):
        raise ArgumentError(f"path: found {show(path)}, expected {_FORM}")
    parts: list[str | int] = []
    at = 0
    while at < len(path) <= _LONGEST:
        found = _PART.match(path, at)
        if found is None:
            break
        word, at = found[0].strip(), found.end()
        if word[0] == "[":
            parts.append(int(word[1:-1]))
        else:
            parts.append(_unquoted(word, path))
        if at == len(path) and isinstance(parts[0], str):
            return parts
        if path[at : at + 1] == ".":
            at += 1
        elif path[at : at + 1] != "[":
            break
    raise ArgumentError(f"{show(path)}: found no parameter's path, expected {_FORM}")


def quoted(name: str) -> str:
    """Return a name as it stands in a path: in quotes where it needs them."""
    if _BARE.fullmatch(name):
        return name
    inner = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{inner}"'


def _unquoted(word: str, path: str) -> str:
    if word[0] not in "\"'":
        return word
    try:
        return next(iter(tomllib.loads(f"{word} = 0")))
    except tomllib.TOMLDecodeError:
        raise ArgumentError(f"{show(path)}: found {word}, expected a key in quotes") from None


class _Way:
    """The way along a path, from a scene's tables to the place that it names."""

    def __init__(self, path: str, scene: type[Described], tables: dict[str, Any]) -> None:
        self.path, self.parts = path, path_parts(path)
        self.cls: type[Described] | None = scene
        self.tables = tables

    def fail(self, found: str, expected: str, hint: str = "") -> ArgumentError:
        return ArgumentError(
            f"{self.path}: found {found}, expected {expected}" + (f" ({hint})" if hint else "")
        )

    def place_and_unit(self) -> tuple[tuple[str | int, ...], str]:
        """Return the place by keys and numbers, and the unit of its parameter."""
        at: Any = self.begin()
        found: list[str | int] = []
        unit = ""
        for part, after in zip(self.parts, (*self.parts[1:], None), strict=True):
            found.append(self.place(at, part) if isinstance(at, list) else part)
            if self.cls and isinstance(part, str) and part in parameters_of(self.cls):
                unit = parameters_of(self.cls)[part].unit
            if after is not None:
                at = self.step(at, part, after)
        return tuple(found), unit

    def begin(self) -> dict[str, Any]:
        """Return where the path starts."""
        first = self.parts[0]
        top = list(parameters_of(self.cls)) if self.cls else []
        if first not in top:
            near = difflib.get_close_matches(str(first), top, 1)
            hint = f"did you mean {near[0]}?" if near else ""
            raise self.fail(show(first), f"a path that begins with one of {', '.join(top)}", hint)
        return self.tables

    def put(self, value: object) -> None:
        """Set the value."""
        at: Any = self.begin()
        last = self.parts[-1]
        for part, after in zip(self.parts, self.parts[1:], strict=False):
            at = self.step(at, part, after)
        if isinstance(at, list):
            at[self.place(at, last)] = _plain(value)
        elif not isinstance(last, str):
            raise self.fail(f"[{last}]", "a key here")
        elif value is None:
            at.pop(last, None)
        else:
            for other in self.cls.alternatives.get(last, ()) if self.cls else ():
                at.pop(other, None)
            at[last] = _plain(value)

    def step(self, at: Any, part: str | int, after: str | int) -> Any:
        """Return what a part leads to: a table, or a list of tables or of numbers."""
        if isinstance(at, list):
            found = at[self.place(at, part)]
        elif isinstance(part, int):
            raise self.fail(f"[{part}]", "a key here")
        else:
            parameter = parameters_of(self.cls).get(part) if self.cls else None
            if part not in at:
                at[part] = self.absent(part, isinstance(parameter, NestedList))
            found = at[part]
            self.cls = parameter.base if isinstance(parameter, Nested) else None
            self.cls = self.cls or getattr(parameter, "member", None)
        if isinstance(found, dict):
            self.cls = self.kind(found)
        if not isinstance(found, dict | list):
            raise self.fail(f"{part} = {show(found)}", f"the path to end there, not at {after}")
        return found

    def absent(self, key: str, many: bool) -> dict[str, Any] | list[Any]:
        """Return what stands for a key that the tables leave out."""
        if many:
            return []
        default = default_of(self.cls, key) if self.cls and key in parameters_of(self.cls) else None
        return list(default) if isinstance(default, tuple) else {}

    def kind(self, table: dict[str, Any]) -> type[Described] | None:
        """Return the class of a table: that of its kind where it has one."""
        kinds = KINDS.get(self.cls, {}) if self.cls else {}
        return kinds.get(str(table.get("kind")), self.cls)

    def place(self, listed: Sequence[Any], part: str | int) -> int:
        """Return where in a list a part of the path leads: by name, or by number."""
        if isinstance(part, int):
            if part >= len(listed):
                raise self.fail(f"[{part}]", f"a number below {len(listed)}, counted from 0")
            return part
        names = [
            item["name"]
            for item in listed
            if isinstance(item, dict) and item.get("name") is not None
        ]
        if len(names) < len(listed):
            raise self.fail(show(part), f"a number in brackets, [0] to [{len(listed) - 1}]")
        if part not in names:
            raise unknown_name(self.path, part, [str(name) for name in names])
        return names.index(part)


def _plain(value: Any) -> Any:
    """Return a value as tables hold it."""
    if isinstance(value, Described):
        return value.to_table()
    if hasattr(value, "tolist"):  # of numpy
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return value
