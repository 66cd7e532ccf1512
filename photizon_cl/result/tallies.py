"""What effects count in cells of their own: a list of labels, each with a value and a count.

No effect is named here: one that labels its cells (`Effect.labels`) is in the summary, the files,
the printed result and the report. What has no labels, as the far field, is shown in a way of its
own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.result.ledger import Estimate, watts
from photizon_cl.scene.names import Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import CellGroup
    from photizon_cl.result.statistics import Accumulator

__all__ = ["EffectTally", "effect_tallies", "only_counts", "ranked"]


class EffectTally(Table[Estimate]):
    """Estimates by label, in the effect's order.

    Parameters
    ----------
    cells : mapping of str to Estimate
        In `unit`, which is mostly ``W``.
    unit : str
        Of values and standard errors.
    """

    def __init__(self, cells: Mapping[str, Estimate], unit: str) -> None:
        super().__init__("tallies", cells)
        self.unit = unit

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self), self.unit)


def effect_tallies(compiled: CompiledScene, tally: Accumulator) -> Table[EffectTally]:
    """Return the estimates of labelled cells, by effect, then by label in the effect's order.

    Parameters
    ----------
    compiled : CompiledScene
        What the cells mean and are worth.
    tally : Accumulator
        At least one batch.
    """
    labelled = compiled.layout.labelled
    return Table("tallies", ((g.effect, _cells(compiled, tally, g)) for g in labelled))


def _cells(compiled: CompiledScene, tally: Accumulator, group: CellGroup) -> EffectTally:
    errors = tally.standard_error(group.first, group.size) * compiled.unit_power * group.scale
    counts = tally.counts(group.first, group.size)
    cells = range(group.first, group.first + group.size)
    estimates = {
        label: Estimate(
            watts(compiled, tally.exact(cell), tally.batches) * group.scale,
            float(error) if tally.batches > 1 else None,
            int(count),
        )
        for label, cell, error, count in zip(group.labels, cells, errors, counts, strict=True)
    }
    return EffectTally(estimates, group.unit)


def ranked(cells: Mapping[str, Estimate], most: int) -> tuple[dict[str, Estimate], int]:
    """Return the `most` largest rows, and how many are left.

    The largest power comes first; where powers are equal, the largest count; then the first.
    """
    order = sorted(cells, key=lambda label: (-abs(cells[label].value), -(cells[label].count or 0)))
    return {label: cells[label] for label in order[:most]}, max(len(order) - most, 0)


def only_counts(cells: Mapping[str, Estimate]) -> bool:
    """Say whether something was counted and none of it has power: an effect that only counts."""
    return any(cell.count for cell in cells.values()) and not any(
        cell.value or cell.sigma for cell in cells.values()
    )
