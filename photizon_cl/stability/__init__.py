"""Numerical stability: hard cases through the kernels of the trace, against 60-digit arithmetic.

``python -m photizon_cl.stability`` prints one table, family × cases × worst ulps × bound ×
condition, and draws a figure. It needs mpmath, or gmpy2, which is faster; both come with the extra
``test``.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hostcode.device.device import OpenDevice
    from photizon_cl.stability.report import Row

__all__ = ["add_arguments", "main", "run", "stability_report"]


def stability_report(
    device: OpenDevice, only: Sequence[str] = (), precision: str = "fp64"
) -> list[Row]:
    """Measure the families, see `photizon_cl.stability.report.stability_report`."""
    from photizon_cl.stability.report import stability_report

    return stability_report(device, only, precision)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to a parser."""
    parser.add_argument("--device", metavar="D", help="number, type or part of a name")
    parser.add_argument(
        "--family", action="append", default=[], metavar="F", help="only this family; repeatable"
    )
    parser.add_argument(
        "--precision", metavar="P", default="fp64", help="fp64 (the default), mixed or fp32"
    )
    parser.add_argument(
        "--figure", metavar="FILE", help="draw every case's error into FILE (.png, .svg, .pdf)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the report; return 0 where every family keeps its bound, 1 otherwise.

    Raises
    ------
    ArgumentError
        Where a family does not exist.
    RunError
        Where there is no usable device, or mpmath is not installed.
    """
    from photizon_cl.checks.precision import mode_of
    from photizon_cl.errors import ArgumentError
    from photizon_cl.run.distribution import device_failures, open_chosen
    from photizon_cl.stability.digits import load_digits
    from photizon_cl.stability.report import FAMILIES, table, write_figure

    mode_of(arguments.precision)
    load_digits()
    known = (*FAMILIES, "fresnel")
    for name in arguments.family:
        if name not in known:
            raise ArgumentError(f"--family: found {name!r}, expected one of: {'; '.join(known)}")
    if arguments.figure:
        from photizon_cl.views.figures.style import check_figure

        check_figure(Path(arguments.figure))  # before the minutes that it takes
    device = open_chosen(arguments.device)
    with device_failures(device.record.label):
        rows = stability_report(device, arguments.family, arguments.precision)
    print(table(rows, arguments.precision))
    if arguments.figure:
        write_figure(rows, arguments.figure)
        print(f"figure: {arguments.figure}")
    return 0 if all(row.passed for row in rows) else 1


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; default those of the process.

    Returns
    -------
    int
        Exit status: 0, 1 where a family fails or the report cannot be made, 2 for bad input.
    """
    from photizon_cl.errors import PhotizonError

    parser = argparse.ArgumentParser("photizon stability", description=__doc__.splitlines()[0])
    add_arguments(parser)
    try:
        return run(parser.parse_args(argv))
    except PhotizonError as error:
        print(str(error), file=sys.stderr)
        return error.exit_code
