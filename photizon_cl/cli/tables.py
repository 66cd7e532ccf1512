"""Consoles, tables and paragraphs of at most 80 columns."""

from __future__ import annotations

import textwrap
from typing import Any, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from photizon_cl.errors import printable_lines

__all__ = [
    "WIDTH",
    "console",
    "heading",
    "paragraph",
    "print_table",
    "table",
]

WIDTH: Final = 80
_LEAST_WIDTH: Final = 40


class _Console(Console):
    """A console that leaves a closed pipe to the command: rich would exit with status 1."""

    def print(self, *objects: Any, **how: Any) -> None:
        """Print, with what steers a terminal escaped in text that came from elsewhere."""
        super().print(*(printable_lines(o) if isinstance(o, str) else o for o in objects), **how)

    def on_broken_pipe(self) -> None:
        """Hand the error on."""
        raise BrokenPipeError


def console(stderr: bool = False) -> Console:
    """Return a console of at most 80 columns; names in its output are never read as markup."""
    made = _Console(stderr=stderr, markup=False, emoji=False, highlight=False)
    # COLUMNS=0, as some terminals and job systems say, means unknown; below 40 nothing is legible
    made.width = min(max(made.width or WIDTH, _LEAST_WIDTH), WIDTH)
    return made


def heading(name: str, more: str = "") -> Text:
    """Return a line that begins in bold."""
    return Text.assemble((printable_lines(name), "bold"), printable_lines(more))


def table(*columns: tuple[str, str], title: str = "") -> Table:
    """Return an empty table; columns are (heading, ``left`` or ``right``)."""
    made = Table(title=Text(title, "bold") if title else None, title_justify="left", box=None)
    made.pad_edge = False
    for heading, side in columns:
        last = heading == ""
        justify: Any = side
        made.add_column(Text(heading), justify=justify, no_wrap=not last and side == "right")
    return made


def print_table(rows: Table, out: Console) -> None:
    """Print a table without the blanks that pad its lines."""
    with out.capture() as captured:
        out.print(rows)
    for line in captured.get().splitlines():
        out.file.write(line.rstrip() + "\n")


def paragraph(text: str, indent: str = "  ") -> str:
    """Return text wrapped to 80 columns with an indent."""
    return textwrap.fill(
        text, WIDTH - 1, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
    )
