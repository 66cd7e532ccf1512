"""The preset `baffled-telescope`'s point source transmittance: ``python -m benchmarks.telescope``.

PST(θ), the mean irradiance on the detector over that of the star's beam across itself. Reverse: the
detector shines as a Lambertian disk of 1 W, and a bin of its far field of intensity I holds
PST = π I (docs/reverse-traces.md). Forward: a beam as wide as the entrance, which is 900 mm before
the primary's vertex. Both without help: importance sampling is left out, so that a forward trace
sees something only next to the field.

Prints every angle with σ and arrivals, the forward ones beside them with z, the difference over its
σ. Exit status 1 where a |z| exceeds 3.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import photizon_cl as pz
from benchmarks.facts import facts, lines
from benchmarks.report import Report, table
from hostcode.device.device import choose

if TYPE_CHECKING:
    from collections.abc import Sequence

PRESET: Final = "baffled-telescope"
DETECTOR: Final = "detector"
ENTRANCE: Final = 0.9
"""Where the last vane stands, in metres from the primary's vertex."""
AWAY: Final = 2.0
"""From the entrance's middle to where the beam starts, in metres."""
ANGLES: Final = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
"""Degrees."""
FORWARD: Final = (0.5, 1.0, 5.0)
"""Of these those that a forward trace without help sees."""
PART: Final = 0.05
"""Half the width of a bin, as a part of its angle up to 40 degrees."""
WORST: Final = 3.0


def bin_about(theta: float) -> tuple[float, float]:
    """Return the edges of the bin about an angle, in degrees: ± 5 %, at most ± 2 degrees."""
    half = min(PART * theta, 2.0)
    return theta - half, theta + half


def star_at(theta: float) -> pz.CollimatedDisk:
    """Return the star's beam of 1 W from an angle in degrees, clear of the tube."""
    scene = pz.load(PRESET)
    turn = math.radians(theta)
    place = (AWAY * math.sin(turn), 0.0, ENTRANCE + AWAY * math.cos(turn))
    star = scene.source["star"]
    assert isinstance(star, pz.CollimatedDisk)
    return replace(star, position=place, tilt_deg=(theta, 0.0))


def in_reverse(edges: Sequence[float]) -> pz.Scene:
    """Return the scene in which the detector shines 1 W, binned between edges in degrees."""
    scene = pz.load(PRESET)
    detector = scene.element[DETECTOR]
    assert isinstance(detector, pz.Disk)
    lamp = pz.LambertianDisk(
        name="detector's light", flux=1.0, position=detector.position, axis=detector.axis,
        radius=detector.radius,
    )  # fmt: skip
    far_field = pz.FarField(axis=detector.axis, theta_edges_deg=edges, n_phi=1)
    return replace(scene, name=f"{PRESET} in reverse", source=(lamp,), far_field=far_field)


def reverse(**run: Any) -> list[dict[str, Any]]:
    """Return the transmittance at every angle from one trace."""
    bins = [bin_about(theta) for theta in ANGLES]
    edges = sorted({edge for ends in bins for edge in ends})
    far = pz.trace(in_reverse(edges), **run).far_field
    assert far is not None
    rows = [edges.index(low) for low, _ in bins]
    return [
        {
            "theta_deg": theta,
            "bin_deg": [low, high],
            "pst": math.pi * float(far.intensity[j, 0]),
            "sigma": math.pi * float(far.sigma[j, 0]),
            "count": int(far.count[j, 0]),
        }
        for theta, (low, high), j in zip(ANGLES, bins, rows, strict=True)
    ]


def forward(theta: float, **run: Any) -> dict[str, Any]:
    """Return the transmittance at an angle from a trace of the star's beam."""
    scene = pz.load(PRESET)
    detector, star = scene.element[DETECTOR], star_at(theta)
    assert isinstance(detector, pz.Disk)
    power = pz.trace(replace(scene, source=(star,)), **run).detectors[DETECTOR].power
    scale = (star.radius / detector.radius) ** 2
    return {
        "theta_deg": theta,
        "pst": scale * power.value,
        "sigma": scale * (power.sigma or 0.0),
        "count": power.count,
    }


def _shown(found: dict[str, Any]) -> tuple[str, str, str]:
    part = f"{100.0 * found['sigma'] / found['pst']:.1f}" if found["pst"] else "–"
    return f"{found['pst']:.3e}", part, str(found["count"])


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.telescope", description=__doc__)
    parser.add_argument("--batches", type=int, default=256, help="in reverse; default 256")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    asked = parser.parse_args(arguments)
    started = time.perf_counter()
    report = Report()
    known = facts(choose(None))
    report.say(*lines(known))
    report.heading(f"PST of {PRESET}")
    back = reverse(batches=asked.batches, rays_per_batch=1 << 19, seed=1)
    ahead = {
        theta: forward(theta, batches=max(asked.batches // 4, 2), rays_per_batch=1 << 20, seed=2)
        for theta in FORWARD
    }
    rows, worst = [], 0.0
    for one in back:
        other = ahead.get(one["theta_deg"])
        more = ("", "", "", "")
        if other is not None:
            z = (one["pst"] - other["pst"]) / math.hypot(one["sigma"], other["sigma"])
            worst = max(worst, abs(z))
            more = (*_shown(other), f"{z:+.2f}")
        rows.append((f"{one['theta_deg']:g}", *_shown(one), *more))
    header = ("θ in degrees", "reverse", "± %", "arrivals", "forward", "± %", "arrivals", "z")
    report.say(*table(header, rows))
    report.say("", f"largest |z| {worst:.2f} of {len(ahead)}; at most {WORST:g} passes")
    report.say(f"{time.perf_counter() - started:.0f} s")
    if asked.out:
        kept = {"facts": known, "reverse": back, "forward": list(ahead.values())}
        report.write(asked.out, "telescope", kept)
    return 0 if worst <= WORST else 1


if __name__ == "__main__":
    sys.exit(main())
