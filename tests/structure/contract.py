"""What the contract tests share: every row of the registry, and a scene that has all of it."""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, trace_compiled

import photizon_cl as pz
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import SceneError
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.files import load
from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.registry import COATINGS, ELEMENTS, SCATTERS, SOURCES, SURFACES

if TYPE_CHECKING:
    from oracles.engine import Traced

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))

from photizon_docs.examples import example, guess  # noqa: E402

GROUPS = {
    "element": ELEMENTS, "surface": SURFACES, "source": SOURCES, "scatter": SCATTERS,
    "coating": COATINGS,
}  # fmt: skip
ROWS = [(group, kind) for group, kinds in GROUPS.items() for kind in kinds]
every_kind = pytest.mark.parametrize(("group", "kind"), ROWS, ids=[f"{g}-{k}" for g, k in ROWS])
every_effect = pytest.mark.parametrize("effect", EFFECTS, ids=[e.name for e in EFFECTS])
ALL_EFFECTS = frozenset(effect.name for effect in EFFECTS)


@cache
def shown(group: str, kind: str) -> pz.Scene:
    """Return the scene of a kind's own page."""
    return example(group, kind, GROUPS[group][kind])


def of_kind(scene: pz.Scene, group: str, kind: str) -> Any:
    """Return the first thing of a kind in a scene."""
    things = {
        "element": scene.element, "source": scene.source,
        "surface": [e.surface for e in scene.element],
        "scatter": [e.surface.lobe for e in scene.element if e.surface.lobe is not None],
        "coating": [e.surface.coat for e in scene.element if e.surface.coat is not None],
    }[group]  # fmt: skip
    return next(thing for thing in things if thing.kind == kind)


WIDE = 8
"""What one lane is compared with; 16 builds for half a minute, and are among the slow tests."""


def named(name: str) -> pz.Scene:
    """Return `everything`, a preset, or what the page of a ``group-kind`` shows."""
    if name == "everything":
        return everything()
    return load(name) if name in preset_names() else shown(*name.split("-", 1))


@cache
def traced(name: str, lanes: int, force: frozenset[str] = frozenset()) -> Traced:
    """Trace a scene by name once."""
    made = compiled(named(name), force, rays_per_batch=2048 if name == "everything" else 256)
    return trace_compiled(made, plan=PLAN.with_(lanes=lanes, refill=max(lanes // 4, 1)))


def same_cells(found: Traced, plain: Traced) -> bool:
    """Say whether all cells but those of effects that only `found` has are the same bits."""
    groups = {group.effect for group in plain.compiled.layout.groups}
    keep = np.ones(len(found.cells), bool)
    for group in found.compiled.layout.groups:
        if group.effect not in groups:
            keep[group.first : group.first + math.prod(group.shape)] = False
    layout = found.compiled.layout
    if layout.parts and not plain.compiled.layout.parts:
        keep[layout.divided : layout.divided + layout.n_rows * layout.parts] = False
    return found.cells[keep].tobytes() == plain.cells.tobytes()


def turned(kind: str) -> Any:
    """Return a kind's element off the axes, with a hole where it can have one."""
    element = of_kind(shown("element", kind), "element", kind)
    hole = {"inner_radius": 0.02} if "inner_radius" in parameters_of(type(element)) else {}
    return replace(element, position=(0.1, -0.2, 0.3), tilt_deg=(20.0, 30.0), **hole)


# -- all at once -----------------------------------------------------------------------------------


@cache
def everything() -> pz.Scene:
    """Return a scene with every element, surface and source, turned, in a room that lights them.

    There are two wavelengths.

    Elements stand on a grid, wide enough that none touch; sources in the middles of its cells,
    with shares that are not their fluxes'. What can have a map has one, and a ladder.
    """
    black = {
        "surface": pz.Absorber(),
        "detector": pz.Detector(map=(5, 3), generations=4, wavelengths=True),
    }
    shapes = [of_kind(shown("element", kind), "element", kind) for kind in ELEMENTS]
    rest = [kind for kind in SURFACES if kind != "absorber"]
    rest.sort(key=lambda kind: not SURFACES[kind].refracts)
    unused, elements = list(rest), []
    for shape in shapes:
        if shape.has_map:
            elements.append(replace(shape, **black))
            continue
        thing, kind = next(
            (made, k) for k in (*unused, *rest) if (made := with_surface(shape, k)) is not None
        )
        elements.append(thing)
        unused = [k for k in unused if k != kind]
    flat = next(shape for shape in shapes if shape.kind == "rectangle")
    elements += [replace(flat, detector=None, surface=surface(kind)) for kind in unused]
    # and one more of glass, which has a medium where others have an index
    kind = next(kind for kind in SURFACES if SURFACES[kind].refracts)
    body = next(made for shape in shapes if (made := with_surface(shape, kind)) and not shape.flat)
    elements.append(replace(body, surface=SURFACES[kind](medium="glass")))
    # what scatters, on every surface that takes a lobe in turn
    takers = [kind for kind in SURFACES if "scatter" in parameters_of(SURFACES[kind])]
    for n, cls in enumerate(SCATTERS.values()):
        optics = replace(surface(takers[n % len(takers)]), scatter=cls(**guess(cls)))
        elements.append(replace(flat, detector=None, surface=optics))
    # and every coating on glass
    elements += [
        replace(flat, detector=None, surface=replace(surface(kind), coating=cls(**guess(cls))))
        for cls in COATINGS.values()
    ]
    step = 2.2 * max(shape.reach for shape in shapes)
    side = range(-1, 2)
    places = sorted(itertools.product(side, side, side), key=lambda p: sum(map(abs, p)))
    assert len(elements) <= len(places), "the grid is full: make it larger"
    stand = [
        replace(element, name=f"{n} {element.kind}", position=tuple(step * x for x in place),
                tilt_deg=(20.0 * n % 360.0, 30.0) if n % 2 else (0.0, 0.0))
        for n, (element, place) in enumerate(zip(elements, places, strict=False))
    ]  # fmt: skip
    room = pz.Sphere(
        name="room", position=(0.0, 0.0, 0.0), axis="+z", radius=3.0 * step, port_fraction=0.05,
        surface=pz.Lambertian(reflectance=pz.Curve([400.0, 700.0], [0.95, 0.94])),
    )  # fmt: skip
    cells = list(itertools.product((-0.5, 0.5), repeat=3))
    assert len(SOURCES) <= len(cells), "more sources than cells: find them another place"
    sources = []
    for n, (kind, cls) in enumerate(SOURCES.items()):
        place = {"name": kind, "flux": 1.0 + n, "position": tuple(step * x for x in cells[n])}
        turned = {"axis": "+x", "tilt_deg": (10.0 * n, 20.0)} if cls.directed else {}
        sources.append(cls(**{**guess(cls), **place, **turned, "share": 1.0 + n % 3}))
    return pz.Scene(
        name="everything",
        run=pz.RunSettings(generation_cap=60, roulette_floor=0.05),
        far_field=pz.FarField(n_mu=4, n_phi=6),
        importance=pz.Importance(toward=[stand[0].name, stand[-1].name], fraction=0.25),
        spectrum=pz.Spectrum([450.0, 650.0]),
        medium=(
            pz.Medium(
                "glass", absorption_per_m=1.0 / step, dispersion=pz.Cauchy(A=1.5046, B_um2=0.0042)
            ),
        ),
        source=tuple(sources),
        element=(*stand, room),
    )


def surface(kind: str) -> Any:
    """Return a surface of a kind, with the values of its page where they are asked for."""
    return SURFACES[kind](**guess(SURFACES[kind]))


def with_surface(element: Any, kind: str) -> Any:
    """Return an element with another surface and no detector; None where it takes none such."""
    try:
        return replace(element, surface=surface(kind), detector=None)
    except SceneError:
        return None


@cache
def followed() -> pz.Paths:
    """Return the paths of some rays through the scene of everything."""
    return pz.paths(everything(), rays=2048)
