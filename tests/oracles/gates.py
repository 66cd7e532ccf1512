"""Checks that a right engine passes and that a broken one of some kind fails.

Tests call them on the engine as it is; the mutants call them on engines broken on purpose. Each
raises AssertionError when it is not satisfied.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from oracles import compare, corners, curved, regions, scenes
from oracles.engine import (
    PLAN,
    compiled,
    probe,
    scene_of,
    trace,
    trace_compiled,
    with_tree,
)
from oracles.scenes import BLACK, beam, cube, glass, matt, mirror, wall
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.files import load
from photizon_cl.scene.surfaces.mirror import Mirror

if TYPE_CHECKING:
    from oracles.engine import Traced

GHOSTS = {
    "transmitted": {2: "0.9216", 4: "1.47456e-3", 6: "2.359296e-6"},
    "reflected": {1: "0.04", 3: "0.036864", 5: "5.89824e-5"},
}
"""T², T²R², T²R⁴ and R, T²R, T²R³ for R = 0.04 by generation, to the last digit."""


def closes(traced: Traced) -> None:
    """Every batch: |closure| ≤ 1e-15 of the flux; far field = escaped; ladder = map = power."""
    for closure in traced.closures():
        assert abs(closure) <= Fraction(1, 10**15)
    if traced.compiled.layout.n_mu:
        assert sum(traced.far_field) == traced.escaped
    for d in traced.compiled.layout.detectors:
        name = traced.compiled.scene.element[d.element].name
        detector = traced.detector(name)
        if d.n_generations:
            assert sum(detector.ladder) == detector.power
            assert sum(detector.ladder_counts) == detector.count
        if d.nx:
            assert detector.map_total == detector.power
            assert detector.map_counts.sum() == detector.count
        assert detector.power >= 0
        # what a surface lets pass is not taken
        if traced.compiled.scene.element[d.element].surface.counts:
            assert detector.power <= traced.absorbed(name)


def busy_room_closes() -> None:
    """Closure with roulette, several weights, a small cap and splitting at once."""
    closes(trace(load(scenes.random_scene(3)), rays_per_batch=2000))
    closes(trace("box-room", rays_per_batch=2000, generation_cap=5, roulette_floor=0.4))


def ghost_ladder(rays: int = 1 << 12) -> None:
    """Six orders to 1e-12, each at its generation, and nothing in between."""
    found = trace("ghost-ladder", rays_per_batch=rays)
    for name, orders in GHOSTS.items():
        detector = found.detector(name)
        for generation, power in enumerate(detector.ladder[:-1]):
            share = power / found.emitted
            if generation in orders:
                want = Fraction(orders[generation])
                assert abs(share - want) < want * Fraction(1, 10**12), (name, generation)
                assert detector.ladder_counts[generation] == rays
            elif generation % 2 != min(orders) % 2:
                assert share == 0, (name, generation)


def closed_cube(surface: dict[str, Any], rays: int = 1 << 16, cap: int = 160) -> Traced:
    """Nothing leaves a closed room of white walls; everything is alive at the cap."""
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, -0.2, 0.3]}
    scene = scene_of([lamp], cube(surface))
    found = trace(scene, rays_per_batch=rays, generation_cap=cap)
    assert found.escaped == 0
    assert found.interactions == rays * cap
    assert found.depth_capped == found.emitted
    return found


def generation_cap(cap: int) -> None:
    """With a cap of c exactly c interactions are made, and the rest is in the depth-capped row."""
    half = Fraction(1, 2)
    found = trace(scene_of([beam((0, 0, 0), "+z")], cube(mirror(0.5))), generation_cap=cap)
    rays = found.compiled.settings.rays_per_batch
    assert found.interactions == cap * rays
    assert found.count(found.compiled.layout.interactions) == cap * rays
    assert found.depth_capped == rays * half**cap
    ceiling, floor = found.absorbed("element 5"), found.absorbed("element 4")
    assert ceiling == rays * sum(half ** (k + 1) for k in range(0, cap, 2))
    assert floor == rays * sum(half ** (k + 1) for k in range(1, cap, 2))


def first_named_is_hit() -> None:
    """Of coincident faces the first named is hit, and only that one."""
    target = {**wall((0.0, 0.0, 0.0), "+z"), "name": "target", **BLACK}
    shiny = {**wall((0.0, 0.0, 0.0), "+z"), "name": "shiny", **mirror()}
    lamp = beam((0.0, 0.0, 1.0), "-z")
    found = trace(scene_of([lamp], [shiny, target]), rays_per_batch=64)
    assert (found.absorbed("target"), found.escaped) == (0, 64)
    found = trace(scene_of([lamp], [target, shiny]), rays_per_batch=64)
    assert (found.absorbed("target"), found.escaped) == (64, 0)
    assert found.interactions == 64


def rays_in_turn_keep_apart() -> None:
    """Rays that change places at every node and row, also in a corner: the plain scan's bits."""
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.1, 0.2, 0.3]}
    into_edge = beam((0.1, 0.2, 1.0), "-z", 1e-17)
    into_edge["position"][0] = -1.0
    ball = {"kind": "sphere", "radius": 0.3, "position": [0.3, -0.2, -0.4], "axis": "+z"}
    scene = scene_of([lamp, into_edge], [*cube(matt(0.9)), {**ball, **mirror(0.9)}])
    made = [
        compile_scene(scene, replace(scene.run, rays_per_batch=512), **with_tree(a))
        for a in (False, True)
    ]
    assert ["acceleration" in m.effects for m in made] == [False, True]
    want = trace_compiled(made[0])
    assert want.escaped == 0
    for lanes in (4, 8):
        plan = PLAN.with_(lanes=lanes, cached_bytes=1)
        assert trace_compiled(made[1], plan=plan).digest == want.digest


def contact_behind_glass() -> None:
    """A glass face in contact with an absorber: from behind its normal light passes it first."""
    for axis in ("+z", "-z"):
        plate = {**wall((0.0, 0.0, 0.0), axis), **glass(1.5, 1.5 if axis == "-z" else 1.0)}
        if axis == "-z":
            plate["surface"].update(index=1.0)
        share = Fraction("0.96") if axis == "-z" else Fraction(1)
        for other in ("+z", "-z"):
            target = {**wall((0.0, 0.0, 0.0), other), "name": "target", **BLACK}
            lamp = beam((0.0, 0.0, 1.0), "-z")
            for faces in ([plate, target], [target, plate]):
                found = trace(scene_of([lamp], faces), rays_per_batch=64)
                assert abs(found.absorbed("target") / 64 - share) < Fraction(1, 10**14)
                assert abs(found.escaped / 64 - (1 - share)) < Fraction(1, 10**14)


def launched_rays_leave_their_face() -> None:
    """A ray launched from a face is not stopped by it, on either side."""
    for axis in ("+z", "-z"):
        for direction in ("+z", "-z"):
            target = {**wall((0.0, 0.0, 0.3), axis), "name": "target", **BLACK}
            lamp = beam((0.0, 0.0, 0.3), direction, radius=0.1)
            found = trace(scene_of([lamp], [target]), rays_per_batch=64)
            assert (found.absorbed("target"), found.escaped) == (0, 64)


def edges_hold() -> None:
    """Rays aimed exactly at edges, corners and rims are hits; just beyond they are not."""
    elements = [
        {**wall((0.5, 0.25, 0.0), "+z", 0.1), **BLACK},
        {"kind": "disk", "position": [3.0, 0.0, 0.0], "axis": "+z", "radius": 0.1, **BLACK},
    ]
    scene = scene_of([beam((0, 0, 1), "-z")], elements)
    aims, want = [], []
    for i in (-0.1, 0.0, 0.1):
        for j in (-0.1, 0.0, 0.1):
            for factor, hit in ((1.0, 0), (1.0 + 1e-9, -1), (1.0 - 1e-9, 0)):
                if (i, j) != (0.0, 0.0):
                    aims.append((0.5 + i * factor, 0.25 + j * factor, 0.0))
                    want.append(hit)
    for k in range(16):
        c, s = math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)
        for factor, hit in ((0.1, 1), (0.1 * (1.0 + 1e-9), -1), (0.1 * (1.0 - 1e-9), 1)):
            aims.append((3.0 + factor * c, factor * s, 0.0))
            want.append(hit)
    r = random.Random(1)
    for _ in range(20):
        height = r.choice([-1, 1]) * r.uniform(0.2, 2)
        origin = np.array([r.uniform(-1, 3), r.uniform(-1, 1), height])
        directions = np.array(aims) - origin
        directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
        assert probe(scene, np.tile(origin, (len(aims), 1)), directions).element.tolist() == want


def corners_hold() -> None:
    """No ray gets out between plates that cross at all angles, aimed at their edges and corners."""
    for number in range(3):
        r = np.random.default_rng([1, number])
        chamber = corners.polyhedron(r, 4, 1.0, np.zeros(3), Mirror(1.0))
        rays = corners.rays_at_edges(r, chamber, 2000)
        assert corners.leaks(chamber, *rays) == (0, 0, 0)


def curved_corners_hold() -> None:
    """No ray gets out where plates cut a tube, a lens and a concentrator."""
    for number in range(4):
        for kind in ("tube and plates", "halved lens", "halved cpc"):
            r = np.random.default_rng([3, number])
            region = regions.made(kind, Mirror(1.0), (33.3, 0.0), 1.0, r.uniform(-1, 1, 3))
            assert curved.leaks_of(region, *curved.rays_in(r, region, 2000)) == (0, 0), kind


def round_corners_hold() -> None:
    """No ray gets out where disks close a tube, a cone, a dish and a dish with a hole."""
    for number in range(3):
        for kind in ("closed cylinder", "closed cone", "hemisphere and disk", "holed dish"):
            r = np.random.default_rng([4, number])
            scale = (1.0, 1e-6, 1e6)[number]
            region = regions.made(kind, Mirror(1.0), (0.0, 0.0), scale, np.zeros(3))
            assert curved.leaks_of(region, *curved.rays_in(r, region, 1000)) == (0, 0), kind


def hollow_faces_are_met_again() -> None:
    """A beam at sin 50° into a hollow hemisphere meets it at 50° and at −30° from its pole."""
    hollow = {
        "kind": "lens", "name": "hollow", "position": [0.0, 0.0, 0.0], "axis": "+z",
        "front_radius": -1.0, "back_radius": 5.0, "thickness": 0.2, "aperture_radius": 1.0,
        **mirror(1.0),
    }  # fmt: skip
    lamp = {**beam((math.sin(math.radians(50.0)), 0.0, 3.0), "-z", 1e-3)}
    traced = trace(scene_of([lamp], [hollow]), rays_per_batch=256)
    assert traced.interactions == 2 * 256
    assert traced.escaped > 0


def far_field_bins() -> None:
    """A beam in the middle of a bin's range of directions lights that bin and no other."""
    n_mu, n_phi = 6, 8
    sources, want = [], np.zeros((n_mu, n_phi), np.int64)
    for j in range(n_mu):
        for i in range(n_phi):
            theta = math.degrees(math.acos(-1.0 + (2 * j + 1) / n_mu))
            phi = 360.0 * (i + 0.5) / n_phi
            # from +z: first about u = x by a, then about v = y by b
            x = math.sin(math.radians(theta)) * math.cos(math.radians(phi))
            y = math.sin(math.radians(theta)) * math.sin(math.radians(phi))
            z = math.cos(math.radians(theta))
            a = math.degrees(math.asin(-y))
            b = math.degrees(math.atan2(x, z))
            want[j, i] = 1 + len(sources) * 7 % 13
            share = float(want[j, i] - 1) or 1e-9  # every source launches one ray at least
            sources.append(beam((0, 0, 0), "+z", tilt_deg=[a, b], share=share))
    scene = scene_of(sources, [], far_field={"n_mu": n_mu, "n_phi": n_phi})
    found = trace(scene, rays_per_batch=int(want.sum()))
    assert (found.far_field_counts == want).all()


EDGES = (0.0, 1e-7, 0.01, 3.0, 45.0, 89.999, 90.0, 120.0, 179.99)
"""Degrees."""


def far_field_edges(axis: str = "-z") -> None:
    """A beam 16 roundings above an edge in θ is above it, one as much below it is below it.

    So few are what frame, normalisation and products may amount to. At 45° and 90° there are none,
    and a beam on the edge itself is above it.
    """
    sources, want = [], np.zeros((len(EDGES) - 1, 4), np.int64)
    for k, edge in enumerate(EDGES):
        for column, turn in enumerate(((0, 1), (-1, 0), (0, -1), (1, 0))):
            near = [(edge * (1.0 - 2.0**-49), k - 1), (edge * (1.0 + 2.0**-49), k)]
            if edge in (45.0, 90.0):
                near.append((edge, k))
            for angle, row in near:
                if not edge:
                    row, column = 0, 0
                if row < 0 or row >= len(want):
                    continue
                want[row, column] += 1
                tilt = [sign * angle for sign in turn]
                sources.append(beam((0, 0, 0), axis, tilt_deg=tilt, radius=1e-9))
    far_field = {"axis": axis, "theta_edges_deg": EDGES, "n_phi": 4}
    found = trace(scene_of(sources, [], far_field=far_field), rays_per_batch=len(sources))
    assert (found.far_field_counts == want).all()


def one_sided_detectors() -> None:
    """A detector counts only arrivals at the side it faces; the ledger counts both."""
    for kind, axis, side in (
        ("rectangle", "+z", None),
        ("rectangle", "-z", None),
        ("disk", "+z", None),
        ("disk", "-z", None),
        ("sphere", "+z", "outside"),
        ("sphere", "+z", "inside"),
    ):
        shape = {"half_width": 0.5, "half_height": 0.5} if kind == "rectangle" else {"radius": 0.5}
        detector: dict[str, Any] = {"generations": 3, "map": [2, 2]}
        if side:
            detector["side"] = side
        element = {"kind": kind, "position": [0, 0, 0], "axis": axis, **shape, **BLACK}
        start = 0.25 if side == "inside" else 1.0
        for direction in (1.0, -1.0):
            lamp = beam((0.0, 0.0, start * direction), "-z" if direction > 0 else "+z")
            scene = scene_of([lamp], [{**element, "detector": detector}])
            found = trace(scene, rays_per_batch=16)
            faces = kind == "sphere" or (axis == "+z") == (direction > 0)
            assert found.absorbed("element 0") == 16
            assert found.detector("element 0").power == (16 if faces else 0)
            assert found.detector("element 0").count == (16 if faces else 0)
    for side, start in (("outside", 0.25), ("inside", 1.0)):
        element = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5, **BLACK}
        scene = scene_of(
            [beam((0.0, 0.0, start), "-z")],
            [{**element, "detector": {"side": side, "generations": 3, "map": [2, 2]}}],
        )
        found = trace(scene, rays_per_batch=16)
        assert found.absorbed("element 0") == 16
        assert found.detector("element 0").count == 0


def order_does_not_matter() -> None:
    """Maps and far field have the same bits whatever the order of the sums."""
    made = compiled(load(scenes.everything()), rays_per_batch=3000)
    plan = PLAN.with_(tally_copies=1)
    plans = [plan, plan.with_(composition="classical"), plan.with_(wave_rays=1 << 10, items=64)]
    assert len({trace_compiled(made, plan=plan).digest for plan in plans}) == 1


def periscope() -> None:
    """Countable bounces: two mirrors at 45° and a target, each with its exact share."""
    elements = [
        {**wall((0, 0, 0), "+z", 0.2), "tilt_deg": [0.0, -45.0], "name": "low", **mirror(0.75)},
        {**wall((-1, 0, 0), "-z", 0.2), "tilt_deg": [45.0, 0.0], "name": "high", **mirror(0.5)},
        {**wall((-1, 0, 1), "-z", 0.2), "name": "target", **BLACK, "detector": {"generations": 4}},
    ]
    found = trace(scene_of([beam((0, 0, 1), "-z", 0.05)], elements), rays_per_batch=64)
    assert found.interactions == 3 * 64
    assert found.absorbed("low") == 16
    assert found.absorbed("high") == 24
    assert found.detector("target").ladder == [0, 0, 24, 0]


ONE_PROGRAM = frozenset({"tilt", "shares"})
"""Effects forced on so that all random scenes that are `alike` have the same program."""


def reference_agrees(
    number: int, rays: int = 200, force: frozenset[str] = ONE_PROGRAM, *, alike: bool = False
) -> None:
    """A random scene of everything has the tallies of the plain reference tracer."""
    tables = scenes.random_scene(number, rays=rays, alike=alike)
    made = compiled(load(tables), force, seed=2**40 + number)
    assert compare.differences(trace_compiled(made), tables, 1e-9) == []


PRESETS: dict[str, dict[str, int]] = {
    "cosine-fourth": {"rays_per_batch": 500},
    "lambertian-sphere": {"rays_per_batch": 500},
    "integrating-sphere": {"rays_per_batch": 100, "generation_cap": 60},
    "ghost-ladder": {"rays_per_batch": 50},
    "box-room": {"rays_per_batch": 100},
}


def preset_agrees(name: str, first: int = 0) -> None:
    """A batch of a preset has the tallies of the plain reference tracer."""
    run = PRESETS[name]
    made = compiled(name, **run)
    tables = made.scene.to_dict()
    tables["run"].update(run)
    assert compare.differences(trace_compiled(made, first=first), tables, 1e-9) == []


def shares_are_unbiased() -> None:
    """Shares move effort and not the answer: each source's flux arrives whole."""
    sources = [
        beam((-1.0, 0.0, 1.0), "-z", 0.1, share=1.0),
        {**beam((1.0, 0.0, 1.0), "-z", 0.1, share=7.0), "flux": 3.0},
    ]
    elements = [
        {**wall((-1.0, 0.0, 0.0), "+z", 0.5), **BLACK, "detector": {"generations": 1}},
        {**wall((1.0, 0.0, 0.0), "+z", 0.5), **BLACK, "detector": {"generations": 1}},
    ]
    found = trace(scene_of(sources, elements), rays_per_batch=800)
    unit = Fraction(found.compiled.unit_power)
    for n, flux in ((0, 1), (1, 3)):
        watts = found.absorbed(f"element {n}") * unit
        assert abs(watts - flux) < Fraction(1, 10**15)
    counts = [found.detector(f"element {n}").count for n in (0, 1)]
    assert counts[0] + counts[1] == 800
    assert abs(counts[0] - 100) <= 1


def mixed_shares() -> None:
    """A surface of 1/2 specular and 1/4 diffuse keeps a quarter, and sends the rest to both."""
    surface = {"surface": {"kind": "mixed", "specular": 0.5, "diffuse": 0.25}}
    target = {**wall((0, 0, 3), "-z", 1e-4), **BLACK, "detector": {}}
    found = trace(
        scene_of(
            [beam((0, 0, 1), "-z", 1e-9)], [{**wall((0, 0, 0), "+z", 5.0), **surface}, target]
        ),
        rays_per_batch=256,
    )
    assert found.absorbed("element 0") == 64
    assert found.detector("element 1").power == 128
