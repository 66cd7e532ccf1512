"""Whether the checks tell a σ that is not to be believed: ``python -m benchmarks.believing``.

Two scenes have a rare bright path, by which one arrival in 10^5 carries a third of the power. A
beam of 2 W, radius 1.5 m and half of the rays falls on a black disk of radius 1 m, of which 4/9
arrive; the other half is a lamp's so far away that 4/9 of 10^-5 of its rays come there, and so
strong that they bring 4/9 W. In the second scene the same light passes a sheet of glass before the
disk, so that rays split. The runs have so many rays that 4, 9 or 30 such arrivals are to be
expected: few enough that σ, which they make, is good to no better than 13 %. A run that saw none of
them cannot know; it counts as one that was not flagged.

Healthy ones are the presets, all but the one in which chance decides nothing, each in runs towards
targets and of fixed numbers of batches. A run is flagged where an advisory doubts a σ.

Prints the shares with their 95 % intervals (Clopper and Pearson), and how often the value lay
within ± 2 σ of the truth. Exit status 1 where fewer than 95 % of the rare ones or more than 2 % of
the healthy ones are flagged.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path
from typing import Any, Final

import photizon_cl as pz
from benchmarks.facts import facts, lines
from benchmarks.report import Report, table
from hostcode.device.device import choose

POWER: Final = "detectors.plate.power"
ONE_IN: Final = 1e5
"""Arrivals of which one is a bright one."""
BEAM: Final = 4.0 / 9.0
"""Part of the beam that arrives: radius 1 m of 1.5 m."""
LAMP: Final = BEAM / ONE_IN
"""Part of the lamp's rays that arrives."""
EXPECTED: Final = (4, 9, 30)
"""Bright arrivals that a run has on average."""
BATCHES: Final = (8, 20, 60)
HEALTHY: Final = (
    "baffled-telescope", "baffled-tube", "box-room", "cassegrain", "cosine-fourth",
    "cpc-concentrator", "integrating-sphere", "lambertian-sphere", "plano-convex-condenser",
    "square-lightpipe",
)  # fmt: skip
GOALS: Final[tuple[dict[str, Any], ...]] = (
    {"batches": 8, "rays_per_batch": 4096},
    {"batches": 30, "rays_per_batch": 512},
    {"target": 0.2, "rays_per_batch": 4096, "max_seconds": 1.0},
    {"target": 0.1, "rays_per_batch": 16384, "max_seconds": 1.0},
)
MOST_HEALTHY: Final = 0.02
LEAST_RARE: Final = 0.95


def rare(*, glass: bool) -> pz.Scene:
    """Return a scene of which one arrival in `ONE_IN` carries a third of the power."""
    # of an isotropic point on the axis of a disk of radius 1: ½ (1 − d/√(d² + 1))
    far = (1.0 - 2.0 * LAMP) / math.sqrt(1.0 - (1.0 - 2.0 * LAMP) ** 2)
    beam = pz.CollimatedDisk(
        name="beam", flux=2.0, position=(0, 0, 1), axis="-z", radius=1.5, share=0.5
    )
    lamp = pz.IsotropicPoint(
        name="lamp", flux=0.5 * 2.0 * BEAM / LAMP, position=(0, 0, far), share=0.5
    )
    plate = pz.Disk(
        name="plate", position=(0, 0, 0), axis="+z", radius=1.0, surface=pz.Absorber(),
        detector=pz.Detector(),
    )  # fmt: skip
    window = pz.Disk(
        name="window", position=(0, 0, 0.5), axis="+z", radius=3.0, surface=pz.Fresnel(1.5)
    )
    name = "rare, behind glass" if glass else "rare"
    return pz.Scene(name, (beam, lamp), (window, plate) if glass else (plate,))


def rays_for(expected: float) -> int:
    """Return the rays of which so many are expected to take the bright path."""
    return round(expected / (0.5 * LAMP))


def truth(*, glass: bool) -> float:
    """Return the power that arrives: two thirds the beam's, all of it (nearly) at right angles."""
    return 2.0 * BEAM * 1.5 * ((1.0 - 0.04) if glass else 1.0)


def doubted(result: pz.Result) -> bool:
    """Say whether an advisory of a run doubts a σ."""
    return any(text.startswith("the σ of") for text in result.advisories)


def interval(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of which k of n were seen, by Clopper and Pearson."""

    def at_most(p: float, most: int) -> float:
        return sum(
            math.exp(
                math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1)
                + i * math.log(p) + (n - i) * math.log1p(-p)
            )
            for i in range(most + 1)
        )  # fmt: skip

    def solved(most: int, wanted: float) -> float:
        low, high = 1e-12, 1.0 - 1e-12
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if at_most(middle, most) > wanted else (low, middle)
        return 0.5 * (low + high)

    return (0.0 if k == 0 else solved(k - 1, 0.975)), (1.0 if k == n else solved(k, 0.025))


def _share(k: int, n: int) -> str:
    low, high = interval(k, n)
    return f"{100 * k / n:.1f} % of {n} [{100 * low:.1f}–{100 * high:.1f}]"


def rare_runs(seeds: int, report: Report) -> list[dict[str, Any]]:
    """Trace the scenes with a rare bright path; print a row a setting."""
    runs, rows = [], []
    for glass in (False, True):
        scene, wanted = rare(glass=glass), truth(glass=glass)
        for expected in EXPECTED:
            for batches in BATCHES:
                rays = rays_for(expected) // batches
                these = []
                for _ in range(seeds):
                    # of the same seed other batches hold the very same rays
                    seed = len(runs) + len(these)
                    found = pz.trace(scene, seed=seed, batches=batches, rays_per_batch=rays)
                    power = found.quantity(POWER)
                    # the beam alone brings two thirds, to 10^-3
                    seen = power.value > wanted * (2.0 + 0.5 / expected) / 3.0
                    within = abs(power.value - wanted) <= 2.0 * (power.sigma or 0.0)
                    these.append(
                        {
                            "glass": glass, "expected": expected, "batches": batches,
                            "rays": rays * batches, "seed": seed, "flagged": doubted(found),
                            "seen": seen, "within": within,
                        }
                    )  # fmt: skip
                runs += these
                n = len(these)
                rows.append(
                    (
                        scene.name, str(expected), str(batches), f"{rays * batches:.2e}", str(n),
                        *(str(sum(run[key] for run in these)) for key in ("flagged", "seen")),
                        f"{100 * sum(run['within'] for run in these) / n:.0f} %",
                    )
                )  # fmt: skip
    header = ("scene", "expected", "batches", "rays", "runs", "flagged", "saw any", "within 2σ")
    report.say(*table(header, rows))
    return runs


def healthy_runs(seeds: int, report: Report) -> list[dict[str, Any]]:
    """Trace the presets; print a row each."""
    runs, rows = [], []
    for name in HEALTHY:
        these = []
        for goal in GOALS:
            for _ in range(seeds):
                seed = len(runs) + len(these)
                found = pz.trace(name, seed=seed, **goal)
                these.append({"scene": name, "seed": seed, **goal, "flagged": doubted(found)})
        runs += these
        rows.append((name, str(len(these)), str(sum(run["flagged"] for run in these))))
    report.say(*table(("preset", "runs", "flagged"), rows))
    return runs


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.believing", description=__doc__)
    parser.add_argument("--seeds", type=int, default=8, help="runs a setting; default 8")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    started = time.perf_counter()
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    report.heading("One arrival in 10^5 carries a third of the power")
    found = rare_runs(asked.seeds, report)
    report.heading("Healthy runs")
    well = healthy_runs(asked.seeds, report)
    report.heading("Shares, with their 95 % intervals")
    flagged = [run for run in found if run["flagged"]]
    seen = [run for run in found if run["seen"]]
    bad = [run for run in well if run["flagged"]]
    report.say(
        f"rare bright path, flagged                 {_share(len(flagged), len(found))}",
        "  of those that saw it                    "
        + _share(sum(run["flagged"] for run in seen), len(seen)),
        f"healthy, flagged                          {_share(len(bad), len(well))}",
        f"{time.perf_counter() - started:.0f} s",
    )
    if asked.out:
        report.write(asked.out, "believing", {"facts": known, "rare": found, "healthy": well})
    fits = len(flagged) >= LEAST_RARE * len(found) and len(bad) <= MOST_HEALTHY * len(well)
    return 0 if fits else 1


if __name__ == "__main__":
    sys.exit(main())
