"""What a cost study says in words."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Final

from photizon_cl.result.cost import TARGETS
from photizon_cl.result.stopping import LEAST_BATCHES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.result.cost import CostSetting, CostStudy

__all__ = ["advice"]

_WORTH: Final = 1.2
"""Times as soon to the same σ from which on a setting is worth a word."""
_SURE: Final = 2.0
"""Standard errors by which it must be."""
_SMALL: Final = 0.1
"""Part of the smallest target up to which a bias is no matter."""
_CLOSED: Final = 1e-14
"""Closure, in parts of the emitted power, that is rounding."""


def advice(study: CostStudy) -> tuple[str, ...]:
    """Return what follows from a study, the scene's own settings first."""
    return tuple(_lines(study))


def _lines(study: CostStudy) -> Iterator[str]:
    given = study[study.given]
    if given.is_biased:
        write = study[study.reference].written
        yield (
            f"the scene as it stands is off by {_bias(given)} against {study.reference}"
            + (f": write {write}" if write else "")
        )
    if given.estimate == 0.0:
        yield (
            f"nothing arrives at {study.quantity}: name another quantity with --quantity, or trace "
            "for longer"
        )
    elif study.is_certain:
        yield (
            f"every batch gave the same {study.quantity}: it is known as it stands, and no setting "
            "has a σ to save time on"
        )
    elif all(t.measured_seconds == given.targets[0].measured_seconds for t in given.targets):
        least = given.targets[0].measured_seconds
        if least is not None:
            tightest = given.targets[-1].target
            yield (
                f"the fewest batches that a run makes, {LEAST_BATCHES}, reach {100 * tightest:g} % "
                f"already, in {least:.2g} s"
            )
    others = [row for row in study if row.name != study.given]
    small = [row for row in others if row.is_biased and not _matters(row)]
    if small:
        named = ", ".join(
            f"{row.written or row.name} ({100.0 * (row.relative_bias or 0.0):.2g} %)"
            for row in small
        )
        yield (
            f"off by less than {100.0 * _SMALL * TARGETS[-1]:g} %, which is no matter where σ is "
            f"{100.0 * TARGETS[-1]:g} %: {named}"
        )
    for knob, rows in groupby(others, key=lambda row: row.knob):
        yield from _of_knob(study, knob, list(rows))


def _of_knob(study: CostStudy, knob: str, rows: list[CostSetting]) -> Iterator[str]:
    gains = {row.name: gain for row in rows if (gain := study.gain(row)) is not None}
    worth = [
        row
        for row in rows
        if row.name in gains
        and gains[row.name][0] > _WORTH
        and gains[row.name][0] - _SURE * gains[row.name][1] > 1.0
    ]
    true = [row for row in worth if not _matters(row)]
    if true:
        best = max(true, key=lambda row: gains[row.name][0])
        ratio, error = gains[best.name]
        yield (
            f"{best.written or best.name} gives the same σ in {1.0 / ratio:.2g} of the time "
            f"({ratio:.2g} ± {error:.1g} times as soon); {_no_bias(best)}"
        )
    for row in rows:
        if _matters(row):
            sooner = ""
            if row in worth:
                sooner = f", though {gains[row.name][0]:.2g} times as soon to the same σ"
            yield f"{row.written or row.name} is off by {_bias(row)}{sooner}"
        elif row.closure > _CLOSED:
            yield f"{row.written or row.name} leaves {row.closure:.1e} of the power unaccounted for"
    slower = [row for row in rows if row.name in gains and _slower(gains[row.name])]
    if slower and not worth:
        worst = min(slower, key=lambda row: gains[row.name][0])
        yield (
            f"{worst.written or worst.name} takes {1.0 / gains[worst.name][0]:.2g} times as long "
            "to the same σ"
        )
    if gains and not worth and not slower and not any(map(_matters, rows)):
        yield f"{knob}: no value that was tried is surely sooner to a σ by a fifth or more"


def _matters(row: CostSetting) -> bool:
    """Say whether a bias shows that is no small part of the smallest σ that anyone asks for."""
    relative = row.relative_bias
    return row.is_biased and (relative is None or abs(relative) > _SMALL * TARGETS[-1])


def _slower(gain: tuple[float, float]) -> bool:
    ratio, error = gain
    return ratio < 1.0 / _WORTH and ratio + _SURE * error < 1.0


def _bias(row: CostSetting) -> str:
    """Return a bias with its σ, in percent of the value where there is one."""
    relative = row.relative_bias
    bias, sigma = row.bias or 0.0, row.bias_sigma or 0.0
    if not relative:
        return f"{bias:.3g} ± {sigma:.1g} W"
    return f"{100.0 * relative:.3g} % ± {100.0 * (row.relative_bias_sigma or 0.0):.1g} %"


def _no_bias(row: CostSetting) -> str:
    if row.bias is None or row.bias_sigma is None or row.estimate == 0.0:
        return "its bias is not known"
    if row.is_biased:
        return f"its bias is {_bias(row)}"
    most = max(abs(row.bias), row.bias_sigma) / abs(row.estimate)
    return f"no bias shows, to {100.0 * most:.1g} %" if most else "it has no bias at all"
