"""Kernel templates to source text, with the template's own line numbers kept for the compiler.

Mako swallows control lines, so the text it gives has other line numbers than the file. Before every
stretch of text behind swallowed lines a ``#line`` directive names the file and the line, and the
compiler's messages point into the template.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from mako import exceptions
from mako.template import Template

from hostcode.assets import kernels_dir
from hostcode.errors import KernelBuildError

__all__ = ["MUTATIONS", "lane", "point", "render"]

_LANES = "0123456789abcdef"
_CONTROL = re.compile(r"\s*%(?!%)|##")
_BLOCK_START = re.compile(r"\s*<%(?!def|/def|block|/block|include|namespace|inherit|page)")
_EXPANSION = re.compile(r"\$\{\w+\}\s*$")


def lane(value: str, number: int, lanes: int) -> str:
    """Return the C expression of one lane of a value: ``v.s3``, or ``v`` itself for scalars."""
    return value if lanes == 1 else f"{value}.s{_LANES[number]}"


def _with_line_directives(name: str, text: str) -> str:
    """Insert a ``#line`` directive before each text line that Mako would give another number."""
    out: list[str] = []
    stale = True
    in_block = False
    for number, line in enumerate(text.splitlines(), start=1):
        if in_block or _BLOCK_START.match(line):
            in_block = "%>" not in line
            out.append(line)
            stale = True
        elif _CONTROL.match(line):
            out.append(line)
            stale = True
        else:
            if stale:
                out.append(f'#line {number} "kernels/{name}"')
            out.append(line)
            stale = bool(_EXPANSION.match(line))
    return "\n".join(out) + "\n"


@cache
def _template(name: str) -> Template:
    path = kernels_dir() / name
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise KernelBuildError(name, None, f"cannot be read ({error})") from error
    return Template(text=_with_line_directives(name, text), strict_undefined=True, uri=name)


def _template_line(name: str, line: int) -> int:
    """Return the line in the file for a line of the text that holds the directives."""
    text = (kernels_dir() / name).read_text(encoding="utf-8")
    directives = 0
    for number, content in enumerate(_with_line_directives(name, text).splitlines(), start=1):
        if content.startswith("#line "):
            directives += 1
        if number == line:
            break
    return line - directives


MUTATIONS: dict[str, str | int] = {}
"""What stands at named points instead; only tests fill it, to see a broken engine caught."""


def point(name: str, text: str | int) -> str | int:
    """Return a piece of a template that tests can replace by its name, ``<file's stem>.<what>``."""
    return MUTATIONS.get(name, text)


def render(name: str, plain: frozenset[str] = frozenset(), **context: Any) -> str:
    """Render a kernel template.

    Parameters
    ----------
    name : str
        Path below ``kernels/``.
    plain : frozenset of str
        Parts for which ``careful(part, text, short)`` gives the short way; else it gives the text.
    **context
        Everything the template names; an undefined name is an error.

    Raises
    ------
    KernelBuildError
        With the template's line, where rendering fails.
    """

    def careful(part: str, text: str, short: str) -> str:
        return short if part in plain else text

    try:
        return str(_template(name).render_unicode(point=point, careful=careful, **context))
    except KernelBuildError:
        raise
    except Exception as error:
        trace = exceptions.RichTraceback()
        line = next((entry[5] for entry in reversed(trace.records) if entry[4] == name), None)
        message = f"rendering failed: {error or type(error).__name__}"
        where = _template_line(name, line) if line else None
        raise KernelBuildError(name, where, message) from error
