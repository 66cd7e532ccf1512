"""The same scene turned, scaled or moved: the same tallies, to the bit where numbers are exact."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from oracles import scenes, tracer
from oracles.engine import scene_of, trace
from oracles.scenes import AXES, BLACK, beam, cube, matt, wall

from photizon_cl.scene.files import load

if TYPE_CHECKING:
    from collections.abc import Callable

    from oracles.engine import Traced

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

LENGTHS = ("radius", "half_width", "half_height")


def changed(tables: dict[str, Any], change: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Return tables with every source and element changed in place."""
    out = copy.deepcopy(tables)
    for row in (*out["source"], *out.get("element", [])):
        change(row)
    return out


def scaled(tables: dict[str, Any], factor: float) -> dict[str, Any]:
    """Return a scene in other units of length."""

    def change(row: dict[str, Any]) -> None:
        row["position"] = [factor * x for x in row["position"]]
        row.update({key: factor * row[key] for key in LENGTHS if key in row})

    return changed(tables, change)


def moved(tables: dict[str, Any], shift: list[float]) -> dict[str, Any]:
    """Return a scene elsewhere."""

    def change(row: dict[str, Any]) -> None:
        row["position"] = [x + s for x, s in zip(row["position"], shift, strict=True)]

    return changed(tables, change)


def turned(tables: dict[str, Any]) -> dict[str, Any]:
    """Return a scene turned so that +x goes to +y, +y to +z and +z to +x."""

    def change(row: dict[str, Any]) -> None:
        x, y, z = row["position"]
        row["position"] = [z, x, y]
        if "axis" in row:
            row["axis"] = row["axis"].translate(str.maketrans("xyz", "yzx"))

    return changed(tables, change)


def tables_of(name: str, **run: Any) -> dict[str, Any]:
    """Return tables of a preset or of `everything`, few rays."""
    tables = scenes.everything() if name == "everything" else load(name).to_dict()
    tables["run"].update({"rays_per_batch": 1000, "generation_cap": 60, **run})
    if name == "everything":
        tables["run"]["generation_cap"] = 9
    return tables


NAMES = ("integrating-sphere", "ghost-ladder", "box-room", "everything")


@pytest.mark.parametrize("power", [-100, -20, -1, 20, 100])
@pytest.mark.parametrize("name", NAMES)
def test_a_scale_of_a_power_of_two_changes_no_bit(name: str, power: int) -> None:
    tables = tables_of(name)
    assert trace(load(scaled(tables, 2.0**power))).digest == trace(load(tables)).digest


def dyadic(tables: dict[str, Any]) -> dict[str, Any]:
    """Return a scene with its positions rounded to 2^-12."""

    def change(row: dict[str, Any]) -> None:
        row["position"] = [round(x * 4096) / 4096 for x in row["position"]]

    return changed(tables, change)


@pytest.mark.parametrize("shift", [[2.0**26, 0.0, 0.0], [-(2.0**30), 2.0**26, 2.0**27]])
@pytest.mark.parametrize("name", NAMES)
def test_a_scene_far_away_has_the_same_bits(name: str, shift: list[float]) -> None:
    """Positions that both places represent exactly, moved by 2^20 and more of its sizes."""
    near = dyadic(tables_of(name))
    assert trace(load(moved(near, shift))).digest == trace(load(near)).digest


def close(a: Traced, b: Traced) -> None:
    """Assert equal counts and amounts that agree to 1e-12 of what was emitted."""
    assert a.interactions == b.interactions
    n = a.compiled.layout.far_field
    assert a.cells[:n, 3].tolist() == b.cells[:n, 3].tolist()
    for cell in range(n):
        assert abs(a.amount(cell) - b.amount(cell)) < 1e-12 * a.emitted


def test_moving_by_an_odd_length_changes_rounding_only() -> None:
    near = tables_of("ghost-ladder")
    close(trace(load(moved(near, [1e5 / 3, -7e4 / 9, 1e6 / 7]))), trace(load(near)))


def test_black_flat_scenes_have_the_same_bits_however_the_axes_are_named() -> None:
    """Nothing but axis frames: a turn by permutation is exact, map and ladder included."""
    tables = tables_of("cosine-fourth")
    del tables["far_field"]
    once = turned(tables)
    twice = turned(once)
    digests = {trace(load(t)).digest for t in (tables, once, twice)}
    assert len(digests) == 1


@pytest.mark.parametrize("axis", AXES)
def test_every_axis_gives_the_same_bits(axis: str) -> None:
    """The same beam, target and map about each of the six axes."""
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))

    def built(u: np.ndarray, v: np.ndarray, w: np.ndarray, axis: str) -> Traced:
        target = {**wall(tuple(0.25 * w), axis, 1.0), "half_height": 0.5, **BLACK}
        target["position"] = (0.25 * w + 0.5 * u - 0.125 * v).tolist()
        target["detector"] = {"map": [7, 5], "generations": 3}
        lamp = {"kind": "cosine-point", "flux": 1.0, "axis": axis.translate(MIRRORED)}
        return trace(scene_of([{**lamp, "position": (2.0 * w).tolist()}], [target]))

    there = built(u, v, w, axis)
    # the lamp's own u and v change places with those of the target: so they do at +z
    here = built(*(np.array(tracer.axis_vector(name)) for name in ("+x", "+y", "+z")), "+z")
    assert there.digest == here.digest


MIRRORED = str.maketrans("+-", "-+")


def test_a_turned_room_of_mirrors_and_plates_agrees_to_rounding() -> None:
    tables = tables_of("ghost-ladder", rays_per_batch=100)
    once = turned(tables)
    want = trace(load(tables))
    for found in (trace(load(once)), trace(load(turned(once)))):
        close(found, want)


def test_a_turned_diffuse_room_has_the_same_power_within_errors() -> None:
    """Scattering bases are not turned along: equal in law only (z below 5, fixed seed)."""
    lamp = {"kind": "cosine-point", "flux": 1.0, "position": [0.1, -0.2, 0.9], "axis": "-z"}
    walls = cube(matt(0.6))
    walls[4].update(BLACK)
    room = {"source": [lamp], "element": walls}
    rays = 1 << 16
    a = trace(scene_of(room["source"], room["element"]), rays_per_batch=rays)
    b = trace(scene_of(**_parts(turned(room))), rays_per_batch=rays)
    found, want = (float(t.absorbed("element 4") / rays) for t in (b, a))
    assert found != want
    assert abs(found - want) < 5.0 * (2.0 * 0.25 / rays) ** 0.5


def _parts(tables: dict[str, Any]) -> dict[str, Any]:
    return {"sources": tables["source"], "elements": tables["element"]}


def lit_bin(row: dict[str, Any], start: np.ndarray, towards: str) -> tuple[int, int]:
    """Return (i along u or φ, j along v or cos θ) of the bin that a thin beam lights."""
    lamp = beam(tuple(start.tolist()), towards)
    found = trace(scene_of([lamp], [row]), rays_per_batch=8)
    counts = found.detector("element 0").map_counts
    (j, i), *more = np.argwhere(counts).tolist()
    assert not more
    assert counts[j, i] == 8
    return i, j


@pytest.mark.parametrize(
    ("kind", "axis"),
    [
        pytest.param(
            kind, axis, marks=pytest.mark.slow if kind == "disk" and axis[1] != "z" else ()
        )
        for kind in ("rectangle", "disk")
        for axis in AXES
    ],
)
def test_maps_of_flats_run_along_u_then_v(kind: str, axis: str) -> None:
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))
    centre = np.array([0.3, -0.2, 0.1])
    half = (1.0, 0.5) if kind == "rectangle" else (1.0, 1.0)
    shape = {"half_width": 1.0, "half_height": 0.5} if kind == "rectangle" else {"radius": 1.0}
    row = {"kind": kind, "axis": axis, "position": centre.tolist(), **shape, **BLACK}
    row["detector"] = {"map": [8, 4]}
    for i, j in ((4, 1), (6, 2), (2, 1), (5, 3), (3, 0)):
        at = half[0] * (2 * i + 1 - 8) / 8 * u + half[1] * (2 * j + 1 - 4) / 4 * v
        assert lit_bin(row, centre + at + w, axis.translate(MIRRORED)) == (i, j)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("side", ["outside", "inside"])
def test_maps_of_spheres_run_along_phi_then_cos_theta(side: str, axis: str) -> None:
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))
    centre = np.array([0.3, -0.2, 0.1])
    row = {"kind": "sphere", "axis": axis, "position": centre.tolist(), "radius": 1.0, **BLACK}
    row["detector"] = {"map": [8, 5], "side": side}
    # beams along each of ±u, ±v at some height; from inside from the axis, from outside from far
    for direction, phi in ((u, 0), (v, 2), (-u, 4), (-v, 6)):
        for height, j in ((-0.7, 0), (-0.3, 1), (0.1, 2), (0.5, 3), (0.9, 4)):
            # a little to the left of the direction, so that phi is inside the bin
            left = np.cross(w, direction)
            r = np.sqrt(1.0 - height * height)
            name = next(n for n in AXES if np.array_equal(tracer.axis_vector(n), direction + 0.0))
            if side == "inside":
                start = centre + height * w + 0.1 * r * left
                assert lit_bin(row, start, name) == (phi, j)
            else:
                start = centre + height * w + 0.1 * r * left + 3.0 * direction
                assert lit_bin(row, start, name.translate(MIRRORED)) == (phi, j)
