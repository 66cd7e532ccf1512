"""Bands: every ray has a wavelength of its own, and what it meets is that of this wavelength."""

from __future__ import annotations

import math
import random

import mpmath
import pytest
from oracles import spectra
from oracles.engine import PLAN, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from photizon_cl.compile.grid import Grid, numbers_of
from photizon_cl.compile.kinds import Kinds
from photizon_cl.compile.packing import material_table

EDGES = [400.0, 480.0, 500.0, 700.0]


def test_a_prism_turns_each_ray_as_its_own_wavelength_says():
    spectra.prism_of_bands()


def test_lanes_and_compositions_change_no_bit():
    scene = spectra.tables_scene().replace(
        {"spectrum.edges_nm": [400.0, 450.0, 500.0, 550.0, 660.0]}
    )
    made = compiled(scene, rays_per_batch=64)
    found = trace_compiled(made, batches=2)
    for plan in (
        {"lanes": 1}, {"items": 2, "wave_rays": 32}, {"composition": "classical"},
        {"composition": "whole-path", "lanes": 1, "wave_rays": 64},
    ):  # fmt: skip
        assert trace_compiled(made, batches=2, plan=PLAN.with_(**plan)).digest == found.digest
    spectra.sums(found)
    assert all(abs(closure) < 1e-15 for closure in found.closures())


def value(rows: list[tuple[float, ...]], column: int, t: float) -> float:
    """Return a number of a piece at a place in it, as kernels compute it."""
    found = mpmath.mpf(0)
    for row in reversed(rows):  # each fma rounds once
        found = mpmath.mpf(float(found * t + row[column]))
    return float(found)


@pytest.mark.parametrize("other", [None, {"kind": "cauchy", "A": 1.62, "B_um2": 0.011}])
@pytest.mark.parametrize("edges", [EDGES, [320.0, 2300.0]])
def test_polynomials_are_their_formulas(edges, other):
    """Ratios of indices of two glasses, at random wavelengths, to 2e-13 of 40 digits."""
    media = [{"name": "bk7", "dispersion": spectra.N_BK7}]
    surface = {"kind": "fresnel", "medium": "bk7"}
    if other:
        media.append({"name": "flint", "dispersion": other})
        surface["medium_outside"] = "flint"
    scene = scene_of(
        [beam((0, 0, -0.5), "+z", 1e-9)],
        [{**wall((0, 0, 0), "-z", 1.0), "surface": surface}],
        medium=media, spectrum={"edges_nm": edges},
    )  # fmt: skip
    grid = Grid.of(scene)
    assert set(edges) <= set(grid.edges)
    assert grid.n < 200
    numbers = numbers_of(scene, scene.element[0].surface)
    rows = list(grid.rows(numbers))
    r = random.Random(1)
    for _ in range(200):
        piece, t = r.randrange(grid.n), r.random()
        a, b = grid.edges[piece : piece + 2]
        nm = mpmath.mpf(a) + mpmath.mpf(t) * (mpmath.mpf(b) - a)
        with mpmath.workdps(40):
            n = spectra.index_of_bk7(nm)
            um = nm / 1000
            m = 1 if other is None else mpmath.mpf(1.62) + mpmath.mpf(0.011) / um**2
            wanted = (m / n, 1 - (m / n) ** 2, n / m, 1 - (n / m) ** 2)
        mine = rows[piece * (grid.degree + 1) : (piece + 1) * (grid.degree + 1)]
        for column in range(4):
            assert abs(value(mine, column, t) - wanted[column]) < 2e-13


def test_tables_are_exact_at_their_nodes_and_linear_between():
    scene = spectra.tables_scene().replace(
        {"spectrum.edges_nm": [420.0, 480.0, 550.0, 580.0, 660.0]}
    )
    grid = Grid.of(scene)
    # edges of bands, and the nodes of the tables that lie within
    assert grid.edges == (420.0, 450.0, 480.0, 500.0, 550.0, 580.0, 600.0, 650.0, 660.0)
    assert grid.first == (0, 2, 4, 5, 8)
    surface = scene.element["element 2"].surface
    rows = [row[0] for row in grid.rows(numbers_of(scene, surface))]
    for k, nm in enumerate(grid.edges[:-1]):
        lowest, rise, *others = rows[6 * k : 6 * k + 6]
        assert lowest == surface.reflectance.at(nm)
        assert lowest + rise == pytest.approx(surface.reflectance.at(grid.edges[k + 1]), abs=1e-16)
        assert not any(others)


@pytest.mark.parametrize("light", [{"edges_nm": EDGES}, {"wavelengths_nm": [450.0, 600.0]}])
def test_each_surface_reads_its_own_rows(light):
    """Those without numbers among them, wherever they stand in the file."""
    curve = {"wavelength_nm": [400.0, 700.0], "value": [0.25, 0.75]}
    surfaces = [
        {"kind": "absorber"}, {"kind": "mirror", "reflectance": curve}, {"kind": "clear"},
        {"kind": "lambertian", "reflectance": 0.5}, {"kind": "mixed", "specular": curve,
                                                     "diffuse": 0.125},
    ]  # fmt: skip
    for order in (surfaces, surfaces[::-1]):
        scene = scene_of(
            [beam((0, 0, -0.5), "+z", 1e-9)],
            [{**wall((0, 0, z), "-z", 1.0), "surface": s} for z, s in enumerate(order)],
            spectrum=light,
        )
        made = compiled(scene, rays_per_batch=16)
        grid, width = Grid.of(scene), made.tables.spec.strides.material
        table = made.tables.materials.reshape(-1, width)
        places = material_table(
            scene, Kinds.of(scene, general=False), made.tables.spec.strides, grid
        )[1]
        assert len(table) == len(places) * grid.n * (grid.degree + 1)
        for surface, place in places.items():
            wanted = list(grid.rows(numbers_of(scene, surface)))
            assert len(wanted) == grid.n * (grid.degree + 1)
            for row, found in zip(wanted, table[place // width :], strict=False):
                assert found[: len(row)].tolist() == list(row)
                assert not found[len(row) :].any()


def test_black_before_others_takes_none_of_their_numbers():
    """What a mirror leaves behind a black wall in the file is what it leaves before it."""
    curve = {"wavelength_nm": [400.0, 700.0], "value": [0.25, 0.25]}
    rows = [
        {**wall((0, 0, 0), "-z", 1.0), "name": "black", **BLACK},
        {**wall((0, 0, -1.0), "+z", 1.0), "name": "mirror",
         "surface": {"kind": "mirror", "reflectance": curve}},
    ]  # fmt: skip
    for order in (rows, rows[::-1]):
        found = trace(
            scene_of([beam((0, 0, -0.5), "-z", 0.01)], order, spectrum={"edges_nm": EDGES}),
            rays_per_batch=48,
        )
        assert found.absorbed("black") == found.emitted / 4
        assert found.closures() == [0]


@pytest.mark.statistical
def test_a_band_is_uniform_per_nm():
    """A linear reflectance reflects what its middle does: |z| < 4.5, false alarm 7e-6 a band."""
    curve = {"wavelength_nm": [400.0, 700.0], "value": [0.0, 1.0]}
    scene = scene_of(
        [beam((0, 0, 0.5), "-z", 0.01)],
        [{**wall((0, 0, 0), "+z", 1.0), "surface": {"kind": "mirror", "reflectance": curve}}],
        spectrum={"edges_nm": EDGES},
    )
    result = pz.trace(scene, batches=32, rays_per_batch=300)
    emitted = result.ledger.emitted.by_wavelength
    for k, part in enumerate(result.ledger.escaped.by_wavelength):
        wanted = emitted[k] * ((EDGES[k] + EDGES[k + 1]) / 2 - 400) / 300
        assert abs(part - wanted) < 4.5 * part.sigma


def test_too_steep_an_index_is_refused():
    steep = {"kind": "sellmeier", "B": [1.0, 1e-7], "C_um2": [0.01, 0.2553]}
    with pytest.raises(pz.SceneError, match=r"spectrum.edges_nm\[1\].*500 to 510 nm.*505.27"):
        scene_of(
            [beam((0, 0, -0.5), "+z", 1e-9)],
            [{**wall((0, 0, 0), "-z", 1.0), **BLACK}],
            medium=[{"name": "x", "dispersion": steep}], spectrum={"edges_nm": [490, 500, 510]},
        )  # fmt: skip
    for square, fits in ((0.245, True), (0.2499, False)):  # resonances at 495 and 499.9 nm
        wild = {"kind": "sellmeier", "B": [1.0, 1e-3], "C_um2": [0.01, square]}
        scene = scene_of(
            [beam((0, 0, -0.5), "+z", 1e-9)],
            [{**wall((0, 0, 0), "-z", 1.0), "surface": {"kind": "fresnel", "medium": "x"}}],
            medium=[{"name": "x", "dispersion": wild}], spectrum={"edges_nm": [500.0, 510.0]},
        )  # fmt: skip
        if fits:
            assert 8 < Grid.of(scene).n < 200
        else:
            with pytest.raises(pz.ArgumentError, match=r"between 500 and 510 nm .* resonance"):
                compiled(scene)


def long_tables(n: int, tables: int) -> pz.Scene:
    """Walls whose reflectances are tables of n nodes, none of them at another one's."""
    step = 300.0 / n
    walls = [
        {**wall((0, 0, float(k)), "-z", 1.0), "surface": {"kind": "mirror", "reflectance": {
            "wavelength_nm": [400.0 + step * (i + k / tables) for i in range(n)],
            "value": [(0.25, 0.75)[i % 2] for i in range(n)],
        }}}
        for k in range(tables)
    ]  # fmt: skip
    return scene_of(
        [beam((0, 0, -0.5), "+z", 1e-9)], walls, spectrum={"edges_nm": [400.0, 550.0, 700.0]}
    )


def test_the_longest_table_there_may_be_is_cut_at_each_of_its_nodes():
    scene = long_tables(10_000, 1)
    grid = Grid.of(scene)
    assert grid.n == 10_000
    assert grid.first == (0, 5000, 10_000)
    table = scene.element[0].surface.reflectance
    rows = list(grid.rows(lambda nm: (table.at(nm),)))
    assert [rows[6 * k][0] for k in range(10_000)] == list(table.value)


def test_too_many_nodes_are_refused_as_such():
    with pytest.raises(pz.ArgumentError) as caught:
        Grid.of(long_tables(10_000, 4))
    text = str(caught.value)
    assert "more than 32768" in text
    assert 'element "element 0": surface.reflectance, has 10000' in text
    assert "resonance" not in text
    assert len(text.splitlines()) == 1


def test_what_comes_out_has_the_edges(tmp_path):
    scene = spectra.tables_scene().replace(
        {"spectrum.edges_nm": [400.0, 450.0, 500.0, 550.0, 660.0]}
    )
    assert scene.spectrum.names[0] == "400 – 450 nm"
    assert scene.spectrum.about == "4 bands, 400 … 660 nm"
    result = pz.trace(scene, batches=2, rays_per_batch=64)
    result.save(tmp_path / "out")
    again = pz.open_result(tmp_path / "out")
    assert again.summary() == result.summary()
    found = again.to_dataset()
    assert found["ledger/wavelength_edges"].values.tolist() == list(scene.spectrum.edges_nm)
    assert found["element 3/power_by_wavelength"].shape == (4,)
    axes = pz.figures.by_wavelength(result).axes[0]
    assert axes.get_ylabel() == "part of the band's emitted power"
    whole = pz.trace(scene, batches=5, rays_per_batch=64)
    assert pz.resume(tmp_path / "out", batches=5).tally_digest == whole.tally_digest
    assert math.isclose(sum(whole.ledger.emitted.by_wavelength), 3.5)


@pytest.mark.slow
def test_other_precisions():
    scene = spectra.tables_scene().replace(
        {"spectrum.edges_nm": [400.0, 450.0, 500.0, 550.0, 660.0]}
    )
    exact = trace(scene, rays_per_batch=64)
    floats = trace(scene, rays_per_batch=64, precision="fp32")
    layout = exact.compiled.layout
    for k in range(4):
        cell = layout.part(2, k)
        assert float(floats.amount(cell)) == pytest.approx(float(exact.amount(cell)), rel=1e-5)
