"""A sweep's points are traces of their scenes, bit for bit, in one program."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tubes import ANGLE, MEASURE, TUBE, WALL, a_sweep

import photizon_cl as pz
from hostcode.run import wavefront
from photizon_cl.compile.common import Common, kinds_of
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.table import EFFECTS

SCENE = pz.load(TUBE)


@pytest.fixture
def built(monkeypatch):
    """Return the digests of all program texts that engines take while the test runs."""
    digests = []
    build = wavefront.build

    def noted(*args, **kwargs):
        made = build(*args, **kwargs)
        digests.append(made.digest)
        return made

    monkeypatch.setattr(wavefront, "build", noted)
    return digests


def test_each_point_is_the_trace_of_its_scene(swept):
    assert [point.values["angle"] for point in swept] == [float(n) for n in range(12)]
    assert len({point.digest for point in swept}) == 12
    for point in (swept[0], swept[1], swept[11]):
        scene = SCENE.replace({"source.sun.tilt_deg[0]": point.values["angle"]})
        traced = pz.trace(scene, batches=4)
        assert point.digest == traced.tally_digest
        assert point.scene_digest == traced.scene.digest()
        assert point["power"] == traced.quantity("detectors.sensor.power")


@pytest.mark.parametrize("n", [12, pytest.param(60, marks=pytest.mark.slow)])
def test_one_program_for_all_angles(built, n):
    found = pz.sweep(a_sweep({**ANGLE, "linspace": [0, 60, n]}))
    assert found.finished
    assert found.programs == 1
    assert len(built) == 2 * n  # what traces, and what counts
    assert len(set(built)) == 2


def test_a_program_of_its_own_without_the_others(built):
    # what the test above would see, were the points not compiled alike
    for number in (0.0, 5.0):
        wall = {"element.tube.tilt_deg[0]": number, "element.sensor.tilt_deg[0]": number}
        pz.trace(SCENE.replace(wall), batches=1)
    assert len(set(built)) > 2
    built.clear()
    both = [
        {"path": "element.tube.tilt_deg[0]", "values": [0, 5]},
        {"path": "element.sensor.tilt_deg[0]", "values": [0, 5], "together": True},
    ]
    found = pz.sweep(a_sweep(*both, run={"batches": 1}, measure={}))
    assert found.programs == 1
    assert len(set(built)) == 2


MANY = {
    "schema": "photizon/1",
    "name": "many",
    "run": {"rays_per_batch": 512},
    "source": [
        {"name": n, "kind": "isotropic-point", "flux": 1.0, "position": [0.0, 0.1 * k, 0.5]}
        for k, n in enumerate(("a", "b"))
    ],
    "element": [
        {
            "name": name,
            "kind": "rectangle",
            "position": [x, 0.0, 0.0],
            "axis": "+z",
            "half_width": 0.5,
            "half_height": 0.5,
            "surface": surface,
        }
        for name, x, surface in (
            ("left", -0.5, {"kind": "lambertian", "reflectance": 0.5}),
            ("right", 0.5, {"kind": "lambertian", "reflectance": 0.5}),
            ("far", 3.0, {"kind": "mixed", "specular": 0.4, "diffuse": 0.0}),
        )
    ],
}
CHANGES = {
    "a tilt": {"element.right.tilt_deg[0]": 5.0},
    "another axis": {"element.far.axis": "-x"},
    "another material": {"element.right.surface.reflectance": 0.9},
    "a second child": {"element.far.surface.diffuse": 0.3},
    "one child is chosen": {"element.far.surface.diffuse": 0.3, "run.splitting": False},
    "another flux": {"source.a.flux": 2.0},
    "roulette": {"run.roulette_floor": 0.1},
    "elements that cross": {"element.far.position[0]": 0.6, "element.far.tilt_deg[1]": 20.0},
}
OWN = frozenset(effect.name for effect in EFFECTS)


def own(changes):
    """Return a scene's own program, and what it needs."""
    scene = pz.load(MANY).replace(changes)
    made = compile_scene(scene, scene.run)
    return scene, made.tables.spec, Common.of(scene, made.tables.spec, made.effects & OWN)


@pytest.mark.parametrize("what", list(CHANGES))
def test_scenes_compiled_alike_share_a_program(what):
    plain, first, needs = own({})
    other, second, more = own(CHANGES[what])
    assert kinds_of(plain) == kinds_of(other)
    assert first != second  # by themselves they are two
    common = needs | more
    specs = {compile_scene(s, s.run, common=common).tables.spec for s in (plain, other)}
    assert len(specs) == 1
    layouts = {compile_scene(plain, plain.run, common=c).layout for c in (None, common)}
    assert len(layouts) == 1  # no cell more


def test_what_is_compiled_for_others_changes_no_bit():
    plain, crossing = pz.load(MANY), CHANGES["elements that cross"]
    every = {p: v for c in CHANGES.values() for p, v in c.items()} | crossing
    every.pop("run.splitting")
    start = {
        "element.right.tilt_deg[0]": 0.0, "element.far.axis": "+z",
        "element.right.surface.reflectance": 0.5, "element.far.surface.diffuse": 0.0,
        "source.a.flux": 1.0, "run.roulette_floor": "auto", "element.far.position[0]": 3.0,
        "element.far.tilt_deg[1]": 0.0,
    }  # fmt: skip
    assert set(start) == set(every)
    vary = [
        {"path": path, "values": [start[path], every[path]], "together": n > 0}
        for n, path in enumerate(start)
    ]
    found = pz.sweep(
        {"schema": "photizon-sweep/1", "scene": MANY, "vary": vary, "run": {"batches": 2}}
    )
    assert found.programs == 1
    for point, changes in zip(found, ({}, every), strict=True):
        assert point.digest == pz.trace(plain.replace(changes), batches=2).tally_digest


# -- grids, steps, settings ------------------------------------------------------------------------


def test_the_last_axis_changes_fastest_and_others_step_together():
    cap = {"path": "run.generation_cap", "values": [4, 8], "together": True}
    found = pz.sweep(a_sweep(WALL, cap, {"path": "source.sun.flux", "values": [1, 2, 3]}))
    assert found.plan.shape == (2, 3)
    assert [tuple(point.values.values()) for point in found] == [
        (r, c, f) for r, c in ((0.1, 4), (0.5, 8)) for f in (1, 2, 3)
    ]
    data = found.to_dataset()
    assert data["power"].dims == ("element.tube.surface.reflectance", "source.sun.flux")
    assert data["run.generation_cap"].dims == ("element.tube.surface.reflectance",)
    assert data["power"].values[1, 2] == found[5]["power"]
    assert data["power.sigma"].values[1, 2] == found[5]["power"].sigma
    assert data["digest"].values[1, 2] == found[5].digest
    assert data["power"].attrs["units"] == "W"
    assert data["source.sun.flux"].attrs["units"] == "W"
    # three times the flux is three times the power, and the same PST
    assert found[2]["power"] == pytest.approx(3 * found[0]["power"], rel=1e-14)
    assert found[2]["PST"] == pytest.approx(found[0]["PST"], rel=1e-14)


def test_settings_of_the_sweep_go_before_those_of_the_scene():
    run = {"seed": 7, "rays_per_batch": 256, "batches": 3, "generation_cap": 5}
    found = pz.sweep(a_sweep(WALL, run=run))
    traced = pz.trace(
        SCENE.replace({"run.generation_cap": 5}), seed=7, rays_per_batch=256, batches=3
    )
    assert found[0].digest == traced.tally_digest
    assert (found[0].seed, found[0].rays, found[0].stopped) == (7, 768, "batches")
    again = pz.sweep(a_sweep(WALL, run={**run, "seed": 9, "batches": 9}), seed=7, batches=3)
    assert again[0].digest == found[0].digest


def test_workers_give_the_same_bits(swept):
    with ThreadPoolExecutor(2) as executor:
        found = pz.sweep(a_sweep({**ANGLE, "linspace": [3, 4, 2]}), executor=executor)
    assert [point.digest for point in found] == [swept[3].digest, swept[4].digest]


def test_a_point_ends_at_its_target():
    found = pz.sweep(a_sweep(WALL, run={"target_sigma": 0.05}))
    traced = pz.trace(SCENE, target=0.05)
    assert found[0].stopped == "target"
    assert found[0].digest == traced.tally_digest


def test_without_a_measure_every_scalar_is_one():
    found = pz.sweep(a_sweep(WALL, measure={}))
    traced = pz.trace(SCENE, batches=4)
    assert list(found.names) == traced.quantity_names
    assert [found[0][name] for name in found.names] == [
        traced.quantity(name) for name in traced.quantity_names
    ]


def test_values_that_are_no_numbers():
    kinds = [{"kind": "absorber"}, {"kind": "lambertian", "reflectance": 0.1}]
    surface = {"path": "element.tube.surface", "name": "wall", "values": kinds}
    found = pz.sweep(a_sweep(surface))
    assert found.programs == 2  # of other kinds
    assert found[1].digest == pz.trace(SCENE, batches=4).tally_digest
    assert found.to_dataset()["wall"].values.tolist() == [
        '{"kind": "absorber"}', '{"kind": "lambertian", "reflectance": 0.1}',
    ]  # fmt: skip


# -- what is measured ------------------------------------------------------------------------------


def test_a_ratio_and_its_error_are_those_of_the_batches(swept):
    traced = pz.trace(SCENE.replace({"source.sun.tilt_deg[0]": 3.0}), batches=4)
    a = traced.batch_values("detectors.sensor.power")
    b = traced.batch_values("ledger.absorbed.tube")
    share = swept[3]["share"]
    assert share == pytest.approx(a.mean() / b.mean(), rel=1e-12)
    # the delta method: of the batches' deviations from the common ratio
    error = (a - share * b).std(ddof=1) / 2.0 / b.mean()
    assert share.sigma == pytest.approx(error, rel=1e-12)


def test_a_pst_is_irradiance_over_irradiance(swept):
    beam = 1.0 / (math.pi * 0.05**2)
    for point in swept:
        sensor = point["power"].value / (math.pi * 0.02**2)
        assert point["PST"] == pytest.approx(sensor / beam, rel=1e-12)
        assert point["PST"].sigma == pytest.approx(
            point["power"].sigma / (math.pi * 0.02**2) / beam, rel=1e-12
        )
    # a beam that fills the tube, and black walls: all of it arrives
    black = {"path": "element.tube.surface.reflectance", "values": [0.0]}
    found = pz.sweep(a_sweep(black, run={"batches": 40, "rays_per_batch": 8192}))
    assert abs(found[0]["PST"] - 1.0) < 4.0 * found[0]["PST"].sigma
    assert found[0]["PST"].sigma < 0.01
    meaning = found.to_dataset()["PST"].attrs["comment"]
    assert "(P/A)/(Φ/S)" in meaning
    assert "cross-section" in meaning


def test_differences_are_paired(swept):
    runs = [
        pz.trace(SCENE.replace({"source.sun.tilt_deg[0]": angle}), batches=4)
        for angle in (2.0, 3.0)
    ]
    (row,) = (r for r in pz.compare(*runs) if r.name == "detectors.sensor.power")
    found = swept.difference("power", 2, 3)
    assert found.paired
    assert (found.difference, found.sigma) == (row.difference, row.sigma)
    assert (found.ratio, found.ratio_sigma) == (row.ratio, row.ratio_sigma)
    # with the noise of both taken as independent it would be known worse
    apart = math.hypot(swept[2]["power"].sigma, swept[3]["power"].sigma)
    assert found.sigma < 0.9 * apart
    # the table has that against the first point
    first = swept.difference("PST", 0, 3)
    assert swept[3].change["PST"] == first.difference
    assert swept[3].change["PST"].sigma == first.sigma
    assert swept.to_dataset()["PST.change"].values[3] == first.difference
    assert swept[0].change["PST"] == 0.0


def test_points_of_several_streams_are_not_paired():
    found = pz.sweep(a_sweep({"path": "run.seed", "values": [1, 2]}))
    difference = found.difference("power", 0, 1)
    assert not difference.paired
    assert difference.sigma == pytest.approx(
        math.hypot(found[0]["power"].sigma, found[1]["power"].sigma)
    )


def test_a_single_batch_has_no_sigma():
    found = pz.sweep(a_sweep(WALL, run={"batches": 1}))
    assert found[1]["PST"].sigma is None
    assert found[1]["share"].sigma is None
    assert np.isnan(found.to_dataset()["PST.sigma"].values).all()
    assert found.summary()["points"][1]["measures"]["PST"]["sigma"] is None


def test_a_ratio_to_nothing_has_no_value():
    nothing = {"ratio": ["detectors.sensor.power", "ledger.depth_capped"]}
    found = pz.sweep(a_sweep(WALL, measure={"none": nothing}))
    assert math.isnan(found[0]["none"])
    assert found.summary()["points"][0]["measures"]["none"]["value"] is None
    assert ",,,,," in found.to_csv()


# -- what it says ----------------------------------------------------------------------------------


def test_it_says_what_it_is(swept):
    assert repr(swept) == "<photizon_cl.Sweep of 'tube': 12 points over angle>"
    with pytest.raises(pz.UnknownNameError, match='expected one of "power"'):
        swept[0]["pwr"]
    with pytest.raises(pz.UnknownNameError, match='did you mean "PST"'):
        swept.difference("pST", 0, 1)
    with pytest.raises(pz.ArgumentError, match="found 12, expected one below 12"):
        swept.difference("PST", 0, 12)
    with pytest.raises(pz.ResultError, match="give out="):
        swept.open(0)
    with pytest.raises(pz.ResultError, match="give out="):
        swept.resume()
    assert set(MEASURE) == set(swept.names)


def test_advisories_are_told_once_with_their_points():
    caps = {"path": "run.generation_cap", "values": [4, 8, 1000]}
    run = {"batches": 3, "rays_per_batch": 256}
    found = pz.sweep(a_sweep(caps, run=run, measure={}) | {"scene": "integrating-sphere"})
    first, second, *_ = found.advisories
    assert first.startswith("at every point: σ from 3 batches is itself uncertain")
    assert second.startswith("at points 0, 1; at the first of them ")
    assert second.removeprefix("at points 0, 1; at the first of them ") in found[0].advisories
    assert "generation cap of 4" in second
    assert not any("generation cap" in text for text in found[2].advisories)


def test_csv_has_every_number_to_the_bit(swept):
    import csv
    import io

    rows = list(csv.DictReader(io.StringIO(swept.to_csv())))
    assert len(rows) == 12
    for row, point in zip(rows, swept, strict=True):
        assert float(row["angle"]) == point.values["angle"]
        assert float(row["PST"]) == point["PST"]
        assert float(row["PST_sigma"]) == point["PST"].sigma
        assert float(row["PST_change"]) == point.change["PST"]
        assert row["digest"] == point.digest


def test_a_data_frame_has_the_columns_of_the_csv(swept):
    import csv
    import io

    frame = swept.to_dataframe()
    head, *rows = csv.reader(io.StringIO(swept.to_csv()))
    assert list(frame.columns) == head
    for row, cells in zip(frame.itertuples(index=False), rows, strict=True):
        for value, cell in zip(row, cells, strict=True):
            same = value == cell if isinstance(value, str) else value == float(cell or "nan")
            assert same or (cell == "" and math.isnan(value))


def test_progress_tells_of_the_whole_job():
    said = []
    pz.sweep(a_sweep(WALL), progress=said.append)
    assert said[0].number == -1  # looking at the points
    points = [now for now in said if now.number >= 0]
    assert [now.number for now in points if now.point is None] == [0, 1]
    assert {now.points for now in said} == {2}
    assert points[-1].done == 1
    assert all(now.eta_seconds is None or now.eta_seconds >= 0.0 for now in said)
    # once a point has been run there is a time for the rest
    assert all(now.eta_seconds is not None for now in points if now.number == 1)
