"""Ties, contacts, edges, corners, rims: what the contract says of geometry at its limits."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from oracles import gates, tracer
from oracles.engine import probe, scene_of, trace
from oracles.scenes import AXES, BLACK, beam, cube, glass, matt, mirror, wall

PENCIL = 1e-140
"""Radius of a beam so thin that its rays start in the very position of the source."""


def pencil(position, towards, **more):
    """Return a source of parallel rays from a point towards another."""
    d = np.subtract(towards, position)
    d = d / np.linalg.norm(d)
    b = math.degrees(math.atan2(d[0], d[2]))
    a = math.degrees(math.asin(-d[1]))
    return beam(tuple(position), "+z", PENCIL, tilt_deg=[a, b], **more)


def some(firsts, *fast: str):
    """Return all pairs with a rectangle or a disk: each makes a program, so all but few are slow.

    A kernel has text of its own for each axis and each kind, whichever way a face looks.
    """
    pairs = [(f"{first}-{kind}", first, kind) for first in firsts for kind in ("rectangle", "disk")]
    return [
        pytest.param(first, kind, id=name, marks=() if name in fast else pytest.mark.slow)
        for name, first, kind in pairs
    ]


def test_of_coincident_faces_the_first_named_is_hit() -> None:
    gates.first_named_is_hit()


def test_a_plate_in_contact_with_an_absorber_feeds_it() -> None:
    gates.contact_behind_glass()


def test_launched_rays_leave_their_face() -> None:
    gates.launched_rays_leave_their_face()


def test_edges_corners_and_rims_are_hit() -> None:
    gates.edges_hold()


@pytest.mark.parametrize(("axis", "kind"), some(AXES, "+x-rectangle", "-y-disk"))
def test_coincident_flats_of_other_size_and_centre(kind: str, axis: str) -> None:
    """Overlapping faces in one plane: where both are, the first named is hit."""
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))
    shape = {"half_width": 0.5, "half_height": 0.5} if kind == "rectangle" else {"radius": 0.5}
    faces = []
    for n, (shift, surface) in enumerate(((0.1, mirror()), (-0.1, BLACK), (0.2, BLACK))):
        position = (0.7 * w + shift * u + 0.05 * n * v).tolist()
        faces.append({"kind": kind, "axis": axis, "position": position, **shape, **surface})
    start = 0.7 * w + w
    lamp = beam(tuple(start.tolist()), axis.translate(str.maketrans("+-", "-+")), 0.2)
    for order in itertools.permutations(range(3)):
        scene = scene_of([lamp], [faces[n] for n in order])
        found = trace(scene, rays_per_batch=64)
        first = order.index(0)
        assert found.interactions == 64
        assert found.escaped == (64 if first == 0 else 0)
        if first:
            assert found.absorbed("element 0") == 64


TILTS = [(0.0, 0.0), (33.3, 0.0), (0.0, -71.0), (10.0, 20.0), (123.4, 56.7)]


def tilted_faces(tilt, shifts, surfaces, kind="rectangle"):
    """Return coincident faces of one tilted plane, their centres shifted along u."""
    row = {"axis": "+z", "tilt_deg": list(tilt)}
    u, _, w = (np.array(x) for x in tracer.frame(row))
    shape = {"half_width": 0.5, "half_height": 0.5} if kind == "rectangle" else {"radius": 0.5}
    origin = np.array([0.3, -0.2, 0.1])
    faces = []
    for shift, surface in zip(shifts, surfaces, strict=True):
        position = (origin + shift * u).tolist()
        faces.append({"kind": kind, **row, "position": position, **shape, **surface})
    lamp = beam(tuple((origin + w).tolist()), "-z", 0.2)
    lamp["axis"] = "+z"
    # the beam runs against w: turn the frame of +z by the tilt and then half a turn about u
    lamp["tilt_deg"] = [tilt[0] + 180.0, tilt[1]]
    return lamp, faces


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("kind", ["rectangle", "disk"])
def test_coincident_tilted_flats(kind: str, tilt: tuple[float, float]) -> None:
    for surfaces, escaped in (((mirror(), BLACK), 64), ((BLACK, mirror()), 0)):
        lamp, faces = tilted_faces(tilt, (0.0, 0.0), surfaces, kind)
        found = trace(scene_of([lamp], faces), rays_per_batch=64)
        assert found.escaped == escaped
        assert found.interactions == 64


R = Fraction(1, 25)


def zero_thickness(ladder, rays: int) -> None:
    """Assert the six orders of the ghost ladder in two detectors' ladders."""
    for name, orders in gates.GHOSTS.items():
        for generation, want in orders.items():
            share = ladder(name)[generation] / rays
            assert abs(share - Fraction(want)) < Fraction(want) * Fraction(1, 10**12)


@pytest.mark.parametrize(
    ("axes", "kind"),
    some(["+z +z", "+z -z", "-z +z", "-z -z"], "+z -z-disk"),
)
def test_a_plate_of_no_thickness_has_the_whole_ghost_ladder(kind: str, axes) -> None:
    """Two faces in contact: light goes to and fro between them at distance zero."""
    shape = {"half_width": 0.5, "half_height": 0.5} if kind == "rectangle" else {"radius": 0.5}
    front, back = axes.split()
    elements = [
        # glass lies behind the first face (seen from above) and above the second
        {"kind": kind, "axis": front, "position": [0, 0, 0], **shape}
        | (glass(1.5) if front == "+z" else glass(1.0, 1.5)),
        {"kind": kind, "axis": back, "position": [0, 0, 0], **shape}
        | (glass(1.0, 1.5) if back == "+z" else glass(1.5)),
    ]
    detector = {"detector": {"generations": 12}}
    elements += [
        {**wall((0, 0, -1), "+z"), "name": "transmitted", **BLACK, **detector},
        {**wall((0, 0, 2), "-z"), "name": "reflected", **BLACK, **detector},
    ]
    found = trace(scene_of([beam((0, 0, 1), "-z", 0.1)], elements), rays_per_batch=16)
    zero_thickness(lambda name: found.detector(name).ladder, 16)
    assert found.escaped == 0


# along the axes is another program
@pytest.mark.parametrize(
    "tilt", [pytest.param(tilt, marks=() if any(tilt) else pytest.mark.slow) for tilt in TILTS]
)
def test_a_plate_of_no_thickness_on_an_absorber(tilt) -> None:
    """What does not come through the two faces leaves again: 12/13 and 1/13."""
    surfaces = (glass(1.0, 1.5), glass(1.5), BLACK)  # met from behind
    lamp, faces = tilted_faces(tilt, (0.0, 0.0, 0.0), surfaces)
    for face in faces:
        face["tilt_deg"] = [tilt[0] + 180.0, tilt[1]]
    found = trace(scene_of([lamp], faces), rays_per_batch=16)
    total = (1 - R) ** 2 / (1 - R**2)
    assert abs(found.absorbed("element 2") / 16 - total) < Fraction(1, 10**12)
    assert abs(found.escaped / 16 - (1 - total)) < Fraction(1, 10**12)


def shell_on_an_absorber(height: float):
    """Trace a pencil onto three coincident spheres: two faces of glass and an absorber."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.5}
    detector = {"detector": {"side": "inside", "generations": 12}}
    elements = [
        {**ball, **glass(1.0, 1.5)},
        {**ball, **glass(1.5)},
        {**ball, **BLACK, **detector, "name": "target"},
    ]
    lamp = beam((0, 0, height), "-z", PENCIL)
    return trace(scene_of([lamp], elements), rays_per_batch=16, generation_cap=12)


def test_a_shell_of_no_thickness_in_an_absorber() -> None:
    """From inside: two interfaces, then the absorber; what turns back meets them again across."""
    ladder = shell_on_an_absorber(0.0).detector("target").ladder
    through = (1 - R) ** 2
    for generation, want in ((2, through), (3, R * through), (4, 2 * R**2 * through)):
        assert abs(ladder[generation] / 16 - want) < want * Fraction(1, 10**12)
    assert ladder[:2] == [0, 0]


def test_an_absorber_around_a_shell_takes_what_comes_from_outside() -> None:
    found = shell_on_an_absorber(1.0)
    assert (found.absorbed("target"), found.interactions) == (16, 16)
    assert found.detector("target").power == 0


def test_a_ball_that_touches_a_plate() -> None:
    """At the point of contact: what the glass above it lets out meets the ball."""
    ball = {"kind": "sphere", "position": [0, 0, -1], "axis": "+z", "radius": 1.0, **BLACK}
    lamp = beam((0, 0, 1), "-z", PENCIL)
    for axis, surface, taken in (
        ("-z", glass(1.0, 1.5), 8 * (1 - R)),
        ("+z", glass(1.5), 8),  # met from outside, where the ball comes first
    ):
        for turn in (1, -1):
            faces = [{**wall((0, 0, 0), axis), **surface}, {**ball, "name": "ball"}][::turn]
            found = trace(scene_of([lamp], faces), rays_per_batch=8)
            assert abs(found.absorbed("ball") - taken) < Fraction(1, 10**13)
    found = trace(scene_of([lamp], [{**wall((0, 0, 0), "+z"), **mirror()}, ball]), rays_per_batch=8)
    assert found.absorbed("element 1") == 0
    found = trace(scene_of([lamp], [ball, {**wall((0, 0, 0), "+z"), **mirror()}]), rays_per_batch=8)
    assert found.absorbed("element 0") == 8


@pytest.mark.parametrize("axis", AXES)
def test_a_ray_in_a_plane_misses_it(axis: str) -> None:
    """Along u, v and diagonals, from within the face and from outside."""
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))
    faces = [
        {**wall(tuple((0.25 * w).tolist()), axis, 0.5), **BLACK},
        {"kind": "disk", "position": (0.5 * w).tolist(), "axis": axis, "radius": 0.5, **BLACK},
    ]
    origins, directions = [], []
    for height in (0.25, 0.5):
        for start in (0.0, -3.0):
            for d in (u, v, -u, (u + v) / math.sqrt(2.0)):
                origins.append(height * w + start * d)
                directions.append(d)
    scene = scene_of([beam((0, 0, 9), "+z")], faces)
    found = probe(scene, np.array(origins), np.array(directions))
    assert (found.element == -1).all()
    assert np.isinf(found.distance).all()


def edge_and_corner_points(half: float = 1.0) -> list[tuple[float, float, float]]:
    """Return corners, edge middles and odd points of the edges of a cube."""
    points = []
    for x, y, z in itertools.product((-1.0, -0.371, 0.0, 0.618, 1.0), repeat=3):
        if sum(abs(c) == 1.0 for c in (x, y, z)) >= 2:
            points.append((half * x, half * y, half * z))
    return points


@pytest.mark.parametrize("surface", [mirror(), matt()], ids=["mirror", "lambertian"])
def test_a_closed_cube_keeps_rays_aimed_at_its_edges_and_corners(surface) -> None:
    starts = [(0.0, 0.0, 0.0), (0.1, -0.2, 0.3), (0.5, 0.5, 0.0), (-0.99, 0.99, 0.98)]
    sources = [pencil(s, p) for s in starts for p in edge_and_corner_points()]
    found = trace(scene_of(sources, cube(surface)), rays_per_batch=len(sources), generation_cap=60)
    assert found.escaped == 0
    assert found.interactions == 60 * len(sources)


@pytest.mark.parametrize("angle", [33.3, -71.0, 1e-7, 45.0])
@pytest.mark.parametrize(
    "surface",
    # in hard/test_corners.py matt walls are turned, too
    [pytest.param(mirror(), id="mirror"),
     pytest.param(matt(), id="lambertian", marks=pytest.mark.slow)],
)  # fmt: skip
def test_a_turned_cube_keeps_rays_aimed_at_its_edges(surface, angle: float) -> None:
    """Four walls turned about x share edges to rounding only; the ends are straight."""
    turn = np.array(tracer.frame({"axis": "+z", "tilt_deg": [angle, 0.0]}))
    walls = []
    for n, row in enumerate(cube(surface)):
        axis = AXES[n]
        tilt = {"x": [0.0, 0.0], "y": [0.0, angle], "z": [angle, 0.0]}[axis[1]]
        if axis in ("-y", "-z"):  # u and v change places for a negative axis
            tilt = tilt[::-1]
        position = (np.array(row["position"]) @ turn).tolist()
        walls.append({**row, "position": position, "tilt_deg": tilt})
        if axis[1] == "x":
            walls[-1].update(half_width=2.0, half_height=2.0)
    aims = [p for p in edge_and_corner_points() if abs(p[0]) != 1.0]
    # no path may come to where the ends meet the walls: that is another test's matter
    starts = [(0.0, 0.0, 0.0), (0.137, -0.2, 0.3), (0.511, 0.9, -0.9)]
    sources = [pencil(np.array(s) @ turn, np.array(p) @ turn) for s in starts for p in aims]
    found = trace(scene_of(sources, walls), rays_per_batch=len(sources), generation_cap=60)
    assert found.escaped == 0


@pytest.mark.parametrize(
    "surface",
    # mirrors on a larger floor: hard/test_leaks.py
    [pytest.param(mirror(), id="mirror", marks=pytest.mark.slow),
     pytest.param(matt(), id="lambertian")],
)  # fmt: skip
def test_walls_that_stand_on_a_larger_floor_leave_no_gap(surface) -> None:
    """A room of which floor and ceiling reach beyond the walls, rays aimed at all its edges."""
    walls = cube(surface)
    for row in walls:
        if row["axis"][1] == "z":
            row.update(half_width=2.0, half_height=3.0)
    starts = [(0.0, 0.0, 0.0), (0.1, -0.2, 0.3), (0.5, 0.5, 0.0), (-0.99, 0.99, 0.98)]
    sources = [pencil(s, p) for s in starts for p in edge_and_corner_points()]
    found = trace(scene_of(sources, walls), rays_per_batch=len(sources), generation_cap=60)
    assert found.escaped == 0


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.3, 1e6 + 0.1])
def test_two_walls_side_by_side_leave_no_gap(offset: float) -> None:
    """Rays aimed at the seam of two rectangles in one plane end on just one of them."""
    halves = [
        {**wall((offset - 0.5, 0.0, 0.0), "+z", 0.5), **BLACK},
        {**wall((offset + 0.5, 0.0, 0.0), "+z", 0.5), **BLACK},
    ]
    aims = [(offset, y, 0.0) for y in np.linspace(-0.49, 0.49, 41)]
    sources = [pencil((offset + 0.3, 0.1, 1.0), aim) for aim in aims]
    sources += [beam((offset, y, 1.0), "-z", PENCIL) for y in np.linspace(-0.49, 0.49, 41)]
    found = trace(scene_of(sources, halves), rays_per_batch=len(sources))
    assert found.escaped == 0
    assert found.interactions == len(sources)


@pytest.mark.parametrize("fraction", [0.05, 0.3, 0.5, 0.77])
@pytest.mark.parametrize("axis", ["+z", "-x"])
def test_a_sphere_closed_by_a_disk_at_its_port_leaves_no_gap(axis: str, fraction: float) -> None:
    """The lid's rim is the port's rim: rays aimed at it from inside hit one of the two."""
    radius = 0.7
    u, v = (np.array(tracer.axis_vector(name)) for name in tracer.FRAMES[axis])
    w = np.array(tracer.axis_vector(axis))
    height = radius * (1.0 - 2.0 * fraction)
    rim = 2.0 * radius * math.sqrt(fraction * (1.0 - fraction))
    lid = {"kind": "disk", "position": (height * w).tolist(), "axis": axis, "radius": rim}
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": axis, "radius": radius}
    ball["port_fraction"] = fraction
    origins, directions = [], []
    for k in range(200):
        phi = 2.0 * math.pi * k / 200
        aim = height * w + rim * (math.cos(phi) * u + math.sin(phi) * v)
        for start in (-0.1 * w, -0.6 * w + 0.01 * u, height * w - 0.05 * w):
            d = aim - start
            origins.append(start)
            directions.append(d / np.linalg.norm(d))
    scene = scene_of([beam((0, 0, 0), "+z")], [{**ball, **matt()}, {**lid, **BLACK}])
    found = probe(scene, np.array(origins), np.array(directions))
    assert (found.element >= 0).all()


def test_the_rim_of_a_port_belongs_to_the_wall() -> None:
    """cos θ = 0.9 is a hit, a little above it is not, in 12 azimuths."""
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0}
    scene = scene_of([beam((0, 0, 0), "+z")], [{**ball, "port_fraction": 0.05, **BLACK}])
    directions, want = [], []
    for k in range(12):
        for cosine, element in ((0.9, 0), (0.9 + 1e-13, -1), (0.9 - 1e-13, 0)):
            s, phi = math.sqrt((1.0 - cosine) * (1.0 + cosine)), 2.0 * math.pi * k / 12
            directions.append((s * math.cos(phi), s * math.sin(phi), cosine))
            want.append(element)
    found = probe(scene, np.zeros((36, 3)), np.array(directions))
    assert found.element.tolist() == want


@pytest.mark.parametrize("surface", [mirror(), matt()], ids=["mirror", "lambertian"])
def test_closed_rooms_lose_nothing_in_ten_million_interactions(surface) -> None:
    gates.closed_cube(surface)


@pytest.mark.parametrize("surface", [mirror(), matt()], ids=["mirror", "lambertian"])
def test_closed_spheres_lose_nothing_in_ten_million_interactions(surface) -> None:
    ball = {"kind": "sphere", "position": [0.1, 0.2, -0.3], "axis": "+z", "radius": 0.9}
    lamp = {"kind": "isotropic-point", "flux": 1.0, "position": [0.4, -0.2, 0.1]}
    scene = scene_of([lamp], [{**ball, **surface}])
    found = trace(scene, rays_per_batch=1 << 16, generation_cap=160)
    assert found.escaped == 0
    assert found.depth_capped == found.emitted
    assert found.interactions == 160 << 16


def test_a_mirror_corner_sends_a_ray_back() -> None:
    """Three mirrors that share edges: rays into edges and the corner come back turned round."""
    walls = [
        {**wall((0, 1, 1), "+x"), **mirror()},
        {**wall((1, 0, 1), "+y"), **mirror()},
        {**wall((1, 1, 0), "+z"), **mirror()},
    ]
    starts = [(1.0, 1.0, 1.0), (1.0, 0.5, 0.25), (0.7, 0.4, 0.5)]
    aims = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.1), (0.2, 0.0, 0.0)]
    sources = [pencil(s, a) for s in starts for a in aims]
    scene = scene_of(sources, walls, far_field={"n_mu": 2, "n_phi": 4})
    found = trace(scene, rays_per_batch=len(sources))
    assert found.escaped == len(sources)
    assert found.far_field_counts[1, 0] == len(sources)
