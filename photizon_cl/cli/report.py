"""The verb ``report``: the page of a saved result, or of a sweep."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from photizon_cl.errors import ArgumentError

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument(
        "directory", metavar="DIR", help="the directory that `run --out` or `sweep --out` wrote"
    )
    parser.add_argument("--out", metavar="FILE", help="the page to write; default DIR/report.html")


def call(arguments: argparse.Namespace) -> int:
    """Write the report as the arguments say and print its path; return the exit status."""
    for name, value in (("DIR", arguments.directory), ("--out", arguments.out)):
        if value == "":
            raise ArgumentError(f"{name}: found nothing, expected a path")

    from photizon_cl.studies.sweep_folder import is_sweep

    if is_sweep(arguments.directory):
        from photizon_cl.studies.sweep_report import write_sweep_report

        written = write_sweep_report(arguments.directory, arguments.out)
    else:
        from photizon_cl.run.report import write_report

        written = write_report(arguments.directory, arguments.out)
    for text in written.warnings:
        print(text, file=sys.stderr)
    print(written.page)
    return 0
