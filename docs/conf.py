"""How Sphinx builds these pages. Nothing is fetched: the build works offline."""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "agg")
sys.path.insert(0, str(Path(__file__).parent / "_ext"))

from photizon_cl.version import __version__  # the extension needs the package as well

project = "photizon_cl"
author = "photizon_cl contributors"
project_copyright = author
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "photizon_docs",  # pages and tables from the registry, the parser and the declarations
]
exclude_patterns = ["_build", "_ext", "images"]

myst_heading_anchors = 3
smartquotes = False  # quotes and dashes are often a file's or a command's

# Docstrings are numpy's; single backticks in them are code.
default_role = "literal"
numpydoc_show_class_members = False  # autodoc lists them, with their docstrings
autodoc_typehints = "none"
autodoc_member_order = "bysource"
nitpicky = True
nitpick_ignore: list[tuple[str, str]] = []

html_theme = "furo"
html_title = "photizon_cl"
html_copy_source = False
html_show_sphinx = False
