"""Scale, translation and permutation of the axes change nothing, for all seven elements.

And no absolute tolerance stands in the kernels.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, glass, mirror

from hostcode.assets import kernels_dir

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from oracles.engine import Traced

AXES = "xyz"
LENGTHS = {
    "radius",
    "half_width",
    "half_height",
    "length",
    "clear_half_width",
    "exit_radius",
    "curvature_radius",
    "front_radius",
    "back_radius",
    "aperture_radius",
}
LEVEL, LEAN = (0.0, 0.0), (30.0, -50.0)


def rows(tilt: tuple[float, float]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return sources and elements, one of each kind; all positions are short binary fractions."""
    lamp = {
        "kind": "lambertian-disk",
        "flux": 1.0,
        "position": [0.0, 0.0, 0.0],
        "axis": "+z",
        "radius": 0.25,
    }
    beam = {
        "kind": "collimated-disk",
        "flux": 1.0,
        "position": [0.125, 0.25, -1.0],
        "axis": "+x",
        "radius": 0.5,
    }
    elements: list[dict[str, Any]] = [
        {
            "kind": "rectangle",
            "position": [0.0, 0.0, -1.75],
            "half_width": 1.5,
            "half_height": 2.0,
            **mirror(0.9),
        },
        {"kind": "disk", "position": [2.25, 0.25, -0.5], "radius": 1.0, **BLACK},
        {"kind": "sphere", "position": [-2.0, 0.0, 0.5], "radius": 0.75, **glass(1.5)},
        {
            "kind": "sphere",
            "position": [0.0, 2.5, 1.0],
            "radius": 1.0,
            "port_fraction": 0.25,
            **mirror(0.8),
        },
        {
            "kind": "cpc",
            "position": [0.0, -3.0, 1.0],
            "exit_radius": 0.5,
            "acceptance_deg": 40.0,
            **mirror(0.95),
        },
        {
            "kind": "baffled-tube",
            "position": [0.0, 0.0, 1.75],
            "half_width": 0.5,
            "length": 2.0,
            "baffles": 2,
            "clear_half_width": 0.25,
            **mirror(0.7),
        },
        {
            "kind": "plano-convex",
            "position": [1.5, -1.5, 0.75],
            "curvature_radius": 1.5,
            "aperture_radius": 0.75,
            **glass(1.7),
        },
        {
            "kind": "biconvex",
            "position": [0.125, 0.0, 0.75],
            "front_radius": 1.5,
            "back_radius": 2.0,
            "aperture_radius": 0.75,
            **glass(1.5),
        },
    ]
    for element in elements:
        element |= {"axis": "+z", "tilt_deg": list(tilt)}
    elements[1] |= {"axis": "-x"}
    return [lamp, beam], elements


def run(change: Callable[[dict[str, Any]], None], tilt: tuple[float, float]) -> Traced:
    sources, elements = rows(tilt)
    for row in (*sources, *elements):
        change(row)
    return trace(scene_of(sources, elements), rays_per_batch=4000, generation_cap=8)


def amounts(traced: Traced) -> np.ndarray:
    names = [element.name for element in traced.compiled.scene.element]
    found = [float(traced.absorbed(name) / traced.emitted) for name in names]
    return np.array([*found, float(traced.escaped / traced.emitted)])


def scaled(k: float) -> Callable[[dict[str, Any]], None]:
    def change(row: dict[str, Any]) -> None:
        row["position"] = [k * x for x in row["position"]]
        row |= {key: k * row[key] for key in LENGTHS & set(row)}

    return change


def moved(by: Sequence[float]) -> Callable[[dict[str, Any]], None]:
    def change(row: dict[str, Any]) -> None:
        row["position"] = [x + d for x, d in zip(row["position"], by, strict=True)]

    return change


def permuted(turns: int) -> Callable[[dict[str, Any]], None]:
    """Return a turn of the scene that takes x to y to z to x."""

    def change(row: dict[str, Any]) -> None:
        x = row["position"]
        row["position"] = [x[(i - turns) % 3] for i in range(3)]
        sign, axis = row["axis"]
        row["axis"] = sign + AXES[(AXES.index(axis) + turns) % 3]

    return change


def nothing(row: dict[str, Any]) -> None:
    pass


@pytest.mark.parametrize(
    "tilt",
    [pytest.param(LEVEL, marks=pytest.mark.slow, id="level"), pytest.param(LEAN, id="tilted")],
)
def test_scale_changes_nothing(tilt: tuple[float, float]) -> None:
    plain = run(nothing, tilt)
    assert min(amounts(plain)[[0, 1, 3, 4, 5]]) > 1e-4  # every wall is lit
    for power in (-20, 20):
        assert run(scaled(2.0**power), tilt).digest == plain.digest
    for power in (-6, 6):
        other = run(scaled(10.0**power), tilt)
        assert np.abs(amounts(other) - amounts(plain)).max() < 1e-12
        assert other.interactions == plain.interactions


# what rounding may decide is more where faces are tilted
@pytest.mark.parametrize(
    "tilt",
    [pytest.param(LEVEL, marks=pytest.mark.slow, id="level"), pytest.param(LEAN, id="tilted")],
)
def test_a_scene_a_million_sizes_away_is_the_same(tilt: tuple[float, float]) -> None:
    plain = run(nothing, tilt)
    for by in ((2.0**22, 0.0, 0.0), (-(2.0**22), 2.0**23, 2.0**22)):
        other = run(moved(by), tilt)
        assert np.abs(amounts(other) - amounts(plain)).max() < 1e-12
        assert other.interactions == plain.interactions


# level faces of all axes are in the contract tests and the corners
@pytest.mark.parametrize(
    "tilt",
    [pytest.param(LEVEL, id="level", marks=pytest.mark.slow), pytest.param(LEAN, id="tilted")],
)
def test_permuted_axes_change_nothing(tilt: tuple[float, float]) -> None:
    plain = run(nothing, tilt)
    for turns in (1, 2):
        other = run(permuted(turns), tilt)
        assert np.abs(amounts(other) - amounts(plain)).max() < 1e-12
        assert other.interactions == plain.interactions


LITERAL = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)[eE]-\d+|0x[\da-fA-F.]+p-\d+")
ALLOWED = {
    "prelude.mako": {
        "0x1p-53",
        "0x1p-24",
    },  # unit roundoffs: bounds are multiples of one and a size
    "effects/acceleration.mako": {"0x1p-42"},  # relative: times coordinates
    "effects/importance.mako": {"0x1.45f306dc9c883p-3"},  # 1/(2 pi) per steradian
    "lib/directions.mako": {"0x1.45f306dc9c883p-2"},  # 1/pi per steradian
}
COEFFICIENTS = {
    "lib/angles.mako",
    "lib/elementary.mako",
    "lib/powers.mako",
    "lib/philox.mako",
    "lib/limbs.mako",
    "lib/ledger.mako",
    "stages/selftest.mako",
}
"""Polynomials, and units of draws and of exact tallies: no geometry."""


def test_no_absolute_tolerance_in_the_kernels() -> None:
    """Small literals outside polynomial coefficients are the unit roundoff, times sizes, alone."""
    found = []
    for path in sorted(kernels_dir().rglob("*.mako")):
        name = path.relative_to(kernels_dir()).as_posix()
        if name in COEFFICIENTS:
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            code = line.split("//")[0]
            small = [m.group(0) for m in LITERAL.finditer(code)]
            bad = [x for x in small if x not in ALLOWED.get(name, set())]
            bad += re.findall(r"(?<![\w.])0\.0{2,}\d+", code)
            bad += re.findall(r"(?i)\b(?:EPS(?:ILON)?|DBL_EPSILON|TOLERANCE)\b", code)
            found += [f"{name}:{number}: {x}" for x in bad]
    assert found == []
