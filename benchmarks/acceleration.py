"""What the tree of boxes costs and gains: ``python -m benchmarks.acceleration``.

Random scenes of all seven element kinds, up to 10^5 of them, traced through the tree and (up to
10^4) by the plain scan, in turn. Prints the time of a segment (a search for the nearest hit), the
ratio, the seconds to compile the scene and the memory of its tables; fits the growth of a segment's
time; finds the number of elements from which the tree is faster; draws the figure where --figure
names a file.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

import numpy as np

from benchmarks.random_scenes import random_scene
from benchmarks.report import Report
from hostcode.device import choose, open_device, preferred_lanes
from hostcode.plan import default_plan
from hostcode.wavefront import Engine
from photizon_cl.compile import compile_scene
from photizon_cl.settings import RunSettings

SIZES = (16, 32, 48, 64, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)
PLAIN_UP_TO = 10_000


def seconds_a_segment(engine: Engine, rays: int, batch: int) -> float:
    """Return device seconds for each search of a batch: every ray once and once an interaction."""
    statistic = engine.statistics
    seconds, interactions = statistic.seconds, statistic.interactions
    list(engine.run(batch, 1))
    segments = rays + statistic.interactions - interactions
    return (statistic.seconds - seconds) / segments


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.acceleration")
    parser.add_argument("--device")
    parser.add_argument("--rays", type=int, default=16384)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--lanes", type=int, help="lane width, by default the device's")
    parser.add_argument("--largest", type=int, default=SIZES[-1])
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--out", type=Path, help="folder for acceleration.txt and .json")
    asked = parser.parse_args(arguments)
    record = choose(asked.device)
    device = open_device(record)
    plan = default_plan(record, asked.lanes or preferred_lanes(record))
    run = RunSettings(rays_per_batch=asked.rays, generation_cap=64)
    report = Report()
    report.say(
        f"tree of boxes on {record.label}, {asked.rounds} rounds of {asked.rays} rays", "",
        "elements   tree ns/segment   plain ns/segment   plain/tree   compile s   tables MB",
    )  # fmt: skip
    rows = []
    for n in (size for size in SIZES if size <= asked.largest):
        scene = random_scene(n, seed=n)
        started = time.perf_counter()
        compiled = compile_scene(scene, run, accelerate=True)
        seconds = time.perf_counter() - started
        tables = compiled.tables
        size = tables.geometry.nbytes + tables.codes.nbytes
        engines = [Engine(device, tables, plan)]
        if n <= PLAIN_UP_TO:
            plain = compile_scene(scene, run, accelerate=False)
            engines.append(Engine(device, plain.tables, plan))
        times: list[list[float]] = [[] for _ in engines]
        for round_ in range(asked.rounds + 1):
            for engine, kept in zip(engines, times, strict=True):
                kept.append(seconds_a_segment(engine, asked.rays, round_))
        tree, *rest = (1e9 * statistics.median(kept[1:]) for kept in times)
        ratio = rest[0] / tree if rest else float("nan")
        rows.append({"n": n, "tree_ns": tree, "plain_ns": rest[0] if rest else None,
                     "compile_s": seconds, "bytes": size})  # fmt: skip
        shown = f"{rest[0]:18.1f}   {ratio:10.2f}" if rest else f"{'-':>18}   {'-':>10}"
        report.say(f"{n:8d}   {tree:15.1f} {shown}   {seconds:9.2f}   {size / 2**20:9.1f}")
    large = [row for row in rows if row["n"] >= 100]
    if len(large) > 2:
        x = np.log([row["n"] for row in large])
        y = np.array([row["tree_ns"] for row in large])
        power = np.polyfit(x, np.log(y), 1)[0]
        growth = y[-1] / y[0]
        logs = x[-1] / x[0]
        report.say(
            "",
            f"from {large[0]['n']} to {large[-1]['n']} elements a segment takes {growth:.2f} times "
            f"as long; log n grows {logs:.2f} times; fitted power of n {power:.3f}",
        )
    faster = [row["n"] for row in rows if row["plain_ns"] and row["plain_ns"] > row["tree_ns"]]
    report.say(f"the tree is faster from {min(faster) if faster else 'none of these'} elements on")
    if asked.out:
        report.write(asked.out, "acceleration", {"rows": rows, "device": record.label})
    if asked.figure:
        draw(rows, asked.figure)
    return 0


def draw(rows: list[dict[str, float]], path: Path) -> None:
    """Draw the time of a segment against the number of elements."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    n = [row["n"] for row in rows]
    plain = [(row["n"], row["plain_ns"]) for row in rows if row["plain_ns"]]
    axes.loglog(n, [row["tree_ns"] for row in rows], "o-", color="#0072b2", label="tree of boxes")
    axes.loglog(*zip(*plain, strict=True), "s--", color="#d55e00", label="plain scan")
    axes.set_xlabel("elements")
    axes.set_ylabel("time of a segment in ns")
    axes.grid(which="both", alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    raise SystemExit(main())
