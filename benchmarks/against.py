"""Throughput beside another checkout: ``python -m benchmarks.against PATH [--starts N]``.

Both checkouts trace the same scenes, turn and turn about, in processes that live through all rounds
of a start. Prints the ratio of their throughputs scene by scene: the median over the rounds of all
starts, since how fast a process runs depends on where its memory happens to lie, with the
quartiles, and the medians of the single starts.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parents[1]
PRESETS: Final = (
    "integrating-sphere", "box-room", "ghost-ladder", "plano-convex-condenser", "cpc-concentrator",
)  # fmt: skip
FILLED: Final = "10^4 elements"
SECONDS: Final = 0.5
"""Of a round and scene."""
OLD: Final = {
    "hostcode.device.device": "hostcode.device",
    "hostcode.program.plan": "hostcode.plan",
    "hostcode.run.wavefront": "hostcode.wavefront",
    "photizon_cl.compile.compiled": "photizon_cl.compile",
    "photizon_cl.scene.files": "photizon_cl.scene_io",
    "photizon_cl.scene.settings": "photizon_cl.settings",
}
"""Where a checkout has modules that was made before they were put in folders."""


def found(module: str, name: str) -> Any:
    """Return what a module of the checkout that is measured has."""
    try:
        return getattr(import_module(module), name)
    except (ModuleNotFoundError, AttributeError):
        return getattr(import_module(OLD[module]), name)


def engine_of(name: str) -> Any:
    """Return the engine of a scene on the best device, as a trace makes it."""
    load = found("photizon_cl.scene.files", "load")
    devices = "hostcode.device.device"
    device = found(devices, "open_device")(found(devices, "choose")())
    if name == FILLED:
        scene = import_module("benchmarks.random_scenes").filled_scene(10_000, seed=1)
        settings = found("photizon_cl.scene.settings", "RunSettings")
        run = settings(rays_per_batch=65536, generation_cap=40)
    else:
        scene = load(name)
        run = scene.run
    compiled = found("photizon_cl.compile.compiled", "compile_scene")(scene, run)
    lanes = found(devices, "preferred_lanes")(device.record, compiled.tables.spec.effects)
    plan = found("hostcode.program.plan", "default_plan")(device.record, lanes)
    return found("hostcode.run.wavefront", "Engine")(device, compiled.tables, plan)


def work(names: list[str]) -> None:
    """Answer each name on standard input with the interactions per second of a round."""
    engines = {name: engine_of(name) for name in names}
    first = dict.fromkeys(names, 0)
    print("ready", flush=True)
    for line in sys.stdin:
        engine = engines[name := line.strip()]
        made, started = engine.statistics.interactions, time.perf_counter()
        while time.perf_counter() - started < SECONDS:
            batches = max(1, engine.batches_at_once)
            for _ in engine.run(first[name], batches):
                pass
            first[name] += batches
        seconds = time.perf_counter() - started
        print((engine.statistics.interactions - made) / seconds, flush=True)


class Worker:
    """A process that measures a checkout."""

    def __init__(self, checkout: Path, names: list[str]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).resolve()), "--work", json.dumps(names)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=checkout,
            env={**os.environ, "PYTHONPATH": str(checkout)},
        )
        while (line := self._line()) != "ready":
            if not line:
                raise SystemExit(f"{checkout}: its worker ended; is it a checkout of this project?")

    def _line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def rate(self, name: str) -> float:
        """Return interactions per second of one round."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        return float(self._line())

    def end(self) -> None:
        """Let the process end."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


def measure(
    other: Path, names: list[str], starts: int, rounds: int
) -> dict[str, list[list[float]]]:
    """Return the ratios of this checkout's throughput to the other's: scene, start, round."""
    ratios: dict[str, list[list[float]]] = {name: [] for name in names}
    for start in range(starts):
        workers = [Worker(path, names) for path in (other, ROOT)]
        for rows in ratios.values():
            rows.append([])
        for n in range(rounds):
            for name in names:
                order = (0, 1) if (start + n) % 2 else (1, 0)
                rate = {k: workers[k].rate(name) for k in order}
                ratios[name][-1].append(rate[1] / rate[0])
        for worker in workers:
            worker.end()
    return ratios


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", nargs="?", type=Path, help="the other checkout")
    parser.add_argument("--starts", type=int, default=10, help="of both processes (default 10)")
    parser.add_argument("--rounds", type=int, default=5, help="of a start (default 5)")
    parser.add_argument("--out", type=Path, help="directory for the text and the ratios")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        work(json.loads(arguments.work))
        return
    if arguments.other is None:
        parser.error("the path of the other checkout is missing")
    from benchmarks.report import Report

    report = Report()
    names = [*PRESETS, FILLED]
    other = arguments.other.resolve()
    report.say("interactions per second here over those there, interleaved, in one run")
    ratios = measure(other, names, arguments.starts, arguments.rounds)
    for name, rows in ratios.items():
        every = [ratio for row in rows for ratio in row]
        low, middle, high = statistics.quantiles(every, n=4)
        medians = sorted(statistics.median(row) for row in rows)
        report.say(
            f"{name:24} {middle:.3f} (quartiles {low:.3f} to {high:.3f}) in {len(every)} rounds; "
            f"medians of {len(rows)} starts {medians[0]:.3f} to {medians[-1]:.3f}"
        )
    if arguments.out:
        report.write(arguments.out, "against", ratios)


if __name__ == "__main__":
    main()
