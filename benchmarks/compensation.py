"""What the compensated parts cost, and which families of hard cases fail without them.

``python -m benchmarks.compensation [--seconds S] [--skip-families]``

Each part is taken out of the kernels' text (a copy; the tree is not touched), the stability
families that it is there for are run, and a scene that uses it is timed. Prints one table.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Part:
    """A compensated part: its plain replacement, what it is there for, what is timed.

    `edits` are (file, text, replacement); every text must be there, so that the script fails when
    the kernels move on.
    """

    name: str
    scene: str
    families: tuple[str, ...]
    edits: tuple[tuple[str, str, str], ...]


SPHERE = "elements/sphere.mako"
CAP = "lib/cap.mako"
PARTS = (
    Part(
        "sphere: c = |f|^2 - R^2 compensated",
        "sphere",
        ("sphere, far and near", "sphere, origin on it", "sphere, tangent"),
        (
            (
                SPHERE,
                '"(s2 - rr) + (((xe + ye) + (ze - re)) + (s1e + s2e))"',
                '"fma(fx, fx, fma(fy, fy, fz * fz)) - rr"',
            ),
        ),
    ),
    Part(
        "sphere: discriminant from the closest approach",
        "sphere",
        ("sphere, far and near", "sphere, tangent"),
        (
            (
                SPHERE,
                '"(radius - l) * (radius + l)"',
                '"b * b - dot3(fx, fy, fz, fx, fy, fz) + radius * radius"',
            ),
        ),
    ),
    Part(
        "sphere: both roots without cancellation",
        "sphere",
        ("sphere, far and near", "sphere, origin on it"),
        (
            (
                SPHERE,
                "real t1 = fmin(q, other), t2 = fmax(q, other);",
                "real t1 = b - s, t2 = b + s;",
            ),
        ),
    ),
    Part(
        "sphere: departed root removed",
        "sphere",
        ("sphere, chord",),
        (
            (
                SPHERE,
                "const mask free_lanes = ~departed & p->alive;",
                "const mask free_lanes = p->alive;",
            ),
        ),
    ),
    Part(
        "flat: rounding bound at edges",
        "room",
        ("shared edges", "flat, edge"),
        (
            (
                "elements/rectangle.mako",
                "LE(ax, bx + R(row[FLAT_OUTER_U]))",
                "LE(ax, splat((2.0 * row[FLAT_INNER_U] + row[FLAT_OUTER_U]) / 3.0))",
            ),
            (
                "elements/rectangle.mako",
                "LE(ay, by + R(row[FLAT_OUTER_V]))",
                "LE(ay, splat((2.0 * row[FLAT_INNER_V] + row[FLAT_OUTER_V]) / 3.0))",
            ),
        ),
    ),
    Part(
        "lens: cap seen from its rim, not its centre",
        "lens",
        ("lens, shapes", "lens, inside", "lens, rim"),
        (
            (
                CAP,
                '"fma(x, x, fma(y, y, fma(z, z + R(2.0 * s * h), splat(-a * a))))"',
                '"fma(x, x, fma(y, y, (z + s * h) * (z + s * h))) - fma(a, a, h * h)"',
            ),
        ),
    ),
    Part(
        "lens: discriminant at the point nearest the rim",
        "lens",
        ("lens, shapes", "lens, tangent"),
        ((CAP, '"-dot3(x, y, z, dx, dy, dz)"', '"splat(0.0)"'),),
    ),
    Part(
        "lens: rim decided by the distance from the axis",
        "lens",
        ("lens, rim",),
        (("lib/solid.mako", "SELM(from_outside, meets, LE(enter, leave))", "LE(enter, leave)"),),
    ),
    Part(
        "fresnel: forms without cancellation",
        "lens",
        ("fresnel",),
        (
            (
                "surfaces/fresnel.mako",
                '"k / (a * a)"',
                '"(mci - ct) / a "',
            ),
            (
                "surfaces/fresnel.mako",
                '"k * fma(-fma(m, m, splat(1.0)), sin2, splat(1.0)) / (b * b)"',
                '"(ci - m * ct) / b "',
            ),
        ),
    ),
)


def scene(kind: str):
    """Return a scene that spends its time in what is measured."""
    from photizon_cl.scene.elements.biconvex import Biconvex
    from photizon_cl.scene.elements.sphere import Sphere
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings
    from photizon_cl.scene.sources.isotropic_point import IsotropicPoint
    from photizon_cl.scene.surfaces.fresnel import Fresnel
    from photizon_cl.scene.surfaces.lambertian import Lambertian
    from photizon_cl.stability.families_mixed import room

    white = Lambertian(0.99)
    lamp = IsotropicPoint(name="lamp", flux=1.0, position=(0.1, 0.2, 0.3))
    walls = room((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), surface=white)
    where = {"name": "body", "position": (0.0, 0.0, -0.4), "axis": "+z"}
    if kind == "sphere":
        walls = (*walls, Sphere(**where, radius=0.4, surface=white))
    if kind == "lens":
        lens = Biconvex(
            **where,
            aperture_radius=0.7,
            front_radius=1.5,
            back_radius=2.0,
            surface=Fresnel(index=1.5),
        )
        walls = (*walls, lens)
    run = RunSettings(rays_per_batch=4096, generation_cap=200, roulette_floor=0.05)
    return Scene(name=kind, source=(lamp,), element=walls, run=run)


def measure(kind: str, families: list[str], seconds: float) -> None:
    """Print interactions a second, then a line for every family (in a fresh process)."""
    from hostcode.device.device import preferred_lanes
    from hostcode.program.plan import default_plan
    from hostcode.run.wavefront import Engine
    from photizon_cl.compile.compiled import compile_scene
    from photizon_cl.run.distribution import open_chosen
    from photizon_cl.stability.report import stability_report

    device = open_chosen(None)
    made = scene(kind)
    plan = default_plan(device.record, preferred_lanes(device.record))
    engine = Engine(device, compile_scene(made, made.run).tables, plan)
    list(engine.run(0, 4))
    best, first, started = 0.0, 4, time.perf_counter()
    while time.perf_counter() - started < seconds:
        before, now = engine.statistics.interactions, time.perf_counter()
        list(engine.run(first, 8))
        first += 8
        rate = (engine.statistics.interactions - before) / (time.perf_counter() - now)
        best = max(best, rate)  # other work on the machine only ever slows it
    print(f"rate {best:.6g}")
    for row in stability_report(device, families) if families else ():
        inexact = sum(m.forward > 8 for m in row.measured)
        bad = "" if row.passed else f"{row.worst:.2g} ulps, {len(row.wrong)} wrong decisions"
        print(f"family|{row.family}|{inexact}|{bad}")


def run_patched(
    part: Part | None, kind: str, families: tuple[str, ...], seconds: float
) -> list[str]:
    """Run `measure` on a copy of the tree with a part taken out."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("photizon_cl", "hostcode", "kernels", "benchmarks", "presets"):
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        for file, text, plain in part.edits if part else ():
            path = copy / "kernels" / file
            source = path.read_text(encoding="utf-8")
            if source.count(text) != 1:
                raise SystemExit(f"{file}: found {source.count(text)} times, expected once: {text}")
            path.write_text(source.replace(text, plain), encoding="utf-8")
        done = subprocess.run(
            [
                sys.executable,
                "-m",
                "benchmarks.compensation",
                "--worker",
                kind,
                "--seconds",
                str(seconds),
                *families,
            ],
            cwd=copy,
            env={**os.environ, "PYTHONPATH": str(copy)},
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        raise SystemExit(f"{part.name if part else 'as it is'}:\n{done.stderr}")
    return done.stdout.splitlines()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=6.0, help="of timing for each part")
    parser.add_argument("--skip-families", action="store_true", help="time only")
    parser.add_argument("--worker", metavar="SCENE", help=argparse.SUPPRESS)
    parser.add_argument("families", nargs="*", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.worker:
        measure(arguments.worker, arguments.families, arguments.seconds)
        return
    print(f"{'without':50} {'scene':7} {'M/s with':>9} {'without':>9} {'it costs':>9}  what fails")
    for part in PARTS:
        families = () if arguments.skip_families else part.families
        runs = [
            run_patched(taken, part.scene, families if n < 2 else (), arguments.seconds)
            for n, taken in enumerate((None, part, None, part))
        ]
        a, b = (max(float(runs[k][0].split()[1]), float(runs[k + 2][0].split()[1])) for k in (0, 1))
        print(
            f"{part.name:50} {part.scene:7} {a / 1e6:9.2f} {b / 1e6:9.2f} "
            f"{100 * (1 - a / b):8.1f}%  "
            f"{_failures(runs[0][1:], runs[1][1:])}",
            flush=True,
        )
    print("M/s: the best of short runs.  what fails: ulps of a backward-stable solution beyond the")
    print("bound and wrong decisions; > 8u: cases whose plain relative error is above 8 roundoffs.")


def _failures(with_it: list[str], without: list[str]) -> str:
    """Say what a part's absence spoils, family by family."""
    found = []
    for a, b in zip(with_it, without, strict=True):
        _, family, before, _ = a.split("|")
        _, _, after, bad = b.split("|")
        spoiled = [bad] if bad else []
        if int(after) > int(before):
            spoiled.append(f"> 8u: {after} instead of {before}")
        if spoiled:
            found.append(f"{family}: {', '.join(spoiled)}")
    return "; ".join(found) or "nothing"


if __name__ == "__main__":
    main()
