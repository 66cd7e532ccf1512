"""Arguments that several verbs take."""

from __future__ import annotations

import argparse
from typing import Final

__all__ = [
    "DEVICE",
    "DIRECTORY",
    "JSON",
    "SCENE",
    "SEED",
    "add_goal",
    "integer",
    "number",
]

SCENE: Final = "a preset's name, or a scene file (.toml or .json)"
DIRECTORY: Final = "the directory that `photizon run --out` wrote"
DEVICE: Final = "number, type or part of a name, see `photizon devices`"
SEED: Final = "random stream, 0 to 2^64 - 1"
JSON: Final = "print the summary as JSON, nothing else"


def integer(text: str) -> int:
    """Read an integer of the command line."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected an integer") from None


def number(text: str) -> float:
    """Read a number of the command line."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number") from None


def add_goal(parser: argparse.ArgumentParser, batches: str, more: str = "") -> None:
    """Declare what a run is to reach.

    Parameters
    ----------
    parser : ArgumentParser
        The verb's.
    batches : str
        What ``--batches`` does.
    more : str, optional
        Word before "seconds" in the help of ``--max-seconds``.
    """
    goal = parser.add_mutually_exclusive_group()
    goal.add_argument("--batches", type=integer, metavar="N", help=batches)
    goal.add_argument(
        "--target", type=number, metavar="S", help="stop at a median relative σ of S, in (0, 1]"
    )
    parser.add_argument(
        "--max-seconds", type=number, metavar="T", help=f"stop after T {more}seconds"
    )
