"""Time and memory of a run with a 2048 × 2048 map: ``python -m benchmarks.large_map``.

Traces `cosine-fourth` with such a map, writes checkpoint, result and figures, and opens the result,
each in a process of its own so that the peak memory is that of the step. Prints one table.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.report import Report

SIDE = 2048


def step(name: str, folder: Path, side: int, batches: int) -> dict[str, float]:
    """Do one step; return its seconds and the process's peak memory in MiB before and after."""
    import photizon_cl as pz
    from photizon_cl.result.file import write_state
    from photizon_cl.run.checkpoint import latest
    from photizon_cl.run.directory import CHECKPOINT
    from photizon_cl.run.result import Result

    tables = pz.load("cosine-fourth").to_dict()
    tables["element"][0]["detector"] = {"map": [side, side]}
    if name != "trace":
        result = Result.of(latest(folder))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    started = time.perf_counter()
    size = 0
    if name == "trace":
        result = pz.trace(tables, batches=batches, rays_per_batch=1 << 20, max_seconds=3600.0)
    elif name == "checkpoint":
        write_state(result, folder / CHECKPOINT)
        size = (folder / CHECKPOINT).stat().st_size
    elif name == "save":
        result.save(folder, figures=False)
        size = (folder / "result.nc").stat().st_size
    elif name == "save with figures":
        result.save(folder)
        size = sum(f.stat().st_size for f in (folder / "figures").iterdir())
    elif name == "open":
        opened = pz.open_result(folder)
        assert opened.detectors["target"].map is not None
    elif name == "one more batch":
        result.refine(batches=result.batches + 1)
    seconds = time.perf_counter() - started
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if name == "trace":
        write_state(result, folder / CHECKPOINT)
    return {"seconds": seconds, "before": before, "peak": peak, "size": size / 2**20}


STEPS = ("trace", "checkpoint", "save", "save with figures", "open", "one more batch")


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.large_map")
    parser.add_argument("--side", type=int, default=SIDE, help="bins a side")
    parser.add_argument("--batches", type=int, default=16, help="of 2^20 rays")
    parser.add_argument("--out", type=Path, help="folder for large-map.txt and .json")
    parser.add_argument("--step", nargs=2, metavar=("STEP", "DIR"), help=argparse.SUPPRESS)
    asked = parser.parse_args(arguments)
    if asked.step:
        name, folder = asked.step
        print(json.dumps(step(name, Path(folder), asked.side, asked.batches)))
        return 0
    report = Report()
    report.say(
        f"a map of {asked.side} x {asked.side} bins, {asked.batches} batches of 2^20 rays", "",
        "step                 seconds   peak MiB   of that before   file MiB",
    )  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in STEPS:
            done = subprocess.run(
                [
                    sys.executable, "-m", "benchmarks.large_map", "--step", name, folder,
                    "--side", str(asked.side), "--batches", str(asked.batches),
                ],
                check=True, capture_output=True, text=True,
            )  # fmt: skip
            row = {"step": name, **json.loads(done.stdout.splitlines()[-1])}
            rows.append(row)
            size = f"{row['size']:8.1f}" if row["size"] else f"{'-':>8}"
            report.say(
                f"{name:20s} {row['seconds']:7.2f}   {row['peak']:8.0f}   {row['before']:14.0f}"
                f"   {size}"
            )
    if asked.out:
        report.write(asked.out, "large-map", {"rows": rows})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
