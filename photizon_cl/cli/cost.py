"""The verb ``cost``: what accuracy costs in time."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

from photizon_cl.cli.arguments import DEVICE, JSON, SEED, add_scene, integer, load_scene, number
from photizon_cl.errors import ArgumentError, printable

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from photizon_cl.result.cost import CostSetting, CostStudy

__all__ = ["add_arguments", "call", "show"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    add_scene(parser)
    parser.add_argument(
        "--quantity", metavar="Q",
        help="what σ and bias are of: detectors.NAME.power, ledger.escaped, ...",
    )  # fmt: skip
    parser.add_argument(
        "--max-seconds", type=number, metavar="T", default=120.0,
        help="how long it may take, building many programs aside; default 120",
    )  # fmt: skip
    parser.add_argument("--seed", type=integer, metavar="N", help=SEED)
    parser.add_argument("--device", metavar="D", help=DEVICE)
    parser.add_argument(
        "--out", metavar="DIR",
        help="write cost.json and the figure there; beside a saved result the report has them",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help=JSON)


def call(arguments: argparse.Namespace) -> int:
    """Make the study as the arguments say; return the exit status."""
    if arguments.out == "":
        raise ArgumentError("--out: found nothing, expected a directory")
    scene = load_scene(arguments)  # a bad scene is told before anything heavy is imported

    from photizon_cl.cli.progress import Lines
    from photizon_cl.studies.cost_files import check_folder, save
    from photizon_cl.studies.costing import cost

    if arguments.out is not None:
        check_folder(arguments.out)
    with Lines(scene.heading) as lines:
        study = cost(
            scene,
            quantity=arguments.quantity,
            max_seconds=arguments.max_seconds,
            seed=arguments.seed,
            device=arguments.device,
            progress=lines.update,
        )
    written = [] if arguments.out is None else save(study, arguments.out)
    if arguments.json:
        print(json.dumps(study.summary(), indent=2, ensure_ascii=True, allow_nan=False))
    else:
        from photizon_cl.cli.tables import console

        show(study, console())
    for path in written:
        print(f"written to {printable(str(path))}", file=sys.stderr)
    return 0


def show(study: CostStudy, out: Console) -> None:
    """Print a study: two tables and the advice."""
    from rich.text import Text

    from photizon_cl.cli.tables import heading, paragraph, print_table, table
    from photizon_cl.result.cost import TARGETS

    out.print(heading(study.scene, f"  {printable(study.quantity)}"))
    out.print(
        paragraph(
            f"{study.device}; {study.rays_per_batch} rays a batch for this study, seed "
            f"{study.seed}; bias against {study.reference}",
            "",
        ),
        soft_wrap=True,
    )
    out.print()
    rows = table(
        ("setting", "left"), ("M/s", "right"), ("σ, %", "right"), ("bias, %", "right"),
        ("± σ", "right"), ("closure", "right"), ("gain", "right"), ("± σ", "right"),
    )  # fmt: skip
    for row in study:
        rows.add_row(
            Text(row.name + (" *" if row.is_biased else "")),
            f"{row.interactions_per_s / 1e6:.3g}",
            _percent(row.relative_sigma),
            *_bias(row),
            f"{row.closure:.0e}" if row.closure else "0",
            *_gain(study, row),
        )
    print_table(rows, out)
    out.print()
    times = table(("to a σ of", "left"), *((f"{100.0 * t:g} %", "right") for t in TARGETS))
    for row in study:
        cells = [
            _seconds(t.predicted_seconds) + " / " + _seconds(t.measured_seconds)
            for t in row.targets
        ]
        times.add_row(Text(row.name), *cells)
    print_table(times, out)
    out.print()
    out.print(
        paragraph(
            f"{study.given} is the scene as it stands, in every other row one thing is another; "
            "M/s: million interactions a second; gain: times as soon to the same σ; σ is that of "
            "each row's own seconds; seconds: predicted / measured, – where not reached; * the "
            "bias shows",
            "",
        ),
        soft_wrap=True,
    )
    for name, why in study.left_out:
        out.print(paragraph(f"left out: {printable(name)}: {printable(why)}", ""), soft_wrap=True)
    if study.advice:
        out.print()
        out.print(Text("advice", "bold"))
    for text in study.advice:
        out.print(paragraph(f"- {printable(text)}"), soft_wrap=True)


def _percent(part: float | None) -> str:
    return "–" if part is None else f"{100.0 * part:.2g}"


def _bias(row: CostSetting) -> tuple[str, str]:
    if row.relative_bias is None or row.relative_bias_sigma is None:
        return "–", "–"
    return f"{100.0 * row.relative_bias:.2g}", f"{100.0 * row.relative_bias_sigma:.1g}"


def _gain(study: CostStudy, row: CostSetting) -> tuple[str, str]:
    found = study.gain(row)
    if row.name == study.given or found is None:
        return ("1", "") if row.name == study.given else ("–", "–")
    return f"{found[0]:.2f}", f"{found[1]:.2f}"


def _seconds(value: float | None) -> str:
    return "–" if value is None else f"{value:.2g}" if value < 100.0 else f"{value:.0f}"
