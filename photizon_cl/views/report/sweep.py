"""The report of a sweep: its table, its figure, what was measured and how."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

from markupsafe import Markup

from photizon_cl.errors import ArgumentError
from photizon_cl.scene.sweep_values import value_text
from photizon_cl.views.report.figures import Drawing
from photizon_cl.views.report.numbers import integer, number, pair
from photizon_cl.views.report.page import GENERATOR, lookup
from photizon_cl.views.report.tables import MOST_ROWS, Table

if TYPE_CHECKING:
    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.measures import Measure
    from photizon_cl.result.sweep import SweepPoint, SweepTable

__all__ = ["render_sweep"]

_MOST_MEASURES: Final = 6
"""Measures side by side; the table on disk has all."""
_HERE: Final = Path(__file__).resolve().parent


def render_sweep(sweep: SweepTable) -> str:
    """Return the page as text."""
    from photizon_cl.version import __version__

    plan = sweep.plan
    shown = _shown(sweep)
    text: str = (
        lookup()
        .get_template("sweep.mako")
        .render_unicode(
            generator=f"{GENERATOR} {__version__}",
            style=Markup((_HERE / "style.css").read_text(encoding="utf-8")),
            title=plan.heading,
            scene_name=plan.scene.name,
            notes=plan.notes.strip(),
            summary=_summary(sweep),
            advisories=sweep.advisories,
            measures=[(m.name, m.meaning) for m in shown],
            drawing=_drawn(sweep),
            points=_points(sweep, shown),
            changes=_changes(sweep, shown),
            runs=_runs(sweep),
            failed=[f"Point {p.number} ({plan.said(p.number)}): {p.why}" for p in sweep.failed],
        )
    )
    return text.lstrip()


def _shown(sweep: SweepTable) -> list[Measure]:
    """Return the measures on the page: detectors' powers first where none were named."""
    measures = list(sweep.measured)
    if not sweep.plan.measures:
        measures.sort(key=lambda m: not m.name.endswith(".power"))
    return measures[:_MOST_MEASURES]


def _summary(sweep: SweepTable) -> list[str]:
    plan = sweep.plan
    across = " × ".join(str(n) for n in plan.shape)
    over = ", ".join(axis.path for axis in plan.axes)
    first = f"{across} points of {plan.scene.name} over {over}."
    if not sweep.finished:
        first += f" {sweep.n_done} of {len(sweep)} have been run."
    seeds = {point.seed for point in sweep.points if point.done}
    stream = (
        "All points have one random stream: what they have in common cancels in differences."
        if len(seeds) == 1
        else "Points have random streams of their own: their errors add in quadrature."
    )
    return [first, stream]


def _drawn(sweep: SweepTable) -> Drawing | None:
    """Return the figure, None where there is nothing to draw."""
    from photizon_cl.views.figures.style import write
    from photizon_cl.views.figures.sweep_plot import draw_sweep

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweep.png"
        try:
            write(lambda: draw_sweep(sweep), path, "png")
        except ArgumentError:
            return None
        png = path.read_bytes()
    names = ", ".join(m.name for m in _shown(sweep))
    over = ", ".join(axis.name for axis in sweep.plan.axes)
    alt = f"{names} over {over}, {sweep.n_done} points with error bars; the table has the numbers."
    return Drawing("sweep.png", "sweep", "", png, alt, "Bars are ± 1 σ.")


def _heads(sweep: SweepTable) -> list[tuple[str, bool]]:
    return [("point", True), *((axis.label, axis.numeric) for axis in sweep.plan.axes)]


def _start(sweep: SweepTable, point: SweepPoint) -> list[str]:
    out = [str(point.number)]
    for axis in sweep.plan.axes:
        value = point.values[axis.name]
        out.append(number(f"{value:.6g}") if axis.numeric else value_text(value))
    return out


def _points(sweep: SweepTable, shown: list[Measure]) -> Table:
    columns = _heads(sweep)
    for measure in shown:
        unit = "" if measure.unit == "1" else f" in {measure.unit}"
        columns += [(f"{measure.name}{unit}", True), ("± σ", True)]
    rows = []
    for point in sweep.points[:MOST_ROWS]:
        row = _start(sweep, point)
        for measure in shown:
            row += _cells(point.measures.get(measure.name))
        rows.append(row)
    return Table("table-points", "What was measured at each point", columns, rows, _left(sweep))


def _changes(sweep: SweepTable, shown: list[Measure]) -> Table:
    columns = _heads(sweep)
    for measure in shown:
        columns += [(f"change of {measure.name}", True), ("± σ", True)]
    rows = []
    for point in sweep.points[1:MOST_ROWS]:
        row = _start(sweep, point)
        for measure in shown:
            row += _cells(point.change.get(measure.name))
        rows.append(row)
    caption = "Differences from point 0, paired batch by batch where both share a stream"
    return Table("table-changes", caption, columns, rows, _left(sweep))


def _cells(found: Estimate | None) -> tuple[str, str]:
    if found is None or math.isnan(found.value):
        return "–", "–"
    return pair(found.value, found.sigma)


def _runs(sweep: SweepTable) -> Table:
    columns = (
        ("point", True), ("batches", True), ("rays", True), ("seconds", True),
        ("ended by", False), ("tally digest", False),
    )  # fmt: skip
    rows = [
        (str(p.number), integer(p.batches), integer(p.rays), number(f"{p.seconds:.3g}"),
         p.stopped or "–", p.digest or "–")
        for p in sweep.points[:MOST_ROWS]
    ]  # fmt: skip
    return Table("table-runs", "Batches, time and digest of each point", columns, rows)


def _left(sweep: SweepTable) -> str:
    more = len(sweep) - MOST_ROWS
    return f"{integer(more)} more points are in sweep.csv." if more > 0 else ""
