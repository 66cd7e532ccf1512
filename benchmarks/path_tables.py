"""What a path table costs: ``python -m benchmarks.path_tables [--rounds N] [--out DIR]``.

Presets with a detector, and a window and a lens before a sensor, traced in turn without path tables
and with them, through ``photizon_cl.trace``, so that sums and words on the host count as well. The
digests of the detectors' own cells are compared, and the rows with the detectors' power.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any, Final

from benchmarks import facts
from benchmarks.report import Report, Spread, table
from hostcode.device.device import choose
from hostcode.errors import DeviceError
from photizon_cl.run.simulation import trace
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names

ROWS: Final = 100


def ghosts() -> dict[str, Any]:
    """Return a window and a plano-convex lens before a sensor."""

    def sheet(name: str, z: float, axis: str) -> dict[str, Any]:
        return {
            "name": name, "kind": "disk", "position": [0, 0, z], "axis": axis, "radius": 0.02,
            "surface": {"kind": "fresnel", "index": 1.5},
        }  # fmt: skip

    return {
        "schema": "photizon/1", "name": "window and lens", "run": {"rays_per_batch": 4096},
        "source": [{
            "name": "sun", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -0.05],
            "axis": "+z", "radius": 0.004,
        }],
        "element": [
            sheet("window front", 0.0, "-z"), sheet("window back", 0.003, "+z"),
            {
                "name": "lens", "kind": "plano-convex", "position": [0, 0, 0.02], "axis": "-z",
                "curvature_radius": 0.05, "aperture_radius": 0.01,
                "surface": {"kind": "fresnel", "index": 1.5168},
            },
            {
                "name": "sensor", "kind": "rectangle", "position": [0, 0, 0.1], "axis": "-z",
                "half_width": 0.02, "half_height": 0.02, "surface": {"kind": "absorber"},
                "detector": {},
            },
        ],
    }  # fmt: skip


def with_tables(scene: dict[str, Any], rows: int) -> dict[str, Any]:
    """Return a scene whose detectors all have path tables."""
    made: dict[str, Any] = json.loads(json.dumps(scene))
    for element in made.get("element", []):
        if "detector" in element:
            element["detector"]["paths"] = rows
    return made


def measure(scene: dict[str, Any], rounds: int, seconds: float) -> dict[str, Any]:
    """Return seconds a batch without and with tables, round by round, and how many paths."""
    plain, tabled = load(scene), load(with_tables(scene, ROWS))
    first = trace(plain, batches=4)
    batches = max(4, min(round(4 * seconds / max(first.info.seconds, 1e-3)), 4096))
    ratios, paths = [], 0
    trace(tabled, batches=4)
    for _ in range(rounds):
        without = trace(plain, batches=batches)
        with_them = trace(tabled, batches=batches)
        ratios.append(with_them.info.seconds / without.info.seconds)
        sums = with_them.tally.keyed
        assert sums is not None
        paths = len(sums)
        n = without.tally.n_cells
        assert with_them.tally.n_cells == n
        for cell in range(n):
            assert with_them.tally.exact(cell) == without.tally.exact(cell), cell
    spread = Spread.of(ratios)
    return {
        "ratio": spread.median, "low": spread.low, "high": spread.high, "batches": batches,
        "paths": paths, "interactions_per_ray": first.info.interactions / first.rays,
    }  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.path_tables")
    parser.add_argument("--rounds", type=int, default=7, help="default %(default)s")
    parser.add_argument("--seconds", type=float, default=1.0, help="of a run, default %(default)g")
    parser.add_argument("--out", type=Path, help="folder for path_tables.txt and .json")
    asked = parser.parse_args(arguments)
    try:
        record = choose(None)
    except DeviceError as error:
        print(f"benchmarks.path_tables: {error}", file=sys.stderr)
        return 2
    started = time.perf_counter()
    report, known = Report(), facts.facts(record)
    report.say(
        "what a path table costs", "", *facts.lines(known), "",
        f"time of a run with tables of {ROWS} rows for one without, median of {asked.rounds}",
        "rounds in turn [quartiles]; paths: different ones found. All other cells: the same bits.",
        "",
    )  # fmt: skip
    scenes = {name: load(name).to_dict() for name in preset_names()}
    scenes["window and lens"] = ghosts()
    data, rows = {}, []
    for name, scene in scenes.items():
        if any("detector" in element for element in scene.get("element", [])):
            found = data[name] = measure(scene, asked.rounds, asked.seconds)
            ratio = f"{found['ratio']:.3f} [{found['low']:.3f}–{found['high']:.3f}]"
            rows.append([name, ratio, f"{found['paths']}", f"{found['interactions_per_ray']:.1f}"])
    report.say(*table(["scene", "time", "paths", "interactions a ray"], rows))
    report.say("", f"{time.perf_counter() - started:.0f} s, load {facts.load()} at the end")
    if asked.out:
        report.write(asked.out, "path_tables", {"facts": known, "scenes": data})
    return 0


if __name__ == "__main__":
    sys.exit(main())
