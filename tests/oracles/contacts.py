"""Bodies in contact: scenes of plane slabs, and what they must do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from oracles import films, tracer
from oracles.engine import probe, scene_of, trace
from oracles.scenes import BLACK, beam, glass, mirror, wall

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.model import Scene

THICK = 0.01
"""Of each slab, in metres."""
PENCIL = 1e-140
"""Radius of a beam so thin that its rays start in the very position of the source."""


def slabs(
    indices: Sequence[float],
    angle_deg: float,
    axis: str = "+z",
    tilt: tuple[float, float] = (0.0, 0.0),
    place: Sequence[float] = (0.0, 0.0, 0.0),
    order: Sequence[int] | None = None,
    *,
    cemented: bool = False,
) -> Scene:
    """Return slabs in contact, a beam onto the first, and black walls before and behind.

    `order` is that of the faces, two a slab, in the file. Where slabs are cemented the touching
    face of each has the next one's index outside, and the next one's is clear.
    """
    pose = {"axis": axis, "tilt_deg": list(tilt)}
    u, _, w = (np.array(x) for x in tracer.frame(pose))
    # half a turn about u of the untilted frame turns the normal round, whatever the tilt
    turned = {"axis": axis, "tilt_deg": [tilt[0] + 180.0, tilt[1]]}
    shape = {"kind": "rectangle", "half_width": 3.0, "half_height": 3.0}
    at = lambda z: (np.array(place) + z * w).tolist()  # noqa: E731
    faces = []
    for n, index in enumerate(indices):
        first, last = n == 0, n == len(indices) - 1
        outside = 1.0 if last or not cemented else indices[n + 1]
        front = glass(index) if first or not cemented else {"surface": {"kind": "clear"}}
        front_face = {**shape, **turned, "position": at(n * THICK), **front}
        back_face = {**shape, **pose, "position": at((n + 1) * THICK), **glass(index, outside)}
        faces.append({"name": f"slab {n} front", **front_face})
        faces.append({"name": f"slab {n} back", **back_face})
    angle = math.radians(angle_deg)
    d = math.sin(angle) * u + math.cos(angle) * w
    height = 0.1 * math.cos(angle)
    black = {**shape, **pose, **BLACK, "detector": {}}
    walls = [
        {"name": "before", **black, "position": at(-2.0 * height)},
        {"name": "behind", **black, "position": at(2.0 * height + len(indices) * THICK)}
        | {"detector": {"side": "back"}},
    ]
    lamp = beam(tuple((np.array(place) - 0.1 * d).tolist()), "+z", PENCIL)
    lamp["tilt_deg"] = [
        math.degrees(math.asin(max(-1.0, min(1.0, -d[1])))),
        math.degrees(math.atan2(d[0], d[2])),
    ]
    return scene_of([lamp], [faces[n] for n in order or range(len(faces))] + walls)


def is_film(scene: Scene, want: films.Film, cap: int, room: float = 1e-12) -> None:
    """Assert what is transmitted, reflected and left after `cap` interactions."""
    found = trace(scene, rays_per_batch=2, generation_cap=cap)
    got = [
        float(x) / 2
        for x in (
            found.detector("behind").power,
            found.detector("before").power,
            found.depth_capped,
        )
    ]
    for value, wanted in zip(got, (want.transmitted, want.reflected, want.left), strict=True):
        assert abs(value - wanted) < room, (got, want)


def have_a_film() -> None:
    """Two slabs, in both orders of the file, along the axes and tilted."""
    want = films.stack([1.0, 1.5, 1.0, 1.8, 1.0], 60.0, 8)
    for order in ((0, 1, 2, 3), (3, 2, 1, 0)):
        for pose in (("+z", (0.0, 0.0), (0.0, 0.0, 0.0)), ("+z", (33.3, -71.7), (0.3, -0.2, 0.1))):
            is_film(slabs([1.5, 1.8], 60.0, *pose, order=order), want, 8)


def clear_lies_in_front() -> None:
    """A clear plane in a mirror, named behind it: what arrives and what is sent back pass it."""
    for surface, back in ((mirror(0.5), 0.5), (BLACK, 0.0)):
        faces = [
            {**wall((0.0, 0.0, 0.0), "+z"), "name": "wall", **surface},
            {**wall((0.0, 0.0, 0.0), "+z"), "name": "plane", "surface": {"kind": "clear"}},
        ]
        for side, power in (("front", 1.0), ("back", back)):
            faces[1]["detector"] = {"side": side}
            found = trace(scene_of([beam((0.0, 0.0, 1.0), "-z")], faces), rays_per_batch=64)
            assert float(found.detector("plane").power) / 64 == power


def walls_stand_on_floors(tilt: tuple[float, float] = (0.0, 0.0)) -> None:
    """Rays that meet a wall next to the floor it stands on, both with faces in their places."""
    _, v, w = (np.array(x) for x in tracer.frame({"axis": "+z", "tilt_deg": tilt}))
    flat = {"kind": "rectangle", "half_width": 1.0, "half_height": 1.0}
    upright = {"axis": "+z", "tilt_deg": list(tilt)}
    # a quarter turn about the untilted v brings the normal w to u
    aside = {"axis": "+z", "tilt_deg": [tilt[0], tilt[1] + 90.0]}
    n = np.array(tracer.frame(aside))[2]
    at = np.array([0.3, -0.2, 0.1])
    faces = [
        {**flat, **upright, "position": at.tolist(), "name": "floor", "surface": {"kind": "clear"}},
        {**flat, **upright, "position": at.tolist(), "name": "glass", **glass(1.5)},
        {**flat, **aside, "position": (at + w).tolist(), "name": "wall", **BLACK},
        {**flat, **aside, "position": (at + w).tolist(), "name": "pane", **glass(1.5)},
    ]
    scene = scene_of([beam((0, 0, 9), "-z")], faces)
    heights = 2.0 ** np.arange(-44.0, -36.0)  # beyond the rounding of where the floor is
    starts = np.array([at + 0.5 * n + 0.5 * w + 0.01 * v for _ in heights])
    aims = np.array([at + h * w + 0.01 * v for h in heights]) - starts
    found = probe(scene, starts, aims / np.linalg.norm(aims, axis=1)[:, None])
    # the pane is met from outside, so the wall comes first; the floor lies beyond
    names = {scene.element[int(element)].name for element in found.element}
    assert names == {"wall"}
