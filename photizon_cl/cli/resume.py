"""The verb ``resume``: a run, or a sweep, goes on."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DEVICE, DIRECTORY, JSON, NO_FIGURES, add_goal, swallowed
from photizon_cl.cli.workers import add_workers, open_workers
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument("directory", metavar="DIR", nargs="?", help=DIRECTORY)
    add_goal(parser, "run until there are N batches in all", "more ")
    parser.add_argument("--device", metavar="D", help=DEVICE)
    add_workers(parser)
    parser.add_argument("--no-figures", action="store_true", help=NO_FIGURES)
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """Go on with a run as the arguments say; return the exit status."""
    if arguments.directory is None:
        raise ArgumentError(
            "DIR: found nothing, expected the directory of a run" + swallowed("DIR", arguments)
        )
    from photizon_cl.studies.sweep_folder import is_sweep

    if is_sweep(arguments.directory):
        return _sweep(arguments)
    from photizon_cl.cli.outcome import give
    from photizon_cl.cli.progress import Display
    from photizon_cl.run.checkpoint import latest
    from photizon_cl.run.result import Result

    # `pz.resume` in two steps, since the display has the scene's title
    start = Result.of(latest(arguments.directory))
    with open_workers(arguments) as executor, Display(start.scene.heading) as display:
        result = start.refine(
            batches=arguments.batches,
            target=arguments.target,
            target_on=arguments.target_on,
            max_seconds=arguments.max_seconds,
            device=arguments.device,
            progress=display.update,
            executor=executor,
            checkpoint=arguments.directory,
        )
    return give(
        result, arguments.directory, figures=not arguments.no_figures, as_json=arguments.json
    )


def _sweep(arguments: argparse.Namespace) -> int:
    """Go on with a sweep; return the exit status."""
    for name in ("batches", "target", "target_on"):
        if getattr(arguments, name) is not None:
            raise ArgumentError(
                f"--{name.replace('_', '-')}: found {show(getattr(arguments, name))}, expected "
                "nothing: the [run] of a sweep says what each point is to reach"
            )
    from photizon_cl.cli.progress import SweepDisplay
    from photizon_cl.cli.sweep import give
    from photizon_cl.studies.sweeps import open_sweep

    start = open_sweep(arguments.directory)
    if start.finished:
        print(f"photizon: {show(arguments.directory)} holds a sweep that is done", file=sys.stderr)
        return give(start, as_json=arguments.json)
    with open_workers(arguments) as executor, SweepDisplay(start.plan.heading) as display:
        found = start.resume(
            max_seconds=arguments.max_seconds,
            device=arguments.device,
            progress=display.update,
            executor=executor,
            figure=not arguments.no_figures,
        )
    return give(found, as_json=arguments.json)
