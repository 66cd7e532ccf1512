"""Small traces for a simulator that watches every access to memory; a program of its own there.

``oclgrind … python -m oracles.watched CASE`` traces a case on the simulator and prints its digest,
to be compared with that of `digest` on a device. A process each: what the simulator keeps for every
buffer that there ever was makes a second case several times as slow.
"""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hostcode import templates
from hostcode.device import device as devices
from hostcode.program import build
from hostcode.program.plan import ExecutionPlan
from hostcode.program.source import program_source
from hostcode.run.paths import trace_paths
from hostcode.run.probe import follow_rays, probe_faces
from hostcode.run.wavefront import Engine
from oracles.engine import compiled, open_device
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hostcode.program.spec import ProgramSpec
    from photizon_cl.scene.model import Scene

PLATFORM: Final = "Oclgrind"

_SURFACES: Final[dict[str, dict[str, Any]]] = {
    "black": {"kind": "absorber"},
    "mirror": {"kind": "mirror", "reflectance": 0.9},
    "matt": {"kind": "lambertian", "reflectance": 0.6},
    "glass": {"kind": "fresnel", "index": 1.5},
    "dyed": {"kind": "fresnel", "medium": "dyed", "medium_outside": "vacuum"},
    "by angle": {"kind": "mirror", "reflectance": {"angle_deg": [0, 60], "value": [0.9, 0.6]}},
    "clear": {"kind": "clear"},
    "mixed": {"kind": "mixed", "specular": 0.3, "diffuse": 0.5},
}
_LOBES: Final[dict[str, dict[str, Any]]] = {
    "abg": {"kind": "abg", "A": 0.02, "B": 0.05, "g": 1.5},
    "gaussian": {"kind": "gaussian", "sigma": 0.2, "tis": 0.3},
    "harvey-shack": {"kind": "harvey-shack", "b0": 1.0, "L": 0.1, "S": -1.5},
    "lambertian": {"kind": "lambertian", "tis": 0.2},
    "table": {"kind": "table", "delta": [0.1, 0.5, 1.0], "bsdf_per_sr": [0.3, 0.1, 0.02]},
}
_STACK: Final = [
    {"index": 1.38, "thickness_nm": 99.6}, {"index": 2.3, "extinction": 0.1, "thickness_nm": 30.0}
]  # fmt: skip
_COATINGS: Final[dict[str, dict[str, Any]]] = {
    "glass": {"kind": "fixed", "reflectance": 0.3, "transmittance": 0.6},
    "glass, harvey-shack": {
        "kind": "table", "angle_deg": [0.0, 30.0, 90.0], "reflectance": [0.2, 0.3, 1.0],
        "transmittance": [0.7, 0.7, 0.0],
    },
    "dyed, lambertian": {"kind": "stack", "layers": _STACK},
}  # fmt: skip
"""What glass of these names has; stacks where there is a spectrum."""
for _surface, _lobe in (
    ("mirror", "abg"), ("by angle", "gaussian"), ("glass", "harvey-shack"), ("dyed", "lambertian"),
    ("black", "table"),
):  # fmt: skip
    _SURFACES[f"{_surface}, {_lobe}"] = {**_SURFACES[_surface], "scatter": _LOBES[_lobe]}


_OVER_NM: Final = {"wavelength_nm": [400.0, 550.0, 700.0], "value": [0.9, 0.7, 0.8]}
_LIGHT: Final[dict[str, dict[str, Any]]] = {
    "lines": {"wavelengths_nm": [450.0, 550.0, 650.0]},
    "bands": {"edges_nm": [420.0, 500.0, 700.0]},
}
"""The spectra of which a case may be."""


def every_kind(light: str = "") -> dict[str, Any]:
    """Return the tables of a scene with every kind of element, surface, source and tally.

    Each element is a metre from the middle, where the sources are, in a round room with a port. Of
    ``lines`` or ``bands`` glass disperses and a part of it has a stack of films, a medium, mirrors
    and walls have tables over wavelength, and detectors tell lines apart.
    """
    elements = [
        ("+x", "-x", "black", {"kind": "rectangle", "half_width": 0.4, "half_height": 0.3},
         {"map": [3, 2], "generations": 4}),
        ("-x", "+x", "mirror, abg", {"kind": "disk", "radius": 0.4, "inner_radius": 0.1}, None),
        ("+y", "-y", "by angle, gaussian",
         {"kind": "cpc", "exit_radius": 0.1, "acceptance_deg": 40.0}, None),
        ("-y", "-y", "matt", {"kind": "baffled-tube", "half_width": 0.3, "length": 0.5,
                              "baffles": 1, "clear_half_width": 0.1}, None),
        ("+z", "+z", "glass", {"kind": "plano-convex", "curvature_radius": 0.6,
                               "aperture_radius": 0.4}, None),
        ("-z", "-z", "dyed, lambertian",
         {"kind": "biconvex", "front_radius": 0.6, "back_radius": 0.8, "aperture_radius": 0.4},
         None),
        ("+x+y", "+z", "black", {"kind": "cylinder", "radius": 0.3, "length": 0.4},
         {"map": [4, 3], "side": "outside"}),
        ("-x+y", "+z", "mixed", {"kind": "cone", "entrance_radius": 0.1, "exit_radius": 0.4,
                                 "length": 0.4}, None),
        ("+x-y", "+z", "clear", {"kind": "conic", "curvature_radius": 0.4, "conic_constant": -1.0,
                                 "aperture_radius": 0.4}, {"generations": 3}),
        ("-x-y", "+z", "black, table",
         {"kind": "disk", "radius": 0.3, "tilt_deg": [20.0, 70.0]}, None),
        ("+x+z", "+x", "glass, harvey-shack",
         {"kind": "lens", "front_radius": -0.6, "back_radius": 0.8, "back_conic": -2.0,
          "thickness": 0.2, "aperture_radius": 0.3}, None),
        ("", "+z", "matt", {"kind": "sphere", "radius": 2.0, "port_fraction": 0.2}, None),
    ]  # fmt: skip
    sources: list[dict[str, Any]] = [
        {"kind": "isotropic-point"},
        {"kind": "lambertian-sphere", "radius": 0.02},
        {
            "kind": "cosine-point",
            "axis": "+x",
            "medium": "dyed",
            "polarisation": {"degree": 0.5, "angle_deg": 30.0},
        },
        {"kind": "cone-point", "axis": "-z", "half_angle_deg": 20.0},
        {"kind": "lambertian-disk", "axis": "+y", "radius": 0.05},
        {"kind": "lambertian-rectangle", "axis": "-y", "half_width": 0.05, "half_height": 0.02},
        {"kind": "collimated-disk", "axis": "+z", "radius": 0.2, "divergence_deg": 5.0},
    ]
    rows = []
    for n, (where, axis, surface, shape, detector) in enumerate(elements):
        at = [where.count(f"+{x}") - where.count(f"-{x}") for x in "xyz"]
        row = {"name": f"element {n}", "position": [float(x) for x in at], "axis": axis, **shape}
        row["surface"] = _SURFACES[surface]
        if surface in _COATINGS and (light or "stack" not in _COATINGS[surface].values()):
            row["surface"] = {**row["surface"], "coating": _COATINGS[surface]}
        if detector is not None:
            row["detector"] = detector
        rows.append(row)
    dyed: dict[str, Any] = {"name": "dyed", "index": 1.4, "absorption_per_m": 0.5}
    if light:
        per_m = {"wavelength_nm": [450.0, 600.0], "per_m": [0.2, 0.9]}
        cauchy = {"kind": "cauchy", "A": 1.38, "B_um2": 0.006}
        dyed = {"name": "dyed", "dispersion": cauchy, "absorption_per_m": per_m}
        for row in rows:
            if isinstance(row["surface"].get("reflectance"), float):
                row["surface"] = {**row["surface"], "reflectance": _OVER_NM}
            if "detector" in row:
                row["detector"] = {**row["detector"], "wavelengths": True}
    return {
        "schema": "photizon/1",
        "name": "every kind",
        **({"spectrum": _LIGHT[light]} if light else {}),
        "run": {"roulette_floor": 0.05, "generation_cap": 6, "polarisation": True},
        "far_field": {"n_mu": 3, "n_phi": 4},
        "medium": [dyed],
        # a rectangle, a disk and a ball
        "importance": {"toward": ["element 0", "element 1", "element 6"], "weights": [1, 2, 3]},
        "source": [
            {"name": f"source {n}", "flux": 1.0, "share": 1.0 + n, "position": [0.01, 0.02, 0.03]}
            | source
            for n, source in enumerate(sources)
        ],
        "element": rows,
    }


@dataclass(frozen=True)
class Case:
    """What is traced, and how.

    Without the name of a scene it is that of every kind, of a `light` or of none. `paths` is how
    many rows the detectors' path tables have, `broken` what stands at points of the kernels
    instead, `unset` whether to look for values that were never set.
    """

    scene: str = ""
    rays: int = 14
    batches: int = 1
    plan: dict[str, Any] = field(default_factory=dict)
    force: frozenset[str] = frozenset()
    by_ray: bool = False
    light: str = ""
    paths: int = 0
    unset: bool = True
    broken: dict[str, str] = field(default_factory=dict)


TREE: Final = frozenset({"acceleration"})
SPHERE: Final = "integrating-sphere"
LADDER: Final = "ghost-ladder"

CASES: Final[dict[str, Case]] = {
    "every kind": Case(rays=7),
    "every kind, through a tree": Case(rays=7, force=TREE),
    "every kind, stage by stage": Case(rays=7, plan={"composition": "classical"}),
    "every kind, ray by ray": Case(rays=7, by_ray=True),
    "every kind, of bands": Case(light="bands", rays=14),
    "4 lanes": Case(LADDER, 2, plan={"lanes": 4}),
    "a kernel a path": Case(LADDER, 2, plan={"composition": "whole-path"}),
    "copies of the tally": Case("box-room", 8, 2, {"tally_copies": 2, "wave_rays": 16}),
    "path tables": Case("cosine-fourth", 8, paths=9),
}
"""What is watched in every run of the suite."""

MORE: Final[dict[str, Case]] = {
    "every kind, 2 lanes": Case(plan={"lanes": 2}),
    "every kind, all effects": Case(force=frozenset({"tilt", "contact", "coincidence", "port"})),
    "every kind, 8 in turn through a tree": Case(
        rays=7, force=TREE, plan={"lanes": 8, "cached_bytes": 1}
    ),
    "every kind, of lines": Case(light="lines", rays=21),
    "every kind, of bands, ray by ray": Case(light="bands", rays=14, by_ray=True),
    "every kind, of bands, 4 lanes": Case(light="bands", rays=14, plan={"lanes": 4}),
    "every kind, 8 lanes": Case(plan={"lanes": 8, "refill": 2}),
    "every kind, 16 lanes": Case(plan={"lanes": 16, "refill": 4}, unset=False),
    "every kind, a kernel a path": Case(plan={"composition": "whole-path"}),
    "stacks that grow": Case(LADDER, 8, plan={"stack_rays": 2}),
    "interleaved stacks that grow": Case(LADDER, 8, plan={"stack_rays": 2, "interleaved": True}),
    "groups of 4": Case(SPHERE, 16, plan={"local_size": 4, "items": 8}),
    "stage by stage, 4 lanes": Case(LADDER, 8, plan={"composition": "classical", "lanes": 4}),
    "few steps a launch": Case(SPHERE, 8, plan={"max_bounces": 2}),
    "every kind, path tables": Case(paths=9),
    "path tables beside copies of the tally": Case(
        LADDER, 8, plan={"tally_copies": 2}, paths=9
    ),
    **{f"{name}": Case(name, 8) for name in (
        "cosine-fourth", "lambertian-sphere", SPHERE, LADDER, "cpc-concentrator", "box-room",
        "plano-convex-condenser", "baffled-tube", "square-lightpipe", "cassegrain",
        "baffled-telescope", "absorbing-cuvette", "aspheric-condenser",
        "scattering-mirror", "dispersing-prism", "coated-window", "polariscope",
    )},
}  # fmt: skip
"""What takes longer. When 16 lanes are shuffled the simulator takes one for unset: its
src/plugins/Uninitialized.cpp compares the lane's number with an enumerator of LLVM's."""

BROKEN: Final[dict[str, Case]] = {
    "writes beyond the tally": Case(SPHERE, 8, broken={"far_field.column": "i + (1L << 36)"}),
    "adds without atomics": Case(
        "box-room", 8, 1, {"tally_copies": 0},
        broken={"cells.begin": "cell[3] += 0L; const double s = "},
    ),
    "uses what was never set": Case(
        SPHERE, 8, broken={"cells.begin": "double never; const double s = 0.0 * never + "}
    ),
    "looks at a path's cell without atomics": Case(
        "cosine-fourth", 8, broken={"keyed.first": "entry[KEYED_FIRST] < early"}, paths=9
    ),
}  # fmt: skip
"""Kernels that must be reported, with what is wrong with them."""

ALL: Final = {**CASES, **MORE, **BROKEN}

_PLAN: Final = ExecutionPlan(
    lanes=1, items=2, wave_rays=8, refill=1, stack_rays=64, tally_parts=2, local_size=1
)


def digest(name: str, device: Any = None) -> str:
    """Trace a case, or probe and follow its rays, and return a digest of what came out."""
    case = ALL[name]
    device = device or open_device()
    scene = load(_tabled(load(case.scene or every_kind(case.light)), case.paths))
    made = compiled(scene, case.force, rays_per_batch=case.rays)
    if case.by_ray:
        return _digest(by_ray(device, made.tables, case.rays))
    engine = Engine(device, made.tables, _PLAN.with_(**case.plan))
    found: list[Any] = []
    for batch in engine.run(0, case.batches):
        found += [batch.cells, *(batch.keyed.arrays if batch.keyed else ())]
    return _digest(found)


def _tabled(scene: Scene, paths: int) -> dict[str, Any]:
    """Return the tables of a scene whose detectors all have a path table of so many rows."""
    made = scene.to_dict()
    for element in made["element"] if paths else ():
        if "detector" in element:
            element["detector"]["paths"] = paths
    return made


def by_ray(device: Any, tables: Any, rays: int) -> list[Any]:
    """Return what the programs give that look at single rays: first hits, steps, whole paths."""
    g = np.random.default_rng(1)
    directions = g.normal(size=(rays, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    starts = np.hstack([g.uniform(-0.2, 0.2, (rays, 3)), directions])
    hits, faces = probe_faces(device, tables, starts, 1)
    followed = follow_rays(device, tables, starts, 3)
    paths = trace_paths(device, tables, 12)
    return [hits, faces, followed.point, followed.weight, followed.left, paths.reals, paths.wholes]


def _digest(arrays: Sequence[Any]) -> str:
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def main(name: str) -> None:
    """Trace a case on the simulator and print its digest."""
    _spare_the_simulator()
    (record,) = (found for found in devices.survey().records if found.platform == PLATFORM)
    templates.MUTATIONS.update(ALL[name].broken)
    print(digest(name, devices.open_device(record, self_test=False)))


_HINT: Final = "((void)*(volatile __global const long *)(place))"
"""Has a cell fetched that others may add to: a read whose value nobody looks at, yet a race."""


_REDUCED: Final = "#define __builtin_reduce_or(m) or_of(m)\n" + "".join(
    f"static long __attribute__((overloadable)) or_of(long{n} m) {{ return {either}; }}\n"
    for n, either in (
        (2, "m.x | m.y"),
        *((n, "or_of(m.lo) | or_of(m.hi)") for n in (4, 8, 16)),
    )
)
"""The one builtin of the compiler's that it does not know."""


def _text(spec: ProgramSpec) -> str:
    """Return the text of a program as the simulator can build and judge it."""
    text = program_source(spec)
    assert _HINT in text
    return _REDUCED + text.replace(_HINT, "((void)(place))")


def _spare_the_simulator() -> None:
    """Avoid what Oclgrind 21.10 takes for a fault, and pyopencl's own."""
    import pyopencl as cl
    import pyopencl.characterize

    # It goes on with what it noted of a buffer when another one gets its place: none goes.
    alive, make = [], cl.Buffer

    def keep(*arguments: Any, **options: Any) -> cl.Buffer:
        buffer = make(*arguments, **options)
        alive.append(make.from_int_ptr(buffer.int_ptr, retain=True))
        return buffer

    # After a write from outside it knows of no more of the buffer than was written: all is.
    def fill(queue: Any, buffer: Any, pattern: Any, offset: int, size: int) -> Any:
        whole = np.empty(buffer.size, np.uint8)
        if size < buffer.size:
            copy_as_it_does(queue, whole, buffer)
        whole[offset : offset + size] = np.full(size // pattern.nbytes, pattern).view(np.uint8)
        return copy(queue, buffer, whole)

    copy_as_it_does = cl.enqueue_copy

    def copy(queue: Any, target: Any, source: Any, **options: Any) -> Any:
        if "region" not in options:
            return copy_as_it_does(queue, target, source, **options)
        width, rows = options["region"][:2]
        old = np.zeros(source.size, np.uint8)
        copy_as_it_does(queue, old, source)
        if isinstance(target, np.ndarray):
            (pitch,) = options["buffer_pitches"]
            starts = pitch * np.arange(rows)[:, np.newaxis] + np.arange(width)
            target.reshape(-1).view(np.uint8)[:] = old[starts].reshape(-1)
            return None
        new = np.zeros(target.size, np.uint8)
        new.reshape(rows, -1)[:, :width] = old.reshape(rows, -1)[:, :width]
        return copy_as_it_does(queue, target, new)

    # It is asked whether it is NVIDIA's, whenever a kernel is made.
    for place, name, other in (
        (cl, "Buffer", keep),
        (cl, "enqueue_copy", copy),
        (cl, "enqueue_fill_buffer", fill),
        (build, "program_source", _text),
        (pyopencl.characterize, "nv_compute_capability", lambda device: None),
    ):
        setattr(place, name, other)


if __name__ == "__main__":
    main(sys.argv[1])
