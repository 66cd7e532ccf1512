"""What a precision costs in truth and gains in time: all modes on the presets, in one table.

    python -m benchmarks.precision
    python -m benchmarks.precision --presets box-room --rounds 3 --batches 16 --no-hard-cases
    python -m benchmarks.precision --write       keep the outcome in benchmarks/results

For each preset and mode: interactions a second, timed in interleaved rounds; the bias of a quantity
against fp64, batch against batch of the same random numbers, with its own standard error; the
largest bias of any quantity beside its error; and by how much a batch's ledger missed, at most.
Below, the hard cases of ``photizon stability`` in each mode.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import photizon_cl as pz
from benchmarks import facts
from benchmarks.report import Report, Spread, table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device.device import choose, open_device
from hostcode.errors import DeviceError
from hostcode.program.precision import PRECISIONS
from hostcode.run.usual import usual_plan
from photizon_cl.checks.precision import fitting_mode
from photizon_cl.errors import ArgumentError
from photizon_cl.result.comparison import compared
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names
from photizon_cl.stability.report import stability_report

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hostcode.device.device import OpenDevice
    from photizon_cl.result.comparison import Difference

RESULTS: Final = Path(__file__).absolute().parent / "results"
_SECONDS: Final = 0.5
"""Of tracing that a timed round takes at least."""
_LEAST: Final = 1e-6
"""Part of the emitted power that a quantity must have for its bias to be told."""


@dataclass(frozen=True)
class Row:
    """A preset in a mode.

    Parameters
    ----------
    rate : float
        Millions of interactions a second, the median of the rounds.
    low, high : float
        Its quartiles.
    gain : float
        Over fp64, the median of the rounds' own ratios.
    quantity : str
        What the bias is of: the first detector's power, or what escapes, or is absorbed first.
    bias, bias_sigma : float or None
        Relative, against fp64, and its standard error.
    worst : str
        The quantity that is farthest from that of fp64 beside its error.
    worst_bias, worst_sigma : float or None
        The same of it.
    closure : float
        Largest of a batch, as a part of the emitted power.
    """

    preset: str
    precision: str
    rate: float
    low: float
    high: float
    gain: float
    quantity: str
    bias: float | None
    bias_sigma: float | None
    worst: str
    worst_bias: float | None
    worst_sigma: float | None
    closure: float


def main_quantity(result: pz.Result) -> str:
    """Return the name of what a scene is mostly run for."""
    names = result.quantity_names
    wanted = ("detectors.", "ledger.escaped", "ledger.absorbed.")
    found = [n for start in wanted for n in names if n.startswith(start)]
    emitted = result.ledger.emitted.value
    return next((n for n in found if result.quantity(n).value > _LEAST * emitted), found[0])


def refusal(preset: str, mode: str) -> str:
    """Return why a mode cannot carry a preset, empty where it can."""
    try:
        fitting_mode(mode, load(preset))
    except ArgumentError as error:
        return str(error)
    return ""


def carrying(preset: str) -> list[str]:
    """Return the modes that can carry a preset."""
    return [mode for mode in PRECISIONS if not refusal(preset, mode)]


def measured(device: OpenDevice, preset: str, batches: int, rounds: int) -> list[Row]:
    """Measure a preset in every mode that can carry it."""
    runners = {}
    for mode in carrying(preset):
        compiled = compiled_preset(preset, precision=mode)
        plan = usual_plan(device.record, compiled.tables)
        runners[mode] = Runner(device, compiled, plan)
        runners[mode].warm_up(_SECONDS)
    rates: dict[str, list[float]] = {mode: [] for mode in runners}
    for _ in range(rounds):  # in turn, so that a slow moment meets all
        for mode, runner in runners.items():
            rates[mode].append(runner.time().rate)
    results = {
        mode: pz.trace(preset, batches=batches, precision=mode, device=device.record)
        for mode in runners
    }
    base = results["fp64"]
    name = main_quantity(base)
    rows = []
    for mode, result in results.items():
        spread = Spread.of(rates[mode])
        gain = Spread.of(a / b for a, b in zip(rates[mode], rates["fp64"], strict=True)).median
        found = compared(base, result)
        one, worst = found[name], max(found, key=_beside_error)
        emitted = result.compiled.emitted
        rows.append(
            Row(
                preset,
                mode,
                spread.median,
                spread.low,
                spread.high,
                gain,
                name,
                *_bias(one),
                worst.name,
                *_bias(worst),
                result.info.worst_closure / emitted,
            )
        )
    return rows


def _bias(row: Difference) -> tuple[float | None, float | None]:
    if row.ratio is None:
        return None, None
    return row.ratio - 1.0, row.ratio_sigma


def _beside_error(row: Difference) -> float:
    bias, sigma = _bias(row)
    if not bias:
        return 0.0
    return abs(bias) / sigma if sigma else math.inf


def _told(bias: float | None, sigma: float | None) -> str:
    if bias is None:
        return "0 in fp64"
    return "same bits" if bias == 0.0 and not sigma else f"{bias:+.1e} ± {sigma or 0.0:.1e}"


def lines(rows: Sequence[Row]) -> list[str]:
    """Return the table as lines."""
    head = ["preset", "precision", "M/s", "gain", "quantity", "bias", "worst", "bias", "closure"]
    body = [
        [
            r.preset, r.precision, f"{r.rate:.1f} ({r.low:.1f} – {r.high:.1f})", f"{r.gain:.2f}",
            r.quantity, _told(r.bias, r.bias_sigma), r.worst, _told(r.worst_bias, r.worst_sigma),
            f"{r.closure:.0e}" if r.closure else "0",
        ]
        for r in rows
    ]  # fmt: skip
    return list(table(head, body, left=2))


def hard_cases(device: OpenDevice) -> list[list[str]]:
    """Return what of the hard cases survives in each mode."""
    found = []
    for mode, precision in PRECISIONS.items():
        rows = stability_report(device, precision=mode)
        cases, lost = sum(r.cases for r in rows), sum(len(r.lost) for r in rows)
        found.append(
            [
                mode,
                f"2^{math.frexp(precision.roundoff)[1] - 1}",
                str(cases),
                str(cases - lost),
                str(lost),
                str(sum(len(r.wrong) for r in rows)),
                f"{max(r.worst for r in rows):.2f}",
                f"{sum(not r.verdict for r in rows)} of {len(rows)}",
            ]
        )
    return found


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.precision")
    parser.add_argument("--device")
    parser.add_argument("--presets", nargs="+", choices=preset_names(), metavar="NAME")
    parser.add_argument("--batches", type=int, default=64, help="batches of the comparison")
    parser.add_argument("--rounds", type=int, default=9, help="rounds that are timed")
    parser.add_argument("--no-hard-cases", action="store_true")
    parser.add_argument("--write", action="store_true", help="keep the outcome")
    asked = parser.parse_args(arguments)
    try:
        device = open_device(choose(asked.device))
    except DeviceError as error:
        print(f"benchmarks.precision: {error}", file=sys.stderr)
        return 2
    report = Report()
    conditions = facts.facts(device.record)
    report.say(*facts.lines(conditions))
    rows = []
    for preset in asked.presets or preset_names():
        rows += measured(device, preset, asked.batches, asked.rounds)
    report.heading(f"precision, {asked.rounds} rounds, bias of {asked.batches} batches")
    report.say(*lines(rows))
    refused = {
        f"{preset} in {mode}": why
        for preset in asked.presets or preset_names()
        for mode in PRECISIONS
        if (why := refusal(preset, mode))
    }
    report.say(*(f"refused, {what}: {why}" for what, why in refused.items()))
    hard: list[list[str]] = []
    if not asked.no_hard_cases:
        hard = hard_cases(device)
        report.heading("hard cases")
        head = ["precision", "u", "cases", "asked", "lost", "wrong", "worst ulps", "families whole"]
        report.say(*table(head, hard, left=1))
    if asked.write:
        data = {
            "conditions": conditions,
            "rows": [asdict(r) for r in rows],
            "refused": refused,
            "hard_cases": hard,
        }
        for path in report.write(RESULTS, "precision", data):
            print(f"wrote {path.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
