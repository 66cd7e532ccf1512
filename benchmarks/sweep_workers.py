"""One sweep, whoever computes it: ``python -m benchmarks.sweep_workers``.

Runs ``photizon sweep benchmarks/data/sweep/angles.toml`` (60 angles of a hood) in one process, with
two worker processes, on a Dask cluster of two workers on loopback and on three MPI ranks, each as a
user starts it, and compares the digest of every point. What is not installed is left out, and said.

Prints, for each way, the seconds, the programs that were built for the 60 points, and a SHA-256 of
their digests in order. Exit status 1 where two ways differ in any point.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

import photizon_cl as pz
from benchmarks.facts import ROOT, facts, lines, load
from benchmarks.mpi import Mpi, NoMpiError
from benchmarks.report import Report, table
from hostcode.device.device import choose

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

FILE: Final = ROOT / "benchmarks" / "data" / "sweep" / "angles.toml"
ALONE: Final = "one process"


def ways(
    stack: ExitStack, folder: Path, left_out: list[str]
) -> Iterator[tuple[str, Sequence[str], Mapping[str, str]]]:
    """Give each way's name, the command before its output's name, and the environment.

    Parameters
    ----------
    stack : ExitStack
        Ends what was started for a way.
    folder : Path
        Empty, for what a way needs.
    left_out : list of str
        Is told why a way is left out.
    """
    sweep = ["-m", "photizon_cl", "sweep", str(FILE)]
    here = [sys.executable, *sweep]
    usual = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), *sys.path]))}
    yield ALONE, here, usual
    yield "two processes", [*here, "--workers", "2"], usual
    if find_spec("distributed") is None:
        left_out.append("Dask is not installed")
    else:
        from distributed import LocalCluster

        cluster = LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", host="127.0.0.1"
        )
        stack.enter_context(cluster)
        yield "Dask, two workers", [*here, "--scheduler", cluster.scheduler_address], usual
    try:
        mpi = Mpi(folder)
    except NoMpiError as error:
        left_out.append(str(error))
        return
    yield "MPI, three ranks", mpi.command(3, *sweep), mpi.environment


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.sweep_workers", description=__doc__)
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    left_out: list[str] = []
    found: dict[str, list[str]] = {}
    rows = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        names = folder / "names"
        names.mkdir()
        for number, (name, command, environment) in enumerate(ways(stack, names, left_out)):
            out = folder / str(number)
            started = time.perf_counter()
            done = subprocess.run(
                [*command, "--out", str(out), "--json"], env=environment, stdin=subprocess.DEVNULL,
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            took = time.perf_counter() - started
            if done.returncode:
                report.say(f"{name}: exit status {done.returncode}: {done.stderr.strip()}")
                return 1
            found[name] = [point.digest for point in pz.open_sweep(out).points]
            built = json.loads(done.stdout)["programs"]
            whole = hashlib.sha256("\n".join(found[name]).encode()).hexdigest()
            rows.append((name, f"{took:.1f}", str(built), whole[:16]))
    report.heading(f"{FILE.name}: {len(found[ALONE])} points, 8 batches of 16384 rays each")
    report.say(*table(("who computes", "seconds", "programs", "all digests"), rows))
    report.heading("Does it hold?")
    for name, digests in found.items():
        if name != ALONE:
            differ = sum(a != b for a, b in zip(found[ALONE], digests, strict=True))
            word = "FAILS" if differ else "holds"
            report.say(f"{word:8s} {name}: {differ} of {len(digests)} points differ from {ALONE}")
    report.say(*(f"left out: {why}" for why in left_out))
    report.say(f"load {load()} at the end, {os.cpu_count()} threads")
    same = all(digests == found[ALONE] for digests in found.values())
    if asked.out:
        data = {"facts": known, "left_out": left_out, "digests": found}
        report.write(asked.out, "sweep_workers", data)
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
