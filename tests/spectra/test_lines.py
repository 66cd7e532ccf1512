"""What each line of a spectrum gives: indices, tables, rows, to the last bit where exact."""

from __future__ import annotations

import math

import pytest
from oracles import spectra
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from photizon_cl.compile.rays import beams_of, share_rays


def test_a_prism_turns_each_line_as_its_index_says():
    spectra.prism()


def test_tables_are_linear_and_what_each_line_gives_adds_up():
    spectra.tables()


def test_a_source_shares_its_power_among_lines():
    found = spectra.tables((1.0, 0.0, 3.0, 1.0))
    beams = beams_of(found.compiled.scene)
    assert [(b.source, b.line) for b in beams] == [(0, 0), (0, 2), (0, 3), (1, 1), (1, 3)]
    rays = share_rays(found.compiled.scene, 64)
    assert sum(rays) == 64
    assert min(rays) >= 1
    # the more power, the more rays; what is left is the weights'
    assert rays[1] > rays[0] == rays[2]


@pytest.mark.slow  # of bands, whose kernels have all of it, it is asked always
def test_lanes_and_compositions_change_no_bit():
    made = compiled(spectra.tables_scene(), rays_per_batch=64)
    base = trace_compiled(made, batches=2).digest
    for plan in (
        {"lanes": 1}, {"items": 2, "wave_rays": 32}, {"composition": "classical"},
        {"composition": "whole-path", "lanes": 1, "wave_rays": 64},
    ):  # fmt: skip
        assert trace_compiled(made, batches=2, plan=PLAN.with_(**plan)).digest == base


def test_forced_on_it_is_one_line_and_changes_no_other_bit():
    scene = scene_of(
        [beam((0, 0, -0.5), "+z", 0.01)],
        [{**wall((0, 0, 0), "-z", 1.0), **BLACK, "detector": {"map": [2, 2]}}],
    )
    plain, forced = (
        trace(scene, force=force, rays_per_batch=64) for force in (frozenset(), {"spectrum"})
    )
    layout = forced.compiled.layout
    assert layout.parts == 1
    n = plain.compiled.layout.n_cells - 1
    assert forced.cells[:n].tobytes() == plain.cells[:n].tobytes()
    assert forced.interactions == plain.interactions


@pytest.mark.parametrize("aperture", [0.02, 1e-4])
def test_chromatic_focal_shift_of_the_condenser(aperture):
    """Where each ray of a condenser of N-BK7 crosses the axis, against the chain written out.

    Near the axis that is the paraxial focus, R/(n − 1) − t/n behind the flat face, which is 1.5 mm
    further away for red than for blue light.
    """
    radius, depth = 0.05, math.sqrt(0.05**2 - 0.025**2)
    tables = pz.load("plano-convex-condenser").to_dict()
    lens, target = tables["element"]
    lens["surface"] = {"kind": "fresnel", "medium": "bk7"}
    target.update(position=[0, 0, 0.3], radius=0.1, detector={"wavelengths": True})
    tables["source"][0]["radius"] = aperture
    tables |= {
        "medium": [{"name": "bk7", "dispersion": spectra.N_BK7}],
        "spectrum": {"wavelengths_nm": spectra.LINES},
        "run": {"generation_cap": 3, "roulette_floor": 0.0},
    }
    focus = {}
    for line in pz.paths(pz.load(tables), rays=3, seed=1):
        if line.parent >= 0 or len(line.points) != 4:
            continue
        start, way = line.points[0], line.points[3] - line.points[2]
        h = math.hypot(start[0], start[1])
        n = float(spectra.index_of_bk7(spectra.LINES[line.ray]))
        first = math.asin(h / radius)
        bent = first - math.asin(h / (n * radius))
        at_flat = h - (radius * math.cos(first) - depth) * math.tan(bent)
        wanted = at_flat / math.tan(math.asin(n * math.sin(bent)))
        slope = math.hypot(way[0], way[1]) / way[2]
        focus[line.ray] = math.hypot(*line.points[2][:2]) / slope
        assert focus[line.ray] == pytest.approx(wanted, rel=1e-12)
        if aperture < 1e-3:
            paraxial = radius / (n - 1.0) - (radius - depth) / n
            assert focus[line.ray] == pytest.approx(paraxial, abs=1e-6)
    assert len(focus) == 3
    if aperture < 1e-3:
        assert focus[2] - focus[0] == pytest.approx(1.4760e-3, abs=1e-7)


def test_mixed_surfaces_and_walls_by_line():
    """A wall of a table, and a mixed one of two: what each line leaves on them, exactly."""
    curve = {"wavelength_nm": [400.0, 600.0], "value": [0.25, 0.75]}
    rest = {"wavelength_nm": [400.0, 600.0], "value": [0.5, 0.0]}
    surfaces = [
        {"kind": "lambertian", "reflectance": curve},
        {"kind": "mixed", "specular": curve, "diffuse": rest},
    ]
    for surface, wanted in zip(surfaces, ([0.75, 0.25], [0.25, 0.25]), strict=True):
        scene = scene_of(
            [beam((0, 0, 0.5), "-z", 0.01)],
            [{**wall((0, 0, 0), "+z", 1.0), "surface": surface}],
            spectrum={"wavelengths_nm": [400.0, 600.0]},
        )
        found = trace(scene, rays_per_batch=32)
        layout = found.compiled.layout
        for k, part in enumerate(wanted):
            emitted = found.compiled.emitted_parts[k] / 2**95
            assert float(found.amount(layout.part(0, k))) == pytest.approx(
                part * emitted, rel=1e-15
            )


def test_media_mismatches_and_importance_go_with_it():
    """Effects that book rows of their own have them by line as well."""
    scene = scene_of(
        [beam((0, 0, 0.5), "-z", 0.01)],
        [
            {**wall((0, 0, 0), "+z", 1.0), "surface": {"kind": "lambertian", "reflectance": 0.5}},
            {**wall((0.3, 0, 0.3), "-z", 0.1), **BLACK, "detector": {"wavelengths": True}},
        ],
        spectrum={"wavelengths_nm": [400.0, 600.0]},
        importance={"toward": ["element 1"], "fraction": 0.5},
        run={"roulette_floor": 0.9},
    )
    found = trace(scene, rays_per_batch=256)
    assert found.amount(found.compiled.layout.row("importance.balance"))
    spectra.sums(found)
    assert all(abs(closure) < 1e-15 for closure in found.closures())
