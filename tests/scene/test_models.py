"""The tables of the registry, derived quantities, packing, presets and advisories."""

import dataclasses
import inspect
import math

import pytest

import photizon_cl as pz
from photizon_cl.compile.effects.table import EFFECT_ROWS as EFFECTS
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.files import load
from photizon_cl.scene.frames import frame
from photizon_cl.scene.presets import preset, preset_names, preset_path, presets
from photizon_cl.scene.registry import DETECTORS, ELEMENTS, SOURCES, SURFACES

TABLES = {"element": ELEMENTS, "surface": SURFACES, "source": SOURCES, "detector": DETECTORS}
ROWS = [(label, kind, cls) for label, table in TABLES.items() for kind, cls in table.items()]
COMMON = {"name": "x", "position": (0, 0, 0)}
BLACK = pz.Absorber()


@pytest.mark.parametrize(("label", "kind", "cls"), ROWS, ids=[row[1] for row in ROWS])
def test_rows_of_the_registry(label, kind, cls):
    assert (cls.label, cls.kind) == (label, kind)
    assert cls.kernel == kind.replace("-", "_")
    assert dataclasses.is_dataclass(cls)
    assert cls.__dataclass_params__.frozen
    # One class a file, named after the kind, and every field a declared, documented parameter.
    assert inspect.getfile(cls).endswith(f"{cls.kernel}.py")
    fields = {item.name for item in dataclasses.fields(cls)}
    assert fields == set(parameters_of(cls))
    documented = " ".join(c.__doc__ for c in cls.__mro__ if c.__module__.startswith("photizon"))
    assert all(f"{item} : " in documented for item in fields)
    assert all(parameter.meaning for parameter in parameters_of(cls).values())


def test_kinds_of_the_contract():
    assert set(ELEMENTS) >= {
        "rectangle", "disk", "sphere", "cpc", "baffled-tube", "plano-convex", "biconvex",
        "cylinder", "cone", "conic", "lens",
    }  # fmt: skip
    assert set(SURFACES) >= {"absorber", "mirror", "lambertian", "fresnel", "clear", "mixed"}
    assert set(SOURCES) >= {
        "isotropic-point", "cosine-point", "lambertian-disk", "lambertian-sphere",
        "collimated-disk", "cone-point", "lambertian-rectangle",
    }  # fmt: skip


def test_every_kind_has_an_effect():
    for label in ("element", "surface", "source"):
        for kind in TABLES[label]:
            assert f"{label}.{kind}" in EFFECTS
    words = {name for name in EFFECTS if "." not in name}
    assert words >= {
        "splitting", "roulette", "tilt", "port", "contact", "acceleration", "far-field", "detector",
        "map", "ladder", "shares", "coincidence", "face-surfaces",
    }  # fmt: skip
    assert all(effect.what and effect.costs for effect in EFFECTS.values())
    with pytest.raises(TypeError):
        EFFECTS["new"] = None


def test_rectangle():
    r = pz.Rectangle(**COMMON, axis="+x", half_width=2, half_height=3, surface=BLACK,
                     detector=pz.Detector(map=(4, 3)))  # fmt: skip
    assert r.half_sizes == (2.0, 3.0)
    assert r.area == 24.0
    assert r.derived() == {"area": (24.0, "m²"), "bin area": (2.0, "m²")}
    assert (r.flat, r.has_map, r.detector_side) == (True, True, "front")
    assert r.frame == frame("+x")


def test_disk():
    d = pz.Disk(**COMMON, axis="-z", radius=2, surface=BLACK, tilt_deg=(1, 2))
    assert d.half_sizes == (2.0, 2.0)
    assert d.area == pytest.approx(4 * math.pi, rel=1e-15)
    assert d.detector_side is None
    assert d.frame == frame("-z", (1.0, 2.0))


def test_sphere():
    s = pz.Sphere(**COMMON, axis="+z", radius=0.1, port_fraction=0.05, surface=pz.Lambertian(0.9))
    assert s.packed(s.position, None)["radius"] == 0.1
    assert s.area == pytest.approx(4 * math.pi * 0.01 * 0.95, rel=1e-15)
    assert s.area + s.port_area == pytest.approx(4 * math.pi * 0.01, rel=1e-15)
    assert s.rim_radius == pytest.approx(0.1 * math.sin(math.acos(0.9)), rel=1e-14)
    assert s.multiplier == pytest.approx(1 / 0.145, rel=1e-14)
    assert s.derived()["port angle"] == (pytest.approx(25.84193276), "deg")
    whole = pz.Sphere(**COMMON, axis="+z", radius=1, surface=BLACK, detector=pz.Detector())
    assert whole.cos_port == 1.0
    assert whole.multiplier is None
    assert whole.detector_side == "inside"
    assert list(whole.derived()) == ["wall area"]
    outside = dataclasses.replace(whole, detector=pz.Detector(side="outside"))
    assert outside.detector_side == "outside"
    white = dataclasses.replace(whole, detector=None, surface=pz.Lambertian(1))
    assert white.multiplier == math.inf


def test_surfaces():
    assert pz.Absorber().packed() == {}
    assert pz.Mirror(0.25).packed() == {"reflectance": 0.25}
    assert pz.Lambertian(0.25).derived() == {"absorptance": (0.75, "")}
    glass = pz.Fresnel(1.5)
    assert glass.row.pack(glass.packed()) == [1 / 1.5, 1.25 / 2.25, 1.5, -1.25]
    assert glass.normal_reflectance == pytest.approx(0.04, rel=1e-15)
    assert glass.critical_angle_deg == pytest.approx(41.8103149)
    assert pz.Fresnel(1.0, 1.5).critical_angle_deg == glass.critical_angle_deg
    assert pz.Fresnel(1.2, 1.2).critical_angle_deg is None


def test_sources():
    assert pz.IsotropicPoint(**COMMON, flux=4 * math.pi).radiant_intensity == 1.0
    cosine = pz.CosinePoint(**COMMON, flux=math.pi, axis="-x", tilt_deg=(3, 0))
    assert cosine.radiant_intensity == 1.0
    assert cosine.packed() == {}
    assert cosine.frame == frame("-x", (3.0, 0.0))
    disk = pz.LambertianDisk(**COMMON, flux=math.pi**2, axis="+z", radius=1)
    assert disk.radiance == pytest.approx(1.0, rel=1e-15)
    sphere = pz.LambertianSphere(**COMMON, flux=math.pi**2 * 4, radius=1)
    assert sphere.radiance == pytest.approx(1.0, rel=1e-15)
    assert sphere.frame == frame("+z")
    beam = pz.CollimatedDisk(**COMMON, flux=math.pi, axis="+z", radius=1)
    assert beam.irradiance == pytest.approx(1.0, rel=1e-15)
    for source in (disk, sphere, beam):
        assert source.packed()["radius"] == 1.0
    for source in (cosine, disk, sphere, beam):
        assert all(math.isfinite(value) for value, _ in source.derived().values())


# --- Presets ------------------------------------------------------------------------------------


def test_presets_are_listed_and_valid():
    folder = preset_path("box-room").parent
    assert {path.stem for path in folder.glob("*.toml")} == set(preset_names())
    for entry in presets().values():
        scene = load(entry.name)
        assert scene.name == entry.name
        assert scene.title == entry.title
        assert len(entry.anchor) > 40
        assert pz.advisories(scene) == []
        assert "Anchor:" in scene.notes
    with pytest.raises(KeyError):
        preset_path("../box-room")


def test_anchor_numbers_follow_from_the_scenes():
    scene = load("cosine-fourth")
    h = scene.source[0].position[2]
    centre = scene.source[0].flux / (math.pi * h * h)
    corner = centre * (1 / math.sqrt(1 + 2 * scene.element[0].half_width ** 2)) ** 4
    assert f"{centre:.6f}" in preset("cosine-fourth").anchor
    assert corner == pytest.approx(centre / 9, rel=1e-15)
    caught = 2 * math.sqrt(2) / math.pi * math.atan(1 / math.sqrt(2))
    assert f"{caught:.6f}" in preset("cosine-fourth").anchor

    globe = load("lambertian-sphere").source[0]
    assert globe.radiance == pytest.approx(1.0, rel=1e-15)
    assert f"{math.pi * globe.radius**2:.6f}" in preset("lambertian-sphere").anchor

    wall = load("integrating-sphere").element[0]
    received = (1 - wall.port_fraction) * wall.multiplier
    absorbed = received * wall.surface.absorptance
    for value in (received, absorbed, 1 - absorbed):
        assert f"{value:.6f}" in preset("integrating-sphere").anchor
    assert wall.cos_port == 0.9

    room = load("box-room")
    c = 1 / room.source[0].position[2]
    direct = 4 / math.pi * (c / math.hypot(1, c)) * math.atan(c / math.hypot(1, c))
    assert f"{direct:.6f}" in preset("box-room").anchor
    assert f"{c * c / math.pi:.6f}" in preset("box-room").anchor
    assert 0.6**room.run.generation_cap < 1e-12


def test_ghost_ladder_faces_the_right_way():
    scene = load("ghost-ladder")
    front, back, transmitted, reflected = scene.element
    beam = scene.source[0]
    assert front.frame[2] == (0.0, 0.0, -1.0)  # out of the glass, towards the beam
    assert back.frame[2] == (0.0, 0.0, 1.0)
    assert front.surface == back.surface == pz.Fresnel(1.5, 1.0)
    assert beam.frame[2] == (0.0, 0.0, 1.0)
    z = [e.position[2] for e in (reflected, beam, front, back, transmitted)]
    assert z == sorted(z)
    assert transmitted.frame[2][2] < 0 < reflected.frame[2][2]
    anchor = preset("ghost-ladder").anchor
    r, t = 0.04, 0.96
    for power in (t * t, t * t * r * r, t * t * r**4, r, t * t * r, t * t * r**3):
        shown = {f"{power:.4f}", f"{power:.6f}", f"{power:.2f}", f"{power:.5e}", f"{power:.6e}"}
        assert any(text.replace("e-0", "e-") in anchor for text in shown)


# --- Advisories ---------------------------------------------------------------------------------


def advisories(sources, elements, **run):
    return pz.advisories(pz.Scene("s", sources, elements, run=pz.RunSettings(**run)))


def point(x, y, z):
    return pz.IsotropicPoint(name="p", flux=1, position=(x, y, z))


def plate(surface=BLACK, z=0.0, axis="+z", name="plate", **more):
    return pz.Rectangle(name=name, position=(0, 0, z), axis=axis, half_width=1, half_height=1,
                        surface=surface, **more)  # fmt: skip


def ball(surface=BLACK, radius=1.0, **more):
    return pz.Sphere(name="ball", position=(0, 0, 0), axis="+z", radius=radius, surface=surface,
                     **more)  # fmt: skip


@pytest.mark.parametrize(
    ("source", "element", "lies"),
    [
        (point(0.5, 0.5, 0), plate(), True),
        (point(1, 1, 0), plate(), True),
        (point(0.5, 0.5, 1e-9), plate(), False),
        (point(1.1, 0, 0), plate(), False),
        (point(0, 0.9, 0), plate(tilt_deg=(0, 90)), True),
        (point(0, 0.9, 0), plate(tilt_deg=(90, 0)), False),
        (point(0.1, 0.9, 0.3), plate(tilt_deg=(12, 34)), False),
        (point(0, 0, 0.1 + 0.2), plate(z=0.3), True),
        (point(0.6, 0.8, 0), ball(), True),
        (point(0, 0, 1), ball(port_fraction=0.1, surface=pz.Lambertian(0.5)), False),
        (point(0, 0, -1), ball(port_fraction=0.1, surface=pz.Lambertian(0.5)), True),
        (point(0, 0, 0), ball(), False),
        (pz.LambertianDisk(name="d", flux=1, position=(1.5, 0, 0), axis="-z", radius=0.6),
         plate(), True),
        (pz.LambertianDisk(name="d", flux=1, position=(1.5, 0, 0), axis="-z", radius=0.4),
         plate(), False),
        (pz.LambertianDisk(name="d", flux=1, position=(1.5, 0, 0), axis="-x", radius=0.6),
         plate(), False),
        (pz.LambertianSphere(name="d", flux=1, position=(0, 0, 0), radius=1.0), ball(), True),
        (pz.LambertianSphere(name="d", flux=1, position=(0, 0, 0), radius=0.9), ball(), False),
        (pz.LambertianSphere(name="d", flux=1, position=(0, 0, 0), radius=0.9), plate(), False),
    ],
)  # fmt: skip
def test_source_on_a_face(source, element, lies):
    found = [line for line in advisories([source], [element]) if "within rounding" in line]
    assert len(found) == lies
    if lies:
        assert f'"{source.name}"' in found[0]
        assert f'"{element.name}"' in found[0]


def test_detector_that_faces_away():
    detector = pz.Detector()
    away = plate(axis="-z", detector=detector)
    (line,) = advisories([point(0, 0, 1)], [away])
    assert "set its side to" in line
    assert advisories([point(0, 0, 1)], [plate(detector=detector)]) == []
    assert advisories([point(0, 0, 1)], [away, plate(pz.Mirror(1), z=-2.0, name="m")]) == []
    (line,) = advisories([point(0, 0, 3)], [ball(detector=detector)])
    assert "set its side to" in line
    outside = ball(detector=pz.Detector(side="outside"))
    assert advisories([point(0, 0, 3)], [outside]) == []
    assert len(advisories([point(0, 0, 0)], [outside])) == 1


def through(element, z=3.0, axis="-z"):
    beam = pz.CollimatedDisk(name="b", flux=1, position=(0, 0, z), axis=axis, radius=0.1)
    scene = pz.Scene(name="through", source=(beam,), element=(element,))
    read = pz.trace(scene, batches=2, rays_per_batch=64)
    assert set(pz.advisories(scene)) <= set(read.advisories)
    return read.detectors[element.name].power.value, " ".join(read.advisories)


@pytest.mark.parametrize("side", ["inside", "outside"])
@pytest.mark.parametrize("z", [3.0, 0.0])
def test_a_detector_on_a_closed_face_that_light_passes(side, z):
    power, said = through(ball(pz.Clear(), detector=pz.Detector(side=side)), z)
    assert power == (0.0 if (side, z) == ("outside", 0.0) else 1.0)
    assert ("will read zero" in said) == (power == 0.0)


@pytest.mark.parametrize("side", ["front", "back"])
@pytest.mark.parametrize("surface", [BLACK, pz.Clear()], ids=["absorber", "clear"])
def test_a_detector_on_a_plane_face_that_light_passes_or_not(side, surface):
    power, said = through(plate(surface, detector=pz.Detector(side=side)))
    assert power == (side == "front")
    assert ("will read zero" in said) == (side == "back")


def test_what_turns_light_may_light_a_detector_from_anywhere():
    class Diffuser(pz.Clear):  # light goes through, in other directions
        counts = True

    away = plate(axis="-z", detector=pz.Detector())
    veil = plate(Diffuser(), z=-2.0, name="veil")
    assert advisories([point(0, 0, 1)], [away, veil]) == []
    (line,) = advisories([point(0, 0, 1)], [away, plate(pz.Clear(), z=-2.0, name="veil")])
    assert "will read zero" in line


def test_the_side_that_a_detector_counts_by_the_normals_of_its_kind():
    class Bowl(pz.Sphere):  # a ball whose normals point to its inside
        traits = pz.Sphere.traits | {"inward"}

        @property
        def faces(self):
            return tuple(dataclasses.replace(face, sense=-1.0) for face in super().faces)

    for side, z in (("inside", 3), ("outside", 0)):
        bowl = Bowl(name="bowl", position=(0, 0, 0), axis="+z", radius=1, surface=BLACK,
                    detector=pz.Detector(side=side))  # fmt: skip
        assert bowl.detector_plus == (side == "inside")
        assert len(advisories([point(0, 0, z)], [bowl])) == 1
        assert advisories([point(0, 0, 3 - z)], [bowl]) == []
    for side in ("front", "back"):
        assert plate(detector=pz.Detector(side=side)).detector_plus == (side == "front")
    assert not plate().detector_plus


def test_generation_cap_that_cuts_a_sphere():
    sphere = ball(pz.Lambertian(0.9), port_fraction=0.05)
    (line,) = advisories([point(0, 0, 0)], [sphere])
    assert "a cap of 177 leaves 1e-12" in line
    assert advisories([point(0, 0, 0)], [sphere], generation_cap=177) == []
    assert advisories([point(0, 0, 5)], [sphere]) == []
    (line,) = advisories([point(0, 0, 0)], [ball(pz.Lambertian(1))])
    assert "never decays" in line


def test_covered_element():
    (line,) = advisories([point(0, 0, 1)], [plate(), plate(name="twin")])
    assert '"twin" is never hit' in line


@pytest.mark.parametrize("surface", [pz.Absorber(), pz.Mirror(0.5), pz.Fresnel(1.5)])
def test_a_counting_plane_in_the_place_of_another_is_hit(surface):
    """It lies before what it touches, wherever it is named."""
    wall, plane = plate(surface=surface), plate(name="twin", surface=pz.Clear())
    for elements in (
        [wall, plane],
        [plane, wall],
        [wall, plane, plate(name="third", surface=pz.Clear())],
    ):
        assert advisories([point(0, 0, 1)], elements) == []


def disk(radius, **changes):
    given = {"name": "disk", "surface": pz.Absorber(), "position": (0.0, 0.0, 0.0), "axis": "+z"}
    return pz.Disk(radius=radius, **{**given, **changes})


@pytest.mark.parametrize(
    "small",
    [
        disk(0.3),
        disk(0.3, position=(0.6, -0.7, 0.0)),
        disk(1.0, axis="-z"),
        pz.Rectangle(
            name="disk", surface=pz.Absorber(), position=(0.0, 0.0, 0.0), axis="-z",
            half_width=1.0, half_height=1.0,
        ),
    ],
)  # fmt: skip
def test_an_element_flush_in_one_named_before(small):
    wall = plate()
    (line,) = advisories([point(0, 0, 1)], [wall, small])
    assert 'element "disk" lies flush in "plate", which is named first' in line
    if small.kind == "disk":
        assert advisories([point(0, 0, 1)], [small, wall]) == []  # it takes what it covers
        (line,) = advisories([point(0, 0, 1)], [disk(1.5, name="plate"), small])
        assert '"disk" is never hit' in line


@pytest.mark.parametrize(
    "other",
    [
        disk(0.3, position=(0.0, 0.0, 1e-13)),  # a gap
        disk(0.3, tilt_deg=(1e-6, 0.0)),  # through it
        disk(1.5),  # it holds the wall
        disk(1.3, position=(2.0, 2.0, 0.0)),  # past its corner
        dataclasses.replace(plate(name="tile"), position=(2.0, 0.0, 0.0)),  # an edge in common
    ],
)
def test_elements_that_are_not_flush(other):
    wall = plate()
    assert advisories([point(0, 0, 1)], [wall, other]) == []


def test_an_element_that_is_partly_under_one_named_before():
    (line,) = advisories([point(0, 0, 1)], [plate(), disk(0.3, position=(0.8, 0.0, 0.0))])
    assert '"disk" lies partly flush in "plate", which is named first and takes every' in line
    tiles = [plate(name="left"), dataclasses.replace(plate(name="right"), position=(2.0, 0.0, 0.0))]
    (line,) = advisories([point(0, 0, 1)], [*tiles, disk(0.3, position=(1.0, 0.0, 0.0))])
    assert 'partly flush in "left"' in line


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (25.0, 30.0)])
def test_the_one_named_first_takes_the_hits_of_what_lies_in_its_plane(tilt):
    wall = plate(tilt_deg=tilt)
    u, v, w = wall.frame
    at = tuple(0.3 * a + 0.2 * b for a, b in zip(u, v, strict=True))
    spot = disk(0.3, tilt_deg=tilt, position=at)
    (line,) = advisories([point(0, 0, 1)], [wall, spot])
    assert 'named first and takes every hit where both are equally near: "disk" is never' in line
    assert advisories([point(0, 0, 1)], [spot, wall]) == []
    lifted = tuple(a + 1e-12 * b for a, b in zip(at, w, strict=True))
    spot = dataclasses.replace(spot, position=lifted)
    assert advisories([point(0, 0, 1)], [wall, spot]) == []


def test_planes_an_ulp_apart():
    wall, spot = plate(z=1.0), disk(0.3, position=(0.0, 0.0, math.nextafter(1.0, 2.0)))
    for order in (1, -1):
        (line,) = advisories([point(0, 0, 2)], [wall, spot][::order])
        assert "give both the same coordinate" in line


def test_what_lies_flush_behind_glass_is_told():
    glass = pz.Fresnel(1.5)
    (line,) = advisories([point(0, 0, 1)], [plate(glass), disk(0.3)])
    assert 'element "disk" lies on the glass of "plate": light inside leaves that first' in line
    assert 'give "plate" index_outside = 1.5' in line
    (line,) = advisories([point(0, 0, 1)], [plate(glass), plate(name="twin")])
    assert '"disk"' not in line
    assert 'what comes from outside meets "twin" first' in line
    three = [plate(), plate(name="twin"), disk(0.3, name="small"), disk(0.3, name="smaller")]
    assert len(advisories([point(0, 0, 1)], three)) == 3  # a line for each


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (33.0, -12.0)])
def test_what_the_advisory_says_of_flush_elements_is_so(tilt):
    wall, spot = plate(tilt_deg=tilt), disk(0.3, tilt_deg=tilt)
    for pair, lit in (((wall, spot), "plate"), ((spot, wall), "disk")):
        scene = pz.Scene(name="flush", source=(point(0, 0, 1e-3),), element=pair)
        result = pz.trace(scene, batches=2, rays_per_batch=1024)
        assert bool(result.advisories) == (lit == "plate")
        absorbed = {name: row.value for name, row in result.ledger.absorbed.items()}
        assert absorbed[lit] > 0.4
        assert (absorbed["disk"] == 0.0) == (lit == "plate")


def test_many_coincident_elements_are_told_soon():
    many = [plate(name=f"p{n}", tilt_deg=(20.0, 0.0)) for n in range(3000)]
    assert len(advisories([point(0, 0, 1)], many)) == 2999


def test_fresnel_surfaces():
    (line,) = advisories([point(0, 0, 3)], [plate(pz.Fresnel(1.5, 1.5))])
    assert "both sides" in line
    pair = [plate(pz.Fresnel(1.5)), plate(pz.Mirror(1), z=-1.0, name="m")]
    assert advisories([point(0, 0, 3)], pair) == []  # the automatic floor ends it
    (line,) = advisories([point(0, 0, 3)], pair, roulette_floor=0.0)
    assert "roulette_floor" in line
    assert advisories([point(0, 0, 3)], pair, roulette_floor=1e-6) == []
    assert advisories([point(0, 0, 3)], pair, generation_cap=8, roulette_floor=0.0) == []


def test_the_automatic_floor_is_a_number_where_rays_split():
    glassy = pz.Scene("s", (point(0, 0, 3),), (plate(pz.Fresnel(1.5)),))
    plain = pz.Scene("s", (point(0, 0, 3),), (plate(),))
    assert (glassy.run.roulette_floor, glassy.roulette_floor()) == ("auto", 1e-9)
    assert (plain.run.roulette_floor, plain.roulette_floor()) == ("auto", 0.0)
    # a scene is the one that says the number, and each is kept as it was written
    for scene, number in ((glassy, 1e-9), (plain, 0.0)):
        said = dataclasses.replace(scene, run=pz.RunSettings(roulette_floor=number))
        assert said.digest() == scene.digest()
        assert said.to_dict()["run"]["roulette_floor"] == number
        assert scene.to_dict()["run"]["roulette_floor"] == "auto"
    with pytest.raises(pz.SceneError, match='a number in \\[0, 1\\], or "auto"'):
        pz.RunSettings(roulette_floor="none")


@pytest.mark.parametrize("panes", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_glazing_reaches_its_target_as_it_is(panes):
    """Double and triple glazing, with all defaults."""
    faces = []
    for n in range(panes):
        for z, axis in ((0.02 * n, "-z"), (0.02 * n + 0.004, "+z")):
            faces.append(
                pz.Rectangle(
                    name=f"{n} {axis}", position=(0.0, 0.0, z), axis=axis, half_width=0.5,
                    half_height=0.5, surface=pz.Fresnel(1.5),
                )
            )  # fmt: skip
    lamp = pz.CollimatedDisk(
        name="lamp", flux=1.0, position=(0.0, 0.0, -0.1), axis="+z", radius=0.1
    )
    behind = plate(pz.Absorber(), z=0.1, name="behind", axis="-z", detector=pz.Detector())
    result = pz.trace(pz.Scene("glazing", (lamp,), (*faces, behind)), rays_per_batch=8)
    assert result.converged
    r = 0.04
    through = (1.0 - r) / (1.0 + (2 * panes - 1) * r)  # of a pile of 2 n faces
    left = result.ledger.depth_capped.value + 1e-8
    assert through - left <= result.detectors["behind"].power.value <= through + 1e-8
    assert left < 1e-6
