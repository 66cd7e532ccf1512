"""Whether runs take as long as they told: ``python -m benchmarks.forecasts``.

Forty runs towards targets of 1 to 5 %, each of a few seconds on two cores; see `RUNS`. Prints what
each told of itself and kept, when, what it took, and the ratio; then which share was told within a
factor of 1.25, which lay in the interval that was told, and how much of a run had passed by then.
The same of what would have been told at the eighth batch stands beside it. Presets of which a run
to 1 % ends within a second (`cassegrain`, `cosine-fourth`, `ghost-ladder`, and single numbers of
nearly all) have no time to tell anything of, and are left out.

Time is the thing measured: run it where nothing else runs. Exit status 1 where fewer than nine in
ten are within a factor of 1.25.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import photizon_cl as pz
from benchmarks.facts import facts, lines, load
from benchmarks.report import Report, table
from hostcode.device.device import choose

if TYPE_CHECKING:
    from photizon_cl.run.progress import Progress

WITHIN: Final = 1.25
WANTED: Final = 0.9
FAR_FIELD: Final = ("far_field",)
GHOSTS: Final = ("detectors.focus.ladder[4]",)
"""Two reflections within the lens: a single number that few rays make."""


@dataclass(frozen=True)
class Run:
    """A run of the list: a preset, its target, the seed, and what must meet it."""

    preset: str
    target: float
    seed: int
    on: tuple[str, ...] = ()


def _runs(preset: str, target: float, n: int, on: tuple[str, ...] = ()) -> list[Run]:
    return [Run(preset, target, seed, on) for seed in range(1, n + 1)]


RUNS: Final = (
    *_runs("baffled-tube", 0.05, 3),
    *_runs("baffled-tube", 0.03, 3),
    *_runs("box-room", 0.01, 5),
    *_runs("cpc-concentrator", 0.015, 3),
    *_runs("cpc-concentrator", 0.01, 3),
    *_runs("integrating-sphere", 0.01, 3, FAR_FIELD),
    *_runs("lambertian-sphere", 0.015, 2),
    *_runs("lambertian-sphere", 0.01, 3),
    *_runs("plano-convex-condenser", 0.03, 3),
    *_runs("plano-convex-condenser", 0.02, 3),
    *_runs("plano-convex-condenser", 0.05, 3, GHOSTS),
    *_runs("square-lightpipe", 0.015, 3),
    *_runs("square-lightpipe", 0.01, 3),
)
"""Forty, of 2 to 20 seconds each."""


def traced(run: Run) -> dict[str, Any]:
    """Make a run; return what it told, and when, beside what it took."""
    told: list[dict[str, float]] = []

    def note(now: Progress) -> None:
        latest = now.forecast
        if latest is not None and (not told or told[-1]["after_batches"] != latest.after_batches):
            told.append({**latest.summary(), "at": now.seconds, "batches": now.batches})

    result = pz.trace(
        run.preset, seed=run.seed, target=run.target, target_on=run.on or None,
        max_seconds=120.0, progress=note,
    )  # fmt: skip
    kept, seconds = result.info.forecast, result.info.seconds
    if kept is not None and kept.after_batches == result.batches:
        kept = None  # told when the run was over
    row = {
        "preset": run.preset, "target": run.target, "seed": run.seed, "on": list(run.on),
        "batches": result.batches, "seconds": seconds, "converged": result.converged,
        "told": told, "kept": None if kept is None else kept.summary(), "at": None,
    }  # fmt: skip
    if kept is not None:
        row["at"] = next(t["at"] for t in told if t["after_batches"] == kept.after_batches)
    return row


def within(told: dict[str, float] | None, seconds: float) -> bool:
    """Say whether a forecast is within a factor of `WITHIN` of what a run took."""
    return told is not None and abs(math.log(told["seconds"] / seconds)) <= math.log(WITHIN)


def _line(row: dict[str, Any]) -> tuple[str, ...]:
    what = f"{row['preset']} {', '.join(row['on'])}".strip()
    head = (what, f"{row['target']:g}", str(row["seed"]))
    took = row["seconds"]
    if row["kept"] is None:
        return (*head, str(row["batches"]), "-", "-", "-", "-", f"{took:.2f}", "-", "none")
    kept, first = row["kept"], row["told"][0]
    return (
        *head, str(row["batches"]), str(kept["after_batches"]), f"{100 * row['at'] / took:.0f} %",
        f"{kept['seconds']:.2f}", f"{kept['low']:.2f}–{kept['high']:.2f}", f"{took:.2f}",
        f"{kept['seconds'] / took:.2f}", f"{first['seconds'] / took:.2f}",
    )  # fmt: skip


HEADER: Final = (
    "run", "target", "seed", "batches", "after", "passed", "told", "interval", "took", "ratio",
    "first",
)  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.forecasts", description=__doc__)
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only each N-th run")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    started = time.perf_counter()
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    report.heading("Seconds of whole runs, told and taken")
    for preset in dict.fromkeys(run.preset for run in RUNS):
        pz.trace(preset, batches=1)  # builds the program, which is no part of a run's time
    rows = [traced(run) for run in RUNS[:: asked.every]]
    report.say(*table(HEADER, [_line(row) for row in rows]))
    n = len(rows)
    good = sum(within(row["kept"], row["seconds"]) for row in rows)
    first = sum(within(row["told"][0] if row["told"] else None, row["seconds"]) for row in rows)
    inside = sum(
        row["kept"] is not None and row["kept"]["low"] <= row["seconds"] <= row["kept"]["high"]
        for row in rows
    )
    passed = [row["at"] / row["seconds"] for row in rows if row["at"] is not None]
    report.heading("Does it hold?")
    report.say(
        f"within a factor of {WITHIN}: {good} of {n} ({100 * good / n:.0f} %), wanted "
        f"{100 * WANTED:.0f} %",
        f"within the interval told: {inside} of {n}, 95 of 100 are meant",
        f"had passed by then: {100 * median(passed):.0f} % of the run in the median, "
        f"{100 * max(passed):.0f} % at most",
        f"what the eighth batch told, within a factor of {WITHIN}: {first} of {n}",
        f"{time.perf_counter() - started:.0f} s, load {load()} at the end",
    )
    if asked.out:
        # of what was told on the way, the first is scored
        kept = [{**row, "told": row["told"][:1]} for row in rows]
        report.write(asked.out, "forecasts", {"facts": known, "runs": kept})
    return 0 if good >= WANTED * n else 1


if __name__ == "__main__":
    sys.exit(main())
