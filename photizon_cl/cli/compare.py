"""The verb ``compare``: two runs side by side."""

from __future__ import annotations

import json
import math
from itertools import groupby
from typing import TYPE_CHECKING, Final

from photizon_cl.cli.arguments import DIRECTORY, JSON
from photizon_cl.errors import ArgumentError, printable

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from photizon_cl.result.comparison import Comparison, Difference

__all__ = ["add_arguments", "call"]

_FEW: Final = 20
"""Batches below which it is told how uncertain their σ is."""
_WHOLE: Final = " †"
_ALONE: Final = " *"
_DIGITS: Final = 1e-6
"""Part of a value below which an error shows in its own column alone."""


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
    from photizon_cl.result.text import batches

    out.print(heading(f"{printable(second)} against {printable(first)}"))
    few = found.batches < _FEW
    unsure = f" (σ of so few is itself uncertain by {_unsure(found.batches)} %)" if few else ""
    how = (
        f"paired over {batches(found.batches)}{unsure}, since {found.why}: what they have in "
        "common cancels"
        if found.batches
        else f"errors added in quadrature, since {found.why}"
    )
    out.print(paragraph(how, ""), soft_wrap=True)
    out.print()
    shown = [row for row in found if row.a.value or row.b.value]
    for group, members in groupby(shown, key=lambda row: _split(found.parts_of(row.name)[0])[0]):
        # the second is the first and the difference; so much fits a terminal of 80 columns
        rows = table(
            (f"{group}, W", "left"), ("first", "right"), ("difference", "right"), ("± σ", "right"),
            ("ratio", "right"), ("± σ", "right"),
        )  # fmt: skip
        rows.columns[0].overflow = "fold"
        # what lines or bands bring comes behind what all do
        for row in sorted(members, key=lambda row: bool(found.parts_of(row.name)[1])):
            name, line = found.parts_of(row.name)
            label = _split(name)[1] + (f", {line}" if line else "")
            rows.add_row(
                Text(printable(label) + _mark(row, found)),
                _short(row.a.value, row.a.sigma)[0],
                *_short(row.difference, row.sigma),
                *_ratio(row),
            )
        print_table(rows, out)
        out.print()
    silent = len(found) - len(shown)
    marks = {_mark(row, found) for row in shown}
    if _WHOLE in marks:
        text = (
            f"{_WHOLE.strip()} of all batches of both, whose error is smaller: in quadrature, less "
            f"what the {batches(found.batches)} in common share"
        )
        out.print(paragraph(text, ""), soft_wrap=True)
    if _ALONE in marks:
        text = (
            f"{_ALONE.strip()} of single elements of very many no batches are kept: added in "
            "quadrature"
        )
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


def _unsure(n: int) -> str:
    """Return the relative standard error of σ from `n` batches, in per cent."""
    return f"{100.0 / math.sqrt(2.0 * max(n - 1, 1)):.0f}"


def _mark(row: Difference, found: Comparison) -> str:
    """Return what tells a row that is not paired from those that are."""
    if row.paired or not found.batches:
        return ""
    return _WHOLE if row.whole else _ALONE


def _ratio(row: Difference) -> tuple[str, str]:
    return ("", "") if row.ratio is None else _short(row.ratio, row.ratio_sigma)


def _short(value: float, sigma: float | None) -> tuple[str, str]:
    """Return a number and its error, the number with eight digits at most."""
    from photizon_cl.result.text import with_error

    shown, error = with_error(value, sigma)
    if sigma is not None and sigma < _DIGITS * abs(value):
        shown = with_error(value, _DIGITS * abs(value))[0]
    return shown, error
