"""The verb ``compare``: two runs side by side."""

from __future__ import annotations

import json
from itertools import groupby
from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DIRECTORY, JSON
from photizon_cl.errors import ArgumentError, printable

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from photizon_cl.result.comparison import Comparison, Difference

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument("first", metavar="DIR", help=DIRECTORY)
    parser.add_argument("second", metavar="DIR", help="the one that is compared with it")
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """Compare two saved results; return the exit status."""
    for folder in (arguments.first, arguments.second):
        if not folder:
            raise ArgumentError("DIR: found nothing, expected a directory")
    from photizon_cl.cli.tables import console
    from photizon_cl.run.comparing import compare

    found = compare(arguments.first, arguments.second)
    if arguments.json:
        print(json.dumps(found.summary(), indent=2, ensure_ascii=True, allow_nan=False))
        return 0
    _print(found, arguments.first, arguments.second, console())
    return 0


def _print(found: Comparison, first: str, second: str, out: Console) -> None:
    from rich.text import Text

    from photizon_cl.cli.tables import heading, paragraph, print_table, table
    from photizon_cl.result.text import batches, with_error

    out.print(heading(f"{printable(second)} against {printable(first)}"))
    how = (
        f"paired over {batches(found.batches)}, since {found.why}: what they have in common cancels"
        if found.batches
        else f"errors added in quadrature, since {found.why}"
    )
    out.print(paragraph(how, ""), soft_wrap=True)
    out.print()
    shown = [row for row in found if row.a.value or row.b.value]
    for group, members in groupby(shown, key=lambda row: _split(row.name)[0]):
        # the second is the first and the difference; so much fits a terminal of 80 columns
        rows = table(
            (f"{group}, W", "left"), ("first", "right"), ("difference", "right"), ("± σ", "right"),
            ("ratio", "right"), ("± σ", "right"),
        )  # fmt: skip
        for row in members:
            alone = found.batches and not row.paired
            rows.add_row(
                Text(_split(row.name)[1] + (" *" if alone else "")),
                with_error(row.a.value, row.a.sigma)[0],
                *with_error(row.difference, row.sigma),
                *_ratio(row),
            )
        print_table(rows, out)
        out.print()
    silent = len(found) - len(shown)
    if any(not row.paired for row in found) and found.batches:
        text = "* of single elements of very many no batches are kept: added in quadrature"
        out.print(paragraph(text, ""), soft_wrap=True)
    if silent:
        out.print(paragraph(f"{silent} more are 0 in both", ""), soft_wrap=True)
    for folder, names in ((first, found.only_a), (second, found.only_b)):
        if names:
            listed = ", ".join(names[:12]) + (f" and {len(names) - 12} more" * (len(names) > 12))
            out.print(paragraph(f"only in {printable(folder)}: {listed}", ""), soft_wrap=True)


def _split(name: str) -> tuple[str, str]:
    """Return what a quantity belongs to, ledger or detector, and what it is there."""
    parts = name.split(".")
    if parts[0] == "ledger":
        return "ledger", name.removeprefix("ledger.")
    # an element's name may hold dots in quotes
    owner, _, what = name.rpartition(".")
    return owner, what


def _ratio(row: Difference) -> tuple[str, str]:
    from photizon_cl.result.text import with_error

    return ("", "") if row.ratio is None else with_error(row.ratio, row.ratio_sigma)
