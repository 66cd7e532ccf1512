"""Scene files read, TOML and JSON."""

from __future__ import annotations

import difflib
import json
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from photizon_cl.errors import Problem, SceneError, show
from photizon_cl.scene.limits import LARGEST_FILE, MOST_CHARACTERS, json_excess, toml_excess
from photizon_cl.scene.model import Scene
from photizon_cl.scene.presets import preset_names, preset_path
from photizon_cl.scene.reader import RepeatedKeys, read_scene
from photizon_cl.scene.writing import SUFFIXES

_TOML_PLACE: Final = re.compile(r" ?\(at (line \d+, column \d+|end of document)\)$")
_UNIT: Final = re.compile(
    r"[=\[,]\s*[-+]?\d[\d_]*(\.\d*)?([eE][-+]?\d+)?\s*(nm|[uµμ]?m|mm|cm|km|inch|in|deg|°|rad|m?W|%)"
)
"""A number with a unit behind it."""


def load(source: str | os.PathLike[str] | Mapping[str, Any] | Scene) -> Scene:
    """Load a scene.

    Parameters
    ----------
    source : str, path, mapping or Scene
        A preset's name, the path of a ``.toml`` or ``.json`` file, the tables of one, or a scene,
        which is returned as it is. A preset's name goes before a file of the same name.

    Raises
    ------
    SceneError
        If there is no such scene, or with every problem that it has.
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        return read_scene(Scene, source)
    if isinstance(source, str) and source in preset_names():
        return _load_file(preset_path(source))
    if not isinstance(source, str | os.PathLike):
        raise SceneError(
            [Problem("scene", show(source), "a preset's name, a path, a table or a Scene")]
        )
    path = Path(os.fsdecode(source))
    if isinstance(source, str) and path.suffix.lower() not in SUFFIXES and not _exists(path):
        asked = source.lower()[:MOST_CHARACTERS]
        near = difflib.get_close_matches(asked, preset_names(), 1)
        beside = [path.name + end for end in SUFFIXES if _exists(Path(f"{path}{end}"))]
        if beside:
            near = [show(f"{source}{beside[0][len(path.name) :]}") + ", the file that is there"]
        hint = f"did you mean {near[0]}? " if near else ""
        hint += f"the presets are {', '.join(preset_names())}"
        found = f"{show(source)}, which is neither a preset nor a file"
        raise SceneError([Problem("scene", found, "a preset's name or a scene file", hint=hint)])
    return _load_file(path)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, or with a NUL
        return False


def _load_file(path: Path) -> Scene:
    tables, file = read_tables(path)
    return read_scene(Scene, tables, file)


def read_tables(path: Path, what: str = "a scene file") -> tuple[Any, str]:
    """Return the tables of a TOML or JSON file, and its name for messages.

    Parameters
    ----------
    path : Path
        The file.
    what : str, optional
        What it should be.

    Raises
    ------
    SceneError
        Where it cannot be read, or is neither.
    """
    file = str(path) if str(path).isprintable() else show(str(path))
    text = _read_text(path, file, what)
    tables = parse_toml(text, file) if path.suffix.lower() == ".toml" else parse_json(text, file)
    return tables, file


def _fail(
    file: str | None, found: str, expected: str, hint: str = "", place: str = ""
) -> SceneError:
    return SceneError([Problem(place, found, expected, file=file, hint=hint)])


def _read_text(path: Path, file: str, what: str) -> str:
    expected = f"{what} in TOML or JSON"
    presets = what == "a scene file"
    try:
        if path.is_dir():
            raise _fail(file, "a directory", expected)
        if path.suffix.lower() not in SUFFIXES:
            hint = "the ending says which of the two it is"
            raise _fail(
                file, f"the ending {show(path.suffix)}", "a file that ends in .toml or .json", hint
            )
        if not path.exists():
            raise _fail(file, "no such file", expected, _nearby(path, presets=presets))
        if not path.is_file():
            raise _fail(file, "something that is not a regular file", expected)
        if path.stat().st_size > LARGEST_FILE:
            raise _fail(file, f"{path.stat().st_size} bytes", f"at most {LARGEST_FILE} bytes")
        with path.open("rb") as opened:  # it may grow, or say nothing true of its size
            data = opened.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise _fail(file, f"more than {LARGEST_FILE} bytes", f"{what} that is shorter")
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise _fail(file, f"a file that cannot be read: {reason}", expected) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"the byte 0x{data[error.start]:02x}, which is not UTF-8"
        raise _fail(
            file, found, "text in UTF-8", "save the file as UTF-8", f"line {line}"
        ) from None
    if not text.strip():
        raise _fail(file, "an empty file", expected, "start from a preset's file" * presets)
    return text


def _nearby(path: Path, *, presets: bool) -> str:
    """Return what may have been meant by the path of a file that is not there."""
    there = sorted(p.name for s in SUFFIXES for p in path.parent.glob(f"*{s}"))
    near = [show(name) for name in difflib.get_close_matches(path.name, there, 1)]
    alike = difflib.get_close_matches(path.stem, preset_names(), 1) if presets else []
    near += [f"the preset {show(name)}" for name in alike]
    if near:
        return f"did you mean {' or '.join(near)}?"
    return "check the path, or see the presets" if presets else "check the path"


def parse_toml(text: str, file: str | None = None) -> Any:
    """Return the tables of a TOML text that may be anything.

    Raises
    ------
    SceneError
        Where it is too large or nested too deeply, or not valid.
    """
    _check_limits(text, file, *toml_excess(text))
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        match = _TOML_PLACE.search(message)
        reason = message[: match.start()] if match else message
        place = _line_and_column(text, match.group(1)) if match else ""
        reason = _one_line(reason)
        if match and _with_unit(text, match.group(1)):
            reason += "; numbers carry no units: lengths are in metres, and 250 mm is 0.25"
        raise _fail(file, "a syntax error", "valid TOML", reason, place) from None
    except (ValueError, RecursionError) as error:
        raise _fail(file, "a syntax error", "valid TOML", _parser_limit(error)) from None


def _with_unit(text: str, place: str) -> bool:
    """Return whether letters follow a number where the parser stopped."""
    line = re.match(r"line (\d+)", place)
    return line is not None and bool(_UNIT.search(text.split("\n")[int(line[1]) - 1]))


def parse_json(text: str, file: str | None = None) -> Any:
    """Return the tables of a JSON text that may be anything, as `parse_toml` does."""
    _check_limits(text, file, *json_excess(text))
    try:
        return json.loads(text, object_pairs_hook=_json_object)
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise _fail(file, "a syntax error", "valid JSON", _one_line(error.msg), place) from None
    except (ValueError, RecursionError) as error:
        raise _fail(file, "a syntax error", "valid JSON", _parser_limit(error)) from None


def _check_limits(text: str, file: str | None, found: str, expected: str) -> None:
    if len(text) > LARGEST_FILE:
        found, expected = f"{len(text)} characters", f"at most {LARGEST_FILE}"
    if found:
        raise _fail(file, found, expected)


def _json_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    plain = dict(pairs)
    return plain if len(plain) == len(pairs) else RepeatedKeys(pairs)


def _line_and_column(text: str, place: str) -> str:
    if place != "end of document":
        return place
    return f"line {text.count(chr(10)) + 1}, column {len(text) - text.rfind(chr(10))}"


def _one_line(text: str) -> str:
    return show(text)[1:-1]


def _parser_limit(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return "tables or arrays are nested too deeply"
    return "an integer has too many digits" if "digits" in str(error) else _one_line(str(error))
