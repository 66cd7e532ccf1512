"""Path tables: against closed forms, a second route, and the detector's own integers."""

from __future__ import annotations

import json
import math
from collections import defaultdict

import numpy as np
import pytest
from oracles.scenes import glass, mirror
from piles import SENSOR, pile, plates, sheet, with_tables

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result import keyed_sums

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly", "one_lane")


@pytest.mark.parametrize("n", [1, 3])
def test_every_path_of_a_pile_of_plates_is_its_product_of_r_and_t(n):
    table = plates(n).detectors["sensor"].paths
    r = (0.5 / 2.5) ** 2
    assert len(table) > 2
    for row in table:
        expected = r ** row.events.count("r") * (1.0 - r) ** row.events.count("t")
        assert row.power == pytest.approx(expected, rel=1e-12)
        assert row.interactions == len(row.steps) == len(row.events)
        assert row.ghost_order == row.events.count("r")
        assert row.count == 128
        assert row.sigma == pytest.approx(0.0, abs=1e-15)


def test_a_plate_has_every_order_of_its_ghosts_once():
    table = plates(1).detectors["sensor"].paths
    events = [row.events for row in table]
    assert events == [f"t{'r' * k}t" for k in range(0, 9, 2)]
    assert (
        table[1].sequence
        == '"in 0".face t > "out 0".face r > "in 0".face r > "out 0".face t > sensor'
    )


def test_two_hundred_and_ten_ghosts_of_21_surfaces():
    # ten plates and one more face: C(21, 2) pairs, each met first at the later face
    scene = pile(10, index=1.05, paths=5000, cap=64, rays=2)
    scene["run"]["roulette_floor"] = 1e-9
    scene["element"].insert(20, sheet("last", 0.99, "-z", 1.05))
    ghosts = pz.trace(scene, batches=2).detectors["sensor"].paths.ghosts()
    assert len(ghosts.faces) == 21
    assert len(ghosts.pairs()) == 210
    assert np.array_equal(np.asarray(ghosts), ghosts.power)
    assert (np.triu(ghosts.count) == 0).all()  # the first reflection is at the later face
    r = (0.05 / 2.05) ** 2
    # between two reflections all faces in between are passed two more times
    for a, b in zip(*np.nonzero(ghosts.count), strict=True):
        passed = 21 - 2 + 2 * (a - b - 1) + 2
        assert ghosts.power[a, b] == pytest.approx(r**2 * (1 - r) ** passed, rel=1e-11)


def by_second_route(scene, rays):
    """Return power and arrivals by sequence of elements, from the segments of every ray."""
    found = defaultdict(lambda: [0, 0])
    paths = pz.paths(scene, rays=rays, max_segments=20_000)
    assert not len(paths.cut)
    names = [element.name for element in paths.scene.element]
    for n in np.flatnonzero(paths.ending == 1):  # absorbed
        sequence, at = [], n
        while at >= 0:
            sequence.append(names[paths.element[at]])
            at = paths.parent[at]
        key = tuple(reversed(sequence))
        found[key][0] += paths.weight[n]
        found[key][1] += 1
    return {key: (weight * paths.unit_power, n) for key, (weight, n) in found.items()}


def test_powers_and_counts_are_those_of_the_segments_that_paths_follows():
    scene = {
        "schema": "photizon/1", "name": "lens",
        "run": {"generation_cap": 7, "rays_per_batch": 256, "roulette_floor": 0.0},
        "source": [{
            "name": "sun", "kind": "collimated-disk", "flux": 1.0, "position": [0, 0, -1],
            "axis": "+z", "radius": 0.2,
        }],
        "element": [
            sheet("in", 0.0, "-z", 1.5), sheet("out", 0.05, "+z", 1.5),
            {
                "name": "ball", "kind": "sphere", "position": [0, 0, 0.4], "radius": 0.25,
                "axis": "+z", "surface": {"kind": "fresnel", "index": 1.6},
            },
            {
                "name": "white", "kind": "rectangle", "position": [0, 0, -1.5], "axis": "+z",
                "half_width": 1.0, "half_height": 1.0,
                "surface": {"kind": "mixed", "specular": 0.3, "diffuse": 0.4},
            },
            SENSOR,
        ],
    }  # fmt: skip
    expected = by_second_route(scene, 256)
    table = pz.trace(scene, batches=1).detectors["sensor"].paths
    found = defaultdict(lambda: [0.0, 0])
    for row in table:
        key = (*(step.element for step in row.steps), "sensor")
        found[key][0] += row.power
        found[key][1] += row.count
    wanted = {key: value for key, value in expected.items() if key[-1] == "sensor"}
    assert table.rest.count == 0
    assert found.keys() == wanted.keys()
    for key, (power, count) in wanted.items():
        assert found[key][1] == count
        assert found[key][0] == pytest.approx(power, rel=1e-12)


def test_letters():
    # a slab lit at 60 degrees from inside reflects totally; a mirror and a white wall follow
    letters = set()
    scene = {
        "schema": "photizon/1", "name": "letters", "run": {"rays_per_batch": 1024},
        "source": [{
            "name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.02],
        }],
        "element": [
            {
                "name": "glass", "kind": "plano-convex", "position": [0, 0, 0], "axis": "+z",
                "curvature_radius": 0.1, "aperture_radius": 0.1, **glass(1.5),
            },
            {
                "name": "white", "kind": "rectangle", "position": [0, 0, 0.5], "axis": "-z",
                "half_width": 1.0, "half_height": 1.0,
                "surface": {"kind": "lambertian", "reflectance": 0.5},
            },
            {
                "name": "shiny", "kind": "rectangle", "position": [0.5, 0, 0], "axis": "-x",
                "half_width": 1.0, "half_height": 1.0, **mirror(0.9),
            },
            {**SENSOR, "position": [0, 0, -0.5], "axis": "+z", "detector": {"paths": 500}},
        ],
    }  # fmt: skip
    table = pz.trace(scene, batches=2).detectors["sensor"].paths
    for row in table:
        for step in row.steps:
            letters.add((step.element, step.event))
            assert step.refracting == (step.element == "glass")
    assert letters == {
        ("glass", "t"), ("glass", "r"), ("glass", "i"), ("white", "s"), ("shiny", "r"),
    }  # fmt: skip
    turned = [row for row in table if [s.element for s in row.steps if s.event == "r"] == ["shiny"]]
    assert turned
    assert all(row.ghost_order == 0 for row in turned)  # a mirror's reflection is no ghost's


def test_choosing_one_child_tells_which_one():
    scene = pile(2)
    scene["run"] |= {"splitting": False, "rays_per_batch": 4096}
    table = pz.trace(scene, batches=4).detectors["sensor"].paths
    both = {row.sequence: row.power for row in plates(2).detectors["sensor"].paths}
    for row in table[:4]:
        assert abs(row.power - both[row.sequence]) < 5 * max(row.sigma, 1e-12)
    assert {row.events for row in table} <= {
        key.events for key in plates(2).detectors["sensor"].paths
    }


# -- errors of groups ----------------------------------------------------------------------------


def test_sigma_of_groups_and_of_the_rest_follow_from_their_batches():
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    result = pz.trace(with_tables(scene, 8), batches=8)
    name, detector = next((n, d) for n, d in result.detectors.items() if d.power.value)
    table = detector.paths
    values = result.batch_values(f"detectors.{name}.power")
    sums = result.tally.keyed
    rows = sums.table()[:, table._columns] * result.compiled.unit_power
    n = len(values)
    rest = (values - rows.sum(axis=1)).std(ddof=1) / math.sqrt(n)
    assert table.rest.sigma == pytest.approx(rest, rel=1e-6)
    assert table.sigma == pytest.approx(rows.sum(axis=1).std(ddof=1) / math.sqrt(n), rel=1e-9)
    for row, column in zip(table, rows.T, strict=True):
        assert row.sigma == pytest.approx(column.std(ddof=1) / math.sqrt(n), rel=1e-9)
    assert math.isclose(table.power + table.rest.power, detector.power.value, rel_tol=1e-12)


def test_without_values_of_batches_a_sum_has_an_upper_bound(monkeypatch, tmp_path, capsys):
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 4}
    exact = pz.trace(with_tables(scene, 30), batches=6)
    name = next(n for n, d in exact.detectors.items() if d.power.value)
    table = exact.detectors[name].paths
    assert (table.sigma, table.rest.at_most) == (pytest.approx(table.sigma), False)
    monkeypatch.setattr(keyed_sums, "FOLLOWED", 3)
    result = pz.trace(with_tables(scene, 30), batches=6)
    bounded = result.detectors[name].paths
    assert [row.power for row in bounded] == [row.power for row in table]
    assert bounded.sigma >= table.sigma
    assert bounded.rest.sigma >= table.rest.sigma
    assert bounded.sigma <= sum(row.sigma for row in table)
    # which is said where it is one
    assert bounded.rest.at_most
    groups = bounded.grouped("ghost_order")
    assert [g.at_most for g in groups] == [len(g.rows) > 1 for g in groups]
    result.save(tmp_path / "out", figures=False)
    capsys.readouterr()
    for more, bound in (([], " ± at most "), (["--by", "events"], "≤ ")):
        assert main(["paths", str(tmp_path / "out"), *more]) == 0
        said = capsys.readouterr().out
        assert bound in said
        assert f"all other paths ({bounded.rest.paths}): " in said


# -- what a person does with it --------------------------------------------------------------------


def test_filters_groups_and_ghosts():
    table = plates(2).detectors["sensor"].paths
    via = table.filter(via=["in 1", "out 0"], ghost_order=2)
    for row in via:
        assert {"in 1", "out 0"} <= {step.element for step in row.steps}
        assert row.ghost_order == 2
    assert len(via) == sum(
        row.ghost_order == 2 and {"in 1", "out 0"} <= {s.element for s in row.steps}
        for row in table
    )
    assert via.exact + via.rest.exact == table.exact + table.rest.exact
    at = table.filter(via='"out 0".face r')
    assert at
    assert all(("out 0", "r") in [(s.element, s.event) for s in row.steps] for row in at)
    gone = table.filter(avoiding="out 0 r")
    assert len(gone) + len(table.filter(via="out 0 r")) == len(table)
    groups = table.grouped()
    assert sum(len(group.rows) for group in groups) == len(table)
    assert [g.power for g in groups] == sorted((g.power for g in groups), reverse=True)
    assert {g.label for g in table.grouped("ghost_order")} == {str(r.ghost_order) for r in table}
    ghosts = table.ghosts()
    assert len(ghosts.pairs()) == 6
    both = sum(row.power for row in table if row.ghost_order == 2)
    assert ghosts.power.sum() == pytest.approx(both, rel=1e-12)
    with pytest.raises(pz.PhotizonError, match="in 0"):
        table.filter(via="in O")
    with pytest.raises(pz.PhotizonError, match="event"):
        table.filter(event="x")
    with pytest.raises(pz.PhotizonError, match="ghost_order"):
        table.grouped("ghosts")


def test_the_example_ray_shows_the_path():
    scene = pz.load("box-room").to_dict()
    scene["run"] |= {"rays_per_batch": 512, "generation_cap": 6}
    result = pz.trace(with_tables(scene, 12), batches=3)
    name, table = next((n, d.paths) for n, d in result.detectors.items() if d.power.value)
    for row in table[:6]:
        followed = pz.paths(result.scene, ray_numbers=[row.example_ray], ending_on=name)
        met = [
            tuple(result.scene.element[e].name for e in line.element)
            for line in followed
            if line.ending == "absorbed"
        ]
        assert (*(step.element for step in row.steps), name) in met
        assert set(followed.ray.tolist()) == {row.example_ray}


def test_only_what_leads_to_an_arrival_by_way_of_a_face_is_kept():
    scene = pile(2)
    numbers = range(4)
    every = pz.paths(scene, ray_numbers=numbers)
    names = [element.name for element in every.scene.element]
    wanted = set()
    for n in np.flatnonzero((every.element == names.index("sensor")) & (every.ending == 1)):
        chain, at = [], int(n)
        while at >= 0:
            chain.append(at)
            at = int(every.parent[at])
        if any(every.element[k] == names.index("out 0") for k in chain):
            wanted.update(chain)
    found = pz.paths(scene, ray_numbers=numbers, ending_on="sensor", via="out 0")
    assert 0 < len(found) == len(wanted) < len(every)
    kept = sorted(wanted)
    assert (found.start == every.start[kept]).all()
    assert (found.end == every.end[kept]).all()
    assert (found.ray == every.ray[kept]).all()
    assert found.ledger == {}
    # no ray comes by this one
    scene["element"].append({
        "name": "aside", "kind": "disk", "position": [9.0, 0.0, 0.5], "axis": "-z", "radius": 0.4,
        "surface": {"kind": "absorber"},
    })  # fmt: skip
    nothing = pz.paths(scene, ray_numbers=numbers, ending_on="sensor", via="aside")
    assert (len(nothing), list(nothing)) == (0, [])


def test_a_detector_that_light_passes_has_the_paths_to_it():
    scene = pile(1, paths=50)
    scene["element"].append({
        "name": "counter", "kind": "disk", "position": [0, 0, 0.5], "axis": "-z", "radius": 0.4,
        "surface": {"kind": "clear"}, "detector": {"paths": 50},
    })  # fmt: skip
    result = pz.trace(scene, batches=2)
    there, behind = (result.detectors[n].paths for n in ("counter", "sensor"))
    assert [row.power for row in there] == [row.power for row in behind]
    assert [row.events for row in there] == [row.events for row in behind]
    assert there[0].sequence.endswith("> counter")


def test_a_tube_names_its_wall_and_baffles_once():
    scene = {
        "schema": "photizon/1", "name": "tube",
        "run": {"rays_per_batch": 4096, "generation_cap": 3},
        "source": [{
            "name": "lamp", "kind": "cosine-point", "flux": 1.0, "position": [0, 0, -0.1],
            "axis": "+z",
        }],
        "element": [
            {
                "name": "tube", "kind": "baffled-tube", "position": [0, 0, 0], "axis": "+z",
                "half_width": 0.3, "length": 0.8, "baffles": 2, "clear_half_width": 0.2,
                "surface": {"kind": "lambertian", "reflectance": 0.5},
            },
            SENSOR,
        ],
    }  # fmt: skip
    table = pz.trace(scene, batches=2).detectors["sensor"].paths
    places = {str(step) for row in table for step in row.steps}
    assert places == {"tube.wall s", 'tube."baffle 1" s', 'tube."baffle 2" s'}
    once = [row for row in table if row.events == "s"]
    assert len(once) == len({row.sequence for row in once})
    assert len(table) == len({row.sequence for row in table})


@pytest.mark.parametrize("precision", [pytest.param("mixed", marks=pytest.mark.slow), "fp32"])
def test_other_precisions_have_paths_too(precision):
    table = pz.trace(pile(1), batches=2, precision=precision).detectors["sensor"].paths
    own = plates(1).detectors["sensor"].paths
    assert [row.sequence for row in table] == [row.sequence for row in own]
    for row, exact in zip(table, own, strict=True):
        assert row.power == pytest.approx(exact.power, rel=1e-5)


def test_refusals(tmp_path, capsys):
    scene = pile(1, paths=0)
    with pytest.raises(pz.SceneError, match=r"detector\.paths"):
        pz.load(scene)
    scene["element"][-1]["detector"] = {}
    pz.trace(scene, batches=2).save(tmp_path / "none", figures=False)
    from photizon_cl.cli.main import main

    assert main(["paths", str(tmp_path / "none")]) == 2
    assert "path table" in capsys.readouterr().err
    plates(1).save(tmp_path / "run", figures=False)
    assert main(["paths", str(tmp_path / "run"), "--top", "2"]) == 0
    out = capsys.readouterr().out
    assert '"in 0".face t > "out 0".face t > sensor' in out
    assert main(["paths", str(tmp_path / "run"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["sensor"]["rows"]
    assert [row["ghost_order"] for row in rows] == [0, 2, 4, 6, 8]
    for wrong in (["--detector", "x"], ["--via", "x"], ["--top", "0"], ["--ghosts", "-1"]):
        assert main(["paths", str(tmp_path / "run"), *wrong]) == 2
        assert "Traceback" not in capsys.readouterr().err
