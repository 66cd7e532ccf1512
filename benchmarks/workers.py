"""What a second worker is worth: ``python -m benchmarks.workers``.

Traces a scene with one worker and with two, each of one thread, as processes of this machine and on
Dask clusters on loopback, and in this process with one thread a core for
comparison: turn and turn about, each round in another order. Workers have started and built the
program before; a time is that of a whole `pz.trace`. Prints batches a second, and within each round
the ratio of two to one.
All must have the same digest. Without `distributed` the Dask rows are left out, which is said.

Time is the thing measured: run it where nothing else runs. Exit status 1 where two workers are
worth less than 1.7, or a digest differs.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import time
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import photizon_cl as pz
from benchmarks.facts import facts, lines, load
from benchmarks.report import Report, Spread, table
from hostcode.device.device import choose
from photizon_cl.run.dask import DaskWorkers
from photizon_cl.run.processes import Processes

if TYPE_CHECKING:
    from concurrent.futures import Executor

WANTED: Final = 1.7
SCENE: Final = "integrating-sphere"
HERE: Final = "this process"
RAYS: Final = 1 << 16
HOUSEKEEPING: Final = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1 s",
    "distributed.admin.system-monitor.interval": "10 s",
}
"""What Dask's processes do beside their tasks takes an eighth of a processor where a scheduler and
two workers share two, unless told to do it less often; docs/many-machines.md says how.
"""


def _dask(stack: ExitStack, workers: int) -> Executor:
    from dask.config import set as configured
    from distributed import Client, LocalCluster

    stack.enter_context(configured(HOUSEKEEPING))
    cluster = LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address=":0", host="127.0.0.1"
    )
    stack.enter_context(cluster)
    client = stack.enter_context(Client(cluster.scheduler_address, set_as_default=False))
    client.wait_for_workers(workers, timeout=60)
    return DaskWorkers(client)


def ways(stack: ExitStack) -> dict[str, Executor | None]:
    """Return who computes, by name; closed with the stack."""
    found: dict[str, Executor | None] = {HERE: None}
    for n in (1, 2):
        pool = Processes(n, threads=1)
        stack.callback(pool.close)
        found[f"processes, {n}"] = pool
    if find_spec("distributed") is not None:
        found |= {f"Dask, {n}": _dask(stack, n) for n in (1, 2)}
    return found


def measure(scene: str, batches: int, rounds: int) -> tuple[dict[str, list[float]], set[str]]:
    """Return the seconds of each way, round by round, and the digests that there were."""
    order = random.Random(1)
    with ExitStack() as stack:
        todo = ways(stack)
        seconds: dict[str, list[float]] = {name: [] for name in todo}
        digests = set()
        for executor in todo.values():  # starts workers, and builds programs
            pz.trace(scene, batches=16, rays_per_batch=RAYS, executor=executor)
        for _ in range(rounds):
            for name in order.sample(list(todo), len(todo)):
                started = time.perf_counter()
                result = pz.trace(scene, batches=batches, rays_per_batch=RAYS, executor=todo[name])
                seconds[name].append(time.perf_counter() - started)
                digests.add(result.tally_digest)
    return seconds, digests


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.workers", description=__doc__)
    parser.add_argument("--scene", default=SCENE, help=f"preset or file; default {SCENE}")
    parser.add_argument("--batches", type=int, default=800, help="of 2^16 rays; default 800")
    parser.add_argument("--rounds", type=int, default=5, help="default 5")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    report.heading(f"{asked.scene}, {asked.batches} batches of {RAYS} rays")
    seconds, digests = measure(asked.scene, asked.batches, asked.rounds)
    rows = []
    for name, took in seconds.items():
        rate = Spread.of(asked.batches / t for t in took)
        rows.append((name, Spread.of(took).text(2), rate.text(1)))
    report.say(*table(("who computes", "seconds", "batches a second"), rows))
    report.heading("Does it hold?")
    kinds = [name for name in ("processes", "Dask") if f"{name}, 2" in seconds]
    held = {}
    for kind in kinds:
        pairs = zip(seconds[f"{kind}, 1"], seconds[f"{kind}, 2"], strict=True)
        ratio = held[kind] = Spread.of(one / two for one, two in pairs)
        word = "holds" if ratio.median >= WANTED else "FAILS"
        report.say(f"{word:8s} {kind}: two workers over one: {ratio.text(2)}, wanted ≥ {WANTED}")
    if "Dask" not in kinds:
        report.say("Dask is not installed: its rows are left out")
    same = len(digests) == 1
    report.say(f"{'holds' if same else 'FAILS':8s} one digest in all of {len(seconds)} ways")
    report.say(f"load {load()} at the end, {os.cpu_count()} threads")
    if asked.out:
        data: dict[str, Any] = {
            "facts": known, "scene": asked.scene, "batches": asked.batches, "seconds": seconds,
            "ratios": {kind: ratio.data() for kind, ratio in held.items()},
            "digests": sorted(digests),
        }  # fmt: skip
        report.write(asked.out, "workers", data)
    return 0 if same and all(ratio.median >= WANTED for ratio in held.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
