"""Valid parameters at the ends of their ranges: refused, or compiled, described and drawn."""

from __future__ import annotations

import math
import random
import warnings
from typing import Any

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import SceneError
from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.parameters import LARGEST, SMALLEST, Integer, Number, SignedRadius
from photizon_cl.scene.registry import ELEMENTS, SOURCES, SURFACES

COMMON = {"name", "position", "axis", "tilt_deg", "surface", "detector", "flux", "share"}
PURE = (0.0, 1.0, -1.0, 0.5, -1.0 - 2.0**-52, -1.0 + 2.0**-53, 1e-17, 1.0 - 2.0**-53, 89.99)
DENSITIES = {"irradiance", "radiance", "radiant exitance", "radiant intensity", "intensity"}
"""Of the largest flux from the least area they are infinite."""


def drawn(cls: Any, r: random.Random, size: float, **more: Any) -> Any:
    """Return an object with parameters near `size`, or anywhere, or at the ends of their ranges."""
    values: dict[str, Any] = {}
    for name, p in parameters_of(cls).items():
        if isinstance(p, SignedRadius):
            near, far = size * 10 ** r.uniform(-3, 3), 10 ** r.uniform(-150, 150)
            length = r.choice([near, near, size, far, SMALLEST, LARGEST])
            values[name] = r.choice([length, -length, math.inf])
        if name in COMMON or not isinstance(p, Number | Integer):
            continue
        low, high = p._low, p._high
        if isinstance(p, Integer):
            values[name] = r.choice([low, 3])
        elif p.unit == "m":
            near, far = size * 10 ** r.uniform(-3, 3), 10 ** r.uniform(-150, 150)
            values[name] = r.choice([near, near, size, far, low, SMALLEST, LARGEST])
        else:
            inner = (math.nextafter(low, high), math.nextafter(high, low), r.uniform(low, high))
            values[name] = r.choice([low, high, *inner, *PURE])
    if "port_radius" in values:  # one of the two
        del values[r.choice(["port_fraction", "port_radius"])]
    curved = [values[k] for k in ("curvature_radius", "front_radius", "back_radius") if k in values]
    if curved and r.random() < 0.5:
        values["aperture_radius"] = min(min(map(abs, curved)), LARGEST) * r.choice(
            [1.0, 0.5, 1e-8, 1e-100]
        )
    return cls(**values, **more)


def scene(r: random.Random, number: int) -> pz.Scene:
    """Return a scene of a few elements, each kind in turn."""
    size = 10 ** r.choice([r.uniform(-150, 150), r.uniform(-3, 3), 150.0, -150.0])
    elements = []
    for i in range(r.choice([1, 2, 3])):
        kind = list(ELEMENTS.values())[(number + i) % len(ELEMENTS)]
        surface = drawn(r.choice(list(SURFACES.values())), r, 1.0)
        elements.append(
            drawn(
                kind, r, size, name=f"e{i}", surface=surface, axis=r.choice(["+z", "-x"]),
                position=tuple(r.choice([0.0, size, r.uniform(-size, size)]) for _ in range(3)),
                tilt_deg=r.choice([(0.0, 0.0), (30.0, -50.0)]),
            )
        )  # fmt: skip
    cls = r.choice(list(SOURCES.values()))
    more = {"axis": "-z"} if cls.directed else {}
    flux = r.choice([1.0, SMALLEST, LARGEST])
    source = drawn(cls, r, size, name="s", flux=flux, position=(0.0, 0.0, size), **more)
    return pz.Scene(name="x", source=(source,), element=tuple(elements))


@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(n, marks=pytest.mark.slow) for n in range(3, 8))]
)
def test_what_is_valid_compiles_and_has_numbers(seed: int) -> None:
    r, built, kinds = random.Random(seed), 0, set()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(500):
            try:
                made = scene(r, number)
            except SceneError:
                continue
            built += 1
            kinds |= {e.kind for e in made.element}
            compile_scene(made, made.run)
            pz.advisories(made)
            things: list[Any] = [*made.source]
            for e in made.element:
                things += [e, e.surface]
                row = e.packed(tuple(map(abs, e.position)), e.class_axis)
                assert np.isfinite(list(row.values())).all(), e
                assert not any(np.isnan(line).any() for line in (*edges(e), *facets(e))), e
                cut(e, 0, e.position[0])
            for thing in things:
                for name, (value, _) in getattr(thing, "derived", dict)().items():
                    infinite = name in DENSITIES or name == "sphere multiplier"
                    assert math.isfinite(value) or (infinite and value > 0.0), (thing, name)
    assert built >= 50
    assert kinds == set(ELEMENTS)
