"""The verb ``run``: a scene, or a recipe, traced."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.cli.arguments import (
    DEVICE,
    JSON,
    NO_FIGURES,
    PRECISION,
    SEED,
    add_goal,
    add_scene,
    integer,
    load_scene,
    swallowed,
)
from photizon_cl.cli.workers import add_workers, open_workers
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

    from photizon_cl.run.recipe import Recipe
    from photizon_cl.scene.model import Scene

__all__ = ["add_arguments", "call"]

_FLAGS: Final = {"scene": "SCENE", "changes": "--set"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    add_scene(parser, optional=True)
    parser.add_argument("--seed", type=integer, metavar="N", help=SEED)
    add_goal(parser, "run exactly N batches")
    parser.add_argument(
        "--rays-per-batch", type=integer, metavar="N", help="rays launched in a batch, up to 2^24"
    )
    parser.add_argument("--device", metavar="D", help=DEVICE)
    parser.add_argument("--precision", metavar="P", help=PRECISION)
    add_workers(parser)
    parser.add_argument("--out", metavar="DIR", help="write summary, arrays and figures into DIR")
    parser.add_argument("--no-figures", action="store_true", help=NO_FIGURES)
    parser.add_argument("--json", action="store_true", help=JSON)
    parser.add_argument(
        "--recipe", metavar="TOKEN",
        help="instead of SCENE and settings: make this run again, bit for bit; a token of "
        "`photizon recipe`, or a file that holds one",
    )  # fmt: skip


def call(arguments: argparse.Namespace) -> int:
    """Trace a scene, or a recipe, as the arguments say; return the exit status."""
    if arguments.out == "":
        raise ArgumentError("--out: found nothing, expected a directory")
    recipe = None
    if arguments.recipe is not None:
        recipe = _recipe(arguments)
        scene = recipe.scene
    elif arguments.scene is None:
        raise ArgumentError(
            "SCENE: found nothing, expected a preset's name or a scene file"
            + swallowed("SCENE", arguments)
        )
    else:
        scene = load_scene(arguments)  # a bad scene is told before anything heavy is imported

    from photizon_cl.checks.precision import DEFAULT, mode_of
    from photizon_cl.cli.outcome import give
    from photizon_cl.cli.progress import Display
    from photizon_cl.run.batches import with_settings
    from photizon_cl.run.simulation import trace

    as_run = with_settings(scene, seed=arguments.seed, rays_per_batch=arguments.rays_per_batch)
    precision = recipe.precision if recipe is not None else arguments.precision or DEFAULT
    mode_of(precision)
    _tell_loss(arguments.out, as_run, precision)
    said = _advise(scene, precision, as_json=arguments.json)
    with open_workers(arguments) as executor, Display(scene.heading) as display:
        if recipe is not None:
            result = recipe.trace(
                device=arguments.device,
                progress=display.update,
                executor=executor,
                checkpoint=arguments.out,
            )
        else:
            result = trace(
                scene,
                seed=arguments.seed,
                batches=arguments.batches,
                target=arguments.target,
                target_on=arguments.target_on,
                max_seconds=arguments.max_seconds,
                rays_per_batch=arguments.rays_per_batch,
                device=arguments.device,
                precision=precision,
                progress=display.update,
                executor=executor,
                checkpoint=arguments.out,
            )
    differs = "" if recipe is None else recipe.differs(result)
    status = give(
        result, arguments.out, figures=not arguments.no_figures, as_json=arguments.json, said=said
    )
    if recipe is not None:
        verdict = "reproduced: every bit is the recipe's"
        print(f"not reproduced: {differs}" if differs else verdict, file=sys.stderr)
    return 1 if differs else status


def _tell_loss(out: str | None, as_run: Scene, precision: str) -> None:
    """Say, while it can still be kept, that another run's result will be replaced."""
    from photizon_cl.run.directory import what_is_lost

    lost = what_is_lost(out, as_run, precision) if out is not None else ""
    if lost:
        print(
            f"photizon: {show(out)} holds the result of {lost}, which this run's will replace; "
            "another directory keeps both",
            file=sys.stderr,
        )


def _recipe(arguments: argparse.Namespace) -> Recipe:
    """Return the recipe that ``--recipe`` names; nothing else may say what to run."""
    from photizon_cl.run.recipe import Recipe
    from photizon_cl.scene.limits import LARGEST_FILE

    for name in (
        "scene",
        "changes",
        "seed",
        "batches",
        "target",
        "target_on",
        "max_seconds",
        "rays_per_batch",
        "precision",
    ):
        if getattr(arguments, name) is not None:
            flag = _FLAGS.get(name) or f"--{name.replace('_', '-')}"
            raise ArgumentError(
                f"{flag}: found {show(getattr(arguments, name))}, expected nothing: the recipe "
                "says what is run"
            )
    given: str = arguments.recipe
    try:
        file = Path(given)
        if file.is_file():
            with file.open(encoding="utf-8") as opened:
                given = opened.read(LARGEST_FILE + 1)
    except (OSError, ValueError):  # a token is no path, and too long for one
        pass
    return Recipe.read(given)


def _advise(scene: Scene, precision: str, *, as_json: bool) -> list[str]:
    """Say a scene's advisories before the run; return what was said.

    The JSON has them; a scene that splits without end may take all its time, so then as well.
    """
    if as_json and not scene.splits():
        return []
    from photizon_cl.checks.advisories import advisories

    found = advisories(scene, precision)
    for advisory in found:
        print(f"advisory: {advisory}", file=sys.stderr)
    return found
