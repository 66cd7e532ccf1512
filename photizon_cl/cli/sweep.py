"""The verb ``sweep``: a scene at many values of its parameters."""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Final

from photizon_cl.cli.arguments import DEVICE, NO_FIGURES, number
from photizon_cl.cli.workers import add_workers, open_workers
from photizon_cl.errors import ArgumentError, printable, show

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from photizon_cl.result.measures import Measure
    from photizon_cl.studies.sweeps import Sweep

__all__ = ["add_arguments", "call", "give"]

JSON: Final = "print the table as JSON, nothing else"
_MOST_ROWS: Final = 40
"""Points that are printed; the table has all."""
_MOST_MEASURES: Final = 2
"""Measures that are printed side by side."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument("file", metavar="FILE", help="a sweep file (.toml or .json)")
    parser.add_argument(
        "--out", metavar="DIR",
        help="keep every point's result in DIR, with table and figure; `photizon resume DIR` goes "
        "on with it",
    )  # fmt: skip
    parser.add_argument(
        "--max-seconds", type=number, metavar="T",
        help="stop after T seconds, all points together; max_seconds of the file's [run] is that "
        "of each point",
    )  # fmt: skip
    parser.add_argument("--device", metavar="D", help=DEVICE)
    add_workers(parser)
    parser.add_argument("--no-figures", action="store_true", help=NO_FIGURES)
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """Run a sweep as the arguments say; return the exit status."""
    if not arguments.file:
        raise ArgumentError("FILE: found nothing, expected a sweep file")
    if arguments.out == "":
        raise ArgumentError("--out: found nothing, expected a directory")
    if arguments.max_seconds is not None and not 0.0 < arguments.max_seconds <= 1e9:
        raise ArgumentError(
            f"--max-seconds: found {show(arguments.max_seconds)}, expected a positive time, up to "
            "1e9"
        )
    from photizon_cl.cli.progress import SweepDisplay
    from photizon_cl.scene.sweep_reader import read_sweep
    from photizon_cl.studies.sweeps import sweep

    asked = read_sweep(arguments.file)  # a bad file is told before anything heavy is imported
    with open_workers(arguments) as executor, SweepDisplay(asked.heading) as display:
        found = sweep(
            arguments.file,
            out=arguments.out,
            max_seconds=arguments.max_seconds,
            device=arguments.device,
            progress=display.update,
            executor=executor,
            figure=not arguments.no_figures,
        )
    if found.programs is None and found.finished:
        print(
            f"photizon: {show(arguments.out)} holds this sweep already, done: nothing is run again",
            file=sys.stderr,
        )
    return give(found, as_json=arguments.json)


def give(found: Sweep, *, as_json: bool) -> int:
    """Print what a sweep gave; return the exit status: 1 where a point failed."""
    if as_json:
        print(json.dumps(found.summary(), indent=2, ensure_ascii=True, allow_nan=False))
    else:
        from photizon_cl.cli.tables import console

        show_sweep(found, console())
    for point in found.failed:
        print(
            f"photizon: point {point.number} ({found.plan.said(point.number)}) failed: "
            f"{printable(point.why)}",
            file=sys.stderr,
        )
    if not found.finished:
        left = len(found) - found.n_done
        word = "point is" if left == 1 else "points are"
        how = ""
        if found.folder is not None:
            how = f": `photizon resume {printable(str(found.folder))}` goes on with the sweep"
        print(f"photizon: {left} of {len(found)} {word} not done{how}", file=sys.stderr)
    return 1 if found.failed else 0


def show_sweep(found: Sweep, out: Console) -> None:
    """Print a sweep: a row for each point, with σ."""
    from rich.text import Text

    from photizon_cl.cli.tables import heading, paragraph, print_table, table
    from photizon_cl.result.text import with_error
    from photizon_cl.scene.sweep_values import value_text

    out.print(heading(found.plan.heading))
    out.print(paragraph(_about(found), ""), soft_wrap=True)
    out.print()
    shown = _chosen(found)
    axes = found.plan.axes
    shorts = _shorts(found)
    columns = [
        (f"{short}, {axis.unit}" if axis.unit else short, "right" if axis.numeric else "left")
        for axis, short in zip(axes, shorts, strict=True)
    ]
    for measure in shown:
        unit = "" if measure.unit == "1" else f", {measure.unit}"
        columns += [(f"{measure.name.removeprefix('detectors.')}{unit}", "right"), ("± σ", "right")]
    rows = table(("point", "right"), *columns, ("batches", "right"))
    for point in found.points[:_MOST_ROWS]:
        cells = [
            f"{value:.6g}" if axis.numeric else value_text(value)[:24]
            for axis, value in zip(axes, point.values.values(), strict=True)
        ]
        for measure in shown:
            if not point.done:
                cells += ["failed" if point.why else "–", ""]
                continue
            value = point.measures[measure.name]
            none = math.isnan(value.value)  # a ratio to nothing
            cells += ["–", ""] if none else list(with_error(value.value, value.sigma))
        rows.add_row(str(point.number), *map(Text, cells), str(point.batches or ""))
    print_table(rows, out)
    if len(found) > _MOST_ROWS:
        out.print(f"… {len(found) - _MOST_ROWS} more points")
    left = [m.name for m in found.measured if m not in shown]
    out.print()
    for axis, short in zip(axes, shorts, strict=True):
        if short != axis.path:
            out.print(paragraph(printable(f"{short}: {axis.path}"), ""), soft_wrap=True)
    for measure in shown:
        if measure.meaning != measure.name:
            text = f"{measure.name}: {measure.meaning}"
            out.print(paragraph(printable(text), ""), soft_wrap=True)
    if left:
        named = ", ".join(left[:6]) + (f" and {len(left) - 6} more" if len(left) > 6 else "")
        out.print(paragraph(f"measured too: {printable(named)}", ""), soft_wrap=True)
    for text in found.advisories:
        out.print(paragraph(printable(f"advisory: {text}"), ""), soft_wrap=True)
    if found.folder is not None:
        out.print(f"written to {printable(str(found.folder))}", soft_wrap=True)


def _chosen(found: Sweep) -> list[Measure]:
    """Return what is printed: the first measures or, where none were named, detectors' powers."""
    if found.plan.measures:
        return list(found.measured[:_MOST_MEASURES])
    powers = [m for m in found.measured if m.name.endswith(".power")]
    escaped = [m for m in found.measured if m.name == "ledger.escaped"]
    return (powers + escaped)[:_MOST_MEASURES]


def _shorts(found: Sweep) -> list[str]:
    """Return what the axes are called in a narrow table: the end of a path where it tells."""
    axes = found.plan.axes
    ends = [axis.name.rpartition(".")[2] if axis.name == axis.path else axis.name for axis in axes]
    return [
        end if ends.count(end) == 1 else axis.name for axis, end in zip(axes, ends, strict=True)
    ]


def _about(found: Sweep) -> str:
    """Return how many points there are, of what, in how many programs."""
    done = [point for point in found.points if point.done]
    points = f"{len(found)} point{'s' * (len(found) != 1)} of {found.plan.scene.name}"
    if len(found.plan.shape) > 1:
        points += f" ({' × '.join(map(str, found.plan.shape))})"
    seeds = sorted({point.seed for point in done})
    if len(seeds) == 1:
        points += f", seed {seeds[0]} at every point, so that differences are paired"
    if found.programs is not None:
        points += f"; {found.programs} program{'s' * (found.programs != 1)}"
    if done:
        points += f", {sum(point.seconds for point in done):.3g} s of tracing"
    return points
