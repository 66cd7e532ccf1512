"""What notebooks show of a result, and its tables as data frames."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING, Any, Final

from markupsafe import Markup

from photizon_cl.errors import ArgumentError, show
from photizon_cl.result.data_frame import data_frame_of
from photizon_cl.scene.sweep_values import value_text
from photizon_cl.views.report.numbers import integer, percent
from photizon_cl.views.report.page import lookup
from photizon_cl.views.report.tables import detector_table, ledger_table, tally_tables

if TYPE_CHECKING:
    import pandas as pd

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.sweep import SweepTable

__all__ = ["data_frame", "html", "sweep_frame"]

_MOST_ROWS: Final = 30  # of a table in a notebook


def html(result: Estimates) -> str:
    """Return a header line, the ledger, the detectors and what effects count as HTML."""
    achieved = result.achieved_sigma
    sigma = "unknown" if achieved is None else percent(achieved)
    verdict = "met" if result.converged else "not met"
    head = Markup(
        "{} rays in {} batches, seed {} · {} {}, target {} {} · {} · <code>{}</code>"
    ).format(
        integer(result.rays),
        integer(result.batches),
        result.scene.run.seed,
        result.sigma_is,
        sigma,
        percent(result.target_sigma),
        verdict,
        result.info.device,
        result.tally_digest[:19] + "…",
    )
    n = len(result.advisories)
    text: str = (
        lookup()
        .get_template("notebook.mako")
        .render_unicode(
            title=result.scene.heading,
            head=head,
            ledger=ledger_table(result, _MOST_ROWS),
            detectors=detector_table(result, _MOST_ROWS) if result.detectors else None,
            tallies=tally_tables(result, _MOST_ROWS),
            advisories=f"{n} advisor{'y' if n == 1 else 'ies'}: see .advisories" if n else "",
        )
    )
    return text.strip()


def data_frame(result: Estimates, detector: str | None = None) -> pd.DataFrame:
    """Return the ledger, or a detector's ladder, see `photizon_cl.Result.to_dataframe`."""
    if detector is None:
        rows = result.ledger.labelled_rows()
        emitted = result.ledger.emitted.value
        columns: dict[str, list[Any]] = {
            "row": [name for name, _ in rows],
            "value_W": [row.value for _, row in rows],
            "sigma_W": [nan if row.sigma is None else row.sigma for _, row in rows],
            "share": [row.value / emitted for _, row in rows],
        }
        return data_frame_of(columns)
    ladder = result.detectors[detector].ladder if detector in result.detectors else None
    if ladder is None:
        having = [name for name, d in result.detectors.items() if d.ladder is not None]
        expected = ", ".join(map(show, having[:10])) if having else "none has one in this scene"
        raise ArgumentError(
            f"detector: found {show(detector)}, expected a detector with a ladder ({expected}; "
            "`generations` of a scene's detector gives it one)"
        )
    emitted = result.ledger.emitted.value
    columns = {
        "generation": [rung.generation for rung in ladder],
        "value_W": [rung.value for rung in ladder],
        "sigma_W": [nan if rung.sigma is None else rung.sigma for rung in ladder],
        "share": [rung.value / emitted for rung in ladder],
        "count": [rung.count for rung in ladder],
    }
    return data_frame_of(columns)


def sweep_frame(sweep: SweepTable) -> pd.DataFrame:
    """Return a sweep as a data frame, see `photizon_cl.Sweep.to_dataframe`."""
    points = sweep.points
    columns: dict[str, list[Any]] = {"point": [point.number for point in points]}
    for axis in sweep.plan.axes:
        values = [point.values[axis.name] for point in points]
        columns[axis.name] = values if axis.numeric else [value_text(value) for value in values]
    for name in sweep.names:
        for end, of in (("", "measures"), ("_change", "change")):
            found = [getattr(point, of).get(name) for point in points]
            columns[f"{name}{end}"] = [nan if one is None else one.value for one in found]
            sigmas = [nan if one is None or one.sigma is None else one.sigma for one in found]
            columns[f"{name}{end}_sigma"] = sigmas
    for item in ("batches", "rays", "seconds", "stopped", "digest"):
        columns[item] = [getattr(point, item) for point in points]
    return data_frame_of(columns)
