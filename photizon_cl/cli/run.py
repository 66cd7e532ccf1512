"""The verbs ``run`` and ``resume``: progress, then ledger, detectors and advisories."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.text import Text

from photizon_cl.cli.show import console, paragraph, print_table, table
from photizon_cl.errors import ArgumentError, ResultError, show
from photizon_cl.views.text import lit_percent, with_error

if TYPE_CHECKING:
    import argparse
    from collections.abc import Collection
    from types import TracebackType

    from rich.console import Console

    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.recipe import Recipe
    from photizon_cl.result.result import Result
    from photizon_cl.run.progress import Progress
    from photizon_cl.scene.model import Scene

__all__ = ["print_result", "resume", "run"]


def run(arguments: argparse.Namespace) -> int:
    """Trace a scene, or a recipe, as the arguments say; return the exit status."""
    from photizon_cl.scene.files import load

    if arguments.out == "":
        raise ArgumentError("--out: found nothing, expected a directory")
    recipe = None
    if arguments.recipe is not None:
        recipe = _recipe(arguments)
        scene = recipe.scene
    elif arguments.scene is None:
        raise ArgumentError("SCENE: found nothing, expected a preset's name or a scene file")
    else:
        scene = load(arguments.scene)  # a bad scene is told before anything heavy is imported

    from photizon_cl.run.simulation import trace, with_settings

    as_run = with_settings(scene, seed=arguments.seed, rays_per_batch=arguments.rays_per_batch)
    _tell_loss(arguments.out, as_run)
    said = _warn_of_splitting(scene)
    with _Display(scene.title or scene.name) as display:
        if recipe is not None:
            result = recipe.trace(
                device=arguments.device, progress=display.update, checkpoint=arguments.out
            )
        else:
            result = trace(
                scene,
                seed=arguments.seed,
                batches=arguments.batches,
                target=arguments.target,
                max_seconds=arguments.max_seconds,
                rays_per_batch=arguments.rays_per_batch,
                device=arguments.device,
                precision=arguments.precision or "fp64",
                progress=display.update,
                checkpoint=arguments.out,
            )
    differs = "" if recipe is None else recipe.differs(result)
    status = _give(result, arguments.out, as_json=arguments.json, said=said)
    if recipe is not None:
        verdict = "reproduced: every bit is the recipe's"
        print(f"not reproduced: {differs}" if differs else verdict, file=sys.stderr)
    return 1 if differs else status


def resume(arguments: argparse.Namespace) -> int:
    """Go on with a run as the arguments say; return the exit status."""
    from photizon_cl.run.checkpoint import latest

    # `pz.resume` in two steps, since the display has the scene's title
    start = latest(arguments.directory)
    with _Display(start.scene.title or start.scene.name) as display:
        result = start.refine(
            batches=arguments.batches,
            target=arguments.target,
            max_seconds=arguments.max_seconds,
            device=arguments.device,
            progress=display.update,
            checkpoint=arguments.directory,
        )
    return _give(result, arguments.directory, as_json=arguments.json)


def _tell_loss(out: str | None, as_run: Scene) -> None:
    """Say, while it can still be kept, that another run's result will be replaced."""
    from photizon_cl.result.directory import what_is_lost

    lost = what_is_lost(out, as_run) if out is not None else ""
    if lost:
        print(
            f"photizon: {show(out)} holds the result of {lost}, which this run's will replace; "
            "another directory keeps both",
            file=sys.stderr,
        )


def _recipe(arguments: argparse.Namespace) -> Recipe:
    """Return the recipe that ``--recipe`` names; nothing else may say what to run."""
    from photizon_cl.result.recipe import Recipe

    for name in (
        "scene",
        "seed",
        "batches",
        "target",
        "max_seconds",
        "rays_per_batch",
        "precision",
    ):
        if getattr(arguments, name) is not None:
            flag = "SCENE" if name == "scene" else f"--{name.replace('_', '-')}"
            raise ArgumentError(
                f"{flag}: found {show(getattr(arguments, name))}, expected nothing: the recipe "
                "says what is run"
            )
    given: str = arguments.recipe
    try:
        file = Path(given)
        if file.is_file():
            given = file.read_text(encoding="utf-8")
    except (OSError, ValueError):  # a token is no path, and too long for one
        pass
    return Recipe.read(given)


def _warn_of_splitting(scene: Scene) -> list[str]:
    """Say a scene's advisories before the run where it has glass; return what was said."""
    if not any(element.surface.splits for element in scene.element):
        return []
    # a scene that splits without end may take all its time
    advisories = scene.advisories()
    for advisory in advisories:
        print(f"advisory: {advisory}", file=sys.stderr)
    return advisories


def _give(result: Result, folder: str | None, *, as_json: bool, said: Collection[str] = ()) -> int:
    """Write and print a result, without what was said already; return the exit status."""
    # Files first: a reader that closes the pipe must not cost the result.
    failed: ResultError | None = None
    if folder is not None:
        try:
            result.save(folder)
        except ResultError as error:
            failed = error  # the numbers are still worth printing
    if as_json:
        print(json.dumps(result.summary(), indent=2, ensure_ascii=True, allow_nan=False))
        return _told(failed)
    out = console()
    print_result(result, out, said)
    if folder is not None and failed is None:
        out.print(f"\nwritten to {folder}", soft_wrap=True)
    return _told(failed)


def _told(failed: ResultError | None) -> int:
    """Say that the files could not be written; return the exit status."""
    if failed is None:
        return 0
    print(str(failed), file=sys.stderr)
    return 1


# -- progress ------------------------------------------------------------------------------------


class _Display:
    """One line on standard error that is redrawn; silent where that is no terminal."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.live: Any = None

    def __enter__(self) -> _Display:
        err = console(stderr=True)
        if err.is_terminal:
            from rich.live import Live

            self.live = Live(
                Text(f"{self.title}: building the program, tracing the first batch …"),
                console=err,
                refresh_per_second=8,
                transient=True,
            )
            self.live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.live is not None:
            self.live.stop()

    def update(self, now: Progress) -> None:
        if self.live is not None:
            self.live.update(Text(progress_line(now)))


def progress_line(now: Progress) -> str:
    """Return one line: σ now, batches, interactions a second, time left."""
    sigma = "σ –" if now.achieved_sigma is None else f"σ {now.achieved_sigma:.2e}"
    if now.target is not None:
        sigma += f" (target {now.target:.2e})"
    batches = f"batch {now.batches}" + (f"/{now.goal_batches}" if now.goal_batches else "")
    rate = f"{now.interactions_per_second / 1e6:.1f} M interactions/s"
    left = "" if now.eta_seconds is None else f"  {_time(now.eta_seconds)} left"
    return f"{sigma}  {batches}  {rate}{left}"


def _time(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes < 100 else f"{minutes / 60:.1f} h"


_STOPPED: Final = {"interrupt": "by Ctrl-C", "time": "by max_seconds"}
"""What ends a run before its goal."""


# -- tables --------------------------------------------------------------------------------------


def print_result(result: Result, out: Console, said: Collection[str] = ()) -> None:
    """Print ledger, detectors and advisories, these without what was said before."""
    head = result.scene.title or result.scene.name
    out.print(Text(head, "bold"))
    run = result.scene.run
    out.print(
        paragraph(
            f"{result.batches} batches of {run.rays_per_batch} rays, seed {run.seed}, "
            f"{result.info.interactions / 1e6:.4g} M interactions in {result.info.seconds:.2f} s "
            f"on {result.info.device}",
            "",
        ),
        soft_wrap=True,
    )
    out.print()
    _print_ledger(result, out)
    _print_detectors(result, out)
    achieved = result.achieved_sigma
    sigma = "unknown" if achieved is None else f"{achieved:.3g}"
    verdict = "met" if result.converged else "not met"
    out.print()
    text = f"median relative σ {sigma}, target {result.target_sigma:.3g} {verdict}"
    if result.lit_fraction is not None:
        text += f"; {lit_percent(result.lit_fraction)} of the bins lit"
    out.print(paragraph(text, ""), soft_wrap=True)
    far = None if result.far_field is None else result.far_field.median_sigma
    if far is not None:
        text = f"median relative σ {far:.3g} over the lit bins of the far field"
        out.print(paragraph(text, ""), soft_wrap=True)
    if result.info.stopped in _STOPPED:
        text = f"stopped {_STOPPED[result.info.stopped]} after {result.batches} batches"
        out.print(paragraph(text, ""), soft_wrap=True)
    out.print(result.tally_digest, soft_wrap=True)
    for text in result.advisories:
        if text not in said:
            out.print(paragraph(f"advisory: {text}", ""), soft_wrap=True)


def _print_ledger(result: Result, out: Console) -> None:
    ledger = result.ledger
    emitted = ledger.emitted.value
    rows = table(("ledger", "left"), ("W", "right"), ("± σ", "right"), ("of emitted", "right"))

    def add(name: str, row: Estimate, style: str = "") -> None:
        part = 100.0 * row.value / emitted
        shown = f"{part:.1e} %" if 0.0 < abs(part) < 5e-5 else f"{part:.4f} %"
        rows.add_row(Text(name, style), *with_error(row.value, row.sigma), shown)

    add("emitted", ledger.emitted, "bold")
    for name, row in ledger.absorbed.items():
        add(f"absorbed by {name}", row)
    add("escaped", ledger.escaped)
    roulette = ledger.roulette
    if roulette.killed.value or roulette.boosted.value:
        add("roulette killed", roulette.killed)
        add("roulette boosted", roulette.boosted)
        add("roulette balance", roulette.balance)
    add("depth-capped", ledger.depth_capped)
    rows.add_row("closure", f"{ledger.closure:.1e}" if ledger.closure else "0", "", "")
    print_table(rows, out)


def _print_detectors(result: Result, out: Console) -> None:
    if not result.detectors:
        return
    out.print()
    rows = table(("detector", "left"), ("W", "right"), ("± σ", "right"), ("arrivals", "right"))
    for name, detector in result.detectors.items():
        power = detector.power
        rows.add_row(Text(name), *with_error(power.value, power.sigma), str(power.count))
        for rung in detector.ladder or ():
            if rung.count:
                last = " or more" if rung.generation == len(detector.ladder or ()) - 1 else ""
                label = Text(f"  generation {rung.generation}{last}")
                rows.add_row(label, *with_error(rung.value, rung.sigma), str(rung.count))
        if detector.map is not None:
            lit = detector.map.lit
            values = detector.map.irradiance[lit]
            ny, nx = lit.shape
            text = f"  map {nx} × {ny}"
            if values.size:
                text += f", lit {values.min():.4g} … {values.max():.4g} W/m²"
            rows.add_row(Text(text), "", "", "")
    print_table(rows, out)
