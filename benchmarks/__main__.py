"""``python -m benchmarks``: throughput and build times on one device, as tables and as JSON.

    python -m benchmarks                       everything, about six minutes
    python -m benchmarks --quick               fewer cells and rounds, about one minute
    python -m benchmarks --only throughput     or builds, or a scene's name; may be repeated
    python -m benchmarks --device pocl --out benchmarks/results

The GPU's checks are a command of their own: ``python benchmarks/gpu.py``.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks import builds, cells, facts, throughput
from benchmarks.report import Report
from hostcode.device.device import choose, preferred_lanes
from hostcode.errors import DeviceError

PARTS = ("throughput", "builds")


def main(arguments: list[str] | None = None) -> int:
    summary = "throughput and build times on one device; see benchmarks/README.md"
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=summary)
    parser.add_argument("--quick", action="store_true", help="fewer cells and rounds")
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="NAME",
        choices=(*PARTS, *cells.SCENES),
        help=f"a part ({', '.join(PARTS)}) or a scene ({', '.join(cells.SCENES)})",
    )
    parser.add_argument("--device", help="as `photizon devices` lists it, or a part of its name")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write a .txt and a .json there")
    asked = parser.parse_args(arguments)
    parts = [part for part in PARTS if part in asked.only] or list(PARTS)
    scenes = tuple(name for name in cells.SCENES if name in asked.only)
    if scenes and not any(part in asked.only for part in PARTS):
        parts = ["throughput"]
    try:
        record = choose(asked.device)
    except DeviceError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return 2
    started = time.perf_counter()
    report = Report()
    known = facts.facts(record)
    report.say("photizon_cl benchmarks", "", *facts.lines(known))
    data: dict[str, Any] = {"facts": known, "quick": asked.quick}
    if "builds" in parts:
        data["builds"] = builds.measure(record, report, repeats=1 if asked.quick else 3)
    if "throughput" in parts:
        settings = throughput.Settings(scenes=scenes or cells.SCENES)
        if asked.quick:
            settings = throughput.Settings(
                scenes=settings.scenes,
                rounds=3,
                seconds=0.05,
                lanes=tuple(sorted({1, preferred_lanes(record)})),
            )
        data["throughput"] = throughput.measure(record, settings, report)
    data["seconds"] = round(time.perf_counter() - started, 1)
    report.say("", f"{data['seconds']:.0f} s, load {facts.load()} at the end")
    if asked.out is not None:
        stem = "quick-" if asked.quick else "bench-"
        for path in report.write(asked.out, stem + facts.slug(record.name), data):
            print(f"wrote {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
