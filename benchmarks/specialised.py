"""What specialising is worth: ``python -m benchmarks.specialised [--rounds N] [--out DIR]``.

The program that each preset compiles beside two that have more in them than it needs: every effect
that its scene can have; and, besides, every kind of source, element and surface, with no use made
of there being one of something or few elements, which is what a tracer that does not specialise
would run. Both include the tree of boxes, which a scene of few elements is better off without; the
same two are measured without it as well. Programs run in turn, as ``photizon effects --measure``
does it, and their numbers are compared bit by bit. Exit status 1 where a bit differs, or the box
room's program is not at least twice as fast as the larger of the two.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any, Final

from benchmarks import facts
from benchmarks.report import Report, table
from hostcode.device.device import choose
from hostcode.errors import DeviceError
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names
from photizon_cl.studies.effects import EVERY_EFFECT, EVERYTHING, larger_programs
from photizon_cl.studies.pricing import ROUNDS, Pair, Pricing

WANTED: Final = {"box-room": 2.0}
"""Times the larger program that a preset's own shall reach."""
SEARCHES: Final = frozenset({"acceleration"})
"""Effects that replace a part of the program, and are no addition to it."""


def measure(
    names: tuple[str, ...], report: Report, device: str | None, rounds: int, seconds: float
) -> dict[str, Any]:
    """Measure presets, print a line for each program and return everything as data."""
    data: dict[str, Any] = {}
    header = ["preset", "beside", "time", "M/s", "beside", "compiled", "beside", "KiB", "beside"]
    rows = []
    for name in names:
        scene = load(name)
        programs = [
            *larger_programs(scene, (EVERY_EFFECT, EVERYTHING)),
            *larger_programs(scene, (EVERY_EFFECT, EVERYTHING), SEARCHES),
        ]
        # a scene that has a tree has the same programs in both
        programs = list({program.name: program for program in programs}.values())
        pricing = Pricing(
            compile_scene(scene, scene.run), len(programs), device,
            max_seconds=seconds, rounds=rounds,
        )  # fmt: skip
        data[name] = {}
        for program in programs:
            found = pricing.measure(program.compiled)
            if not isinstance(found, Pair):
                # said, and the others go on: half an hour of them is not lost
                rows.append([name, f"{program.name}: {found}", *[""] * 6])
                continue
            price = found.price()
            data[name][program.name] = {"adds": program.adds, **price.summary()}
            ratio, own, other = price.slowdown, price.less, price.more
            rows.append([
                name, program.name + ("" if price.same_bits else ", OTHER BITS"),
                f"{ratio.median:.2f} [{ratio.low:.2f}–{ratio.high:.2f}]",
                f"{own.interactions_per_s / 1e6:.1f}", f"{other.interactions_per_s / 1e6:.1f}",
                f"{own.build_seconds:.2f}", f"{other.build_seconds:.2f}",
                f"{own.source_bytes / 1024:.0f}", f"{other.source_bytes / 1024:.0f}",
            ])  # fmt: skip
            if not report.quiet:
                print("  ".join(rows[-1]), file=sys.stderr, flush=True)
    report.say(*table(header, rows, left=2))
    return data


def verdicts(data: dict[str, Any], report: Report) -> bool:
    """Say whether it holds; return that."""
    report.heading("Does it hold?")
    same = all(price["same_bits"] for prices in data.values() for price in prices.values())
    report.say(f"{'holds   ' if same else 'FAILS   '} the programs of a preset give the same bits")
    holds = same
    for name, wanted in WANTED.items():
        for program, price in data.get(name, {}).items():
            ratio = price["slowdown"]
            # the acceptance is about all that there is; the others are stated beside it
            counts = program == EVERYTHING
            reached = ratio["median"] >= wanted
            holds &= reached or not counts
            verdict = ("holds   " if reached else "FAILS   ") if counts else "stated  "
            report.say(
                f"{verdict} {name}: its own program over one with {program}: "
                f"{ratio['median']:.2f} [{ratio['low']:.2f}–{ratio['high']:.2f}]"
                + (f", wanted ≥ {wanted:g}" if counts else "")
            )
    return holds


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.specialised")
    parser.add_argument("--device")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="default %(default)s")
    parser.add_argument(
        "--only", action="append", choices=preset_names(), metavar="PRESET", help="default all"
    )
    parser.add_argument(
        "--max-seconds", type=float, default=600.0, help="of a preset, default %(default)g"
    )
    parser.add_argument("--out", type=Path, help="folder for specialised.txt and .json")
    asked = parser.parse_args(arguments)
    try:
        record = choose(asked.device)
    except DeviceError as error:
        print(f"benchmarks.specialised: {error}", file=sys.stderr)
        return 2
    started = time.perf_counter()
    report, known = Report(), facts.facts(record)
    report.say(
        "what specialising is worth", "", *facts.lines(known), "",
        f"time: of the larger program for what the preset's own takes 1, median of {asked.rounds}",
        "rounds in turn [quartiles]; M/s: millions of interactions a second; compiled: seconds,",
        "nothing kept; KiB of text.",
        "",
    )  # fmt: skip
    names = tuple(asked.only or preset_names())
    data = measure(names, report, asked.device, asked.rounds, asked.max_seconds)
    holds = verdicts(data, report)
    seconds = time.perf_counter() - started
    report.say("", f"{seconds:.0f} s, load {facts.load()} at the end")
    if asked.out:
        report.write(asked.out, "specialised", {"facts": known, "presets": data, "holds": holds})
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
