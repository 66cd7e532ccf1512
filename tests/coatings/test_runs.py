"""Coatings in traces: shares, splits and choices, media, scatter, paths, bits, sweeps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from oracles import coatings
from oracles.coatings import MGF2, MIRROR_OF_12, glass, stack
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, random_scene, wall

import photizon_cl as pz
from hostcode.program.source import program_source
from photizon_cl.compile.compiled import compile_scene

HALF = {"kind": "fixed", "reflectance": 0.25, "transmittance": 0.5}
LINES = {"wavelengths_nm": [450.0, 550.0, 650.0]}


def test_what_coatings_take_is_booked_to_the_last_bit():
    coatings.absorbed_to_the_last_bit()


# -- a window --------------------------------------------------------------------------------------


def window(coating, angle=0.0, surface=None, **parts):
    """Two coated faces a centimetre apart, and a sensor behind them."""
    faces = [
        {
            **wall((0, 0, z), axis, 0.5),
            "name": name,
            "surface": {**glass(coating), **(surface or {})},
        }
        for name, z, axis in (("front", 0.0, "-z"), ("back", 0.01, "+z"))
    ]
    sensor = {**wall((0, 0, 0.1), "-z", 0.5), **BLACK, "name": "sensor"}
    sensor["detector"] = parts.pop("detector", {"paths": 32, "generations": 8})
    lamp = {**beam((0, 0, -0.1), "+z"), "tilt_deg": [angle, 0.0]}
    return scene_of([lamp], [*faces, sensor], **parts)


def test_ghosts_of_a_window_are_a_geometric_series():
    """T², T²R², …, by path, with their letters and their ghost order."""
    result = pz.trace(window(HALF), batches=1, rays_per_batch=64)
    rows = list(result.detectors["sensor"].paths)
    for k, row in enumerate(rows[:3]):
        assert row.power == 0.5**2 * 0.25 ** (2 * k)
        assert row.ghost_order == 2 * k
        inner = "back.face r > front.face r > " * k
        assert row.sequence == f"front.face t > {inner}back.face t > sensor"
    taken = [result.ledger.absorbed[name].value for name in ("front", "back")]
    # 1/4 of all that meets a face: 1 and what comes back within the glass
    q = 0.25 * 0.25
    assert taken[0] == pytest.approx(0.25 * (1.0 + 0.5 * 0.25 / (1.0 - q)), rel=1e-14)
    assert taken[1] == pytest.approx(0.25 * 0.5 / (1.0 - q), rel=1e-14)
    assert abs(result.ledger.closure) <= 1e-15


def test_total_reflection_has_its_letter():
    """Within glass beyond the critical angle: i, with R + T of the power."""
    face = {**wall((0, 0, 0), "-z", 5.0), "name": "face", "surface": glass(HALF)}
    sensor = {**wall((0, 0, 1.0), "-z", 5.0), **BLACK, "name": "sensor", "detector": {"paths": 4}}
    lamp = {**beam((0, -0.6, 0.5), "-z"), "tilt_deg": [50.0, 0.0]}
    result = pz.trace(scene_of([lamp], [face, sensor]), batches=1, rays_per_batch=16)
    (row,) = result.detectors["sensor"].paths
    assert row.sequence == "face.face i > sensor"
    assert row.ghost_order == 0
    assert row.power == 0.75


def test_a_stack_by_line_is_that_of_its_formula():
    """T² of a window of MgF2 on both sides, at an angle, for every line; nothing is absorbed."""
    scene = window(MGF2, 30.0, spectrum=LINES, detector={"generations": 4, "wavelengths": True})
    result = pz.trace(scene, batches=1, rays_per_batch=96)
    coating = scene.element["front"].surface.coating
    direct = result.detectors["sensor"].ladder[2]
    for nm, part in zip(LINES["wavelengths_nm"], direct.by_wavelength, strict=True):
        _, t = coating.powers(30.0, 1.5, nm=nm)
        assert 3.0 * part.value == pytest.approx(float(t) ** 2, rel=1e-13)
    assert result.ledger.absorbed["front"].value == 0.0
    assert result.ledger.absorbed["back"].value == 0.0


def test_in_bands_each_ray_has_its_own_wavelength():
    """The mean over a band, by quadrature of the formula: 5 standard errors, 6e-7 by chance."""
    scene = window(MIRROR_OF_12, spectrum={"edges_nm": [420.0, 480.0]}, detector={"generations": 4})
    result = pz.trace(scene, batches=16, rays_per_batch=1024)
    coating = scene.element["front"].surface.coating
    nm = 420.0 + 60.0 * (np.arange(4000) + 0.5) / 4000
    wanted = np.mean([float(coating.powers(0.0, 1.5, nm=x)[1]) ** 2 for x in nm])
    direct = result.detectors["sensor"].ladder[2]
    assert abs(direct.value - wanted) < 5.0 * direct.sigma
    assert 0.0 < direct.sigma < 0.02 * wanted


def test_glass_that_disperses_below_a_stack_in_bands():
    """Indices and wavelengths as polynomials in pieces: what a line at one wavelength gives."""
    medium = {"name": "g", "dispersion": {"kind": "cauchy", "A": 1.5, "B_um2": 0.0042}}
    surface = {"kind": "fresnel", "medium": "g", "coating": MIRROR_OF_12}
    narrow = {"edges_nm": [500.0, 500.0 + 1e-9]}
    absorbed = []
    for spectrum in (narrow, {"wavelengths_nm": [500.0]}):
        board = {**wall((0, 0, 0), "+z", 9.0), "surface": surface}
        lamp = {**beam((0, 0, 1), "-z"), "tilt_deg": [40.0, 0.0]}
        black = {**wall((0, 0, -1), "+z", 9.0), **BLACK, "detector": {}}
        scene = scene_of([lamp], [board, black], spectrum=spectrum, medium=[medium])
        absorbed.append(float(trace(scene, rays_per_batch=8).detector("element 1").power) / 8.0)
    r, t = (
        pz.load(scene.to_dict())
        .element[0]
        .surface.coating.powers(40.0, 1.5 + 0.0042 / 0.25, nm=500.0)
    )
    assert absorbed[1] == pytest.approx(float(t), rel=1e-12)
    assert absorbed[0] == pytest.approx(absorbed[1], rel=1e-9)
    assert r + t == pytest.approx(1.0, abs=1e-15)


def test_black_of_a_coating_ends_everything():
    """R = T = 0: nothing goes on, nor is anything of it scattered."""
    nothing = {"kind": "fixed", "reflectance": 0.0, "transmittance": 0.0}
    for scatter in ({}, {"scatter": {"kind": "lambertian", "tis": 0.5}}):
        found = trace(window(nothing, surface=scatter), rays_per_batch=16)
        assert found.absorbed("front") == found.emitted
        assert found.closures() == [0]


@pytest.mark.parametrize("splitting", [True, False])
def test_scatter_takes_its_share_of_each_child(splitting):
    """TIS of what a coating reflects and of what it lets pass, about each."""
    lobe = {"kind": "lambertian", "tis": 0.2}
    board = {**wall((0, 0, 0), "+z", 1e3), "surface": {**glass(HALF), "scatter": lobe}}
    scene = scene_of([beam((0, 0, 1), "-z")], [board], far_field={"n_mu": 2, "n_phi": 4})
    batches = 1 if splitting else 64
    found = trace(scene, rays_per_batch=256, splitting=splitting, batches=batches)
    assert max(map(abs, found.closures())) <= (1e-15 if splitting else 0)
    bins = np.array([float(x) for x in found.far_field]).reshape(2, 4).sum(axis=1)
    shares = bins / float(found.emitted)
    # one of two by chance: five standard errors of 0.43 and 0.5 over 16384 rays
    room = 1e-12 if splitting else 5.0 * 0.4 / math.sqrt(256 * batches)
    assert shares == pytest.approx([0.5, 0.25], abs=room)
    assert float(found.absorbed("element 0") / found.emitted) == pytest.approx(0.25, abs=1e-12)


def test_absorbing_media_beneath_a_coating():
    """What comes through a coated slab of dyed glass: T² e^(−αd), and the rest of the series."""
    dyed = [{"name": "dyed", "index": 1.5, "absorption_per_m": 30.0}]
    named = {"kind": "fresnel", "medium": "dyed", "coating": HALF}
    faces = [
        {**wall((0, 0, z), axis, 0.5), "surface": named} for z, axis in ((0.0, "-z"), (0.01, "+z"))
    ]
    sensor = {**wall((0, 0, 0.1), "-z", 0.5), **BLACK, "detector": {"generations": 4}}
    scene = scene_of([beam((0, 0, -0.1), "+z")], [*faces, sensor], medium=dyed)
    result = pz.trace(scene, batches=1, rays_per_batch=16)
    left = scene.medium["dyed"].transmittance(0.01)
    direct = result.detectors["element 2"].ladder[2].value
    assert direct == pytest.approx(0.25 * left, rel=1e-14)
    assert abs(result.ledger.closure) <= 1e-15


def test_faces_of_one_lens_have_coatings_of_their_own():
    lens = {
        "kind": "lens", "position": [0, 0, 0], "axis": "-z", "front_radius": "inf",
        "back_radius": "inf", "thickness": 0.01, "aperture_radius": 0.3,
        "surface": glass(None), "front": glass({**HALF, "transmittance": 0.75}),
        "back": glass(HALF),
    }  # fmt: skip
    sensor = {**wall((0, 0, 0.1), "-z", 0.5), **BLACK, "detector": {"generations": 4}}
    result = pz.trace(
        scene_of([beam((0, 0, -0.1), "+z")], [lens, sensor]), batches=1, rays_per_batch=16
    )
    assert result.detectors["element 1"].ladder[2].value == 0.75 * 0.5
    assert result.ledger.absorbed["element 0"].value == pytest.approx(
        0.25 * 0.75 / (1.0 - 0.25**2), rel=1e-14
    )


# -- bits ------------------------------------------------------------------------------------------

METAL = stack((1.38, 90.0), (2.3, 50.0, 0.05))
BY_ANGLE = {
    "kind": "table", "angle_deg": [0.0, 45.0, 90.0], "reflectance": [0.1, 0.3, 1.0],
    "transmittance": [0.8, 0.6, 0.0],
}  # fmt: skip


def busy(**run):
    """Glass with every coating, a mirror by angle, scatter, a target, roulette, a path table."""
    lobe = {"kind": "gaussian", "sigma": 0.2, "tis": 0.3}
    by_angle = {"angle_deg": [10, 80], "value": [0.9, 0.6]}
    elements = [
        {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 0.4,
         "surface": {**glass(METAL), "scatter": lobe}},
        {"kind": "plano-convex", "position": [-0.5, 0, 0.5], "axis": "+x", "curvature_radius": 0.3,
         "aperture_radius": 0.2, "surface": glass(BY_ANGLE)},
        {**wall((0, 0, 1), "-z"), "surface": {"kind": "mirror", "reflectance": by_angle,
                                              "scatter": lobe}},
        {**wall((0, 0, -1), "+z"), "surface": glass(HALF, 1.0, 1.4)},
        {**wall((0, 0, -1.2), "+z"), "surface": {"kind": "lambertian", "reflectance": 0.6}},
        {**wall((1, 0, 0), "-x"), "surface": glass(MIRROR_OF_12)},
        {**wall((0, 1, 0), "-y"), **BLACK, "detector": {"map": [4, 4], "paths": 64}},
        {**wall((0, -1, 0), "+y"), "surface": glass(None)},
    ]  # fmt: skip
    scene = scene_of(
        [{"kind": "isotropic-point", "flux": 1.0, "position": [0.5, 0.1, 0.6]}],
        elements,
        importance={"toward": ["element 6"], "fraction": 0.3},
        spectrum={"edges_nm": [400.0, 500.0, 700.0]} if run.pop("bands", False) else LINES,
    )
    return compiled(scene, rays_per_batch=512, generation_cap=8, roulette_floor=1e-3, **run)


@pytest.mark.parametrize(
    "changes",
    [
        {"lanes": 8},
        {"composition": "whole-path", "lanes": 1, "stack_rays": 1},
        pytest.param({"composition": "classical", "lanes": 1}, marks=pytest.mark.slow),
        pytest.param({"lanes": 16, "interleaved": True}, marks=pytest.mark.slow),
    ],
)
def test_the_bits_are_the_same_however_it_runs(changes):
    made = busy()
    runs = [trace_compiled(made, 2, plan=plan) for plan in (PLAN, PLAN.with_(**changes))]
    assert runs[0].digest == runs[1].digest
    assert max(map(abs, runs[0].closures())) <= 1e-14


@pytest.mark.slow
def test_the_bits_are_the_same_in_bands():
    runs = [trace_compiled(busy(bands=True), 1, plan=PLAN.with_(lanes=n)) for n in (1, 8)]
    assert runs[0].digest == runs[1].digest


def test_rays_that_do_not_split_close_exactly():
    found = trace_compiled(busy(splitting=False), 2)
    assert not found.compiled.tables.spec.splits
    assert found.closures() == [0, 0]


def test_what_has_no_coating_has_nothing_of_it():
    """Not even where they are forced on does a bit change."""
    scene = pz.load("ghost-ladder")
    made = compile_scene(scene, scene.run)
    text = program_source(made.tables.spec.for_device(4, ("wave",)))
    assert "coating" not in text
    asked = frozenset({"coating.fixed", "coating.table", "coating.stack"})
    forced = compile_scene(scene, scene.run, asked)
    assert "coated-faces" in forced.effects
    assert "coat_stack" in program_source(forced.tables.spec.for_device(4, ("wave",)))
    assert trace_compiled(made).digest == trace_compiled(forced).digest


@pytest.mark.slow  # of the presets without: above
@pytest.mark.parametrize("number", [3, 7])
def test_a_coating_beside_bare_glass_changes_no_bit_of_it(number):
    """A random scene, and the same with a coated plate far away from all of it."""
    tables = random_scene(number)
    far = {**wall((1e3, 0, 0), "+x"), "name": "far", "surface": glass(HALF)}
    bare = {**far, "surface": glass(None)}
    runs = [
        trace(pz.load({**tables, "element": [*tables["element"], plate]}), batches=1)
        for plate in (bare, far)
    ]
    assert runs[0].digest == runs[1].digest


@pytest.mark.slow  # four programs each; of one scene of every kind of coating: above
@pytest.mark.parametrize("number", [2, 5, 8])
def test_random_scenes_with_coatings_are_one_whatever_runs_them(number):
    """Every border of a random scene coated at random: lanes, waves and stages change no bit."""
    tables = {**random_scene(number, rays=200), "spectrum": LINES}
    kinds = [HALF, METAL, BY_ANGLE, MIRROR_OF_12]
    for n, element in enumerate(tables["element"]):
        if element["surface"]["kind"] == "fresnel":
            element["surface"] = {**element["surface"], "coating": kinds[(n + number) % 4]}
    made = compiled(pz.load(tables))
    assert "coated-faces" in made.effects
    one = trace_compiled(made, 1, plan=PLAN.with_(lanes=1))
    for changes in ({"lanes": 8}, {"lanes": 1, "wave_rays": 32, "stack_rays": 4}):
        assert trace_compiled(made, 1, plan=PLAN.with_(**changes)).digest == one.digest
    assert max(map(abs, one.closures())) <= 1e-14


@pytest.mark.slow  # four programs each
@pytest.mark.parametrize("precision", ["mixed", "fp32"])
def test_other_precisions_have_the_same_shares(precision):
    scene = window(MGF2, 30.0, spectrum=LINES, detector={"generations": 4})
    wide, narrow = (
        trace(scene, rays_per_batch=48, precision=p).detector("sensor") for p in ("fp64", precision)
    )
    assert float(narrow.ladder[2] / wide.ladder[2]) == pytest.approx(1.0, rel=3e-6)
    found = trace(window(HALF), rays_per_batch=16, precision=precision)
    assert found.detector("sensor").ladder[2] == found.emitted / 4
    assert max(map(abs, found.closures())) <= 1e-7


# -- sweeps, replacing -----------------------------------------------------------------------------


@pytest.mark.slow
def test_a_layer_is_swept_in_one_program():
    scene = window(MGF2, spectrum={"wavelengths_nm": [550.0]}, detector={})
    changes = {"element.front.surface.coating.layers[0].thickness_nm": 0.0}
    bare = scene.replace(changes).element["front"].surface.coating.layers[0]
    assert bare.thickness_nm == 0.0
    sweep = pz.sweep(
        {
            "schema": "photizon-sweep/1",
            "scene": scene,
            "vary": [
                {
                    "path": "element.front.surface.coating.layers[0].thickness_nm",
                    "values": [0.0, 50.0, 99.6],
                }
            ],
            "run": {"batches": 1},
            "measure": {"power": "detectors.sensor.power"},
        }
    )
    power = np.asarray(sweep.to_dataframe()["power"])
    assert (np.diff(power) > 0.0).all()
    specs = {compile_scene(s, s.run).tables.spec for s in (scene, scene.replace(changes))}
    assert len(specs) == 1


def test_points_with_and_without_loss_share_a_program():
    scenes = [window({**HALF, "transmittance": t}) for t in (0.75, 0.5)]
    specs = {compile_scene(s, replace(s.run)).tables.spec for s in scenes}
    assert len(specs) == 1
