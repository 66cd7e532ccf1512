"""The verb ``presets``: the scenes that come along, or one of their files."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument(
        "name", metavar="NAME", nargs="?", help="print this preset's scene file instead"
    )


def call(arguments: argparse.Namespace) -> int:
    """List the presets, or print the file of one; return the exit status."""
    if arguments.name is None:
        _list()
    else:
        _print_file(arguments.name)
    return 0


def _list() -> None:
    """Print name, title and anchor of every preset."""
    from rich.text import Text

    from photizon_cl.cli.tables import console, paragraph
    from photizon_cl.scene.presets import presets

    out = console()
    for n, preset in enumerate(presets().values()):
        if n:
            out.print()
        out.print(Text.assemble((preset.name, "bold"), f"  {preset.title}"))
        out.print(paragraph(preset.anchor), soft_wrap=True)


def _print_file(name: str) -> None:
    from photizon_cl.scene.presets import preset_names, preset_path

    if name not in preset_names():
        raise ArgumentError(
            f"NAME: found {show(name)}, expected the name of a preset: one of "
            f"{', '.join(preset_names())}"
        )
    # byte for byte, whatever the terminal's encoding and line ends: a scene file is UTF-8
    sys.stdout.flush()
    sys.stdout.buffer.write(preset_path(name).read_bytes())
    sys.stdout.buffer.flush()
