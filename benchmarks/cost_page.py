"""Makes the studies of docs/what-accuracy-costs.md: ``python -m benchmarks.cost_page``.

For each preset of the list it runs the command, keeps the study in benchmarks/results, draws its
figure into docs/images and writes what was printed into the page. ``--redraw`` makes page and
figures from the kept studies; a test asks that the page is what that gives.
"""

from __future__ import annotations

import argparse
import io
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Final

from photizon_cl.cli.cost import show
from photizon_cl.cli.tables import console
from photizon_cl.result.cost_file import read_study, study_text
from photizon_cl.studies.costing import cost
from photizon_cl.views.figures.cost_plot import draw_cost
from photizon_cl.views.figures.style import write

if TYPE_CHECKING:
    from photizon_cl.result.cost import CostStudy

ROOT: Final = Path(__file__).resolve().parents[1]
PAGE: Final = ROOT / "docs" / "what-accuracy-costs.md"
IMAGES: Final = ROOT / "docs" / "images"
RESULTS: Final = ROOT / "benchmarks" / "results"
MARK: Final = "<!-- studies -->\n"

STUDIES: Final = (
    ("integrating-sphere", None, "Light that meets a matt wall many times, and leaves by a port."),
    ("box-room", "detectors.floor.map", "A map of many bins, of which each sees few rays."),
    ("ghost-ladder", None, "Rays split deterministically, and nothing scatters."),
    ("plano-convex-condenser", None, "Glass that splits, and a focus that nearly all reaches."),
    ("cpc-concentrator", None, "Many grazing reflections at mirrors."),
)
"""Preset, quantity where it is not the usual one, and what the scene is like."""


def kept(preset: str) -> Path:
    """Return the file of a preset's study."""
    return RESULTS / f"cost-{preset}.json"


def printed(study: CostStudy) -> str:
    """Return what the command prints of a study."""
    out = io.StringIO()
    with redirect_stdout(out):
        made = console()
        made.width = 80
        show(study, made)
    return out.getvalue().rstrip() + "\n"


def page(text: str) -> str:
    """Return the page's text with the kept studies behind the mark."""
    head = text[: text.index(MARK) + len(MARK)]
    parts = []
    for preset, quantity, what in STUDIES:
        if not kept(preset).is_file():
            continue
        study = read_study(kept(preset))
        asked = f" --quantity {quantity}" if quantity else ""
        figure = "" if study.is_certain else f"![](images/cost-{preset}.png)\n\n"
        parts.append(
            f"\n## {preset}\n\n{what}\n\n```text\n$ photizon cost {preset}{asked}\n"
            f"{printed(study)}```\n\n{figure}".rstrip()
            + "\n"
        )
    return head + "".join(parts)


def main(argv: list[str] | None = None) -> int:
    """Run the studies, or make page and figures of those that are kept; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=120.0, help="of each; default 120")
    parser.add_argument("--only", action="append", help="a preset; may be repeated")
    parser.add_argument("--redraw", action="store_true", help="run nothing")
    args = parser.parse_args(argv)
    for preset, quantity, _ in STUDIES:
        if args.only and preset not in args.only:
            continue
        if not args.redraw:
            print(f"{preset}: {args.seconds:g} s", flush=True)
            study = cost(preset, quantity=quantity, max_seconds=args.seconds)
            kept(preset).write_text(study_text(study), encoding="utf-8")
            print(f"{preset}: took {study.seconds:.0f} s", flush=True)
        study = read_study(kept(preset))
        if not study.is_certain:
            write(lambda s=study: draw_cost(s), IMAGES / f"cost-{preset}.png", "png")
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
