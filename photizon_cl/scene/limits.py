"""Limits on the text of a scene, looked at before a parser does: one line, at once, in no memory.

A parser's time and memory need not follow the length of a text: a key of very many parts takes
tomllib time and memory that go with their square. Any scene that a person or a program has reason
to write is far below each of these.
"""

from __future__ import annotations

import re
from typing import Final

__all__ = ["LARGEST_FILE", "MOST_CHARACTERS", "json_excess", "toml_excess"]

LARGEST_FILE: Final = 2**24
"""Bytes of a scene file, and of what a recipe unpacks to: text that somebody wrote."""
MOST_CHARACTERS: Final = 64
"""Characters of a word for which a similar one is sought."""
_MOST_TABLES: Final = 2**19
"""Tables and arrays in a text: six for each element of the largest file."""
_MOST_PARTS: Final = 16
"""Parts of a dotted key; a scene's have three."""
_MOST_DOTS: Final = 2**18
"""Dots between the parts of all keys."""
_MOST_DEPTH: Final = 64
"""Tables and arrays within each other."""

_SUSPECT_LINE: Final = re.compile(rf"^(?:[^.\n]*\.){{{_MOST_PARTS}}}", re.MULTILINE)
_TOKEN: Final = re.compile(
    r'"""(?:[^\\"]|\\.|"(?!""))*+(?:"""|\Z)'
    r"|'''(?:[^']|'(?!''))*+(?:'''|\Z)"
    r'|"(?:[^"\\\n]|\\.)*+"?'
    r"|'[^'\n]*+'?"
    r"|\#[^\n]*+"
    r"|[.=,\[\]{}\n]",
    re.DOTALL,
)


def json_excess(text: str) -> tuple[str, str]:
    """Return what a JSON text has too much of, and how much may be; nothing where it is fine."""
    return _tables(text.count("{") + text.count("["))


def toml_excess(text: str) -> tuple[str, str]:
    """Return what a TOML text has too much of, and how much may be; nothing where it is fine."""
    brackets = text.count("{") + text.count("[")
    too_many = _tables(brackets)
    if too_many[0]:
        return too_many
    # Strings may have all of it too: what looks suspicious is looked at closer.
    suspicious = (
        text.count(".") > _MOST_DOTS
        or _SUSPECT_LINE.search(text)
        or (brackets > _MOST_DEPTH and _deep(text))
    )
    return _scan(text) if suspicious else ("", "")


def _tables(n: int) -> tuple[str, str]:
    if n <= _MOST_TABLES:
        return "", ""
    return f"{n} tables and arrays", f"at most {_MOST_TABLES}"


def _deep(text: str) -> bool:
    """Say whether brackets may be nested too deeply, those in strings counted too."""
    depth = 0
    for match in re.finditer(r"[\[{]+|[\]}]+", text):
        run = match.group()
        depth += len(run) if run[0] in "[{" else -len(run)
        if depth > _MOST_DEPTH:
            return True
        depth = max(depth, 0)
    return False


def _scan(text: str) -> tuple[str, str]:
    """Count the parts of keys and the depth of values exactly, leaving out strings."""
    open_: list[str] = []
    in_value, parts, dots = False, 1, 0
    for match in _TOKEN.finditer(text):
        token = match.group()[0]
        if token in "\"'#":
            continue
        if token == ".":
            if in_value:
                continue
            parts, dots = parts + 1, dots + 1
            if parts > _MOST_PARTS:
                line = text.count("\n", 0, match.start()) + 1
                return f"a key of more than {_MOST_PARTS} parts in line {line}", "shorter keys"
            if dots > _MOST_DOTS:
                return f"more than {_MOST_DOTS} dots in keys", "tables instead of dotted keys"
            continue
        parts = 1
        if token == "=":
            in_value = True
        elif token == "\n":
            in_value = in_value and bool(open_)
        elif token == ",":
            in_value = bool(open_) and open_[-1] == "["
        elif token == "{" or (token == "[" and in_value):
            open_.append(token)
            in_value = token == "["
            if len(open_) > _MOST_DEPTH:
                return f"more than {_MOST_DEPTH} tables or arrays within each other", "fewer"
        elif token in "]}" and open_:
            open_.pop()
            in_value = True
    return "", ""
