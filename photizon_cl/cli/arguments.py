"""Arguments that several verbs take."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError, printable, show

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = [
    "DEVICE",
    "DIRECTORY",
    "JSON",
    "NO_FIGURES",
    "PRECISION",
    "SEED",
    "add_goal",
    "add_scene",
    "integer",
    "load_scene",
    "number",
    "swallowed",
]

_SCENE: Final = "a preset's name, or a scene file (.toml or .json)"
_SET: Final = (
    "another value for a parameter of the scene, such as element.wall.surface.reflectance=0.9, "
    "run.generation_cap=64 or source.lamp.position[2]=0.1; may be given again"
)
NO_FIGURES: Final = "draw no figures into DIR"
DIRECTORY: Final = "the directory that `photizon run --out` wrote"
DEVICE: Final = "number, type or part of a name, see `photizon devices`"
PRECISION: Final = "fp64 (the default), mixed (single precision, weights in double) or fp32"
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


def add_scene(parser: argparse.ArgumentParser, *, optional: bool = False) -> None:
    """Declare a scene, and what is changed of it."""
    parser.add_argument("scene", metavar="SCENE", nargs="?" if optional else None, help=_SCENE)
    parser.add_argument("--set", action="append", metavar="PATH=VALUE", dest="changes", help=_SET)


def load_scene(arguments: argparse.Namespace) -> Scene:
    """Return the scene that the arguments name, with the values that they set."""
    from photizon_cl.scene.files import load
    from photizon_cl.scene.parameter_paths import read_assignment

    changes: dict[str, object] = {}
    for text in arguments.changes or ():
        try:
            path, value = read_assignment(text)
        except ArgumentError as error:
            raise ArgumentError(f"--set: {error}") from None
        if path in changes:
            raise ArgumentError(f"--set {path}: found two values, expected one")
        changes[path] = value
    scene = load(arguments.scene)
    return scene.replace(changes) if changes else scene


def swallowed(what: str, arguments: argparse.Namespace) -> str:
    """Say that ``--target-on`` took what was meant for a positional argument; else nothing.

    Parameters
    ----------
    what : str
        The argument that is missing.
    arguments : Namespace
        What was read.
    """
    taken = arguments.target_on
    if not taken:
        return ""
    last = printable(taken[-1])
    return (
        f"; --target-on takes all that follows, and took {show(taken[-1])} as a quantity: put "
        f"{what} before it, or two hyphens between (--target-on QUANTITY -- {last})"
    )


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
        "--target-on", action="extend", nargs="+", metavar="Q",
        help="quantities that must each meet the target: detectors.NAME.power, .map, far_field, "
        "ledger.escaped, ...; takes all that follows up to the next option, and may be given again",
    )  # fmt: skip
    parser.add_argument(
        "--max-seconds", type=number, metavar="T", help=f"stop after T {more}seconds"
    )
