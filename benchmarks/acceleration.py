"""What the tree of boxes costs and gains: ``python -m benchmarks.acceleration``.

Scenes of 10^2 to 10^5 elements of all kinds, in three families: `filled`, where a ray goes a cell
or two from hit to hit however many elements there are; `tiled`, a room whose walls are cut up; and
`sparse`, where most elements are passed by and a ray that crosses the scene passes n^(1/3) of them.
Prints the nodes and elements that a search visits, which depend on no machine; the time of a
segment (a whole interaction: search, surface, tally) through the tree and by the plain scan; the
seconds to build the scene's objects, to compile it and to build the tree in that; and the memory of
the tables. Then finds the number of elements from which the tree is faster. Draws the figure where
--figure names a file.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from benchmarks.random_scenes import filled_scene, random_scene, tiled_scene
from benchmarks.report import Report
from benchmarks.visits import visits
from hostcode.device.device import choose, open_device, preferred_lanes
from hostcode.program.plan import default_plan
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.tree_nodes import pack_nodes, unpack_nodes
from photizon_cl.geometry.tree import build_tree, world_boxes
from photizon_cl.scene.settings import RunSettings

if TYPE_CHECKING:
    from hostcode.device.device import OpenDevice
    from hostcode.run.tables import DeviceTables

FAMILIES = {"filled": filled_scene, "tiled": tiled_scene, "sparse": random_scene}
SIZES = (64, 216, 1000, 2744, 10_648, 32_768, 110_592)
FEW = (8, 16, 24, 32, 48, 64, 96)
PLAIN_UP_TO = 1000
LOOK_UPS = 400


CHOICES: Final = ({"force": frozenset({"acceleration"})}, {"without": frozenset({"acceleration"})})
"""With a tree of boxes, and without."""


def seconds_a_segment(engine: Engine, round_: int) -> float:
    """Return device seconds for each search of a wave: every ray once and once an interaction."""
    statistic, batches = engine.statistics, engine.batches_at_once
    seconds, interactions = statistic.seconds, statistic.interactions
    list(engine.run(round_ * batches, batches))
    rays = batches * int(engine.tables.launch["rays_per_batch"])
    return (statistic.seconds - seconds) / (rays + statistic.interactions - interactions)


def engine_of(device: OpenDevice, tables: DeviceTables, lanes: int | None = None) -> Engine:
    """Return an engine with the default plan of the program."""
    width = lanes or preferred_lanes(device.record, tables.spec.effects)
    return Engine(device, tables, default_plan(device.record, width))


def alternate(engines: list[Engine], rounds: int) -> list[list[float]]:
    """Return each engine's ns a segment in each round, the engines run in turn."""
    times: list[list[float]] = [[] for _ in engines]
    for round_ in range(rounds + 1):
        for engine, kept in zip(engines, times, strict=True):
            kept.append(1e9 * seconds_a_segment(engine, round_))
    return [kept[1:] for kept in times]  # the first round loads code and caches


def prepare(
    device: OpenDevice, family: str, n: int, run: RunSettings, lanes: int | None
) -> tuple[dict[str, Any], list[Engine]]:
    """Return what is known of one scene without timing it, and its engines: tree, perhaps plain."""
    started = time.perf_counter()
    scene = FAMILIES[family](n, n)
    made = time.perf_counter()
    compiled = compile_scene(scene, run, force=frozenset({"acceleration"}))
    done = time.perf_counter()
    boxes = world_boxes(scene.element, (0.0, 0.0, 0.0))
    before = time.perf_counter()
    tree = build_tree(boxes)
    built = time.perf_counter() - before
    seen = visits(compiled, unpack_nodes(pack_nodes(*tree)), device, LOOK_UPS)
    engines = [engine_of(device, compiled.tables, lanes)]
    if len(scene.element) <= 1.2 * PLAIN_UP_TO:
        plain = compile_scene(scene, run, without=frozenset({"acceleration"}))
        engines.append(engine_of(device, plain.tables))
    size = compiled.tables.geometry.nbytes + compiled.tables.codes.nbytes
    row = {
        "family": family, "n": len(scene.element), "nodes": seen[0], "tests": seen[1],
        "objects_s": made - started, "compile_s": done - made, "build_s": built, "bytes": size,
        "tally_bytes": 32 * compiled.tables.n_cells,
    }  # fmt: skip
    return row, engines


def measure(
    device: OpenDevice, family: str, sizes: list[int], run: RunSettings, rounds: int, lanes: Any
) -> list[dict[str, Any]]:
    """Return everything about scenes of all sizes, timed in turn: a slow spell slows them all."""
    prepared = [prepare(device, family, n, run, lanes) for n in sizes]
    times = iter(alternate([engine for _, engines in prepared for engine in engines], rounds))
    rows = []
    for row, engines in prepared:
        kept = next(times)
        plain = statistics.median(next(times)) if len(engines) > 1 else None
        rows.append({
            **row, "tree_ns": statistics.median(kept), "tree_spread": 0.5 * (max(kept) - min(kept)),
            "tree_rounds": kept, "plain_ns": plain,
        })  # fmt: skip
    return rows


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.acceleration")
    parser.add_argument("--device")
    parser.add_argument("--rays", type=int, default=262_144, help="rays of a batch")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--lanes", type=int, help="lane width, by default the program's")
    parser.add_argument("--largest", type=int, default=SIZES[-1])
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--out", type=Path, help="folder for acceleration.txt and .json")
    asked = parser.parse_args(arguments)
    record = choose(asked.device)
    device = open_device(record)
    run = RunSettings(rays_per_batch=asked.rays, generation_cap=64)
    report = Report()
    report.say(
        f"tree of boxes on {record.label}, {asked.rounds} rounds of {asked.rays} rays", "",
        "family  elements   nodes  tests   tree ns/segment   plain ns/segment   plain/tree"
        "   objects s   compile s   tree s   tables MB",
    )  # fmt: skip
    rows = []
    for family in FAMILIES:
        sizes = [size for size in SIZES if size <= asked.largest]
        for row in measure(device, family, sizes, run, asked.rounds, asked.lanes):
            rows.append(row)
            plain = row["plain_ns"]
            shown = (
                f"{plain:16.1f}   {plain / row['tree_ns']:10.2f}"
                if plain
                else f"{'-':>16}   {'-':>10}"
            )
            report.say(
                f"{family:6s}  {row['n']:8d}   {row['nodes']:5.2f}  {row['tests']:5.2f}   "
                f"{row['tree_ns']:7.1f} ± {row['tree_spread']:5.1f}   {shown}   "
                f"{row['objects_s']:9.2f}   {row['compile_s']:9.2f}   {row['build_s']:6.2f}   "
                f"{row['bytes'] / 2**20:9.1f}"
            )  # fmt: skip
        say_growth([row for row in rows if row["family"] == family], report)
    even = break_even(device, run, asked.rounds, report)
    if asked.out:
        report.write(
            asked.out, "acceleration", {"rows": rows, "break_even": even, "device": record.label}
        )
    if asked.figure:
        draw(rows, asked.figure)
    return 0


def say_growth(rows: list[dict[str, Any]], report: Report) -> None:
    """Print how visits and time grow beside log n."""
    if len(rows) < 3:
        return
    x = np.log10([row["n"] for row in rows])
    first, last = rows[0], rows[-1]
    visited = np.polyfit(x, [row["nodes"] for row in rows], 1)
    left = np.array([row["nodes"] for row in rows]) - np.polyval(visited, x)
    # both in one round, as the machine was then
    grew = np.divide(last["tree_rounds"], first["tree_rounds"])
    low, middle, high = np.quantile(grew, (0.25, 0.5, 0.75))
    power = np.polyfit(x, np.log10([row["tree_ns"] for row in rows]), 1)[0]
    report.say(
        f"  {first['n']} to {last['n']}: log n {x[-1] / x[0]:.2f} times, nodes "
        f"{last['nodes'] / first['nodes']:.2f} times ({visited[0]:+.2f} a decade, residual "
        f"{np.abs(left).max():.2f}), time {middle:.2f} times (quartiles {low:.2f}, {high:.2f}), "
        f"power of n {power:.3f}",
        "",
    )


def break_even(
    device: OpenDevice, run: RunSettings, rounds: int, report: Report
) -> dict[str, list[float]]:
    """Print and return plain over tree for few elements."""
    found: dict[str, list[float]] = {}
    report.say("few elements: plain/tree at " + ", ".join(map(str, FEW)))
    for family in ("tiled", "sparse"):
        ratios = []
        for n in FEW:
            scene = FAMILIES[family](n, n)
            tables = [compile_scene(scene, run, **choice).tables for choice in CHOICES]
            tree, plain = alternate([engine_of(device, t) for t in tables], rounds)
            ratios.append(statistics.median(np.divide(plain, tree)))
        found[family] = ratios
        report.say(f"  {family:6s}  " + "  ".join(f"{r:.2f}" for r in ratios))
    return found


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw visits and the time of a segment against the number of elements."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for family, colour in zip(FAMILIES, ("#0072b2", "#009e73", "#cc79a7"), strict=True):
        of = [row for row in rows if row["family"] == family]
        n = [row["n"] for row in of]
        left.semilogx(n, [row["nodes"] for row in of], "o-", color=colour, label=family)
        right.loglog(n, [row["tree_ns"] for row in of], "o-", color=colour, label=f"{family}, tree")
        plain = [(row["n"], row["plain_ns"]) for row in of if row["plain_ns"]]
        right.loglog(*zip(*plain, strict=True), "s:", color=colour, label=f"{family}, plain scan")
    anchor = next(row for row in rows if row["family"] == "filled")
    x = np.geomspace(anchor["n"], rows[-1]["n"], 50)
    right.loglog(
        x, anchor["tree_ns"] * np.log(x) / np.log(anchor["n"]), "k--", lw=1, label="∝ log n"
    )
    left.set_ylabel("nodes visited by a search")
    right.set_ylabel("time of an interaction in ns")
    for axes in (left, right):
        axes.set_xlabel("elements")
        axes.grid(which="both", alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    raise SystemExit(main())
