"""Faces of several elements in one place: the order is a matter of surfaces, not of rounding."""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import replace

import numpy as np
import pytest
from oracles import contacts, films, tracer
from oracles.engine import PLAN, compiled, probe, scene_of, trace, trace_compiled, with_tree
from oracles.scenes import BLACK, beam, glass, matt, mirror, wall

from photizon_cl.checks.advisories import advisories
from photizon_cl.compile.compiled import compile_scene

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

CLEAR = {"surface": {"kind": "clear"}}
POSES = {
    "along the axes": ("+z", (0.0, 0.0), (0.0, 0.0, 0.0)),
    "across x": ("-x", (0.0, 0.0), (0.3, -0.2, 0.1)),
    "tilted": ("+z", (33.3, -71.7), (0.3, -0.2, 0.1)),
    "tilted, far away": ("+y", (-12.3, 45.6), (1e5, -3e5, 2e5)),
}


def test_of_bodies_in_contact_the_one_that_is_left_comes_first() -> None:
    contacts.have_a_film()


@pytest.mark.parametrize(
    "pose",
    # along another axis is another program
    [pytest.param(p, marks=pytest.mark.slow if p == "across x" else ()) for p in POSES],
)
@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 75.0])
def test_two_slabs_in_contact(pose: str, angle: float) -> None:
    """A film of the outside index between them, in both orders of the file: 1e-12."""
    want = films.stack([1.0, 1.5, 1.0, 1.8, 1.0], angle, 12)
    for order in ((0, 1, 2, 3), (3, 2, 1, 0), (2, 3, 0, 1)):
        contacts.is_film(contacts.slabs([1.5, 1.8], angle, *POSES[pose], order=order), want, 12)


@pytest.mark.slow  # one more is another program
@pytest.mark.parametrize("angle", [0.0, 60.0])
def test_three_slabs_in_contact(angle: float) -> None:
    want = films.stack([1.0, 1.5, 1.0, 1.8, 1.0, 1.3, 1.0], angle, 10)
    for order in ((0, 1, 2, 3, 4, 5), (5, 0, 4, 1, 3, 2)):
        slabs = contacts.slabs([1.5, 1.8, 1.3], angle, *POSES["tilted"], order=order)
        contacts.is_film(slabs, want, 10)


def test_cemented_slabs() -> None:
    """The touching face of one has the other's index outside, and the other's face is clear."""
    want = films.stack([1.0, 1.5, 1.8, 1.0], 60.0, 12)
    for pose, order in itertools.product(
        ("tilted", "tilted, far away"), ((0, 1, 2, 3), (3, 2, 1, 0))
    ):
        scene = contacts.slabs([1.5, 1.8], 60.0, *POSES[pose], order=order, cemented=True)
        contacts.is_film(scene, want, 12)


def test_a_film_where_the_incident_beam_is_turned_at_random() -> None:
    """Poses, orders and angles up to grazing at random: rounding decides nowhere."""
    draw = random.Random(12)
    for _ in range(24):
        tilt = (draw.uniform(-180.0, 180.0), draw.uniform(-90.0, 90.0))
        far = 10.0 ** draw.uniform(-3.0, 6.0)
        place = tuple(draw.uniform(-far, far) for _ in range(3))
        angle = draw.choice([draw.uniform(0.0, 89.0), 89.9, 89.99])
        order = draw.sample(range(4), 4)
        scene = contacts.slabs(
            [1.5, 1.8], angle, draw.choice(["+x", "-y", "+z"]), tilt, place, order
        )
        # the reflectance follows the direction's rounding, near grazing most of all
        room = max(1e-12, 4e-15 / math.cos(math.radians(angle)))
        contacts.is_film(scene, films.stack([1.0, 1.5, 1.0, 1.8, 1.0], angle, 8), 8, room)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("tilt", [pytest.param((0.0, 0.0), marks=pytest.mark.slow), (33.3, -71.7)])
def test_a_black_plate_under_glass(order, tilt) -> None:
    """All of the light from its own side; from inside the glass what a film lets through."""
    upright, turned = list(tilt), [tilt[0] + 180.0, tilt[1]]
    u, _, w = (np.array(x) for x in tracer.frame({"axis": "+z", "tilt_deg": tilt}))
    shape = {"kind": "rectangle", "axis": "+z", "half_width": 0.5, "half_height": 0.5}
    faces = [
        {**shape, "tilt_deg": turned, "name": "bottom", "position": [0, 0, 0], **glass(1.5)},
        {**shape, "tilt_deg": upright, "name": "top", "position": (0.01 * w).tolist()} | glass(1.5),
        {**shape, "tilt_deg": upright, "name": "plate", "position": (0.1 * u).tolist(), **BLACK},
    ]
    for side, towards, cap in ((-0.1, upright, 4), (0.1, turned, 16)):
        lamp = {**beam(tuple((side * w).tolist()), "+z", 1e-3), "tilt_deg": towards}
        scene = scene_of([lamp], [faces[n] for n in order])
        found = trace(scene, rays_per_batch=2, generation_cap=cap, force=frozenset({"tilt"}))
        share = float(found.absorbed("plate")) / 2
        if side < 0.0:
            assert (share, found.interactions) == (1.0, 2)
        else:
            assert abs(share - films.stack([1.0, 1.5, 1.0], 0.0, cap).transmitted) < 1e-12


# -- what passes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "surface", [mirror(0.5), matt(0.5), BLACK], ids=["mirror", "matt", "black"]
)
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (33.3, -71.7)])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_clear_plane_lies_in_front_of_what_it_touches(surface, tilt, order) -> None:
    """It counts what arrives from either side, and from the other one what is sent back."""
    frame = np.array(tracer.frame({"axis": "+z", "tilt_deg": tilt}))
    pose = {"kind": "disk", "axis": "+z", "tilt_deg": list(tilt), "radius": 0.5}
    shift = (0.1 * frame[0]).tolist()
    # out of the way, each of the surfaces, so that one program does for all of them
    aside = [
        {**pose, "position": (9.0 * n * frame[0] + n * frame[2]).tolist(), **kind}
        for n, kind in enumerate((mirror(0.5), matt(0.5), BLACK), 1)
    ]
    for side, arrives in ((1.0, "front"), (-1.0, "back")):
        counts = {"front": 0, "back": 0}
        for seen in counts:
            faces = [
                {**pose, "position": [0, 0, 0], "name": "wall", **surface},
                {**pose, "position": shift, "name": "plane", **CLEAR, "detector": {"side": seen}},
            ]
            lamp = beam(tuple((side * frame[2]).tolist()), "+z", 1e-3)
            lamp["tilt_deg"] = [tilt[0] + (180.0 if side > 0.0 else 0.0), tilt[1]]
            scene = scene_of([lamp], [faces[n] for n in order] + aside)
            found = trace(scene, rays_per_batch=64, force=frozenset({"tilt"}))
            counts[seen] = float(found.detector("plane").power) / 64
        back = 0.0 if surface is BLACK else 0.5
        other = "back" if arrives == "front" else "front"
        assert counts == {arrives: 1.0, other: back}


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_clear_ball_around_glass_counts_what_goes_in_and_out(order) -> None:
    """A ball of glass in a coincident clear one: outside of it, whatever the order."""
    ball = {"kind": "sphere", "axis": "+z", "radius": 0.5}
    place = [0.3, -0.2, 0.1]
    lamp = beam((0.3, -0.2, 3.0), "-z", 0.45)
    bare = trace(scene_of([lamp], [{**ball, "position": place, **glass(1.5)}]), rays_per_batch=256)
    power = {}
    for side in ("inside", "outside"):
        faces = [
            {**ball, "position": place, "name": "glass", **glass(1.5)},
            {**ball, "position": place, "name": "ball", **CLEAR, "detector": {"side": side}},
        ]
        found = trace(scene_of([lamp], [faces[n] for n in order]), rays_per_batch=256)
        assert abs(float(found.escaped - bare.escaped)) < 1e-12
        assert found.interactions == bare.interactions
        power[side] = float(found.detector("ball").power)
    assert power["outside"] == 256
    # what escaped has passed it from inside
    assert abs(power["inside"] - float(found.escaped)) < 1e-9


# -- round bodies --------------------------------------------------------------------------------


# along the axes is another program; with a tilt rounding comes in
@pytest.mark.parametrize("tilt", [pytest.param((0.0, 0.0), marks=pytest.mark.slow), (33.3, -71.7)])
def test_half_balls_on_their_flats(tilt) -> None:
    """The same as with a gap of 10⁻⁹ of their size, in both orders."""
    frame = np.array(tracer.frame({"axis": "+z", "tilt_deg": tilt}))

    def halves(gap: float, order: tuple[int, int]):
        half = {"kind": "plano-convex", "curvature_radius": 0.5, "aperture_radius": 0.5}
        turned = [tilt[0] + 180.0, tilt[1]]
        faces = [
            {**half, "axis": "+z", "tilt_deg": list(tilt), "position": [0, 0, 0], **glass(1.5)},
            {**half, "axis": "+z", "tilt_deg": turned, "position": (-gap * frame[2]).tolist()}
            | glass(1.8),
        ]
        faces = [{**face, "name": f"half {n}"} for n, face in enumerate(faces)]
        lamp = beam(tuple((2.0 * frame[2] + 0.05 * frame[0]).tolist()), "+z", 0.4)
        lamp["tilt_deg"] = turned
        scene = scene_of([lamp], [faces[n] for n in order], far_field={"n_mu": 8, "n_phi": 1})
        return trace(scene, rays_per_batch=512, generation_cap=12)

    want = halves(1e-9, (0, 1))
    for order in ((0, 1), (1, 0)):
        found = halves(0.0, order)
        assert float(found.depth_capped) == pytest.approx(float(want.depth_capped), rel=1e-5)
        near = pytest.approx([float(x) for x in want.far_field], abs=1e-4)
        assert [float(x) for x in found.far_field] == near


def test_balls_that_touch() -> None:
    """At the point of contact a ray crosses a film, in both orders."""
    want = films.stack([1.0, 1.5, 1.0, 1.8, 1.0], 0.0, 8)
    for tilt, order in itertools.product(((0.0, 0.0), (33.3, -71.7)), ((0, 1), (1, 0))):
        frame = np.array(tracer.frame({"axis": "+z", "tilt_deg": tilt}))
        balls = [
            {"kind": "sphere", "axis": "+z", "radius": r, "position": (z * frame[2]).tolist()}
            | glass(n)
            for r, z, n in ((0.3, -0.3, 1.8), (0.7, 0.7, 1.5))
        ]
        lamp = beam(tuple((2.0 * frame[2]).tolist()), "+z", 1e-140)
        lamp["tilt_deg"] = [tilt[0] + 180.0, tilt[1]]
        scene = scene_of([lamp], [balls[n] for n in order], far_field={"n_mu": 2, "n_phi": 1})
        found = trace(scene, rays_per_batch=2, generation_cap=8)
        assert float(found.depth_capped) / 2 == pytest.approx(want.left, abs=1e-12)


# -- what is near and not in one place -----------------------------------------------------------


@pytest.mark.parametrize("tilt", [(0.0, 0.0), pytest.param((0.0, 33.3), marks=pytest.mark.slow)])
def test_a_wall_on_a_floor_is_no_face_in_its_place(tilt) -> None:
    contacts.walls_stand_on_floors(tilt)


def test_what_a_ray_touches_is_no_place_of_what_lies_before_it() -> None:
    """A ray along a ball that is a clear one too, past a plate that stands just before."""
    ball = {"kind": "sphere", "axis": "+z", "radius": 0.5, "position": [1.0, 0.5, 0.0]}
    plate = {"kind": "rectangle", "half_width": 0.1, "half_height": 0.1, "axis": "-x"}
    faces = [
        {**ball, "name": "glass", **glass(1.5)},
        {**ball, "name": "ball", **CLEAR},
        {**plate, "position": [0.9995, 0.0, 0.0], "name": "plate", **BLACK},
        {**plate, "position": [0.9995, 0.0, 0.0], "name": "face", **glass(1.5)},
    ]
    scene = scene_of([beam((0, 0, 9), "-z")], faces)
    found = probe(scene, np.array([[0.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]))
    # the glass is met from outside, so the plate first
    assert scene.element[int(found.element[0])].name == "plate"
    assert found.distance[0] == 0.9995


# -- one outcome ---------------------------------------------------------------------------------


@pytest.mark.parametrize("one_lane", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "pose", [pytest.param("along the axes", marks=pytest.mark.slow), "tilted, far away"]
)
def test_the_order_is_one_at_every_width_and_with_a_tree(pose: str, one_lane: bool) -> None:
    scene = contacts.slabs([1.5, 1.8, 1.3], 20.0, *POSES[pose], order=(5, 0, 4, 1, 3, 2))
    settings = replace(scene.run, rays_per_batch=64, generation_cap=8)
    digests = set()
    for tree, lanes in ((False, 4), (True, 1), *([(False, 1)] if one_lane else [])):
        made = compile_scene(scene, settings, **with_tree(tree))
        assert "coincidence" in made.effects
        digests.add(trace_compiled(made, plan=replace(PLAN, lanes=lanes)).digest)
    assert len(digests) == 1


def test_a_probe_meets_the_face_of_the_body_that_is_left() -> None:
    scene = contacts.slabs([1.5, 1.8], 0.0, *POSES["tilted"], order=(3, 2, 1, 0))
    w = np.array(tracer.frame({"axis": "+z", "tilt_deg": (33.3, -71.7)}))[2]
    inside = np.array(POSES["tilted"][2]) + 0.005 * w
    found = probe(scene, np.array([inside]), np.array([w]))
    assert scene.element[int(found.element[0])].name == "slab 0 back"


# -- what is said --------------------------------------------------------------------------------


def named(elements) -> str:
    return "\n".join(advisories(scene_of([beam((0, 0, 9), "-z")], elements)))


def test_every_pair_of_refracting_faces_is_named() -> None:
    half = {"kind": "plano-convex", "curvature_radius": 1.0, "aperture_radius": 0.5}
    flats = named(
        [
            {**half, "name": "a", "axis": "+z", "position": [0, 0, 0], **glass(1.5)},
            {**half, "name": "b", "axis": "-z", "position": [0, 0, 0], **glass(1.5)},
        ]
    )
    assert 'elements "a" and "b" have faces in one place' in flats
    assert "a film of index 1 between them" in flats
    balls = named(
        [
            {"kind": "sphere", "name": n, "axis": "+z", "radius": 1.0, "position": [0, 0, z]}
            | glass(1.5)
            for n, z in (("a", 0.0), ("b", 2.0))
        ]
    )
    assert 'elements "a" and "b" touch' in balls
    rests = named(
        [
            {"kind": "sphere", "name": "a", "axis": "+z", "radius": 1.0, "position": [0, 0, 1]}
            | glass(1.5),
            {**wall((0, 0, 0), "+z"), "name": "b", **glass(1.5, 1.33)},
        ]
    )
    assert 'elements "a" and "b" touch' in rests
    assert 'of index 1 for "a" and 1.33 for "b": make the two equal' in rests


def test_cement_is_told_and_is_cement() -> None:
    """What the advice says to do gives the cemented stack, and then it is silent."""
    film = contacts.slabs([1.5, 1.8], 30.0, *POSES["tilted"])
    text = "\n".join(advisories(film))
    assert 'give "slab 0 back" index_outside = 1.8 and make "slab 1 front" clear' in text
    cemented = contacts.slabs([1.5, 1.8], 30.0, *POSES["tilted"], cemented=True)
    assert "in one place" not in "\n".join(advisories(cemented))


def test_a_body_is_not_told_to_change_all_its_faces() -> None:
    """A lens has one surface: another index outside would change its curved face as well."""
    lens = {"kind": "plano-convex", "curvature_radius": 1.0, "aperture_radius": 0.5}
    lens = {**lens, "name": "lens", "axis": "+z", "position": [0, 0, 0], **glass(1.5)}
    for surface in (glass(1.8), BLACK):
        for order in (1, -1):
            text = named([lens, {**wall((0, 0, 0), "+z"), "name": "plate", **surface}][::order])
            assert '"lens"' in text
            assert "film of index 1 " in text
            assert "index_outside" not in text


def test_nothing_is_compiled_where_the_file_settles_the_order() -> None:
    """Opaque faces at exactly one distance, and bodies with a gap."""
    flush = [{**wall((0, 0, 0), "+z", h), **s} for h, s in ((0.1, BLACK), (0.5, mirror()))]
    assert "coincidence" not in compiled(scene_of([beam((0, 0, 1), "-z")], flush)).effects
    apart = [{**wall((0, 0, z), a), **glass(1.5)} for z, a in ((0, "+z"), (1e-9, "-z"))]
    assert "coincidence" not in compiled(scene_of([beam((0, 0, 1), "-z")], apart)).effects
