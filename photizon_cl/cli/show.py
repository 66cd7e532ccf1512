"""The verb ``show``: a scene drawn with traced rays."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.atomic import in_any_locale
from photizon_cl.cli.arguments import DEVICE, SEED, add_scene, integer, load_scene
from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

__all__ = ["FORMATS", "add_arguments", "call"]

FORMATS: Final = (".png", ".svg", ".pdf")
_DPI: Final = 150
_RAYS: Final = 10_000
_SEGMENTS: Final = 100_000
"""More are a tangle, and take a minute to draw."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    add_scene(parser)
    parser.add_argument("--rays", type=integer, default=50, metavar="N", help="rays, default 50")
    parser.add_argument("--seed", type=integer, metavar="N", help=SEED)
    parser.add_argument(
        "--by", choices=("generation", "weight"), default="generation", help="what colours the rays"
    )
    parser.add_argument("--device", metavar="D", help=DEVICE)
    parser.add_argument(
        "--out", metavar="FILE", help="a .png, .svg or .pdf file; default NAME.png, here"
    )


def call(arguments: argparse.Namespace) -> int:
    """Draw a scene as the arguments say; return the exit status."""
    scene = load_scene(arguments)  # a bad scene is told before anything heavy is imported
    out = arguments.out
    if out is None:
        out = in_any_locale(re.sub(r"[^\w+.-]+", "_", scene.name).strip(".") + ".png")
    path = Path(out)
    if path.suffix.lower() not in FORMATS:
        raise ArgumentError(
            f"--out: found {show(out)}, expected a file that ends in {', '.join(FORMATS)}"
        )
    if path.is_dir() or not path.parent.is_dir():
        why = "it is a directory" if path.is_dir() else "its directory does not exist"
        raise ArgumentError(f"--out: found {show(out)}, expected a file to write ({why})")

    from photizon_cl.cli.tables import console, paragraph
    from photizon_cl.run.pathing import paths
    from photizon_cl.views.drawing.plot import draw_scene
    from photizon_cl.views.figures.style import check_figure, metadata, replace_figure

    check_figure(path)
    if arguments.rays > _RAYS:
        raise ArgumentError(
            f"--rays: found {arguments.rays}, expected at most {_RAYS}: more cannot be told apart "
            "in a drawing; photizon_cl.paths follows any number"
        )
    found = paths(scene, arguments.rays, arguments.seed, device=arguments.device)
    if len(found) > _SEGMENTS:
        raise ArgumentError(
            f"--rays: {arguments.rays} rays make {len(found)} segments, expected at most "
            f"{_SEGMENTS}, which take a minute to draw: take fewer rays, or fewer interactions "
            "with --set run.generation_cap=3"
        )
    figure = draw_scene(found, arguments.by)
    kind = path.suffix.lower()[1:]
    try:
        replace_figure(
            path, lambda file: figure.savefig(file, format=kind, dpi=_DPI, metadata=metadata(kind))
        )
    except OSError as error:
        why = error.strerror or str(error)
        raise ArgumentError(f"--out: {show(out)} cannot be written ({why})") from None
    screen = console()
    for text in found.advisories:
        screen.print(paragraph(f"advisory: {text}", ""), soft_wrap=True)
    screen.print(
        f"{len(found)} segments of {arguments.rays} rays, written to {path}", soft_wrap=True
    )
    return 0
