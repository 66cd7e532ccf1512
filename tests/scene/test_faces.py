"""Faces of elements, and that what follows from them needs to know no kind."""

from __future__ import annotations

import io
import math
import pathlib
import pickle
import tokenize
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pytest

import photizon_cl as pz
from photizon_cl.geometry.contact import in_contact
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.outlines import cut, edges, facets
from photizon_cl.geometry.wedges import edge_factors
from photizon_cl.scene.declarations import positive_length
from photizon_cl.scene.elements.base import Element
from photizon_cl.scene.elements.flat import Flat
from photizon_cl.scene.faces import Ball, Plane, Revolved
from photizon_cl.scene.outlines import Circular, Rectangular
from photizon_cl.scene.registry import ELEMENTS, SOURCES, SURFACES
from photizon_cl.views.drawing.sections import DETECTOR, SOURCE

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")

SILVER, BLACK = pz.Mirror(1.0), pz.Absorber()
WHERE: dict[str, Any] = {"position": (0.3, -0.2, 0.1), "axis": "-y", "surface": BLACK}
TURNED: dict[str, Any] = {**WHERE, "tilt_deg": (25.0, -40.0)}


def elements(**where: Any) -> list[Element]:
    """Return one of each kind, a tube with baffles and a sphere with a port."""
    return [
        pz.Rectangle(name="rectangle", half_width=0.5, half_height=0.2, **where),
        pz.Disk(name="disk", radius=0.4, **where),
        pz.Sphere(name="ported", radius=0.5, port_fraction=0.2, **where),
        pz.Cpc(name="cpc", exit_radius=0.1, acceptance_deg=25.0, **where),
        pz.BaffledTube(
            name="tube", half_width=0.2, length=1.0, baffles=2, clear_half_width=0.1, **where
        ),
        pz.PlanoConvex(name="plano", curvature_radius=0.5, aperture_radius=0.3, **where),
        pz.Biconvex(
            name="biconvex", front_radius=0.5, back_radius=0.8, aperture_radius=0.3, **where
        ),
        pz.Cylinder(name="cylinder", radius=0.3, length=0.8, **where),
        pz.Cone(name="cone", entrance_radius=0.4, exit_radius=0.1, length=0.6, **where),
        pz.Conic(
            name="conic",
            curvature_radius=0.6,
            conic_constant=-1.5,
            aperture_radius=0.4,
            inner_radius=0.1,
            **where,
        ),
        pz.Lens(
            name="lens", front_radius=-0.6, back_radius=0.5, back_conic=-1.5, thickness=0.3,
            aperture_radius=0.4, **where,
        ),
    ]  # fmt: skip


KINDS = [e.kind for e in elements(**WHERE)]
NAMES = {
    "rectangle": ("face",),
    "disk": ("face",),
    "sphere": ("wall",),
    "cpc": ("wall",),
    "baffled-tube": ("wall", "baffle 1", "baffle 2"),
    "plano-convex": ("flat", "curved"),
    "biconvex": ("front", "back"),
    "cylinder": ("wall",),
    "cone": ("wall",),
    "conic": ("sheet",),
    "lens": ("front", "back", "edge"),
}


def test_every_element_names_its_faces() -> None:
    assert sorted(KINDS) == sorted(ELEMENTS)
    assert {e.kind: e.face_names for e in elements(**WHERE)} == NAMES


@pytest.mark.parametrize("number", range(len(KINDS)), ids=KINDS)
def test_faces_lie_on_the_surface_and_their_normals_are_those_of_the_kernels(number: int) -> None:
    element = elements(**TURNED)[number]
    frame, position = np.array(element.frame), np.array(element.position)
    for k, face in enumerate(element.faces):
        points, normals = points_and_normals(face)
        world, across = points @ frame + position, normals @ frame
        start = 1e-3 * across
        scene = pz.Scene(
            name="n", source=(pz.IsotropicPoint(name="s", flux=1.0, position=(9.0, 9.0, 9.0)),),
            element=(element,),
        )  # fmt: skip
        hits = pz.probe(scene, world + start, -across)
        assert hits.distance == pytest.approx(1e-3, rel=1e-9)
        assert (hits.normal * across).sum(axis=1) == pytest.approx(1.0, abs=1e-12)
        assert set(hits.face.tolist()) == {face.name} == {element.face_name(k)}
        assert all(face.touches(tuple(p), 1e-12) for p in points.tolist())
        assert not any(face.touches(tuple(p), 1e-4) for p in (points + 1e-3 * normals).tolist())


def points_and_normals(face: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return some points of a face and the unit normals of its element there."""
    if isinstance(face, Plane):
        share = [(0.7, 0.6), (-0.6, 0.65), (0.1, -0.7)]
        points = face.points(np.array(share) * face.outline.half_sizes)
        return points, np.tile(face.sense * np.array(face.frame[2]), (3, 1))
    assert isinstance(face, Revolved)
    s, step = np.array([0.25, 0.5, 0.8]), 1e-6
    r, z = face.profile(s)
    (r0, z0), (r1, z1) = face.profile(s - step), face.profile(s + step)
    turn = np.array([0.3, 2.0, 4.5])
    along = np.hypot(r1 - r0, z1 - z0)
    out, up = (z1 - z0) / along, (r0 - r1) / along
    sign = np.where(out < 0.0, -face.sense, face.sense)
    normals = np.stack([out * np.cos(turn), out * np.sin(turn), up], 1) * sign[:, None]
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], 1), normals


def test_faces_are_values_and_do_not_travel() -> None:
    for a, b in zip(elements(**WHERE), elements(**TURNED), strict=True):
        assert a.faces == b.faces
        assert hash(a.faces) == hash(b.faces)
        again = pickle.loads(pickle.dumps(a))
        assert "faces" in vars(a)
        assert not {"faces", "outline"} & set(vars(again))
        assert again == a
        assert again.faces == a.faces


def test_the_hole_of_a_plane() -> None:
    face = Plane(name="f", outline=Circular(1.0), hole=Rectangular(0.5, 0.25))
    assert face.touches((0.5, 0.0, 0.0), 1e-12)  # the rim of a hole belongs to the face
    assert face.touches((0.6, 0.1, 0.0), 1e-12)
    assert not face.touches((0.4, 0.1, 0.0), 1e-12)
    assert not face.touches((1.1, 0.0, 0.0), 1e-12)
    assert not face.empty
    assert Plane(name="f", outline=Circular(1.0), hole=Circular(1.0)).empty


def test_what_a_side_is_hidden_from() -> None:
    plane, ball = Plane(name="f", outline=Circular(1.0)), Ball(name="b", radius=1.0)
    assert plane.hidden((0.0, 0.0, -0.5), 0.4, plus=True, passed=False)
    assert not plane.hidden((0.0, 0.0, -0.5), 0.6, plus=True, passed=False)
    assert plane.hidden((0.0, 0.0, 0.5), 0.4, plus=False, passed=False)
    assert not plane.hidden((0.0, 0.0, 0.5), 0.4, plus=True, passed=False)
    assert ball.hidden((0.0, 0.0, 0.5), 0.4, plus=True, passed=False)
    assert ball.hidden((0.0, 0.0, 1.5), 0.4, plus=False, passed=False)
    assert not ball.hidden((0.0, 0.0, 1.5), 0.4, plus=False, passed=True)  # through it
    assert ball.hidden((0.0, 0.0, 0.5), 0.4, plus=True, passed=True)
    assert not ball.hidden((0.0, 0.0, 0.5), 0.4, plus=False, passed=False)
    assert not Ball(name="z", radius=1.0, polar=(0.5, math.pi)).hidden(
        (0.0, 0.0, 0.5), 0.4, plus=True, passed=False
    )
    inward = Ball(name="b", radius=1.0, sense=-1.0)
    assert inward.hidden((0.0, 0.0, 0.5), 0.4, plus=False, passed=False)


# -- elements that no file of the product knows --------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Annulus(Flat):
    """A flat ring."""

    kind: ClassVar[str] = "test-annulus"
    has_map: ClassVar[bool] = False

    radius: float = field(metadata=positive_length("radius"))
    inner: float = field(metadata=positive_length("radius of the hole"))

    @cached_property
    def outline(self) -> Circular:
        return Circular(self.radius)

    @property
    def hole(self) -> Circular:
        return Circular(self.inner)

    @property
    def reach(self) -> float:
        return self.radius

    @property
    def area(self) -> float:
        return math.pi * (self.radius**2 - self.inner**2)

    def derived(self) -> dict[str, tuple[float, str]]:
        return {}


@dataclass(frozen=True, kw_only=True)
class Straight(Revolved):
    """The wall of a frustum."""

    first: float
    last: float
    length: float

    def profile(self, s: Any) -> tuple[Any, Any]:
        return self.first + s * (self.last - self.first), s * self.length


@dataclass(frozen=True, kw_only=True)
class Frustum(Element):
    """The wall of a frustum."""

    kind: ClassVar[str] = "test-frustum"
    family: ClassVar[str] = "walls"
    has_map: ClassVar[bool] = False
    default_side: ClassVar[str] = "inside"

    first: float = field(metadata=positive_length("first radius"))
    last: float = field(metadata=positive_length("last radius"))
    length: float = field(metadata=positive_length("length"))

    @cached_property
    def faces(self) -> tuple[Any, ...]:
        return (Straight(name="wall", first=self.first, last=self.last, length=self.length),)

    @property
    def reach(self) -> float:
        return math.hypot(max(self.first, self.last), self.length)

    @property
    def local_box(self) -> Any:
        a = max(self.first, self.last)
        return (-a, -a, 0.0), (a, a, self.length)

    @property
    def area(self) -> float:
        side = math.hypot(self.length, self.first - self.last)
        return math.pi * (self.first + self.last) * side

    def derived(self) -> dict[str, tuple[float, str]]:
        return {}


def area_of(polygons: list[np.ndarray]) -> float:
    """Return the area of plane polygons in space."""
    total = 0.0
    for p in polygons:
        total += 0.5 * float(np.linalg.norm(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)))
    return total


@pytest.mark.parametrize("where", [WHERE, TURNED], ids=["straight", "tilted"])
def test_outlines_of_elements_unknown_to_them(where: dict[str, Any]) -> None:
    ring = Annulus(name="ring", radius=0.5, inner=0.2, **where)
    wall = Frustum(name="wall", first=0.3, last=0.1, length=0.4, **where)
    for element in (ring, wall):
        for point in np.vstack([*edges(element), *facets(element)]):
            assert element.touches(element.local(tuple(point)), 1e-9)
        # rims are drawn as polygons, and cut as such
        cuts = [x for axis in range(3) for x in cut(element, axis, element.position[axis] + 0.05)]
        for point in np.vstack(cuts):
            assert element.touches(element.local(tuple(point)), 1e-4)
        assert area_of(facets(element)) == pytest.approx(element.area, rel=0.01)
    assert len(cut(ring, 0, 0.3)) == 2  # on both sides of the hole


def test_facets_between_outlines_of_different_shapes() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Plate(pz.Rectangle):
        @property
        def hole(self) -> Circular:
            return Circular(0.1)

    plate = Plate(name="p", half_width=0.5, half_height=0.2, **WHERE)
    assert area_of(facets(plate)) == pytest.approx(0.4 - math.pi * 0.01, rel=1e-4)
    for line in facets(plate):
        for point in line:
            assert plate.touches(plate.local(tuple(point)), 1e-12)


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (20.0, 10.0)], ids=str)
@pytest.mark.parametrize(("first", "last", "end"), [(2.0, 0.5, 0), (2.0, 0.5, 1), (0.1, 3.0, 0.4)])
def test_a_disk_knows_at_what_angle_its_rim_lies_on_a_wall(
    first: float, last: float, end: float, tilt: tuple[float, float]
) -> None:
    where: dict[str, Any] = {"axis": "+x", "tilt_deg": tilt, "surface": SILVER}
    wall = Frustum(name="w", position=(0.1, 0.2, 0.3), first=first, last=last, length=0.3, **where)
    at = np.array(wall.position) + end * wall.length * np.array(wall.frame[2])
    rim = first + end * (last - first)
    sine = 0.3 / math.hypot(0.3, last - first)
    disk = pz.Disk(name="d", position=tuple(at.tolist()), radius=rim, **where)
    assert edge_factors(Neighbours([wall, disk]))[1] == pytest.approx(1.0 / sine, rel=1e-6)
    small = pz.Disk(name="d", position=tuple(at.tolist()), radius=0.99 * rim, **where)
    assert (edge_factors(Neighbours([wall, small])) == 1.0).all()
    aside = pz.Disk(name="d", position=tuple((at + 0.01).tolist()), radius=rim, **where)
    assert (edge_factors(Neighbours([wall, aside])) == 1.0).all()


def test_contact_of_elements_unknown_to_it() -> None:
    where: dict[str, Any] = {"axis": "+z", "surface": SILVER}
    wall = Frustum(name="w", position=(0.0, 0.0, 0.0), first=1.0, last=0.5, length=1.0, **where)
    ring = Annulus(name="r", position=(0.0, 0.0, 0.5), radius=2.0, inner=0.1, **where)
    away = Annulus(name="r", position=(0.0, 0.0, 1.5), radius=2.0, inner=0.1, **where)
    assert in_contact(Neighbours([wall, ring]))
    assert not in_contact(Neighbours([wall, away]))
    floor = pz.Disk(name="f", position=(0.0, 0.0, 0.5), radius=1.0, **where)
    assert in_contact(Neighbours([ring, floor]))


def lines_about(*over: Element) -> list[str]:
    source = pz.IsotropicPoint(name="s", flux=1.0, position=(0.0, 0.0, 3.0))
    return pz.advisories(pz.Scene(name="f", source=(source,), element=over))


def test_flush_elements_with_holes() -> None:
    where: dict[str, Any] = {"axis": "+z", "surface": BLACK, "position": (0.0, 0.0, 0.0)}
    ring = Annulus(name="ring", radius=1.0, inner=0.5, **where)
    inside = pz.Disk(name="inside", radius=0.4, **where)
    over = pz.Disk(name="over", radius=0.6, **where)
    narrow = Annulus(name="narrow", radius=0.9, inner=0.6, **where)
    wide = Annulus(name="wide", radius=1.0, inner=0.3, **where)
    assert lines_about(ring, inside) == lines_about(inside, ring) == []
    (text,) = lines_about(ring, over)
    assert 'element "over" lies partly flush in "ring"' in text
    (text,) = lines_about(ring, narrow)
    assert '"narrow" is never hit' in text
    (text,) = lines_about(pz.Disk(name="disk", radius=1.0, **where), narrow)
    assert '"narrow" is never hit' in text
    assert lines_about(ring, wide) == []  # named first, it is the smaller one
    (text,) = lines_about(wide, ring)
    assert '"ring" is never hit' in text


# -- what sources and surfaces say ---------------------------------------------------------------


@pytest.mark.parametrize("kind", SOURCES)
def test_sources_say_how_far_they_reach(kind: str) -> None:
    values: dict[str, Any] = {"name": "s", "flux": 1.0, "position": (1.0, 2.0, 3.0)}
    if SOURCES[kind].directed:
        values |= {"axis": "-x", "tilt_deg": (10.0, 20.0)}
    sizes = {"radius": 0.25, "half_width": 0.15, "half_height": 0.2}
    values |= {k: v for k, v in sizes.items() if k in SOURCES[kind].__dataclass_fields__}
    if "half_angle_deg" in SOURCES[kind].__dataclass_fields__:
        values["half_angle_deg"] = 30.0
    source = SOURCES[kind](**values)
    sized = bool(set(sizes) & set(values))
    assert source.draws_position == sized
    assert source.reach == pytest.approx(0.25 if sized else 0.0)
    for line in source.outline():
        away = np.linalg.norm(line - np.array(source.position), axis=1)
        # of a rectangle the corners, of a circle every point
        assert away.max() == pytest.approx(source.reach)
        assert ("radius" not in values) or away.min() == pytest.approx(source.reach)
        assert len(line) > 1 or not sized


def test_surfaces_say_what_they_do() -> None:
    traits = ("absorbs", "reflects", "transmits", "refracts", "splits", "draws", "carries_detector")
    said = {kind: {t for t in traits if getattr(cls, t)} for kind, cls in SURFACES.items()}
    known = {
        "absorber": {"absorbs", "carries_detector"},
        "mirror": {"absorbs", "reflects"},
        "lambertian": {"absorbs", "reflects", "draws"},
        # one without a coating takes nothing
        "fresnel": {"absorbs", "reflects", "transmits", "refracts", "splits"},
        "clear": {"transmits", "carries_detector"},
        "mixed": {"absorbs", "reflects", "splits", "draws"},
    }
    assert {kind: said[kind] for kind in known} == known
    assert len({cls.label_text for cls in SURFACES.values()}) == len(SURFACES)
    # one from another, and from what drawings show besides
    colours = [cls.colour for cls in SURFACES.values()] + [DETECTOR, SOURCE]
    assert len(set(colours)) == len(colours)
    assert pz.Fresnel(1.5, 1.5).advice()
    assert not pz.Fresnel(1.5).advice()


def test_no_kind_is_named_where_faces_and_traits_are_asked() -> None:
    package = pathlib.Path(pz.__file__).parent
    tables = (ELEMENTS, SOURCES, SURFACES)
    kinds = {kind for table in tables for kind in table}
    classes = {cls.__name__ for table in tables for cls in table.values()}
    found = []
    for folder in ("geometry", "checks", "views", "result"):
        for path in sorted((package / folder).rglob("*.py")):
            for token in tokenize.generate_tokens(io.StringIO(path.read_text("utf-8")).readline):
                named = token.type == tokenize.NAME and token.string in classes
                quoted = token.type == tokenize.STRING and token.string.strip("\"'") in kinds
                if named or quoted:
                    found.append(f"{path.relative_to(package)}:{token.start[0]} {token.string}")
    assert found == []
