"""The element `lens`: its geometry, its files, and what it refuses."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.errors import SceneError
from photizon_cl.scene.faces import Plane
from photizon_cl.scene.writing import to_json, to_toml

SIZES: dict[str, Any] = {
    "front_radius": 0.06, "back_radius": -0.2, "thickness": 0.012, "aperture_radius": 0.025,
}  # fmt: skip
PLACE: dict[str, Any] = {"name": "lens", "kind": "lens", "position": [0.0, 0.0, 0.0], "axis": "+z"}
GLASS = {"kind": "fresnel", "index": 1.5}
LAMP = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.0, 1.0]}


def tables(**changes: Any) -> dict[str, Any]:
    element = {**PLACE, **SIZES, "surface": GLASS, **changes}
    return {"schema": "photizon/1", "name": "one", "source": [LAMP], "element": [element]}


def lens(**changes: Any) -> Any:
    return pz.load(tables(**changes)).element[0]


def refused(**changes: Any) -> list[str]:
    """Return the lines with which a lens is refused."""
    with pytest.raises(SceneError) as told:
        lens(**changes)
    return str(told.value).split("\n")


def exact_sag(radius: float, k: float, r: float) -> Any:
    if math.isinf(radius):
        return mpmath.mpf(0)
    c, x = 1 / mpmath.mpf(radius), mpmath.mpf(r)
    return c * x * x / (1 + mpmath.sqrt(max(1 - (1 + mpmath.mpf(k)) * c * c * x * x, 0)))


SHAPES = [
    (0.06, -0.2, 0.0, 0.0, 0.012), (-0.06, -0.2, 0.0, 0.0, 0.003),
    (math.inf, -0.06, 0.0, 0.5, 0.002),
    (0.025, 0.025, 0.0, 0.0, 0.06), (0.02, -0.02, -2.25, -1.0, 0.004), (1e6, -1e3, 0.0, 0.0, 1e-4),
]  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_edge_and_vertices_are_those_of_the_sags(shape: Any) -> None:
    front, back, k1, k2, thickness = shape
    one = lens(
        front_radius=front, back_radius=back, thickness=thickness,
        **({"front_conic": k1} if k1 else {}), **({"back_conic": k2} if k2 else {}),
    )  # fmt: skip
    with mpmath.workdps(50):
        s1, s2 = exact_sag(front, k1, 0.025), exact_sag(back, k2, 0.025)
        edge = mpmath.mpf(thickness) - s1 - s2
        size = float(abs(s1) + abs(s2) + thickness)
        assert abs(one.edge_thickness - edge) < 4e-16 * size
        for got, want in zip(one.vertices, (edge / 2 + s1, -edge / 2 - s2), strict=True):
            assert abs(got - want) < 4e-16 * size
    assert one.vertices[0] - one.vertices[1] == pytest.approx(thickness, rel=1e-15)
    low, high = one.local_box
    assert low[2] <= min(one.vertices) <= max(one.vertices) <= high[2]
    for face, radius in zip(one.faces, (front, back), strict=False):
        assert isinstance(face, Plane) == math.isinf(radius)
        if not isinstance(face, Plane):
            r, z = face.profile(np.linspace(0.0, 1.0, 101))
            assert np.hypot(r, z).max() <= one.reach * (1.0 + 1e-15)
            assert all(one.touches((x, 0.0, y), 1e-15) for x, y in zip(r, z, strict=True))
    assert one.face_names == ("front", "back", "edge")


def test_areas_are_exact() -> None:
    plate = lens(front_radius=math.inf, back_radius="inf", thickness=0.01)
    r = 0.025
    assert plate.area == pytest.approx(2.0 * math.pi * r * r + 2.0 * math.pi * r * 0.01, rel=1e-15)
    hollow = lens(front_radius=-0.06, back_radius=-0.2)
    full = lens(front_radius=0.06, back_radius=0.2)
    faces = [one.area - 2.0 * math.pi * r * one.edge_thickness for one in (hollow, full)]
    assert faces[0] == pytest.approx(faces[1], rel=1e-13)
    caps = pz.Biconvex(
        name="caps", position=(0, 0, 0), axis="+z", front_radius=0.06, back_radius=0.2,
        aperture_radius=r, surface=pz.Absorber(),
    )  # fmt: skip
    assert faces[0] == pytest.approx(caps.area, rel=1e-13)


def test_a_lens_as_thick_as_its_sags_has_no_edge() -> None:
    sag = 0.06 - math.sqrt(0.06**2 - 0.025**2)
    for off in (0.0, 1e-17, -1e-17):
        one = lens(front_radius=0.06, back_radius=math.inf, thickness=sag + off)
        assert one.edge_thickness == 0.0
        assert one.face_names == ("front", "back")
        assert one.surfaces == (pz.Fresnel(index=1.5),)
    # a meniscus that is sharp at the rim
    thin = lens(
        front_radius=0.06, back_radius=-0.2,
        thickness=sag - (0.2 - math.sqrt(0.2**2 - 0.025**2)),
    )  # fmt: skip
    assert thin.edge_thickness == 0.0


# -- files -----------------------------------------------------------------------------------------


def test_an_infinite_radius_goes_through_every_file(tmp_path: Any) -> None:
    scene = pz.load(tables(front_radius=math.inf, back_radius=-0.06, thickness=0.002))
    assert "front_radius = inf\n" in to_toml(scene)
    assert json.loads(to_json(scene))["element"][0]["front_radius"] == "inf"
    for name in ("one.toml", "one.json"):
        scene.save(tmp_path / name)
        assert pz.load(tmp_path / name) == scene
        assert pz.load(tmp_path / name).digest() == scene.digest()
    assert pz.load(tables(front_radius="inf", back_radius=-0.06, thickness=0.002)) == scene
    changed = scene.replace({"element.lens.front_radius": 0.05, "element.lens.thickness": 0.02})
    assert (
        changed.replace({"element.lens.front_radius": "inf", "element.lens.thickness": 0.002})
        == scene
    )
    result = pz.trace(scene, batches=1, rays_per_batch=16)
    assert pz.Recipe.read(result.recipe).scene.digest() == result.scene.digest()


def test_surfaces_of_faces_have_paths_and_are_written() -> None:
    scene = pz.load(tables(edge={"kind": "lambertian", "reflectance": 0.5}))
    assert scene.element[0].edge == pz.Lambertian(reflectance=0.5)
    matt = scene.replace({"element.lens.edge.reflectance": 0.8})
    assert matt.element[0].edge == pz.Lambertian(reflectance=0.8)
    silvered = scene.replace({"element.lens.back": {"kind": "mirror", "reflectance": 0.9}})
    assert silvered.element[0].surfaces == (
        pz.Fresnel(index=1.5), pz.Mirror(reflectance=0.9), pz.Lambertian(reflectance=0.5),
    )  # fmt: skip
    assert pz.load(silvered.to_dict()) == silvered
    assert [silvered.element[0].surface_of(n).kind for n in range(3)] == [
        "fresnel", "mirror", "lambertian",
    ]  # fmt: skip
    assert "edge" not in lens().to_table() or lens().to_table()["edge"] == {"kind": "absorber"}


# -- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "path", "said"),
    [
        ({"front_radius": 0.0}, "front_radius", "a flat face is inf"),
        ({"front_radius": -math.inf}, "front_radius", "without a sign"),
        ({"back_radius": math.nan}, "back_radius", "a radius in metres"),
        ({"back_radius": "flat"}, "back_radius", "text is not a number"),
        ({"back_radius": 1e-200}, "back_radius", "from 1e-150 to 1e150"),
        ({"front_radius": 0.02}, "aperture_radius", "at most |front_radius|, 0.02"),
        ({"back_radius": -0.02}, "aperture_radius", "at most |back_radius|, 0.02"),
        (
            {"front_radius": 0.03, "front_conic": 1.0}, "aperture_radius",
            "at most |front_radius|/sqrt(1 + front_conic), 0.0212132",
        ),
        (
            {"front_radius": math.inf, "front_conic": -1.0}, "front_conic",
            "0, or no such key, where the face is flat",
        ),
        ({"thickness": 0.0035}, "thickness", "at least the sags of both faces at the rim together"),
        ({"thickness": 0.0}, "thickness", "a positive length"),
        ({"edge": "absorber"}, "edge", 'write { kind = "absorber" }'),
        ({"edge": {"kind": "glass"}}, "edge.kind", "one of"),
        ({"front": {"kind": "mirror"}}, "front.reflectance", "requires the key reflectance"),
        ({"detector": {}}, "detector", "no detector on a fresnel surface"),
        (
            {"surface": {"kind": "absorber"}, "detector": {}, "back": GLASS}, "back.kind",
            "no fresnel surface beside a detector",
        ),
        (
            {"surface": {"kind": "absorber"}, "detector": {"map": [2, 2]}}, "detector.map",
            "no map on a lens",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(
    changes: dict[str, Any], path: str, said: str
) -> None:
    (line,) = refused(**changes)
    assert f"element[0].{path}" in line
    assert said in line
    assert '"lens"' in line


def test_faces_that_cross_before_the_rim_are_refused() -> None:
    """Their sags at the rim leave an edge, and in between they do not."""
    shape = {"front_radius": 0.03, "back_radius": -0.028, "front_conic": -3.0, "back_conic": 0.2}
    made = {**shape, "aperture_radius": 0.025}
    r = np.linspace(0.0, 0.025, 2001)

    def sag(radius: float, k: float) -> Any:
        return r * r / radius / (1.0 + np.sqrt(1.0 - (1.0 + k) * r * r / radius**2))

    needed = sag(0.03, -3.0) - sag(0.028, 0.2)
    at = int(needed.argmax())
    if not 0 < at < 2000:  # the other way round
        shape = {
            "front_radius": 0.028,
            "back_radius": -0.03,
            "front_conic": -3.0,
            "back_conic": 0.2,
        }
        made = {**shape, "aperture_radius": 0.025}
        needed = sag(0.028, -3.0) - sag(0.03, 0.2)
        at = int(needed.argmax())
    assert 0 < at < 2000
    thinnest, rim = float(needed[at]), float(needed[-1])
    assert thinnest > rim
    thickness = max(thinnest * 0.99, rim + 1e-6)
    (line,) = refused(**made, thickness=thickness)
    assert "element[0].thickness" in line
    assert "the faces would cross or touch at" in line
    assert lens(**made, thickness=thinnest * 1.01).edge_thickness > 0.0


def test_python_refuses_the_same() -> None:
    one = lens()
    with pytest.raises(SceneError, match="thickness"):
        replace(one, thickness=1e-4)
    with pytest.raises(SceneError, match="edge"):
        replace(one, edge="absorber")
