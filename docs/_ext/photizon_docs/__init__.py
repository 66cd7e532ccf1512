"""Sphinx extension: pages and tables that follow from the package itself.

Before anything is read it writes one page for every kind of the registry below ``parts/``, with an
example that it traces and draws. While pages are read it puts tables where they ask for them by
``<!-- generated: NAME -->``.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photizon_docs.command_line import command_line
from photizon_docs.figures import draw
from photizon_docs.parts import escape_bars, group_index, page
from photizon_docs.python_api import python_api
from photizon_docs.tables import FRAGMENTS, GROUPS

if TYPE_CHECKING:
    from sphinx.application import Sphinx

__all__ = ["expand", "setup", "write_parts"]

_MARK = re.compile(r"^<!-- generated: ([\w-]+) -->$", re.M)
_FRAGMENTS = {**FRAGMENTS, "command-line": command_line, "python-api": python_api}


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.connect("builder-inited", lambda app: write_parts(Path(app.srcdir)))
    app.connect("source-read", _read)
    app.connect("autodoc-process-docstring", _docstring)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    source[0] = expand(source[0])


def _docstring(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [escape_bars(line) for line in lines]


def expand(text: str) -> str:
    """Return a page's text with the generated fragments in place."""
    return _MARK.sub(lambda found: _FRAGMENTS[found[1]](), text)


def write_parts(source: Path) -> list[Path]:
    """Write a page and a figure for every kind, and an index for every group.

    Parameters
    ----------
    source : Path
        The documentation's source directory.

    Returns
    -------
    list of Path
        The kinds' pages.
    """
    pages = []
    for group, kinds in GROUPS.items():
        folder = source / "parts" / f"{group}s"
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.iterdir():
            if old.stem not in (*kinds, "index"):
                old.unlink()
        _write(folder / "index.md", group_index(group))
        for kind, cls in kinds.items():
            text, scene = page(group, kind, cls)
            pages.append(folder / f"{kind}.md")
            _write(pages[-1], text)
            draw(scene, folder / f"{kind}.png")
    return pages


def _write(path: Path, text: str) -> None:
    """Write a file where it differs, so that an unchanged page is not built again."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
