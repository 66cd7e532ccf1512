"""What importance sampling is worth: ``python -m benchmarks.importance [--mitsuba PYTHON]``.

1. A patch of 1 % of the wall of an integrating sphere (ρ 0.9, an isotropic lamp off its centre):
   seconds until its power is known to 1 %, without and with importance sampling, in interleaved
   rounds; and of Mitsuba's path tracer where ``--mitsuba`` names an interpreter that has it, in
   the same rounds, see `benchmarks.mitsuba_sphere`. That one leaves out what comes straight from
   the lamp, so the comparison is over what was reflected, and all of it is given beside it.
2. A baffled tube whose walls reflect 7.5 %, lit at 60°: figure of merit 1/(σ² s) without and with.
3. A longer and darker one: seconds until PST is known to 10 %, followed to the end.
4. Ten scenes: the mean without and with importance sampling, each to 0.5 % or better; the ledger of
   every batch closes.

PST is the sensor's mean irradiance over that of the beam across it (1 W/m²). Compilation is not
counted. Exit status 1 where a gain is below `LEAST_GAIN`, the long tube takes more than five
minutes, a mean differs by more than `MOST_Z` of its σ (chance 1e-4 for all ten), a ledger does not
close, or Mitsuba is sooner.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final

import numpy as np

import photizon_cl as pz
from benchmarks.aimed_scenes import TEN, patch_of_sphere, plain, tube
from benchmarks.facts import facts, lines
from benchmarks.report import Report, table
from hostcode.device.device import choose

SENSOR: Final = "detectors.sensor.power"
LEAST_GAIN: Final = 100.0
MOST_Z: Final = 4.42
DEPTH: Final = 200
"""Interactions that both tracers follow in the sphere: 0.9^200 is 1e-9."""
ROULETTE: Final = (5, 20, 1000)
"""Depths from which Mitsuba plays roulette; its best one counts."""
RAYS: Final = 1 << 16
"""Rays of a batch; paths of a run of Mitsuba's."""
RUNS: Final = 16
"""Batches, or such runs, of a round."""
FRACTIONS: Final = (0.1, 0.2, 0.5)
PARTS: Final = ("sphere", "tube", "deep", "ten")


def traced(scene: pz.Scene, batches: int, seed: int = 1, rays: int = RAYS) -> pz.Result:
    """Trace batches, however long it takes; the second time nothing is compiled."""
    pz.trace(scene, batches=1, rays_per_batch=64, seed=seed)
    return pz.trace(scene, batches=batches, rays_per_batch=rays, seed=seed, max_seconds=1e6)


def relative(result: pz.Result) -> tuple[float, float]:
    """Return the sensor's power in watts and its relative σ."""
    power = result.quantity(SENSOR)
    assert power.sigma is not None
    return power.value, power.sigma / power.value if power.value else math.inf


def merit(result: pz.Result) -> float:
    """Return 1/(σ² s) of the sensor's power."""
    return float(1.0 / (relative(result)[1] ** 2 * result.summary()["seconds"]))


# -- the sphere ------------------------------------------------------------------------------------


class Mitsuba:
    """The other path tracer, in its own process."""

    def __init__(self, python: str, roulette: int) -> None:
        script = Path(__file__).with_name("mitsuba_sphere.py")
        words = [python, str(script), "0.9", str(DEPTH + 1), str(roulette)]
        self._process = subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.about = self._read()
        for seed in range(2):
            self.run(1 << 15, 1000 + seed)

    def _read(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit(
                "benchmarks.importance: Mitsuba's process ended; see its message above"
            )
        return dict(json.loads(line))

    def run(self, samples: int, seed: int) -> tuple[float, float]:
        """Return seconds and watts."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{samples} {seed}\n")
        self._process.stdin.flush()
        found = self._read()
        return found["seconds"], found["power"]

    def close(self) -> None:
        """End it."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@dataclasses.dataclass
class Samples:
    """What equal runs gave: the power that was reflected to the patch, all of it, and seconds."""

    reflected: list[float] = dataclasses.field(default_factory=list)
    whole: list[float] = dataclasses.field(default_factory=list)
    seconds: list[float] = dataclasses.field(default_factory=list)

    def to_one_percent(self, values: list[float]) -> float:
        """Return the seconds until a mean of values is known to 1 %, at the median pace."""
        each = statistics.median(self.seconds)
        return 1e4 * statistics.variance(values) / statistics.mean(values) ** 2 * each

    def row(self, name: str) -> tuple[str, ...]:
        """Return its line of the table."""
        cells = [name]
        for values in (self.reflected, self.whole):
            cells += (
                [f"{self.to_one_percent(values):.2e} s", f"{statistics.mean(values):.5f} W"]
                if values
                else ["–", "–"]
            )
        return tuple(cells)


def sphere(report: Report, python: str | None, rounds: int) -> tuple[dict[str, Any], bool]:
    """Measure the patch of the sphere; say whether we are no later than Mitsuba."""
    scene = patch_of_sphere(cap=DEPTH)
    aims = {f"fraction {f:g}": pz.Importance(toward=["sensor"], fraction=f) for f in FRACTIONS}
    ours = {name: dataclasses.replace(scene, importance=aim) for name, aim in aims.items()}
    ours = {"analog": plain(scene), **ours}
    theirs = {} if python is None else {f"Mitsuba, roulette from {n}": n for n in ROULETTE}
    others = {name: Mitsuba(str(python), n) for name, n in theirs.items()}
    for made in ours.values():
        traced(made, 1)
    got = {name: Samples() for name in (*ours, *others)}
    for k in range(rounds):
        for name, made in ours.items():
            result = pz.trace(
                made, batches=RUNS, rays_per_batch=RAYS, seed=100 + k, max_seconds=1e6
            )
            power = np.asarray(result.batch_values(SENSOR))
            direct = np.asarray(result.batch_values("detectors.sensor.ladder[0]"))
            got[name].whole += power.tolist()
            got[name].reflected += (power - direct).tolist()
            got[name].seconds.append(float(result.summary()["seconds"]) / RUNS)
        for name, other in others.items():
            runs = [other.run(RAYS, 1000 * k + n) for n in range(RUNS)]
            got[name].reflected += [run[1] for run in runs]
            got[name].seconds.append(sum(run[0] for run in runs) / RUNS)
    for other in others.values():
        other.close()
    header = ("", "to 1 %, reflected", "power", "to 1 %, all", "power")
    report.say(*table(header, [found.row(name) for name, found in got.items()]))
    best = min((got[name].to_one_percent(got[name].reflected) for name in others), default=math.inf)
    aimed = [got[name] for name in aims]
    reflected = min(found.to_one_percent(found.reflected) for found in aimed)
    whole = min(found.to_one_percent(found.whole) for found in aimed)
    if others:
        about = next(iter(others.values())).about
        report.say(
            f"Mitsuba {about['mitsuba']} ({about['variant']}) needs for what was reflected "
            f"{best / reflected:.1f} times as long as photizon_cl does, and "
            f"{best / whole:.2f} times as long as that does for all that arrives"
        )
    data = {name: dataclasses.asdict(found) for name, found in got.items()}
    return {"rounds": rounds, "samples": data}, reflected <= best


# -- tubes -----------------------------------------------------------------------------------------


def shallow_tube(report: Report, batches: int) -> tuple[dict[str, Any], bool]:
    """Measure figures of merit on the tube at 60°."""
    scene = tube(0.075, 1.0, 8, 0.06)
    area = scene.element["sensor"].area
    rows, data = [], {}
    for name, made, n in (
        ("analog", plain(scene), batches), ("importance", scene, max(batches // 8, 8)),
    ):  # fmt: skip
        result = traced(made, n)
        power, sigma = relative(result)
        data[name] = {
            "pst": power / area, "sigma": sigma, "seconds": result.summary()["seconds"],
            "merit": merit(result), "rays": result.summary()["rays"],
            "arrivals": result.quantity(SENSOR).count,
        }  # fmt: skip
        rows.append(
            (
                name, f"{power / area:.3e}", f"{100 * sigma:.2f} %",
                f"{data[name]['seconds']:.1f} s", f"{data[name]['merit']:.3g}",
                f"{data[name]['arrivals']}",
            )
        )  # fmt: skip
    report.say(*table(("", "PST", "σ", "seconds", "merit 1/(σ² s)", "arrivals"), rows))
    gain = data["importance"]["merit"] / data["analog"]["merit"]
    apart = data["importance"]["pst"] - data["analog"]["pst"]
    error = math.hypot(*(data[n]["pst"] * data[n]["sigma"] for n in data))
    report.say(f"gain {gain:.0f}; the two differ by {apart / error:+.2f} of their σ")
    return {**data, "gain": gain}, gain >= LEAST_GAIN


def deep_tube(report: Report) -> tuple[dict[str, Any], bool]:
    """Follow a tube of PST about 1e-12 until σ is 10 %."""
    scene = tube(0.02, 2.0, 20, 0.038, 0.01)
    area = scene.element["sensor"].area
    pz.trace(scene, batches=1, rays_per_batch=64)
    result = pz.trace(
        scene, target=0.1, target_on=[SENSOR], rays_per_batch=1 << 18, max_seconds=600.0
    )
    power, sigma = relative(result)
    seconds = result.summary()["seconds"]
    data = {
        "pst": power / area, "sigma": sigma, "seconds": seconds, "rays": result.summary()["rays"],
        "arrivals": result.quantity(SENSOR).count, "advisories": list(result.advisories),
    }  # fmt: skip
    report.say(
        f"PST {power / area:.3e} ± {100 * sigma:.1f} % in {seconds:.0f} s, "
        f"{data['rays']:.3g} rays, {data['arrivals']} arrivals",
        *(f"advisory: {text}" for text in result.advisories),
    )
    return data, sigma <= 0.1 and seconds <= 300.0 and power / area < 2e-12


# -- ten scenes ------------------------------------------------------------------------------------


def ten(report: Report, sigma: float) -> tuple[list[dict[str, Any]], bool]:
    """Compare means."""
    rows, data, good = [], [], True
    for make in TEN:
        scene = make()
        found = {}
        for name, made in (("analog", plain(scene)), ("importance", scene)):
            pz.trace(made, batches=1, rays_per_batch=64)
            found[name] = pz.trace(
                made, target=sigma, target_on=[SENSOR], rays_per_batch=RAYS, max_seconds=300.0,
                seed=1 if name == "analog" else 2,
            )  # fmt: skip
        a, b = (found[name].quantity(SENSOR) for name in ("analog", "importance"))
        assert a.sigma is not None
        assert b.sigma is not None
        z = (b.value - a.value) / math.hypot(a.sigma, b.sigma)
        balance = found["importance"].quantity("ledger.importance.balance")
        assert balance.sigma is not None
        row = {
            "scene": scene.name, "analog": a.value, "importance": b.value, "z": z,
            "sigma": [a.sigma / a.value, b.sigma / b.value],
            "gain": merit(found["importance"]) / merit(found["analog"]),
            "balance": balance.value, "balance_z": balance.value / balance.sigma,
            "closure": found["importance"].ledger.worst_closure,
        }  # fmt: skip
        data.append(row)
        seconds = [found[name].summary()["seconds"] for name in ("analog", "importance")]
        print(f"  {scene.name}: {seconds[0]:.0f} s and {seconds[1]:.0f} s", file=sys.stderr)
        # where rays split, a weight that is the difference of two rounds
        good &= abs(z) <= MOST_Z and abs(row["closure"]) <= 1e-15 and max(row["sigma"]) <= 0.005
        rows.append(
            (
                scene.name, f"{a.value:.4e}", f"{100 * row['sigma'][0]:.2f} %", f"{b.value:.4e}",
                f"{100 * row['sigma'][1]:.2f} %", f"{z:+.2f}", f"{row['gain']:.1f}",
                f"{row['balance_z']:+.2f}", f"{row['closure']:.0e}",
            )
        )  # fmt: skip
    header = ("scene", "analog, W", "σ", "aimed, W", "σ", "z", "gain", "balance, z", "closure, W")
    report.say(*table(header, rows))
    return data, good


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.importance", description=__doc__)
    parser.add_argument("--mitsuba", metavar="PYTHON", help="interpreter that has mitsuba")
    parser.add_argument("--only", choices=PARTS, action="append", default=[])
    parser.add_argument("--rounds", type=int, default=7, help="of the sphere; default 7")
    parser.add_argument("--batches", type=int, default=1600, help="of the tube without it")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    started = time.perf_counter()
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    data: dict[str, Any] = {"facts": known}
    verdicts: dict[str, bool] = {}
    for part, title, measure in (
        ("sphere", "Seconds to 1 % on a patch of an integrating sphere",
         lambda: sphere(report, asked.mitsuba, asked.rounds)),
        ("tube", "A baffled tube at 60°", lambda: shallow_tube(report, asked.batches)),
        ("deep", "A longer and darker one", lambda: deep_tube(report)),
        ("ten", "Ten scenes: the same means", lambda: ten(report, 0.005)),
    ):  # fmt: skip
        if not asked.only or part in asked.only:
            report.heading(title)
            data[part], verdicts[part] = measure()
            report.say("" if verdicts[part] else f"{part}: NOT MET")
    report.say(f"{time.perf_counter() - started:.0f} s")
    if asked.out:
        report.write(asked.out, "importance", {**data, "met": verdicts})
    return 0 if all(verdicts.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
