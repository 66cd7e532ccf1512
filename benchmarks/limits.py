"""Whether runs end when they were told to: ``python -m benchmarks.limits``.

Scenes whose batches last for ever (closed boxes that reflect everything, glass that splits without
bound, light that is trapped) are run with a `max_seconds` of a few seconds, in batches of many
sizes. Prints how much longer each took, the largest overshoot, and what was said. Exit
status 1 where one took more than a fifth and two seconds longer, or ended otherwise than with a
result or one line.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import photizon_cl as pz
from benchmarks.report import Report

ROOM_FACTOR, ROOM_SECONDS = 1.2, 2.0
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")


def box(surface: dict[str, Any], *, inwards: bool) -> list[dict[str, Any]]:
    """Return the six walls of a box of 2 cm."""
    walls = []
    for n, axis in enumerate(AXES):
        position = [0.0, 0.0, 0.0]
        position[n // 2] = 0.01 if (axis[0] == "+") != inwards else -0.01
        shape = {"kind": "rectangle", "half_width": 0.01, "half_height": 0.01}
        walls.append({"name": f"wall {n}", **shape, "position": position, "axis": axis, **surface})
    return walls


def endless(kind: str, rays: int) -> pz.Scene:
    """Return a scene of which a batch of `rays` takes far longer than it may."""
    glass = {"surface": {"kind": "fresnel", "index": 1.5}}
    floor: float | str = 0.0
    if kind == "white box":
        elements = box({"surface": {"kind": "lambertian", "reflectance": 1.0}}, inwards=True)
    elif kind == "mirrors":
        elements = box({"surface": {"kind": "mirror", "reflectance": 1.0}}, inwards=True)
    elif kind == "glass in mirrors":
        elements = box({"surface": {"kind": "mirror", "reflectance": 1.0}}, inwards=True)
        ball = {"kind": "sphere", "position": [0.0, 0.0, 0.003], "axis": "+z", "radius": 0.004}
        elements.append({"name": "ball", **ball, **glass})
    else:
        elements, floor = box(glass, inwards=False), "auto"
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.001, -0.002, -0.004]}
    return pz.load(
        {
            "schema": "photizon/1",
            "name": kind,
            "run": {"rays_per_batch": rays, "generation_cap": 2**20 - 1, "roulette_floor": floor},
            "source": [{"name": "lamp", **lamp}],
            "element": elements,
        }
    )


def main(argv: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.limits", description=__doc__)
    parser.add_argument("--runs", type=int, default=40, help="default 40")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    args = parser.parse_args(argv)
    report = Report()
    draw = random.Random(1)
    rows: list[dict[str, Any]] = []
    late = 0
    report.say(f"{'scene':18s} {'rays':>9s} {'limit':>6s} {'took':>7s} {'over':>7s}  outcome")
    for n in range(args.runs):
        kind = ("white box", "mirrors", "glass in mirrors", "trapped in glass")[n % 4]
        rays, limit = 2 ** draw.randint(4, 20), draw.choice((1.0, 2.0, 4.0))
        scene = endless(kind, rays)
        with suppress(pz.RunError):  # builds the program, which is no part of a run's time
            pz.trace(scene, max_seconds=0.01)
        began = time.monotonic()
        try:
            outcome = f"{pz.trace(scene, max_seconds=limit).batches} batches"
        except pz.RunError as error:
            outcome = "; ".join(str(error).splitlines())
        took = time.monotonic() - began
        late += took > ROOM_FACTOR * limit + ROOM_SECONDS
        rows.append({"scene": kind, "rays": rays, "limit": limit, "seconds": took})
        over = took - limit
        report.say(f"{kind:18s} {rays:9d} {limit:5.1f}s {took:6.2f}s {over:6.2f}s  {outcome[:90]}")
    worst = max(rows, key=lambda row: row["seconds"] - ROOM_FACTOR * row["limit"])
    beyond = worst["seconds"] - worst["limit"]
    report.say(
        "",
        f"largest overshoot {beyond:.2f} s of a limit of {worst['limit']:.0f} s "
        f"({worst['scene']}); {late} of {len(rows)} runs beyond a fifth and two seconds",
    )
    if args.out:
        report.write(args.out, "limits", {"runs": rows})
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
