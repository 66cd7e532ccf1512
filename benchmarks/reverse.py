"""Reverse against forward: ``python -m benchmarks.reverse``.

The point source transmittance PST(θ) of a system, the mean irradiance on its detector over that of
a star's beam across itself, traced in both directions. Reverse: the detector shines as a Lambertian
disk, and its far field gives PST(θ) = π I(θ)/Φ for all bins at once (docs/reverse-traces.md has
why). Forward: a beam that covers the entrance, for each bin by itself; the mean over the bin is a
Gauss-Legendre sum of five angles in cos θ, as five beams in one trace. The two share nothing but
the scene.

The scenes are a round tube with three annular vanes, all painted with a Lambertian reflectance of
0.1, and the same behind a window of glass, at whose faces rays split.

Prints both with their σ and z, their difference over its σ. Exit status 1 where a |z| exceeds 3.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

import photizon_cl as pz
from benchmarks.facts import facts, lines
from benchmarks.report import Report, table
from hostcode.device.device import choose

if TYPE_CHECKING:
    from collections.abc import Sequence

BINS: Final = ((4.0, 6.0), (11.0, 13.0), (19.0, 21.0), (29.0, 31.0), (44.0, 46.0), (59.0, 61.0))
"""Degrees."""
NODES: Final = 5
RADIUS: Final = 0.02
LENGTH: Final = 0.1
DETECTOR: Final = 0.01
PAINT: Final = pz.Lambertian(0.1)
WORST: Final = 3.0


@dataclass(frozen=True)
class Pst:
    """A transmittance with its standard error and the number of arrivals behind it."""

    value: float
    sigma: float
    count: int


def tube(*, window: bool = False) -> tuple[pz.Element, ...]:
    """Return the elements of a system: the detector at the origin looks along +z."""
    found: list[pz.Element] = [
        pz.Disk(
            name="detector", position=(0, 0, 0), axis="+z", radius=DETECTOR,
            surface=pz.Absorber(), detector=pz.Detector(),
        ),
        pz.Disk(
            name="back", position=(0, 0, 0), axis="+z", radius=RADIUS, inner_radius=DETECTOR,
            surface=PAINT,
        ),
        pz.Cylinder(
            name="tube", position=(0, 0, 0), axis="+z", radius=RADIUS, length=LENGTH,
            surface=PAINT,
        ),
    ]  # fmt: skip
    found += [
        pz.Disk(
            name=f"vane {n}", position=(0, 0, 0.025 * n), axis="+z", radius=RADIUS,
            inner_radius=0.015, surface=PAINT,
        )
        for n in (1, 2, 3)
    ]  # fmt: skip
    if window:
        found += [
            pz.Disk(
                name=f"window {axis}", position=(0, 0, at), axis=axis, radius=RADIUS,
                surface=pz.Fresnel(1.5),
            )
            for axis, at in (("-z", 0.09), ("+z", 0.094))
        ]  # fmt: skip
    return tuple(found)


def reverse_scene(elements: Sequence[pz.Element], edges: Sequence[float]) -> pz.Scene:
    """Return the scene in which the detector shines."""
    lamp = pz.LambertianDisk(
        name="detector's light", flux=1.0, position=(0, 0, 0), axis="+z", radius=DETECTOR
    )
    far_field = pz.FarField(axis="+z", theta_edges_deg=edges, n_phi=1)
    return pz.Scene("reverse", (lamp,), tuple(elements), far_field=far_field)


def forward_scene(elements: Sequence[pz.Element], low: float, high: float) -> pz.Scene:
    """Return the scene in which beams from between two angles fall on the entrance.

    Their fluxes are the weights of a mean over the solid angle, of 1 W in all. Each is as wide as
    the tube, so that it covers the entrance as seen from there, and starts clear of it.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    ends = math.cos(math.radians(low)), math.cos(math.radians(high))
    beams = []
    for n, (node, weight) in enumerate(zip(nodes, weights, strict=True)):
        cosine = 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[0] - ends[1]) * node
        sine, away = math.sqrt(1.0 - cosine * cosine), 20.0 * RADIUS
        beams.append(
            pz.CollimatedDisk(
                name=f"beam {n}", flux=0.5 * float(weight), axis="-z", radius=RADIUS,
                tilt_deg=(math.degrees(math.acos(cosine)), 0.0),
                position=(away * sine, 0.0, LENGTH + away * cosine),
            )
        )  # fmt: skip
    return pz.Scene("forward", tuple(beams), tuple(elements))


def reverse(
    elements: Sequence[pz.Element], bins: Sequence[tuple[float, float]], **run: Any
) -> list[Pst]:
    """Return the transmittance in each bin from one reverse trace."""
    edges = sorted({edge for ends in bins for edge in ends})
    far = pz.trace(reverse_scene(elements, edges), **run).far_field
    assert far is not None
    rows = [edges.index(low) for low, _ in bins]
    flux = 1.0
    return [
        Pst(
            math.pi * float(far.intensity[j, 0]) / flux,
            math.pi * float(far.sigma[j, 0]) / flux,
            int(far.count[j, 0]),
        )
        for j in rows
    ]


def forward(elements: Sequence[pz.Element], ends: tuple[float, float], **run: Any) -> Pst:
    """Return the transmittance in a bin from a trace of beams."""
    power = pz.trace(forward_scene(elements, *ends), **run).detectors["detector"].power
    # irradiance π DETECTOR² below, flux 1 over π RADIUS² above; the beams have that radius
    scale = (RADIUS / DETECTOR) ** 2
    return Pst(scale * power.value, scale * (power.sigma or 0.0), power.count or 0)


def compared(
    name: str, elements: Sequence[pz.Element], batches: int, report: Report
) -> list[dict[str, Any]]:
    """Trace a system in both directions; print a row a bin."""
    found = []
    back = reverse(elements, BINS, batches=batches, rays_per_batch=1 << 19, seed=1)
    for ends, one in zip(BINS, back, strict=True):
        other = forward(elements, ends, batches=batches, rays_per_batch=1 << 17, seed=2)
        z = (one.value - other.value) / math.hypot(one.sigma, other.sigma)
        found.append({"scene": name, "theta_deg": ends, "reverse": vars(one),
                      "forward": vars(other), "z": z})  # fmt: skip
    report.say(
        *table(
            ("θ in degrees", "reverse", "± %", "arrivals", "forward", "± %", "arrivals", "z"),
            [
                (
                    f"{row['theta_deg'][0]:g} – {row['theta_deg'][1]:g}",
                    *(
                        text
                        for way in (row["reverse"], row["forward"])
                        for text in (
                            f"{way['value']:.4e}",
                            f"{100.0 * way['sigma'] / way['value']:.2f}",
                            str(way["count"]),
                        )
                    ),
                    f"{row['z']:+.2f}",
                )
                for row in found
            ],
        )
    )
    return found


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reverse", description=__doc__)
    parser.add_argument("--batches", type=int, default=64, help="of each trace; default 64")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    started = time.perf_counter()
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    rows = []
    for name, window in (("Tube with vanes", False), ("The same behind a window", True)):
        report.heading(name)
        rows += compared(name, tube(window=window), asked.batches, report)
    worst = max(abs(row["z"]) for row in rows)
    report.say("", f"largest |z| {worst:.2f} of {len(rows)}; at most {WORST:g} passes")
    report.say(f"{time.perf_counter() - started:.0f} s")
    if asked.out:
        report.write(asked.out, "reverse", {"facts": known, "rows": rows})
    return 0 if worst <= WORST else 1


if __name__ == "__main__":
    sys.exit(main())
