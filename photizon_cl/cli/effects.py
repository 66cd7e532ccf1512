"""The verb ``effects``: what is compiled for a scene and why, what is left out, and the prices."""

from __future__ import annotations

import json
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DEVICE, JSON, add_scene, load_scene, number
from photizon_cl.errors import ArgumentError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from rich.console import Console

    from photizon_cl.result.effects import Effects, EffectUse, ProgramUse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    add_scene(parser)
    parser.add_argument(
        "--measure",
        action="store_true",
        help="measure what each costs or would cost: interactions per second, seconds to compile, "
        "sizes",
    )
    parser.add_argument(
        "--max-seconds",
        type=number,
        metavar="T",
        help="with --measure: end after T seconds, default 120",
    )
    parser.add_argument("--device", metavar="D", help=f"with --measure: {DEVICE}")
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """List a scene's effects; return the exit status, 1 where one changed a bit."""
    for option, value in (
        ("--max-seconds", arguments.max_seconds),
        ("--device", arguments.device),
    ):
        if value is not None and not arguments.measure:
            raise ArgumentError(f"{option}: found no --measure beside it, and nothing else uses it")
    scene = load_scene(arguments)
    from photizon_cl.cli.tables import console
    from photizon_cl.studies.effects import SECONDS, effects

    seconds = arguments.max_seconds
    if arguments.measure:
        limit = SECONDS if seconds is None else seconds
        _tell(f"compiling and timing programs of {scene.name}, for at most {limit:g} s")
    found = effects(scene, arguments.measure, arguments.device, max_seconds=seconds)
    if arguments.json:
        print(json.dumps(found.summary(), indent=2, ensure_ascii=True, allow_nan=False))
    else:
        _print(found, console())
    if found.different:
        _tell(
            f"{', '.join(found.different)}: other bits than without, which is a defect of the "
            "engine: no number of this scene is to be trusted with it; please report it with the "
            "scene and the device"
        )
        return 1
    return 0


def _tell(text: str) -> None:
    """Say what is not what was asked for."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _print(found: Effects, out: Console) -> None:
    from rich.text import Text

    from photizon_cl.cli.tables import heading, paragraph, print_table, table

    out.print(heading(found.scene, "  what is compiled for it"))
    for title, in_use in (("in use", True), ("left out", False)):
        out.print()
        rows = table((title, "left"), ("because", "left"))
        for row in found:
            if row.in_use == in_use and (in_use or row.group == "effect"):
                alone = "" if in_use or row.optional else "; it cannot be forced on here"
                rows.add_row(Text(row.name), Text(row.because + alone))
        print_table(rows, out)
    groups = dict.fromkeys(row.group for row in found if row.group != "effect")
    for group in groups:
        unused = [row for row in found if row.group == group and not row.in_use]
        if unused:
            names = ", ".join(row.name.removeprefix(f"{group}.") for row in unused)
            text = f"left out as {unused[0].because}: {names}"
            out.print(paragraph(text, ""), soft_wrap=True)
    if found.device is not None:
        _print_prices(found, out)


def _print_prices(found: Effects, out: Console) -> None:
    """Print what was measured."""
    from photizon_cl.cli.tables import paragraph

    out.print()
    out.print(
        paragraph(
            f"measured on {found.device} in {found.seconds:.0f} s; time is that of the program "
            "with it for what the one without takes 1, median of rounds in turn with quartiles; "
            "M/s are millions of interactions per second; compiled: seconds of a program of which "
            "nothing was kept",
            "",
        ),
        soft_wrap=True,
    )
    own = found.own
    if own is not None:
        binary = "" if own.binary_bytes is None else f" and {_kib(own.binary_bytes)} KiB compiled"
        text = (
            f"the scene's own program: {own.interactions_per_s / 1e6:.3g} M/s, compiled in "
            f"{own.build_seconds:.2f} s, {_kib(own.source_bytes)} KiB of text{binary}"
        )
        out.print(paragraph(text, ""), soft_wrap=True)
    optional = [row for row in found if row.optional]
    _prices("compiled in unused", [row for row in optional if not row.in_use], out)
    _prices("in use, against out", [row for row in optional if row.in_use], out)
    _prices("all of a sort, unused", found.programs, out)
    if found.same_bits:
        out.print()
        out.print("none changed a bit of what both programs count", soft_wrap=True)


def _prices(title: str, rows: Sequence[EffectUse | ProgramUse], out: Console) -> None:
    """Print a table of prices, and below it what has none."""
    from rich.text import Text

    from photizon_cl.cli.tables import paragraph, print_table, table

    if not rows:
        return
    out.print()
    shown = table(
        (title, "left"), ("time", "right"), ("quartiles", "right"), ("M/s", "right"),
        ("without", "right"), ("compiled", "right"), ("KiB", "right"), ("binary", "right"),
    )  # fmt: skip
    for row in rows:
        if row.price is None:
            continue
        ratio, more, less = row.price.slowdown, row.price.more, row.price.less
        # what the program takes that is not the scene's own
        other = less if getattr(row, "in_use", False) else more
        shown.add_row(
            Text(row.name + ("" if row.price.same_bits else " OTHER BITS")),
            f"{ratio.median:.3f}", f"{ratio.low:.3f}-{ratio.high:.3f}",
            f"{more.interactions_per_s / 1e6:.3g}", f"{less.interactions_per_s / 1e6:.3g}",
            f"{other.build_seconds:.2f}", _kib(other.source_bytes),
            "" if other.binary_bytes is None else _kib(other.binary_bytes),
        )  # fmt: skip
    if any(row.price is not None for row in rows):
        print_table(shown, out)
    for row in rows:
        if row.price is None:
            out.print(paragraph(f"{row.name}: not measured, {row.unmeasured}", ""), soft_wrap=True)


def _kib(size: int) -> str:
    return f"{size / 1024:.0f}"
