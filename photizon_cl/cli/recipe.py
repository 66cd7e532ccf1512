"""The verb ``recipe``: a token that reproduces a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DIRECTORY
from photizon_cl.errors import ArgumentError

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument("directory", metavar="DIR", help=DIRECTORY)


def call(arguments: argparse.Namespace) -> int:
    """Print the recipe of a saved result; return the exit status."""
    if not arguments.directory:
        raise ArgumentError("DIR: found nothing, expected a directory")
    from photizon_cl.run.result import open_result

    print(open_result(arguments.directory).recipe)
    return 0
