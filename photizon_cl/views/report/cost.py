"""What a report says of the cost study beside a result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.views.report.numbers import amount
from photizon_cl.views.report.tables import Table

if TYPE_CHECKING:
    from photizon_cl.result.cost import CostSetting, CostStudy

__all__ = ["cost_table", "describe_cost"]


def cost_table(study: CostStudy, own: str) -> Table:
    """Return a study's settings as a table.

    Parameters
    ----------
    study : CostStudy
        The study.
    own : str
        Digest of the scene that the report is about.
    """
    same = "" if study.scene_digest == own else " It is of other settings than this run's."
    return Table(
        "table-cost",
        f"σ and bias of {study.quantity} on {study.device}, with {study.rays_per_batch} rays a "
        f"batch; bias against {study.reference}, gain over {study.given}",
        (
            ("setting", False), ("million interactions/s", True), ("σ in %", True),
            ("bias in %", True), ("± σ in %", True), ("gain", True), ("± σ", True),
            ("seconds to 1 %", True),
        ),
        [_row(study, row) for row in study],
        "Gain: times as soon to the same σ. * a bias beyond four of its standard errors. "
        f"Seconds are of tracing, measured or, with ~, predicted.{same}",
    )  # fmt: skip


def _row(study: CostStudy, row: CostSetting) -> tuple[str, ...]:
    found = study.gain(row)
    gain = ("–", "–") if found is None else (amount(found[0], 3), amount(found[1], 1))
    if row.name == study.given:
        gain = ("1", "")
    return (
        row.name + (" *" if row.is_biased else ""),
        amount(row.interactions_per_s / 1e6, 3),
        _percent(row.relative_sigma),
        _percent(row.relative_bias),
        _percent(row.relative_bias_sigma),
        *gain,
        _seconds(row),
    )


def _percent(part: float | None) -> str:
    return "–" if part is None else amount(100.0 * part, 2)


def _seconds(row: CostSetting) -> str:
    seconds = row.seconds_to(0.01)
    if seconds is None:
        return "–"
    measured = next(t.measured_seconds for t in row.targets if t.target == 0.01)
    shown = amount(seconds, 2)
    return shown if measured is not None else "~" + shown


def describe_cost(study: CostStudy) -> tuple[str, str]:
    """Return what the study's figure shows, with numbers, and what stands below it."""
    given = study[study.given]
    best = max(
        (row for row in study if study.gain(row) is not None and not row.is_biased),
        key=lambda row: (study.gain(row) or (0.0, 0.0))[0],
        default=given,
    )
    seconds = given.seconds_to(0.01)
    text = f"Error of {study.quantity} against seconds of tracing for {len(study)} settings"
    if seconds is not None:
        text += f"; the scene as it stands reaches 1 % in {seconds:.3g} s"
    if best is not given:
        text += f", and {best.name} is the soonest without a bias that shows"
    return f"{text}.", (
        "Error against seconds of tracing, a panel for each knob; the scene as it stands is black. "
        "Where a bias shows, its curve ends in it."
    )
