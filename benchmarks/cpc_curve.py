"""Transmission of a CPC around its acceptance angle: the engine, and a tracer of its own kind.

``python -m benchmarks.cpc_curve [--batches N] [--out DIR]`` prints, for parallel light at ten
angles on the concentrator of the preset `cpc-concentrator`,

* the engine's transmission with its standard error,
* that of `benchmarks.cpc_reference`, which shares no formula with the engine,
* their difference in standard errors of both,
* for rays of the engine's own, how many of them end otherwise, or after another number of
  reflections, when the reference follows them from the same start,

and draws the curve into ``cpc-acceptance.png``. Exit status 1 where the two disagree.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import photizon_cl as pz
from benchmarks.cpc_reference import follow, sizes, transmission
from photizon_cl.scene.frames import sincos_deg

if TYPE_CHECKING:
    from collections.abc import Sequence

ANGLES = (15.0, 17.0, 18.0, 19.0, 19.5, 20.0, 20.5, 21.0, 22.0, 23.0)
EARLIER = (1.0, 1.0, 0.968, 0.866, 0.756, 0.478, 0.238, 0.134, 0.028, 0.0)
"""Three-digit values from elsewhere, given without an error."""
RAYS = 1 << 18
PAIRS = 20000
_LIMIT = 4.0


def scene_at(angle_deg: float) -> pz.Scene:
    """Return the preset's scene with its beam at another angle; 1 W enters."""
    scene = pz.load("cpc-concentrator")
    (beam,) = scene.source
    wall = scene.element[0]
    assert isinstance(beam, pz.CollimatedDisk)
    assert isinstance(wall, pz.Cpc)
    sine, cosine = sincos_deg(angle_deg)
    before = 1.3 * wall.entrance_radius * sine / cosine + 0.01  # its lower edge clears the rim
    at = (before * sine, 0.0, wall.length + before * cosine)
    beam = dataclasses.replace(beam, flux=1.0 / cosine, position=at, tilt_deg=(angle_deg, 0.0))
    return dataclasses.replace(scene, source=(beam,))


def measured(angle_deg: float, batches: int, seed: int = 1) -> tuple[float, float]:
    """Return the engine's transmission and its standard error."""
    result = pz.trace(scene_at(angle_deg), seed=seed, batches=batches, rays_per_batch=RAYS)
    power = result.detectors["exit"].power
    assert result.ledger.closure == 0.0
    assert result.ledger.depth_capped.value < 1e-6  # rays that creep along the wall
    return power.value, float(power.sigma or 0.0)


def pairs_that_differ(angle_deg: float, rays: int = PAIRS, seed: int = 2) -> tuple[int, int, int]:
    """Follow the engine's rays again with the reference.

    Returns
    -------
    entered, other_end, other_number : int
        Rays that enter; those that end elsewhere; those that end alike, after another number of
        reflections.
    """
    found = pz.paths(scene_at(angle_deg), rays, seed, max_segments=1001)
    entrance, length = sizes(0.025, 20.0)
    last = np.append(np.flatnonzero(found.begins)[1:], len(found)) - 1
    first = np.flatnonzero(found.begins)
    assert not len(found.cut)
    start, along = found.start[first], found.end[first] - found.start[first]
    along /= np.linalg.norm(along, axis=1)[:, None]
    at = start + ((length - start[:, 2]) / along[:, 2])[:, None] * along
    enters = np.hypot(at[:, 0], at[:, 1]) < entrance
    again = follow(at[enters], along[enters])
    exits = found.element[last][enters] == 1
    reflections = found.generation[last][enters]
    other = exits != again.transmitted
    number = ~other & (reflections != again.reflections)
    return int(enters.sum()), int(other.sum()), int(number.sum())


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cpc_curve", description=__doc__)
    parser.add_argument("--batches", type=int, default=64, help=f"of {RAYS} rays an angle")
    parser.add_argument("--repeats", type=int, default=8, help="of 250000 rays, by the reference")
    parser.add_argument("--out", type=Path, default=Path("docs/images"), metavar="DIR")
    arguments = parser.parse_args(argv)
    print("angle   engine    ± σ̂      reference  ± σ̂      differ   earlier  rays, other end/number")
    rows, worst = [], 0.0
    for angle, earlier in zip(ANGLES, EARLIER, strict=True):
        value, sigma = measured(angle, arguments.batches)
        other, spread, unfinished = transmission(angle, repeats=arguments.repeats)
        both = math.hypot(sigma, spread)
        z = (value - other) / both if both else 0.0 if value == other else math.inf
        entered, ends, numbers = pairs_that_differ(angle)
        worst = max(worst, abs(z), math.inf if ends > 1e-3 * entered else 0.0)
        rows.append((angle, value, sigma, other, spread, earlier))
        print(
            f"{angle:5.1f}°  {value:.5f}  {sigma:.5f}  {other:.5f}  {spread:.5f}  {z:+5.1f} σ  "
            f"{earlier:.3f}    {entered}, {ends}/{numbers}"
            + (f"  ({unfinished} unfinished)" if unfinished else ""),
            flush=True,
        )
    rays = equivalent_rays(rows)
    print(f"the earlier values scatter about these like runs of {rays:.0f} rays an angle")
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "cpc-acceptance.png"
    draw(rows, path)
    print(f"drawn into {path}")
    return 0 if worst <= _LIMIT else 1


def equivalent_rays(rows: list[tuple[float, ...]]) -> float:
    """Return the rays an angle whose noise would explain the difference of the earlier values."""
    terms = [(t - v) ** 2 / (v * (1 - v)) for _, v, _, _, _, t in rows if 0.001 < v < 0.999]
    return len(terms) / sum(terms)


def draw(rows: list[tuple[float, ...]], path: Path) -> None:
    """Draw the curve."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    angle, value, sigma, other, _, target = (np.array(column) for column in zip(*rows, strict=True))
    figure = Figure(figsize=(7.2, 5.2), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1.2])
    above.axvline(20.0, color="#999999", linewidth=0.8, linestyle=(0, (4, 3)))
    above.text(20.04, 1.0, "acceptance angle", fontsize=8, color="#5f5f5f", va="top")
    above.plot(angle, value, color="#0072b2", linewidth=1.2, zorder=2)
    above.plot(angle, value, "o", color="#0072b2", markersize=5, label="engine", zorder=3)
    above.plot(
        angle, other, "s", markersize=10, markerfacecolor="none", markeredgecolor="#e69f00",
        markeredgewidth=1.2, label="reference tracer (focus and directrix)", zorder=2,
    )  # fmt: skip
    above.plot(
        angle, target, "x", color="#000000", markersize=6, label="earlier three-digit values"
    )
    above.set_ylabel("transmission", fontsize=9)
    above.legend(frameon=False, fontsize=8.5, loc="lower left")
    above.set_title(
        "CPC, a′ = 25 mm, θa = 20°: parallel light, three dimensions",
        loc="left", fontsize=11, weight="bold",
    )  # fmt: skip
    below.axhline(0.0, color="#999999", linewidth=0.8)
    below.errorbar(
        angle, 1e3 * (value - other), yerr=1e3 * sigma, fmt="o", color="#0072b2", markersize=4,
        capsize=3,
    )  # fmt: skip
    below.plot(angle, 1e3 * (target - other), "x", color="#000000", markersize=6)
    below.set_ylabel("less the reference,\nin 1/1000", fontsize=9)
    below.set_xlabel("angle against the axis in degrees", fontsize=9)
    for axes in (above, below):
        axes.tick_params(labelsize=8)
        axes.grid(color="#e4e4e4", linewidth=0.5)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    figure.savefig(path, format="png", dpi=160, metadata={"Software": "photizon_cl"})


if __name__ == "__main__":
    sys.exit(main())
