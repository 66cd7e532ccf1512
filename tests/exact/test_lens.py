"""The element `lens`: what it does to light, against closed forms and an independent trace."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracles.sequential import Surface, meridional

import photizon_cl as pz
from photizon_cl.compile.compiled import compile_scene

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly", "one_lane")

N = 1.5168
GLASS = pz.Fresnel(index=N)
HERE: dict[str, Any] = {"name": "lens", "position": (0.0, 0.0, 0.0), "axis": "+z"}


def black(z: float, half: float = 0.1, **detector: Any) -> pz.Rectangle:
    """A screen that light going down meets."""
    return pz.Rectangle(
        name="screen", position=(0.0, 0.0, z), axis="+z", half_width=half, half_height=half,
        surface=pz.Absorber(), detector=pz.Detector(**detector),
    )  # fmt: skip


def beam(radius: float, **more: Any) -> pz.CollimatedDisk:
    """Parallel light that goes down."""
    return pz.CollimatedDisk(
        name="beam", flux=1.0, position=(0.0, 0.0, 1.0), axis="-z", radius=radius, **more
    )


def scene(*elements: Any, source: Any = None, **run: Any) -> pz.Scene:
    settings = pz.RunSettings(**{"roulette_floor": 0.0, "generation_cap": 8, **run})
    return pz.Scene(name="lenses", source=(source or beam(0.01),), element=elements, run=settings)


def arrivals(made: pz.Scene, faces: int, rays: int = 200) -> tuple[Any, Any]:
    """Launch heights, and heights on the screen along the launch's azimuth, of the direct light."""
    found = pz.paths(made, rays=rays, seed=1)
    last = np.flatnonzero((found.element == len(made.element) - 1) & (found.generation == faces))
    assert len(last) == rays
    launched = found.start[found.generation == 0]
    assert (found.ray[found.generation == 0] == found.ray[last]).all()
    h = np.hypot(launched[:, 0], launched[:, 1])
    along = (found.end[last, :2] * launched[:, :2]).sum(axis=1) / h
    across = np.hypot(found.end[last, 0], found.end[last, 1])
    assert np.abs(across - np.abs(along)).max() < 1e-15  # it stays in its meridian
    return h, along


SHAPES = {
    "biconvex": (0.06, 0.09, 0.008),
    "biconcave": (-0.06, -0.09, 0.003),
    "meniscus": (0.04, -0.09, 0.006),
    "negative meniscus": (-0.09, 0.04, 0.003),
    "plano-convex": (math.inf, 0.05, 0.006),
    "plano-concave": (-0.05, math.inf, 0.002),
    "plate": (math.inf, math.inf, 0.004),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_paraxial_rays_meet_where_the_lensmakers_formula_says(shape: str) -> None:
    front, back, thickness = SHAPES[shape]
    lens = pz.Lens(
        **HERE, front_radius=front, back_radius=back, thickness=thickness, aperture_radius=0.012,
        surface=GLASS,
    )  # fmt: skip
    c1, c2 = 1.0 / front, 1.0 / back
    power = (N - 1.0) * (c1 + c2 - (N - 1.0) * thickness * c1 * c2 / N)
    # from the back vertex: f (1 − (N − 1) d c₁/N)
    back_focus = (1.0 - (N - 1.0) * thickness * c1 / N) / power if power else math.inf
    assert lens.focal_length == (pytest.approx(1.0 / power, rel=1e-15) if power else None)
    at = lens.vertices[1] - 0.02
    h, y = arrivals(scene(lens, black(at), source=beam(1e-6)), 2)
    # heights leave the last face as 1 − (N − 1) d c₁/N and fall by the power over the distance
    want = (1.0 - (N - 1.0) * thickness * c1 / N) - 0.02 * power
    assert y / h == pytest.approx(want, rel=1e-9)
    if power > 0.0:
        h, y = arrivals(scene(lens, black(lens.vertices[1] - back_focus), source=beam(1e-6)), 2)
        assert np.abs(y).max() < 1e-15


def test_a_plano_hyperbolic_lens_focuses_a_beam_to_rounding() -> None:
    """From a plane into air the ideal face is the hyperboloid with k = −n² (Descartes)."""
    lens = pz.Lens(
        **HERE, front_radius=math.inf, back_radius=0.05, back_conic=-N * N, thickness=0.025,
        aperture_radius=0.03, surface=GLASS,
    )  # fmt: skip
    focus = lens.vertices[1] - 0.05 / (N - 1.0)
    _, y = arrivals(scene(lens, black(focus), source=beam(0.029)), 2)
    assert np.abs(y).max() < 1e-16
    ball = replace(lens, back_conic=0.0)
    _, y = arrivals(scene(ball, black(ball.vertices[1] - 0.05 / (N - 1.0)), source=beam(0.029)), 2)
    assert np.abs(y).max() > 1e-3


def test_an_ellipsoidal_meniscus_focuses_a_beam_to_rounding() -> None:
    """Into glass it is the ellipsoid with k = −1/n²; the back face is a sphere about the focus."""
    inside = N * 0.05 / (N - 1.0)
    lens = pz.Lens(
        **HERE, front_radius=0.05, front_conic=-1.0 / (N * N), back_radius=-(inside - 0.02),
        thickness=0.02, aperture_radius=0.03, surface=GLASS,
    )  # fmt: skip
    focus = lens.vertices[0] - inside
    _, y = arrivals(scene(lens, black(focus), source=beam(0.029)), 2)
    assert np.abs(y).max() < 1e-16


def same_as(lens: pz.Lens, other: Any, names: dict[str, str]) -> None:
    """The screen sees the very same paths of the same powers."""
    tables = []
    for element in (lens, other):
        made = scene(element, black(-0.09, paths=40, generations=8), source=beam(0.02))
        result = pz.trace(made, batches=2, rays_per_batch=512)
        assert abs(result.ledger.closure) < 1e-15
        tables.append(result.detectors["screen"].paths.to_dataframe())
    mine, theirs = tables
    for old, new in names.items():
        theirs["sequence"] = theirs["sequence"].str.replace(old, new)
    assert (mine["sequence"] == theirs["sequence"]).all()
    assert len(mine) >= 3
    assert (mine["count"] == theirs["count"]).all()
    np.testing.assert_allclose(mine["power"], theirs["power"], rtol=1e-12)


def test_it_is_a_biconvex_lens_where_it_has_the_shape_of_one() -> None:
    other = pz.Biconvex(
        **HERE, front_radius=0.1, back_radius=0.07, aperture_radius=0.03, surface=GLASS
    )
    lens = pz.Lens(
        **HERE, front_radius=0.1, back_radius=0.07, aperture_radius=0.03,
        thickness=other.thickness, surface=GLASS,
    )  # fmt: skip
    assert lens.edge_thickness == 0.0
    assert lens.area == pytest.approx(other.area, rel=1e-14)
    for mine, theirs in zip(lens.local_box, other.local_box, strict=True):
        assert mine == pytest.approx(theirs, abs=1e-17)
    same_as(lens, other, {})


def test_it_is_a_plano_convex_lens_where_it_has_the_shape_of_one() -> None:
    other = pz.PlanoConvex(**HERE, curvature_radius=0.07, aperture_radius=0.03, surface=GLASS)
    lens = pz.Lens(
        **HERE, front_radius=0.07, back_radius=math.inf, aperture_radius=0.03,
        thickness=other.thickness, surface=GLASS,
    )  # fmt: skip
    same_as(lens, other, {"lens.flat": "lens.back", "lens.curved": "lens.front"})


# -- two lenses ------------------------------------------------------------------------------------

CROWN, FLINT = 1.5168, 1.6727
RADII = (0.06185, -0.04468, -0.12956)
THICK = (0.008, 0.0025)


def doublet(**flint: Any) -> tuple[pz.Lens, pz.Lens]:
    """A cemented doublet: light goes down through the crown, then the flint."""
    first, second, third = RADII
    crown = pz.Lens(
        **{**HERE, "name": "crown"}, front_radius=first, back_radius=-second, thickness=THICK[0],
        aperture_radius=0.0125, surface=pz.Fresnel(CROWN), back=pz.Fresnel(CROWN, FLINT),
    )  # fmt: skip
    other = pz.Lens(
        **{**HERE, "name": "flint"}, front_radius=second, back_radius=-third, thickness=THICK[1],
        aperture_radius=0.0125, surface=pz.Fresnel(FLINT), **{"front": pz.Clear(), **flint},
    )  # fmt: skip
    return crown, replace(other, position=(0.0, 0.0, crown.vertices[1] - other.vertices[0]))


@pytest.mark.parametrize("flint_first", [False, True])
@pytest.mark.parametrize("tilted", [False, True])
def test_heights_behind_a_cemented_doublet_are_those_of_a_sequential_trace(
    flint_first: bool, tilted: bool
) -> None:
    crown, flint = doublet()
    faces = [
        Surface(0.0, RADII[0], CROWN),
        Surface(THICK[0], RADII[1], FLINT),
        Surface(sum(THICK), RADII[2], 1.0),
    ]
    at, slope = 0.12, math.tan(math.radians(2.0)) if tilted else 0.0
    elements = (flint, crown) if flint_first else (crown, flint)
    top = crown.vertices[0]
    made = scene(*elements, black(top - at), source=beam(0.0115))
    if tilted:
        # rays in the plane of the tilt
        starts = np.linspace(-0.009, 0.009, 7)
        made = replace(
            made,
            source=tuple(
                pz.CollimatedDisk(
                    name=f"ray {n}", flux=1.0, axis="-z", tilt_deg=(0.0, 2.0), radius=1e-13,
                    position=(0.0, float(y), top + 0.01),
                )
                for n, y in enumerate(starts)
            ),
        )  # fmt: skip
        found = pz.paths(made, rays=7, seed=1)
        last = np.flatnonzero((found.element == 2) & (found.generation == 3))
        assert len(last) == 7
        first = found.start[found.generation == 0]
        heading = found.end[found.generation == 0] - first
        sense = np.sign(heading[0, 1])
        for k, (start, end) in enumerate(zip(first, found.end[last], strict=True)):
            y, z, dy, dz = meridional(faces, start[1], sense * slope, top - start[2])
            assert abs(float(y + (at - z) * dy / dz) - end[1]) < 1e-12, k
        return
    h, y = arrivals(made, 3)
    for height, got in zip(h.tolist(), y.tolist(), strict=True):
        a, z, dy, dz = meridional(faces, height)
        assert abs(float(a + (at - z) * dy / dz) - got) < 1e-15


def test_cement_refracts_once_and_nothing_is_lost() -> None:
    made = scene(*doublet(), black(-0.1, paths=30), source=beam(0.0115), generation_cap=12)
    result = pz.trace(made, batches=2, rays_per_batch=64)
    assert abs(result.ledger.closure) < 1e-15
    table = result.detectors["screen"].paths.to_dataframe()
    assert table["sequence"][0] == "crown.front t > crown.back t > flint.back t > screen"
    # both ways: at cement the crown's face alone is met
    assert not any("flint.front" in sequence for sequence in table["sequence"])
    assert "crown.front t > crown.back r > crown.front r > crown.back t" in " ".join(
        table["sequence"]
    )
    assert pz.advisories(made) == []


@pytest.mark.parametrize("traced", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_without_cement_there_is_a_film_of_air(traced: bool) -> None:
    film = scene(*doublet(front=None), black(-0.1, paths=30), source=beam(0.0115))
    film = replace(film, element=(replace(film.element[0], back=None), *film.element[1:]))
    said = " ".join(pz.advisories(film))
    assert "a film of index 1 between them" in said
    assert 'give the back of "crown" index_outside = 1.6727' in said
    assert 'make the front of "flint" clear' in said
    if not traced:
        return
    found = pz.trace(film, batches=2, rays_per_batch=1024)
    first = found.detectors["screen"].paths.to_dataframe()["sequence"][0]
    assert first == "crown.front t > crown.back t > flint.front t > flint.back t > screen"


def test_cement_that_one_lens_is_too_narrow_for_is_told() -> None:
    """Beyond its rim the wider one's face would be of no glass, or of the wrong one."""
    for wide, said in ((0, "second"), (1, "first")):
        pair = [*doublet()]
        pair[wide] = replace(pair[wide], aperture_radius=1.1 * pair[wide].aperture_radius)
        # where the rim is wider the centre of the edge moves, not the vertices
        was = doublet()[wide]
        moved = was.position[2] + was.vertices[0] - pair[wide].vertices[0]
        pair[wide] = replace(pair[wide], position=(0.0, 0.0, moved))
        (text,) = pz.advisories(scene(*pair, black(-0.1), source=beam(0.001)))
        assert text.startswith('the front of "flint" is clear'), said
        assert "are not equally wide (" in text
    assert not pz.advisories(scene(*doublet(), black(-0.1), source=beam(0.001)))
    # of very many only some are named
    row = [
        replace(e, name=f"{e.name} {n}", position=(float(n), 0.0, e.position[2]))
        for n in range(22)
        for e in pair
    ]
    told = [text for text in pz.advisories(scene(*row, source=beam(0.001))) if "wide" in text]
    assert len(told) == 21
    assert told[-1] == "2 more pairs of cemented faces are not equally wide"


# -- the edge, and faces of their own --------------------------------------------------------------


def test_the_edge_takes_what_meets_it_and_the_lens_is_charged() -> None:
    lens = pz.Lens(
        **HERE, front_radius=math.inf, back_radius=math.inf, thickness=0.05, aperture_radius=0.02,
        surface=GLASS,
    )  # fmt: skip
    side = pz.CollimatedDisk(
        name="side", flux=1.0, position=(1.0, 0.0, 0.0), axis="-x", radius=0.01
    )
    result = pz.trace(scene(lens, source=side), batches=2, rays_per_batch=256)
    assert result.ledger.absorbed["lens"].value == 1.0
    clear = pz.trace(
        scene(replace(lens, edge=pz.Clear()), source=side), batches=2, rays_per_batch=256
    )
    assert clear.ledger.escaped.value == 1.0
    # of two coated faces each does its own
    mirror = replace(lens, back=pz.Mirror(reflectance=0.9), front=pz.Clear())
    made = scene(mirror, source=beam(0.01))
    found = pz.trace(made, batches=2, rays_per_batch=256)
    assert found.ledger.escaped.value == pytest.approx(0.9, rel=1e-15)
    assert found.ledger.absorbed["lens"].value == pytest.approx(0.1, rel=1e-15)
    assert pz.probe(made, [(0, 0, 1), (1, 0, 0)], [(0, 0, -1), (-1, 0, 0)]).face.tolist() == [
        "front", "edge",
    ]  # fmt: skip


def test_surfaces_of_faces_are_compiled_in_only_where_there_are_some() -> None:
    lens = pz.Lens(
        **HERE, front_radius=0.1, back_radius=0.1, thickness=0.02, aperture_radius=0.02,
        surface=pz.Absorber(),
    )  # fmt: skip
    one = compile_scene(scene(lens), pz.RunSettings())
    assert "face-surfaces" not in one.effects
    several = compile_scene(scene(replace(lens, surface=GLASS)), pz.RunSettings())
    assert "has faces with surfaces of their own" in several.reasons["face-surfaces"]
    assert several.reasons["surface.absorber"] == '"lens" has one'


@pytest.mark.slow
def test_an_own_face_is_met_in_a_tree_as_without() -> None:
    crown, flint = doublet()
    made = scene(crown, flint, black(-0.1, paths=20), source=beam(0.0115))
    cells = [
        pz.trace(
            replace(made, run=replace(made.run, effects=effects)), batches=1, rays_per_batch=512
        ).summary()["detectors"]["screen"]
        for effects in (None, ["acceleration"])
    ]
    assert cells[0] == cells[1]
