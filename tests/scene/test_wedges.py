"""What the compiler finds out about elements that meet: neighbours, angles, faces at a point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from photizon_cl.geometry.contact import in_contact, note_size
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.wedges import edge_factors as factors_of
from photizon_cl.scene.elements.baffled_tube import BaffledTube
from photizon_cl.scene.elements.disk import Disk
from photizon_cl.scene.elements.rectangle import Rectangle
from photizon_cl.scene.elements.sphere import Sphere
from photizon_cl.scene.surfaces.mirror import Mirror
from photizon_cl.stability.families_mixed import room

SILVER = Mirror(1.0)


def edge_factors(elements: Any) -> np.ndarray:
    """Return the largest factor of each element's edges."""
    return factors_of(Neighbours(elements)).max(axis=1)


def plate(at: float, **changes: Any) -> Rectangle:
    """Return a plate along x that starts at the z axis and rises by `at` degrees."""
    angle = math.radians(at)
    given: dict[str, Any] = {
        "name": "plate", "axis": "+z", "tilt_deg": (0.0, -at), "surface": SILVER,
        "position": (math.cos(angle), 0.0, math.sin(angle)), "half_width": 1.0, "half_height": 1.0,
    }  # fmt: skip
    return Rectangle(**(given | changes))


FLOOR = plate(0.0, name="floor")


@pytest.mark.parametrize("angle", [25.0, 10.0, 1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("obtuse", [False, True])
def test_plates_that_share_an_edge_know_their_angle(angle: float, obtuse: bool) -> None:
    other = plate(180.0 - angle if obtuse else angle)
    want = 1.0 / math.sin(math.radians(angle))
    assert edge_factors([FLOOR, other]) == pytest.approx([want, want], rel=1e-6)


def test_only_the_edge_that_is_shared_needs_room() -> None:
    want = 1.0 / math.sin(math.radians(5.0))
    assert factors_of(Neighbours([FLOOR, plate(5.0)]))[0] == pytest.approx([1.0, want, 1.0, 1.0])


@pytest.mark.parametrize("angle", [31.0, 90.0, 149.0, 180.0])
def test_wide_angles_need_nothing(angle: float) -> None:
    assert edge_factors([FLOOR, plate(angle)]).tolist() == [1.0, 1.0]


def test_a_plate_that_ends_on_another_needs_room_and_the_other_does_not() -> None:
    wide = plate(0.0, position=(0.0, 0.0, 0.0), half_width=5.0, half_height=5.0)
    found = edge_factors([wide, plate(5.0)])
    assert found == pytest.approx([1.0, 1.0 / math.sin(math.radians(5.0))])


@pytest.mark.parametrize(
    "other",
    [
        plate(5.0, position=(1.0, 0.0, 1e-6 + math.sin(math.radians(5.0)))),  # a gap between them
        plate(5.0, position=(1.0, 0.0, 0.0)),  # through its middle
        plate(0.0, position=(2.0, 0.0, 0.0)),  # flush
        plate(5.0, position=(9.0, 0.0, 0.0)),  # elsewhere
    ],
    ids=["gap", "crossing", "flush", "elsewhere"],
)
def test_plates_that_share_no_edge(other: Rectangle) -> None:
    assert edge_factors([FLOOR, other]).tolist() == [1.0, 1.0]


def test_a_disk_on_the_wall_of_a_ball() -> None:
    where: dict[str, Any] = {"axis": "+z", "surface": SILVER}
    ball = Sphere(name="ball", position=(0.1, 0.2, 0.3), radius=1.0, **where)
    rim = 0.05
    height = 0.3 + math.sqrt(1.0 - rim * rim)
    disk = Disk(name="disk", position=(0.1, 0.2, height), radius=rim, **where)
    assert edge_factors([ball, disk]) == pytest.approx([1.0, 20.0])
    aside = Disk(name="disk", position=(0.11, 0.2, height), radius=rim, **where)
    assert edge_factors([ball, aside]).tolist() == [1.0, 1.0]


def test_a_plate_that_ends_on_a_tubes_wall() -> None:
    tube = BaffledTube(
        name="tube",
        position=(0.0, 0.0, -3.0),
        axis="+x",
        half_width=3.0,
        length=5.0,
        surface=SILVER,
    )
    found = edge_factors([tube, plate(5.0)])
    assert found == pytest.approx([1.0, 1.0 / math.sin(math.radians(5.0))])


def test_coincident_plates_share_their_factor() -> None:
    many = [FLOOR, *[plate(5.0)] * 3000]
    assert np.unique(edge_factors(many)).tolist() == [pytest.approx(1 / math.sin(math.radians(5)))]


def test_neighbours_by_tree_are_those_by_comparison(monkeypatch: pytest.MonkeyPatch) -> None:
    r = np.random.default_rng(4)
    low = r.uniform(-1, 1, (700, 3))
    low[:50] = low[0]  # coincident
    sizes = r.uniform(0, 0.1, 700)
    balls = [
        Sphere(name="b", axis="+z", position=tuple(at), radius=float(size), surface=SILVER)
        for at, size in zip(low.tolist(), sizes, strict=True)
    ]

    def pairs() -> np.ndarray:
        return np.concatenate([np.transpose(part) for part in Neighbours(balls).pairs()])

    dense = pairs()
    monkeypatch.setattr("photizon_cl.geometry.neighbours._DENSE", 0)
    assert len(dense) > 1000
    assert (pairs() == dense).all()


def test_words_for_as_many_faces_as_can_meet() -> None:
    box = list(room((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), surface=SILVER))
    assert not in_contact(Neighbours(box))
    assert note_size(Neighbours(box)) == (2, 16)
    four = [w for x in (0, 1) for y in (0, 1) for w in room((x, y, 0), (x + 1, y + 1, 1.0))]
    assert note_size(Neighbours(four)) == (4, 16)  # twelve at a point
    below = [w for x in (0, 1) for y in (0, 1) for w in room((x, y, -1), (x + 1, y + 1, 0.0))]
    assert note_size(Neighbours(four + below)) == (6, 16)  # twenty-four
    assert note_size(Neighbours(box * 400)) == (12, 32)
    # a large wall has many elements around it, of which no two meet
    tiles = [plate(0.0, position=(3.0 * n, 0.0, 0.0)) for n in range(100)]
    wall = plate(0.0, position=(150.0, 0.0, 0.0), half_width=160.0)
    assert note_size(Neighbours([wall, *tiles])) == (2, 16)
