"""The verb ``paths``: which sequences of faces and events bring light to a detector."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DIRECTORY, JSON
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.path_table import PathTable

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument("directory", metavar="DIR", help=DIRECTORY)
    parser.add_argument(
        "--detector", metavar="D", help="which detector, by its element's name; default all"
    )
    parser.add_argument("--top", metavar="N", type=int, default=20, help="rows; default 20")
    parser.add_argument(
        "--via", metavar="NAME", nargs="+", default=[], action="extend",
        help='elements ("window"), faces ("window.back") or events there ("window.back r") that '
        "a path must all meet",
    )  # fmt: skip
    parser.add_argument(
        "--ghosts", metavar="K", type=int, help="paths with exactly K reflections at glass"
    )
    parser.add_argument(
        "--pairs", action="store_true", help="the two-reflection ghosts by pair of faces instead"
    )
    parser.add_argument(
        "--by", choices=("events", "ghost_order", "elements", "last"),
        help="in groups of paths with the same events, ghost order, elements or last element",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """Print path tables; return the exit status."""
    if not arguments.directory:
        raise ArgumentError("DIR: found nothing, expected a directory")
    if arguments.top < 1:
        raise ArgumentError(f"--top: found {arguments.top}, expected at least 1")
    if arguments.ghosts is not None and arguments.ghosts < 0:
        raise ArgumentError(f"--ghosts: found {arguments.ghosts}, expected 0 or more")
    if arguments.pairs and arguments.by:
        raise ArgumentError("--pairs and --by: give one of them")
    from photizon_cl.cli.tables import console
    from photizon_cl.run.directory import open_directory

    result = open_directory(arguments.directory)
    tables = _chosen(result, arguments)
    if arguments.json:
        found = {name: _plain(table, arguments) for name, table in tables.items()}
        print(json.dumps(found, indent=2, ensure_ascii=True, allow_nan=False))
        return 0
    out = console()
    for n, table in enumerate(tables.values()):
        if n:
            out.print()
        _print(table, arguments, result.ledger.emitted.value, out)
    return 0


def _chosen(result: Estimates, arguments: argparse.Namespace) -> dict[str, PathTable]:
    """Return the tables that are asked for, filtered."""
    having = {name: d.paths for name, d in result.detectors.items() if d.paths is not None}
    if not having:
        raise ArgumentError(
            f"{show(arguments.directory)}: no detector of the scene has a path table; detector = "
            "{ paths = 100 } gives it one, and it is then run again"
        )
    name = arguments.detector
    if name is not None and name not in having:
        listed = ", ".join(map(show, list(having)[:12]))
        raise ArgumentError(
            f"--detector: found {show(name)}, expected one that has a path table: {listed}"
        )
    chosen = having if name is None else {name: having[name]}
    return {
        key: table.filter(via=arguments.via, ghost_order=arguments.ghosts)
        if arguments.via or arguments.ghosts is not None
        else table
        for key, table in chosen.items()
    }


def _plain(table: PathTable, arguments: argparse.Namespace) -> dict[str, object]:
    """Return what is printed of a table as plain values."""
    if arguments.pairs:
        return {
            "pairs": [
                {
                    "first": pair.first,
                    "second": pair.second,
                    "value": pair.power,
                    "sigma": pair.sigma,
                    "count": pair.count,
                }
                for pair in table.ghosts().pairs()[: arguments.top]
            ]
        }
    if arguments.by:
        return {
            "groups": [
                {
                    "label": group.label,
                    "value": group.power,
                    "sigma": group.sigma,
                    "count": group.count,
                    "paths": len(group.rows),
                    "sigma_is_upper_bound": group.at_most,
                }
                for group in table.grouped(arguments.by)[: arguments.top]
            ]
        }
    return {
        "rows": [row.summary() for row in table[: arguments.top]],
        "rest": {**table.rest.summary(), "sigma_is_upper_bound": table.rest.at_most},
    }


def _print(table: PathTable, arguments: argparse.Namespace, emitted: float, out: Console) -> None:
    from photizon_cl.cli.tables import heading, paragraph, print_table
    from photizon_cl.cli.tables import table as new_table
    from photizon_cl.result.text import with_error

    picked = bool(arguments.via) or arguments.ghosts is not None
    out.print(heading(f"paths to {table.detector}", f": {len(table)}{' that match' * picked}"))
    out.print()
    if arguments.pairs or arguments.by:
        what = "reflected at first, then at" if arguments.pairs else arguments.by.replace("_", " ")
        grid = new_table(
            (what, "left"), ("power, W", "right"), ("± σ", "right"), ("paths", "right")
        )
        pairs = table.ghosts().pairs() if arguments.pairs else ()
        lines = [(str(pair), pair.power, pair.sigma, "", False) for pair in pairs]
        if arguments.by:
            groups = table.grouped(arguments.by)
            lines = [(g.label, g.power, g.sigma, str(len(g.rows)), g.at_most) for g in groups]
        for label, value, sigma, paths, at_most in lines[: arguments.top]:
            power, error = with_error(value, sigma)
            grid.add_row(label, power, "≤ " * at_most + error, paths)
        if lines:
            print_table(grid, out)
        else:
            out.print("none")
        if len(lines) > arguments.top:
            out.print(paragraph(f"{len(lines) - arguments.top} more: --top shows them", ""))
        if arguments.by:
            _print_rest(table, picked, out)
        return
    for n, row in enumerate(table[: arguments.top], start=1):
        power, error = with_error(row.power, row.sigma)
        part = f"{row.power / emitted:.3g} of emitted"
        ghost = f", ghost of order {row.ghost_order}" if row.ghost_order else ""
        head = f"{n:>3}  {power} W{' ± ' + error if row.sigma is not None else ''}  ({part}"
        out.print(
            f"{head}, {row.count} arrival{'s' * (row.count != 1)}{ghost}; ray {row.example_ray})",
            soft_wrap=True,
        )
        out.print(paragraph(row.sequence, "     "), soft_wrap=True)
    if not table.complete:
        text = "there were more paths than are kept: one that was met late is in the rest"
        out.print(paragraph(text, ""), soft_wrap=True)
    left = len(table) - arguments.top
    if left > 0:
        out.print(paragraph(f"{left} more rows: --top shows them", ""), soft_wrap=True)
    _print_rest(table, picked, out)


def _print_rest(table: PathTable, picked: bool, out: Console) -> None:
    """Say what comes by paths that are not among those that were printed or counted together."""
    from photizon_cl.cli.tables import paragraph
    from photizon_cl.result.text import with_error

    rest = table.rest
    if not rest.count:
        return
    power, error = with_error(rest.power, rest.sigma)
    what = "all other light" if picked else f"all other paths ({rest.paths})"
    more = f" ± {'at most ' * rest.at_most}{error}" if rest.sigma is not None else ""
    out.print(paragraph(f"{what}: {power} W{more}", ""), soft_wrap=True)
