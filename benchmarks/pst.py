"""The point source transmittance of a baffled telescope, 0.5° to 80°: ``python -m benchmarks.pst``.

    photizon sweep benchmarks/data/pst/pst.toml --out pst     the sweep itself
    python -m benchmarks.pst --sweep pst                      tables of it, digests compared
    python -m benchmarks.pst --sweep pst --write              keep them, and make page and figure

The sweep traces the preset ``baffled-telescope`` forward at 15 angles, each until σ is 2.5 % of the
detector's power, with importance sampling towards what sends light on to the detector: the places
where the mirrors image it. Its strongest paths come from the path table. Every number is fixed by
scene, seed and target: another run has the same digests, or says which differ. Beside it stand the
reverse and forward traces without importance sampling of ``python -m benchmarks.telescope``.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any, Final

import photizon_cl as pz
from benchmarks.report import Report, table

HERE: Final = Path(__file__).absolute().parent
RESULTS: Final = HERE / "results"
PAGE: Final = HERE.parent / "docs" / "telescope.md"
FIGURE: Final = HERE.parent / "docs" / "images" / "telescope-pst.png"
SHOWN: Final = (1.0, 10.0, 60.0)
"""Angles in degrees whose strongest paths are told."""
TOP: Final = 10
WORST: Final = 0.03
LOWEST: Final = 1e-9
KNOWN: Final = 0.25
"""Relative σ of a trace without importance sampling up to which it is compared."""
FARTHEST: Final = 3.5
"""|z| of 7 comparisons: one in 300 sets of healthy ones exceeds it."""


def found_in(folder: Path) -> dict[str, Any]:
    """Return what a finished sweep says, as plain values."""
    sweep = pz.open_sweep(folder)
    points, paths = [], {}
    for point in sweep.points:
        if not point.done:
            raise SystemExit(f"point {point.number} is not done: `photizon resume {folder}`")
        angle, one = point.values["angle"], point.measures["PST"]
        result = sweep.open(point.number)
        checks = result.quantity("detectors.detector.power").checks
        points.append(
            {
                "theta_deg": angle,
                "pst": one.value,
                "sigma": one.sigma,
                "batches": point.batches,
                "rays": point.rays,
                "seconds": point.seconds,
                "believable": checks is not None and checks.believable,
                "digest": point.digest,
            }
        )
        if angle in SHOWN:
            paths[f"{angle:g}"] = strongest(result)
    return {"points": points, "paths": paths}


def strongest(result: pz.Result) -> list[dict[str, Any]]:
    """Return the strongest paths to the detector as parts of all that arrives."""
    detector = result.detectors["detector"]
    rows = detector.paths
    assert rows is not None
    whole = detector.power.value
    return [
        {
            "sequence": row.sequence,
            "part": row.power / whole,
            "sigma": (row.sigma or 0.0) / whole,
            "count": row.count,
            "example_ray": row.example_ray,
        }
        for row in rows[:TOP]
    ]


def curve(found: dict[str, Any]) -> list[str]:
    """Return the curve as lines of a table."""
    head = ["θ in degrees", "PST", "± %", "rays", "seconds"]
    body = [
        [
            f"{p['theta_deg']:g}",
            f"{p['pst']:.3e}",
            f"{100.0 * p['sigma'] / p['pst']:.1f}" + ("" if p["believable"] else " *"),
            f"{p['rays']}",
            f"{p['seconds']:.1f}",
        ]
        for p in found["points"]
    ]
    return list(table(head, body))


def ways(rows: list[dict[str, Any]]) -> list[str]:
    """Return paths as lines of a table."""
    body = [
        [f"{100.0 * r['part']:.2f} ± {100.0 * r['sigma']:.2f} %", str(r["count"]), r["sequence"]]
        for r in rows
    ]
    return list(table(["part", "arrivals", "path"], body, left=0))


def beside(found: dict[str, Any]) -> dict[str, float]:
    """Return the largest |z| beside the kept traces without importance sampling, by their way."""
    kept = RESULTS / "telescope.json"
    if not kept.is_file():
        return {}
    other = json.loads(kept.read_text(encoding="utf-8"))
    own = {p["theta_deg"]: p for p in found["points"]}
    worst: dict[str, float] = {}
    for way in ("reverse", "forward"):
        for row in other[way]:
            p = own[row["theta_deg"]]
            if row["sigma"] > KNOWN * row["pst"]:
                continue  # few arrivals of very different weights: its σ says little
            z = (p["pst"] - row["pst"]) / math.hypot(p["sigma"], row["sigma"])
            worst[way] = max(worst.get(way, 0.0), abs(z))
    return worst


def same_bits(found: dict[str, Any], report: Report) -> bool:
    """Compare the digests with the kept ones, where there are any."""
    kept = RESULTS / "pst.json"
    if not kept.is_file():
        return True
    stored = {p["theta_deg"]: p for p in json.loads(kept.read_text(encoding="utf-8"))["points"]}
    other = [
        p["theta_deg"] for p in found["points"] if stored[p["theta_deg"]]["digest"] != p["digest"]
    ]
    report.say(
        f"digests: {len(found['points']) - len(other)} of {len(found['points'])} are stored ones"
        + (f"; others at {other} degrees" if other else "")
    )
    return not other


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw the curve."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.2), dpi=160, layout="constrained")
    axes = figure.add_subplot()
    angles = [p["theta_deg"] for p in found["points"]]
    values = [p["pst"] for p in found["points"]]
    errors = [p["sigma"] for p in found["points"]]
    axes.errorbar(
        angles, values, yerr=errors, fmt="o-", color="#0072b2", markersize=4.0, linewidth=1.0,
        capsize=2.5, ecolor="#222222",
    )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = [0.5, 1, 2, 5, 10, 20, 40, 80]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel("angle of the star from the axis in degrees")
    axes.set_ylabel("point source transmittance")
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(path)


_TEXT: Final = """# Point source transmittance of a telescope

<!-- made by python -m benchmarks.pst: change it there -->

A star outside the field of a telescope lights its tube, and a little of that reaches the detector.
The point source transmittance PST(θ) is the detector's mean irradiance over that of the star's beam
in its own cross-section. Here it is for the preset `baffled-telescope`, whose every length, surface
and source is in its file (`photizon presets baffled-telescope`), from 0.5° to 80°, each angle until
σ was 2.5 % of the detector's power:

![PST against angle](images/telescope-pst.png)

```text
{curve}
```

\\* the statistical checks of the run find that few of very many arrivals make this σ: more that is
rare and bright may be missing, and the value may be low.

In a checkout

```text
$ photizon sweep benchmarks/data/pst/pst.toml --out pst
$ python -m benchmarks.pst --sweep pst
```

makes all of it again, to the bit: the second command compares the digest of every angle with the
stored one. It also compares with those reverse and forward traces without importance sampling
(`benchmarks/results/telescope.txt`) that are known to 25 %: {agree}.

## Which way the light comes

The sweep's detector has a [path table](stray-light.md). Parts of all that arrives:

{ways}
## Where to aim

What arrives mostly comes by a mirror, so that aiming at the detector alone helps little. A first
table of paths told what to aim at: light that the back plate scatters and the secondary reflects.
So the scene of this sweep (`benchmarks/data/pst/telescope.toml`) has `clear` disks, which take no
part in anything: two where the mirrors image the detector, behind the secondary at the primary's
focus, and far down the axis, as wide as the field; and one in the mouth of the main baffle.
`[importance] toward` names them beside the detector, the cap and the back plate. At 10°, after
eight seconds each, σ was 32 % with the mirrors themselves as targets, and 1.4 % with the images.
The mean is the same whatever is aimed at; only σ differs
([importance sampling](importance-sampling.md)).
"""


def page(found: dict[str, Any]) -> str:
    """Return the page of the documentation."""
    told = "".join(
        f"{angle}°:\n\n```text\n{chr(10).join(ways(rows))}\n```\n\n"
        for angle, rows in found["paths"].items()
    )
    worst = ", ".join(f"{way} {z:.2f}" for way, z in beside(found).items())
    return _TEXT.format(
        curve="\n".join(curve(found)), ways=told, agree=f"the largest |z| is {worst}"
    )


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.pst", description=__doc__)
    parser.add_argument("--sweep", type=Path, required=True, help="the directory of the sweep")
    parser.add_argument("--write", action="store_true", help="keep numbers, page and figure")
    asked = parser.parse_args(arguments)
    found = found_in(asked.sweep)
    report = Report()
    report.heading("PST of baffled-telescope")
    report.say(*curve(found))
    for angle, rows in found["paths"].items():
        report.heading(f"strongest paths at {angle}°")
        report.say(*ways(rows))
    worst = max(p["sigma"] / p["pst"] for p in found["points"])
    lowest = min(p["pst"] for p in found["points"])
    report.say("", f"largest σ {100.0 * worst:.1f} %, lowest PST {lowest:.2e}")
    holds = worst <= WORST and lowest <= LOWEST
    apart = beside(found)
    said = ", ".join(f"{way} {z:.2f}" for way, z in apart.items())
    report.say(
        f"largest |z| beside traces without importance sampling that are known to "
        f"{100.0 * KNOWN:.0f} %: {said or 'none are kept'}"
    )
    holds &= max(apart.values(), default=0.0) <= FARTHEST
    if asked.write:
        report.write(RESULTS, "pst", found)
        PAGE.write_text(page(found), encoding="utf-8")
        draw(found, FIGURE)
    else:
        holds &= same_bits(found, report)
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
