"""`probe` on cases whose answer is plain."""

from __future__ import annotations

import math

import numpy as np
import pytest

import photizon_cl as pz

BLACK = {"kind": "absorber"}


def scene(*elements, at=(0.0, 0.0, 50.0)):
    return pz.load(
        {
            "schema": "photizon/1",
            "name": "probed",
            "source": [{"name": "s", "kind": "isotropic-point", "flux": 1.0, "position": list(at)}],
            "element": [{"surface": BLACK, **e} for e in elements],
        }
    )


PLANE = {
    "name": "plane", "kind": "rectangle", "position": [0, 0, 0], "axis": "+z",
    "half_width": 1.0, "half_height": 0.5,
}  # fmt: skip
DISK = {"name": "disk", "kind": "disk", "position": [0, 0, 2], "axis": "-z", "radius": 0.5}
BALL = {"name": "ball", "kind": "sphere", "position": [5, 0, 0], "axis": "+x", "radius": 1.0}
PORTED = {**BALL, "name": "ported", "port_fraction": 0.05}


@pytest.mark.parametrize("lanes", [1, 8, 16])
def test_plane_and_disk(lanes):
    hits = pz.probe(
        scene(PLANE, DISK),
        [[0, 0, 1], [0, 0, 1], [0.9, 0.4, 3], [1.1, 0, 1], [0, 0, -1], [1.0, 0.5, 1]],
        [[0, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, -1], [0, 0, 1], [0, 0, -1]],
        lanes=lanes,
    )
    assert hits.element.tolist() == [0, 1, 0, -1, 0, 0]  # an edge and a corner belong to the plane
    assert hits.distance.tolist() == [1.0, 1.0, 3.0, math.inf, 1.0, 1.0]
    assert hits.point[0].tolist() == [0.0, 0.0, 0.0]
    assert hits.normal[0].tolist() == [0.0, 0.0, 1.0]
    assert hits.normal[1].tolist() == [0.0, 0.0, -1.0]
    assert hits.normal[4].tolist() == [0.0, 0.0, 1.0]  # outward, whatever side it comes from
    assert np.isnan(hits.point[3]).all()
    assert np.isnan(hits.normal[3]).all()


def test_sphere_from_outside_and_inside():
    hits = pz.probe(
        scene(BALL), [[0, 0, 0], [5, 0, 0], [5, 0, 2]], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    )
    assert hits.distance.tolist() == [4.0, 1.0, math.inf]
    assert hits.point[:2].tolist() == [[4.0, 0.0, 0.0], [5.0, 1.0, 0.0]]
    assert hits.normal[:2].tolist() == [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def test_port():
    hits = pz.probe(
        scene(PORTED), [[5, 0, 0], [9, 0, 0], [9, 0.5, 0]], [[1, 0, 0], [-1, 0, 0], [-1, 0, 0]]
    )
    assert hits.element.tolist() == [-1, 0, 0]
    assert hits.distance[1] == 5.0  # in through the port, onto the far wall
    # the port's rim lies at 0.436 R: this one meets the wall beside it
    assert hits.distance[2] == pytest.approx(4.0 - math.sqrt(0.75), rel=1e-15)


def test_a_ray_that_starts_on_a_face_leaves_it():
    hits = pz.probe(
        scene(PLANE, BALL), [[0, 0, 0], [4, 0, 0], [4, 0, 0]], [[0, 0, -1], [-1, 0, 0], [1, 0, 0]]
    )
    assert hits.element.tolist() == [-1, 0, 1] or hits.element.tolist() == [-1, -1, 1]
    assert hits.distance[2] == pytest.approx(2.0, rel=1e-15)


def test_directions_are_brought_to_unit_length():
    directions = [[0, 0, -7.0], [0, 0, -1e-200], [0, 0, -1e300], [0, 3e-310, -4e-310]]
    hits = pz.probe(scene(PLANE), [[0, 0, 1]] * 4, directions)
    assert hits.distance[:3].tolist() == [1.0] * 3
    assert hits.distance[3] == math.inf  # it passes v = 0.75


def test_a_scene_far_from_the_origin():
    far = [1e6, -2e6, 3e6]
    moved = {**BALL, "position": far}
    hits = pz.probe(scene(moved, at=[1e6, -2e6, 3e6]), [far], [[0, 0, 1]])
    assert hits.distance[0] == 1.0
    assert hits.point[0].tolist() == [1e6, -2e6, 3e6 + 1]


def test_nothing_to_hit_and_nothing_to_ask():
    assert pz.probe(scene(), [[0, 0, 1]], [[0, 0, 1]]).element.tolist() == [-1]
    empty = pz.probe(scene(PLANE), np.empty((0, 3)), np.empty((0, 3)))
    assert empty.distance.shape == (0,)
    assert empty.point.shape == (0, 3)


@pytest.mark.parametrize(
    ("origins", "directions", "message"),
    [
        ([0, 0, 1], [[0, 0, 1]], "origins: found the shape"),
        ([[0, 0]], [[0, 0, 1]], "origins: found the shape"),
        ([[0, 0, 1]], [[0, 0, 1], [0, 0, 1]], "directions: found 2 rows, expected 1"),
        ([[0, 0, math.nan]], [[0, 0, 1]], "origins\\[0\\]"),
        ([[0, 0, 1]], [[0, 0, math.inf]], "directions\\[0\\]"),
        ([[0, 0, 1]], [[0, 0, 0]], "expected a direction"),
        ([["a", 0, 1]], [[0, 0, 1]], "origins: expected numbers"),
    ],
)
def test_bad_rays(origins, directions, message):
    with pytest.raises(pz.ArgumentError, match=message):
        pz.probe(scene(PLANE), origins, directions)


HERE = {"position": [0, 0, 0], "axis": "+z"}
TUBE = {"name": "tube", "kind": "baffled-tube", **HERE, "half_width": 1.0, "length": 4.0}
BAFFLED = {**TUBE, "baffles": 3, "clear_half_width": 0.5}
CPC = {"name": "cpc", "kind": "cpc", **HERE, "exit_radius": 0.5, "acceptance_deg": 30.0}
PLANO = {
    "name": "lens", "kind": "plano-convex", **HERE, "curvature_radius": 2.0, "aperture_radius": 1.0
}  # fmt: skip
BICONVEX = {
    "name": "lens", "kind": "biconvex", **HERE, "front_radius": 2.0, "back_radius": 3.0,
    "aperture_radius": 1.0,
}  # fmt: skip
DOWN, UP = [0, 0, -1], [0, 0, 1]


@pytest.mark.parametrize(
    ("element", "rays", "names"),
    [
        (PLANE, [([0, 0, 1], DOWN), ([0, 0, -1], UP), ([5, 0, 1], DOWN)], ["face", "face", ""]),
        (DISK, [([0, 0, 3], DOWN), ([0, 0, 1], UP), ([5, 0, 1], UP)], ["face", "face", ""]),
        (PORTED, [([5, 0, 0], [0, 1, 0]), ([5, 0, 0], [1, 0, 0])], ["wall", ""]),
        (CPC, [([0, 0, 0.1], [1, 0, 0]), ([0, 0, 0.1], UP)], ["wall", ""]),
        (TUBE, [([0, 0, 1], [1, 0, 0]), ([0, 0, 1], [0, -1, 0]), ([0, 0, 1], UP)],
         ["wall", "wall", ""]),
        (BAFFLED, [([0.7, 0, 0.5], UP), ([0.7, 0, 1.5], UP), ([0.7, 0, 3.5], DOWN),
                   ([0, 0, 1.5], [0, 1, 0]), ([0, 0, 0.5], UP)],
         ["baffle 1", "baffle 2", "baffle 3", "wall", ""]),
        (PLANO, [([0, 0, -1], UP), ([0, 0, 1], DOWN), ([2, 0, 1], DOWN)], ["flat", "curved", ""]),
        (BICONVEX, [([0, 0, 1], DOWN), ([0, 0, -1], UP), ([2, 0, 1], DOWN)],
         ["front", "back", ""]),
    ],
    ids=lambda value: value["name"] if isinstance(value, dict) else "",
)  # fmt: skip
def test_the_face_has_its_name_and_lies_where_the_element_says(element, rays, names):
    body = scene(element).element[0]
    origins, directions = zip(*rays, strict=True)
    hits = pz.probe(scene(element), origins, directions)
    assert hits.face.tolist() == names
    assert set(names) - {""} <= set(body.face_names)
    for name, point in zip(names, hits.point.tolist(), strict=True):
        local = body.local(tuple(point))
        on = {face.name for face in body.faces if name and face.touches(local, 1e-12)}
        assert on == ({name} if name else set())


def test_names_of_faces_in_a_scene_of_several():
    hits = pz.probe(
        scene(PLANE, {**BAFFLED, "position": [0, 0, 5]}),
        [[0, 0, 1], [0.7, 0, 5.5], [9, 9, 9], [0.7, 0, 6.5]],
        [DOWN, UP, UP, UP],
    )
    assert hits.element.tolist() == [0, 1, -1, 1]
    assert hits.face.tolist() == ["face", "baffle 1", "", "baffle 2"]
    assert pz.probe(scene(PLANE), np.empty((0, 3)), np.empty((0, 3))).face.shape == (0,)
