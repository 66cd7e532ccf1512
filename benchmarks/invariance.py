"""Whether anything but scene and seed decides a bit: ``python -m benchmarks.invariance``.

Random scenes in which much goes wrong if it can: elements that coincide, touch and cross, on a
lattice, off it by units in the last place or anywhere, at many sizes, far from the origin. Each is
traced in every way there is: effects forced on, with the tree of boxes and without, at several lane
widths and compositions, on one compute unit. All must give the same cells. Scenes come in families
that share their programs, since building those takes longest. Exit status 1 where any differs.
"""

from __future__ import annotations

import argparse
import hashlib
import math
import random
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.report import Report
from hostcode.program.plan import ExecutionPlan
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import PhotizonError
from photizon_cl.scene.files import load

# scenes are traced as the tests trace them
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from oracles.engine import open_device, trace_compiled, with_tree

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.scene.model import Scene

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
TILTS = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (33.3, -71.7), (90.0, 0.0), (180.0, 0.0), (-12.0, 7.0))
SIZES = (0.25, 0.5, 0.5, 1.0)
SCALES = (1.0, 1.0, 1e-3, 1e3, 1e-6, 1e6)
RAYS = 256

FORCED = ("tilt", "contact", "coincidence", "port", "shares", "splitting")
"""Effects that bring no cells or rows of their own."""
SOME = ("contact", "coincidence")
"""Those that some scenes of a family have and others have not."""


def _surfaces(r: random.Random) -> dict[str, Any]:
    kind = r.choice(("absorber", "mirror", "lambertian", "fresnel", "fresnel", "clear", "mixed"))
    values: dict[str, Any] = {}
    if kind in ("mirror", "lambertian"):
        values["reflectance"] = r.choice((0.5, 0.9, 1.0))
    if kind == "fresnel":
        values = {"index": r.choice((1.5, 1.8, 1.0)), "index_outside": r.choice((1.0, 1.5))}
    if kind == "mixed":
        values = {"specular": 0.4, "diffuse": 0.5}
    return {"surface": {"kind": kind, **values}}


def _shape(kind: str, size: Any) -> dict[str, Any]:
    """Return the parameters of a kind from a function that gives lengths."""
    match kind:
        case "rectangle":
            return {"half_width": size(), "half_height": size()}
        case "disk":
            return {"radius": size()}
        case "sphere":
            return {"radius": size()}
        case "cylinder":
            return {"radius": size(), "length": size()}
        case "cone":
            return {"entrance_radius": size(), "exit_radius": size(), "length": size()}
        case "conic":
            return {
                "curvature_radius": 2.0 * size(),
                "aperture_radius": size(),
                "conic_constant": -1.0,
            }
        case "cpc":
            return {"exit_radius": size(), "acceptance_deg": 30.0}
        case "baffled-tube":
            half = size()
            return {
                "half_width": half,
                "length": size(),
                "baffles": 1,
                "clear_half_width": 0.5 * half,
            }
        case "plano-convex":
            aperture = size()
            return {"curvature_radius": aperture, "aperture_radius": aperture}
        case _:
            aperture = size()
            return {
                "front_radius": 2.0 * aperture,
                "back_radius": aperture,
                "aperture_radius": aperture,
            }


KINDS = (
    "rectangle", "rectangle", "disk", "disk", "sphere", "sphere", "cylinder", "cone", "conic",
    "cpc", "baffled-tube", "plano-convex", "plano-convex", "biconvex",
)  # fmt: skip
WALLS = ("cylinder", "cone", "cpc", "baffled-tube")


class Family:
    """Scenes of the same kinds, surfaces and axes, at different places and sizes."""

    def __init__(self, number: int) -> None:
        r = random.Random(7919 * number)
        self.number = number
        self.elements: list[dict[str, Any]] = []
        for _ in range(r.randint(2, 6)):
            kind = r.choice(KINDS)
            surface = _surfaces(r)
            while kind in WALLS and surface["surface"]["kind"] == "fresnel":
                surface = _surfaces(r)
            element = {"kind": kind, "axis": r.choice(AXES), "tilt_deg": list(r.choice(TILTS))}
            if surface["surface"]["kind"] in ("absorber", "clear"):
                surface["detector"] = {}
            self.elements.append({**element, **surface})
        self.source = r.choice(("isotropic-point", "lambertian-disk", "lambertian-sphere"))

    def scene(self, number: int) -> Scene:
        """Return one of its scenes."""
        r = random.Random(f"{self.number} {number}")
        scale = r.choice(SCALES)
        far = r.choice((0.0, 0.0, 0.0, 1.0, 1e3, 1e9, 3e13)) * scale
        away = [r.uniform(-far, far) if r.random() < 0.7 else 0.0 for _ in range(3)]

        def size() -> float:
            return scale * (r.choice(SIZES) if r.random() < 0.8 else r.uniform(0.1, 1.0))

        def place() -> list[float]:
            at = []
            for origin in away:
                x = scale * r.choice((-1.0, -0.5, 0.0, 0.0, 0.0, 0.5, 1.0))
                if r.random() < 0.15:
                    x = scale * r.uniform(-1.0, 1.0)
                x += origin
                if r.random() < 0.1:
                    x = math.nextafter(x, r.choice((-math.inf, math.inf)))
                at.append(x)
            return at

        elements = []
        for n, element in enumerate(self.elements):
            shape = _shape(element["kind"], size)
            elements.append({"name": f"e{n}", **element, "position": place(), **shape})
        source: dict[str, Any] = {
            "name": "s",
            "kind": self.source,
            "flux": 1.0,
            "position": place(),
        }
        if self.source == "lambertian-disk":
            source |= {"axis": r.choice(AXES), "radius": size()}
        if self.source == "lambertian-sphere":
            source["radius"] = size()
        return load(
            {
                "schema": "photizon/1",
                "name": f"family {self.number}, scene {number}",
                "run": {"rays_per_batch": RAYS, "generation_cap": 8},
                "source": [source],
                "element": elements,
            }
        )


PLAN = ExecutionPlan(lanes=4, items=8, wave_rays=1 << 16, refill=1, stack_rays=64)


def ways(scene: Scene) -> Iterator[tuple[str, str]]:
    """Trace a scene in every way; give each way's name and the digest of its cells."""

    def digest(*forced: str, tree: bool = False, units: int | None = None, **plan: Any) -> str:
        made = compile_scene(scene, scene.run, **with_tree(tree, frozenset(forced)))
        found = trace_compiled(made, device=open_device("", units), plan=PLAN.with_(**plan))
        return hashlib.sha256(found.cells.tobytes()).hexdigest()

    # what one scene of a family needs and another does not is in most ways forced on, so that few
    # programs are built
    yield "as it is", digest()
    yield "one lane", digest(*SOME, lanes=1)
    yield "all effects forced on", digest(*FORCED)
    yield "tilt forced on", digest(*SOME, "tilt")
    yield "tree", digest(*SOME, tree=True)
    yield "tree, all forced, 8 rays in turn", digest(*FORCED, tree=True, lanes=8)
    yield "8 lanes", digest(*SOME, lanes=8, refill=2)
    yield "classical", digest(*SOME, composition="classical")
    yield "whole path", digest(*SOME, composition="whole-path", lanes=1)
    yield "one compute unit", digest(units=1)


def main(argv: list[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.invariance", description=__doc__)
    parser.add_argument("--families", type=int, default=40, help="default 40")
    parser.add_argument("--scenes", type=int, default=60, help="a family; default 60")
    parser.add_argument("--first", type=int, default=0, help="first family")
    parser.add_argument("--out", type=Path, help="directory for the printed text and the numbers")
    args = parser.parse_args(argv)
    report = Report()
    report.say(f"random scenes, {RAYS} rays each, traced in every way")
    traced = runs = 0
    different: list[dict[str, Any]] = []
    refused: dict[str, int] = {}
    for number in range(args.first, args.first + args.families):
        family, began, here = Family(number), time.monotonic(), 0
        for n in range(args.scenes):
            try:
                scene = family.scene(n)
            except PhotizonError as error:
                why = str(error).splitlines()[0]
                refused[why] = refused.get(why, 0) + 1
                continue
            found = list(ways(scene))
            traced, runs, here = traced + 1, runs + len(found), here + 1
            odd = [way for way, digest in found if digest != found[0][1]]
            if odd:
                different.append({"family": number, "scene": n, "ways": odd})
                report.say(f"DIFFERENT: family {number}, scene {n}: {', '.join(odd)}")
        kinds = " ".join(e["kind"] for e in family.elements)
        took = time.monotonic() - began
        report.say(f"family {number:3d}: {here:3d} scenes, {took:5.1f} s  {kinds}")
    report.say("", f"{traced} scenes, {runs} runs, {len(different)} scenes that differ")
    if args.out:
        data = {"scenes": traced, "runs": runs, "different": different, "refused": refused}
        report.write(args.out, "invariance", data)
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
