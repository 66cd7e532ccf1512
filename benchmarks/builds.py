"""Seconds that the device's compiler takes: cold, and warm from the runtime's own caches.

Each measurement is a process of its own, with empty cache directories (cold) and then with what the
first one left there (warm). PoCL compiles a kernel when it is first enqueued, so that the program's
build alone says little: what counts is the time until all kernels are code, and until the first
tally.

    python -m benchmarks.builds PRESET [--device SELECTOR]     one measurement, as JSON
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from typing import TYPE_CHECKING, Any, Final

from benchmarks import facts
from benchmarks.report import Spread, table
from benchmarks.runner import Runner, compiled_preset
from hostcode.device.device import choose, open_device, preferred_lanes
from hostcode.program.plan import default_plan
from photizon_cl.scene.presets import preset_names

if TYPE_CHECKING:
    from benchmarks.report import Report
    from hostcode.device.device import DeviceRecord

_RAYS: Final = 64
"""Rays of the first batch: few, so that its tracing takes no time beside the compiler."""
_CACHES: Final = ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "CUDA_CACHE_PATH")
"""Where PoCL, pyopencl (with our self-test) and NVIDIA's driver keep what they compiled."""


def one(preset: str, selector: str | None) -> dict[str, Any]:
    """Build and run a preset's program once in this process."""
    started = time.perf_counter()
    device = open_device(choose(selector))
    opened = time.perf_counter()
    compiled = compiled_preset(preset, _RAYS)
    plan = default_plan(device.record, preferred_lanes(device.record))
    runner = Runner(device, compiled, plan, 1)
    runner.time()
    first = time.perf_counter()
    runner.time()
    second = time.perf_counter()
    program = runner.engine.program
    return {
        "self_test": opened - started,
        "program": program.build_seconds,
        "build": runner.engine.build_seconds,
        "first_result": first - opened,
        "second_result": second - first,
        "source_bytes": len(program.source.encode()),
        "source_lines": sum(
            1 for line in program.source.splitlines() if line and not line.startswith("#line")
        ),
        "kernels": int(program.built.num_kernels),
    }


def _in_process(preset: str, selector: str, caches: str) -> dict[str, Any]:
    environment = dict(os.environ)
    for name in _CACHES:
        place = os.path.join(caches, name.lower())
        os.makedirs(place, exist_ok=True)
        environment[name] = place
    environment["PYTHONPATH"] = os.pathsep.join(
        [str(facts.ROOT), *filter(None, [environment.get("PYTHONPATH")])]
    )
    command = [sys.executable, "-m", "benchmarks.builds", preset, "--device", selector]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=600, check=False
    )
    if done.returncode:
        raise RuntimeError(f"building {preset} in a process of its own failed:\n{done.stderr}")
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def measure(
    record: DeviceRecord,
    report: Report,
    repeats: int = 3,
    presets: tuple[str, ...] | None = None,
) -> dict[str, Any]:
    """Measure every preset, cold and warm, print the table and return everything as data."""
    selector = f"{record.platform_index}:{record.device_index}"
    names = preset_names() if presets is None else presets
    runs: dict[str, dict[str, list[dict[str, Any]]]] = {
        name: {"cold": [], "warm": []} for name in names
    }
    for _ in range(repeats):
        for name in names:
            with tempfile.TemporaryDirectory(prefix="photizon-builds-") as caches:
                runs[name]["cold"].append(_in_process(name, selector, caches))
                runs[name]["warm"].append(_in_process(name, selector, caches))
    report.heading("Kernel builds")
    report.say(
        f"seconds, median of {repeats} processes; cold: every cache empty, warm: the caches that",
        "the cold process left. program: the runtime's build call; build: that and the code that",
        "it generates at the first launch; first result: from the scene file to the tally of a",
        f"batch of {_RAYS} rays, build included.",
        "",
    )
    data: dict[str, Any] = {}
    rows = []
    for name, found in runs.items():
        spread = {
            (state, key): Spread.of(run[key] for run in found[state])
            for state in ("cold", "warm")
            for key in ("self_test", "program", "build", "first_result", "second_result")
        }
        size = found["cold"][0]
        data[name] = {
            **{key: size[key] for key in ("source_bytes", "source_lines", "kernels")},
            **{
                state: {key: value.data() for (s, key), value in spread.items() if s == state}
                for state in ("cold", "warm")
            },
        }
        rows.append(
            [
                name,
                *(
                    f"{spread[state, key].median:.2f}"
                    for state in ("cold", "warm")
                    for key in ("program", "build", "first_result")
                ),
                f"{spread['cold', 'self_test'].median:.2f}",
                str(size["kernels"]),
                str(size["source_lines"]),
                f"{size['source_bytes'] / 1024:.0f}",
            ]
        )
    header = [
        "preset",
        "cold: program",
        "build",
        "first result",
        "warm: program",
        "build",
        "first result",
        "self-test, cold",
        "kernels",
        "lines",
        "KiB",
    ]
    report.say(*table(header, rows))
    return data


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.builds")
    parser.add_argument("preset", choices=preset_names())
    parser.add_argument("--device")
    asked = parser.parse_args()
    print(json.dumps(one(asked.preset, asked.device)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
