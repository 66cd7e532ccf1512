"""Counting surfaces in the place of others, of every kind: nothing missed, nothing twice."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from oracles.engine import scene_of, trace
from oracles.scenes import BLACK, beam, glass, matt, mirror

from photizon_cl.scene.registry import ELEMENTS

if TYPE_CHECKING:
    from collections.abc import Iterable

pytestmark = pytest.mark.usefixtures("built_quickly")

CLEAR = {"surface": {"kind": "clear"}}
KINDS: dict[str, tuple[dict[str, Any], tuple[float, float, float], tuple[float, float, float]]] = {
    "rectangle": ({"half_width": 0.5, "half_height": 0.4}, (0, 0, 0.3), (0, 0, -0.3)),
    "disk": ({"radius": 0.5, "inner_radius": 0.1}, (0, 0.1, 0.3), (0, 0, -0.3)),
    "sphere": ({"radius": 0.5, "port_fraction": 0.1}, (0, 0.1, -0.9), (0, 0.1, 0.1)),
    "cylinder": ({"radius": 0.5, "length": 0.6}, (0, 0.9, 0.2), (0, 0.1, 0.2)),
    "cone": (
        {"entrance_radius": 0.5, "exit_radius": 0.3, "length": 0.6}, (0, 0.9, 0.2), (0, 0.1, 0.2),
    ),
    "conic": (
        {"curvature_radius": 1.0, "conic_constant": -1.0, "aperture_radius": 0.5,
         "inner_radius": 0.1},
        (0, 0.1, -0.4), (0, 0.1, 0.4),
    ),
    "cpc": ({"exit_radius": 0.2, "acceptance_deg": 30.0}, (0.9, 0.5, 0.2), (0, 0.1, 0.2)),
    "baffled-tube": (
        {"half_width": 0.5, "length": 0.6, "baffles": 2, "clear_half_width": 0.3},
        (0, 0.9, 0.2), (0, 0.1, 0.3),
    ),
    "plano-convex": (
        {"curvature_radius": 0.8, "aperture_radius": 0.4}, (0, 0.1, 0.5), (0, 0.02, 0.03),
    ),
    "biconvex": (
        {"front_radius": 0.8, "back_radius": 0.7, "aperture_radius": 0.4},
        (0, 0.1, 0.5), (0, 0.02, 0.03),
    ),
    "lens": (
        {"front_radius": -0.8, "back_radius": 0.7, "thickness": 0.2, "aperture_radius": 0.4},
        (0, 0.1, 0.5), (0, 0.02, 0.03),
    ),
}  # fmt: skip
"""Parameters, and where a lamp stands on either side, with the axis along +z."""
MAPS = ("rectangle", "disk", "sphere", "cylinder")
APART = 100.0


def sides(kind: str) -> tuple[str, str]:
    return ("front", "back") if ELEMENTS[kind].flat else ("outside", "inside")


def lamps(kinds: Iterable[str]) -> list[dict[str, Any]]:
    """One on each side of every element."""
    return [
        {"kind": "isotropic-point", "flux": 1.0, "position": [APART * n + x, y, z]}
        for n, kind in enumerate(KINDS)
        if kind in kinds
        for x, y, z in KINDS[kind][1:]
    ]


def element(kind: str, name: str, surface: dict[str, Any], side: str | None = None) -> Any:
    n = list(KINDS).index(kind)
    made = {"kind": kind, "name": name, "position": [APART * n, 0, 0], "axis": "+z"}
    if side is not None:
        made["detector"] = {"side": side, "generations": 14}
        if kind in MAPS:
            made["detector"]["map"] = [3, 2]
    return {**made, **KINDS[kind][0], **surface}


def covered(surfaces: dict[str, dict[str, Any]], first: bool) -> list[dict[str, Any]]:
    """Every kind, and in its place two clear ones that count either side, named before or after."""
    found = []
    for kind, surface in surfaces.items():
        planes = [element(kind, f"{kind} {side}", CLEAR, side) for side in sides(kind)]
        found += [*planes, element(kind, kind, surface)] if first else [
            element(kind, kind, surface), *planes
        ]  # fmt: skip
    return found


SOME = ("disk", "sphere", "conic")
"""What the suite always looks at: flat, a ball with a port, a sheet; a program of every kind is
slow to build."""
EVERY = pytest.param(tuple(KINDS), marks=pytest.mark.slow, id="every kind")


def run(kinds: tuple[str, ...]) -> dict[str, int]:
    return {"rays_per_batch": 300 * 2 * len(kinds), "generation_cap": 12}


def test_every_kind_is_here() -> None:
    assert set(KINDS) == set(ELEMENTS)


@pytest.mark.parametrize("kinds", [pytest.param(SOME, id="some"), EVERY])
@pytest.mark.parametrize("first", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_before_a_black_one_they_count_what_its_own_detector_does(
    first: bool, kinds: tuple[str, ...]
) -> None:
    black = dict.fromkeys(kinds, BLACK)
    found = trace(scene_of(lamps(kinds), covered(black, first)), **run(kinds))
    for which in (0, 1):
        alone = [element(k, k, BLACK, sides(k)[which]) for k in kinds]
        own = trace(scene_of(lamps(kinds), alone), **run(kinds))
        assert found.escaped == own.escaped
        assert found.interactions == own.interactions
        for kind in kinds:
            plane, detector = found.detector(f"{kind} {sides(kind)[which]}"), own.detector(kind)
            assert found.absorbed(kind) == own.absorbed(kind) > 0, kind
            assert (plane.power, plane.count) == (detector.power, detector.count), kind
            assert plane.ladder == detector.ladder, kind
            if kind in MAPS:
                assert (plane.map_counts == detector.map_counts).all(), kind
                assert plane.map_total == plane.power
    for kind in kinds:
        both = sum(found.detector(f"{kind} {side}").power for side in sides(kind))
        assert both == found.absorbed(kind), kind


@pytest.mark.slow
@pytest.mark.parametrize("first", [True, False])
def test_before_what_sends_half_back_they_count_arrivals_and_what_returns(first: bool) -> None:
    """Arrivals A, returned A/2, absorbed A/2: in all 3 A/2, less what the cap ends there."""
    kinds = tuple(KINDS)
    surfaces = {k: (mirror(0.5), matt(0.5))[n % 2] for n, k in enumerate(kinds)}
    bare = [element(k, k, s) for k, s in surfaces.items()]
    found = trace(scene_of(lamps(kinds), covered(surfaces, first)), **run(kinds))
    plain = trace(scene_of(lamps(kinds), bare), **run(kinds))
    counted = absorbed = 0
    for kind in kinds:
        assert found.absorbed(kind) == plain.absorbed(kind) > 0
        counted += sum(found.detector(f"{kind} {side}").power for side in sides(kind))
        absorbed += found.absorbed(kind)
    assert counted == 3 * absorbed - found.depth_capped
    assert (found.escaped, found.interactions) == (plain.escaped, plain.interactions)
    assert found.depth_capped == plain.depth_capped


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_on_a_face_of_glass_they_lie_outside(order: tuple[int, ...]) -> None:
    """From outside: the beam, and what is reflected. From inside: only what leaves the glass."""
    pose = {"kind": "disk", "position": [0, 0, 0], "axis": "+z", "radius": 0.5}
    faces = [
        {**pose, "name": "face", **glass(1.5)},
        {**pose, "name": "in", **CLEAR, "detector": {"side": "front", "map": [2, 2]}},
        {**pose, "name": "out", **CLEAR, "detector": {"side": "back", "map": [2, 2]}},
    ]
    for axis, start in (("-z", 1.0), ("+z", -1.0)):
        lamp = beam((0.01, 0.01, start), axis, 1e-3)
        scene = scene_of([lamp], [faces[n] for n in order], far_field={"n_mu": 2, "n_phi": 1})
        found = trace(scene, rays_per_batch=64)
        down, up = found.far_field
        into, out = found.detector("in"), found.detector("out")
        assert out.power == up
        assert into.power == (64 if axis == "-z" else 0)
        assert float(down + up) == pytest.approx(64.0, rel=1e-14)
        assert (into.map_total, out.map_total) == (into.power, out.power)
        assert float(up if axis == "-z" else down) / 64 == pytest.approx(0.04, rel=1e-12)


def test_a_black_ball_in_a_clear_one_in_a_clear_one() -> None:
    """Three in one place, and light that passes one of them twice beside it."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5}
    around = {**ball, "radius": 0.8, **CLEAR}
    elements = [
        {**around, "name": "in", "detector": {"side": "outside", "map": [2, 2]}},
        {**ball, "name": "near", **CLEAR, "detector": {"side": "outside", "map": [2, 2]}},
        {**ball, "name": "ball", **BLACK},
        {**around, "name": "out", "detector": {"side": "inside", "map": [2, 2]}},
    ]
    lamps = [beam((0.6, 0, 1), "-z", 1e-3), beam((0, 0, 1), "-z", 1e-3)]
    found = trace(scene_of(lamps, elements), rays_per_batch=64)
    powers = {name: float(found.detector(name).power) for name in ("in", "near", "out")}
    assert powers == {"in": 64.0, "near": 32.0, "out": 32.0}
    assert (found.absorbed("ball"), found.escaped) == (32, 32)
    # what comes in through a half of the ball leaves through the other
    into, out = found.detector("in").map_counts, found.detector("out").map_counts
    assert into.sum(axis=1).tolist() == [0, 64]
    assert out.sum(axis=1).tolist() == [32, 0]
