"""Bad sweep files: a line for each thing that is wrong, before anything runs."""

from __future__ import annotations

import json
import math
from decimal import Decimal

import pytest
from tubes import ANGLE, TUBE, WALL, a_sweep

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.scene.registry import SOURCES
from photizon_cl.scene.sweep_reader import read_sweep
from photizon_cl.studies import sweeping

FLUX = "source.sun.flux"


def one(path, *values, **more):
    """Return a vary table."""
    return {"path": path, "values": list(values), **more}


BAD = {
    "no table": ([], "found [], expected a table with schema, scene and vary"),
    "nothing": (
        {},
        'schema: found nothing, expected "photizon-sweep/1" (the key schema is required)',
        ("scene: found nothing, expected a preset's name, or the path of a scene file beside this "
        "one (the key scene is required)"),
        "vary: found nothing, expected at least one [[vary]] table (the key vary is required)",
    ),
    "a scene": (
        {**a_sweep(), "schema": "photizon/1"},
        ('schema: found "photizon/1", expected "photizon-sweep/1" (that is a scene: a sweep file '
        "names one by its key scene)"),
    ),
    "unknown keys": (
        {**a_sweep({**WALL, "valeus": 1}, run={"bathces": 3}), "meassure": {}},
        ("meassure: found {}, expected no such key; a sweep file takes schema, scene, vary, run, "
        "measure, title, notes (did you mean measure?)"),
        ("run.bathces: found 3, expected no such key; the run table of a sweep takes seed, "
        "rays_per_batch, target_sigma, max_seconds, generation_cap, roulette_floor, splitting, "
        "polarisation, target_on, effects, batches, precision (did you mean batches?)"),
        ("vary[0].valeus: found 1, expected no such key; a vary table takes path, values, "
        "linspace, logspace, together, name (did you mean values?)"),
    ),
    "no such scene": (
        {**a_sweep(), "scene": "tubes.toml"},
        ("tubes.toml: found no such file, expected a scene file in TOML or JSON (check the path, "
        "or see the presets)"),
    ),
    "no such preset": (
        {**a_sweep(), "scene": "box-rom"},
        ('scene: found "box-rom", which is neither a preset nor a file, expected a preset\'s name '
        'or a scene file (did you mean box-room? the presets are cosine-fourth'),
    ),
    "a bad scene": (
        {**a_sweep(), "scene": {**TUBE, "run": {"seed": -1}}},
        "scene.run.seed: found -1, expected an integer from 0 to 2^64 - 1",
    ),
    "unknown path": (
        a_sweep(one("source.son.flux", 1, 2), one("sauce.sun.flux", 1), one("element[5].axis", 1)),
        'vary[0].path: found "source.son.flux": "son", expected one of "sun" (did you mean "sun"?)',
        ('vary[1].path: found "sauce.sun.flux": "sauce", expected a path that begins with one of '
        "name, source, element, run, far_field, importance, title, notes, medium, spectrum "
        "(did you mean source?)"),
        'vary[2].path: found "element[5].axis": [5], expected a number below 2, counted from 0',
    ),
    "no path": (
        a_sweep({"values": [1]}, one("a[", 1), one(3, 1)),
        'vary[0].path: found nothing, expected a parameter\'s path, "source.NAME.KEY" say',
        'vary[2].path: found 3, expected a parameter\'s path, "source.NAME.KEY" say',
    ),
    "no such key": (
        a_sweep(one("element.tube.colour", 1, 2)),
        ("point 0: element[0].colour: found 1, expected no such key; the element cylinder takes "
        'kind, name, position, axis, tilt_deg, surface, detector, radius, length (in element '
        '"tube"; at every point)'),
    ),
    "out of range at point 17": (
        a_sweep(one("source.sun.tilt_deg[0]", *range(17), 361, *range(17, 20))),
        ("point 17: source[0].tilt_deg[0]: found 361, expected an angle in degrees, from -360 to "
        '360 (in source "sun"; at source.sun.tilt_deg[0] = 361)'),
    ),
    "out of range in a grid": (
        a_sweep(WALL, one("source.sun.radius", 0.1, -0.1)),
        ("point 1: source[0].radius: found -0.1, expected a positive length in metres, from 1e-150 "
        'to 1e150 (in source "sun"; at element.tube.surface.reflectance = 0.1, '
        "source.sun.radius = -0.1 and 1 more point)"),
    ),
    "a float for an integer": (
        a_sweep({"path": "run.generation_cap", "linspace": [1, 4, 3]}),
        ("point 1: run.generation_cap: found 2.5, expected an integer from 1 to 1048575 (at "
        "run.generation_cap = 2.5)"),
    ),
    "one place twice": (
        a_sweep(one(FLUX, 1, 2), one("source[0].flux", 3, 4), one('source."sun"', {})),
        ('vary[1].path: found "source[0].flux", expected a parameter that no other vary changes '
        "(vary[0] changes source.sun.flux)"),
        ('vary[2].path: found "source.\\"sun\\"", expected a parameter that no other vary changes '
        "(vary[0] changes source.sun.flux)"),
    ),
    "a name twice": (
        a_sweep(one(FLUX, 1, 2, name="angle"), ANGLE),
        'vary[1].name: found "angle", expected a name of its own (vary[0] is called so)',
    ),
    "a measure called as an axis": (
        a_sweep(ANGLE, measure={"angle": "ledger.escaped", "point": "ledger.escaped",
                                "a": "ledger.escaped", "a_sigma": "ledger.escaped"}),
        'measure.angle: found "angle", expected a name of its own (vary[0] is called so)',
        ('measure.point: found "point", expected a name of its own (a column of every sweep is '
        "called so)"),
        ('measure.a_sigma: found "a_sigma", expected a name of its own (a column of measure.a is '
        "called so)"),
    ),
    "columns of two measures": (
        a_sweep({**ANGLE, "name": "b.sigma"},
                measure={"a_sigma": "ledger.escaped", "a": "ledger.escaped",
                         "b": "ledger.escaped"}),
        ('measure.a: found "a", expected a name beside which "a_sigma" is free (measure.a_sigma is '
         "called so)"),
        ('measure.b: found "b", expected a name beside which "b.sigma" is free (vary[0] is called '
         "so)"),
    ),
    "all of run": (
        a_sweep(one("run", {"seed": 1}, {"seed": 2})),
        ('vary[0].path: found "run", expected a parameter that [run] does not set (the sweep\'s '
         "[run] sets some of it for all points)"),
    ),
    "also in run": (
        a_sweep(one("run.seed", 1, 2), run={"seed": 3}),
        ('vary[0].path: found "run.seed", expected a parameter that [run] does not set (the '
        "sweep's [run] sets seed for all points)"),
    ),
    "empty grid": (
        a_sweep(one(FLUX)),
        "vary[0].values: found an empty list, expected at least one value",
    ),
    "no vary": (
        {**a_sweep(), "vary": []},
        "vary: found an empty array, expected at least one [[vary]] table",
    ),
    "empty steps": (
        a_sweep({"path": FLUX, "linspace": [1, 2, 0]}),
        ("vary[0].linspace: found [1, 2, 0], expected [from, to, n]: two numbers, and an integer "
        "from 2 on (the axis would be empty)"),
    ),
    "a single table": (
        {**a_sweep(), "vary": ANGLE},
        ("vary: found a single table, expected an array of [[vary]] tables (write [[vary]] with "
        "two brackets)"),
    ),
    "ten million points": (
        a_sweep(*({"path": path, "linspace": [1, 2, 215]}
                  for path in (FLUX, "source.sun.radius", "element.tube.length"))),
        ("vary: found 9938375 points (215 × 215 × 215), expected at most 10000 points (each is a "
        "run of its own)"),
    ),
    "ten million values": (
        a_sweep({"path": FLUX, "linspace": [1, 2, 10_000_000]}),
        ("vary[0].linspace: found 10000000 values, expected at most 10000 points: each is a run of "
        "its own"),
    ),
    "steps that are none": (
        a_sweep({"path": FLUX, "linspace": [1, 2]}, {"path": "run.seed", "logspace": [0, 1, 3]},
                {"path": "source.sun.radius", "linspace": [1, 1, 3]},
                {"path": "source.sun.position[0]", "linspace": [1, 2, 3], "values": [1]},
                {"path": "source.sun.position[1]"}),
        ("vary[0].linspace: found [1, 2], expected [from, to, n]: two numbers, and an integer from "
        "2 on"),
        ("vary[1].logspace: found [0, 1, 3], expected two numbers above 0 (its steps are equal "
        "factors)"),
        ("vary[2].linspace: found [1, 1, 3], expected [from, to, n]: two numbers, and an integer "
        "from 2 on (both ends are the same)"),
        ("vary[3]: found values and linspace, expected values, linspace or logspace (one of them "
        "says what the parameter is set to)"),
        ("vary[4]: found nothing, expected values, linspace or logspace (one of them says what the "
        "parameter is set to)"),
    ),
    "steps of different lengths": (
        a_sweep(WALL, one(FLUX, 1, 2, 3, together=True)),
        ("vary[1]: found 3 values, expected 2, as element.tube.surface.reflectance has, with which "
        "it steps together"),
    ),
    "the first together": (
        a_sweep(one(FLUX, 1, 2, together=True)),
        ("vary[0].together: found true, expected false in the first vary (it would step with the "
        "vary before, and there is none)"),
    ),
    "a value twice": (
        a_sweep(one(FLUX, 1, 2, 1.0)),
        ("vary[0].values[2]: found 1.0 twice, expected every value once (values[0] is the same, "
        "and so would be its points)"),
    ),
    "settings": (
        a_sweep(WALL, run={"seed": "x", "max_seconds": 0}),
        "run.seed: found \"x\", expected an integer from 0 to 2^64 - 1 (text is not a number)",
        "run.max_seconds: found 0, expected a positive time in seconds, up to 1e9",
    ),
    "more settings": (
        a_sweep(WALL, run={"batches": 0, "precision": "fp16"}),
        'run: precision: found "fp16", expected one of "fp64", "mixed", "fp32"',
        "run: batches: found 0, expected an integer from 1 to 549755813888",
    ),
    "unknown measures": (
        a_sweep(WALL, measure={"a": "detectors.sensr.power", "b": "ledger.escapd", "c": 3,
                               "d": {"ratio": ["ledger.escaped"]}}),
        ('measure.c: found 3, expected "detectors.NAME.power", { ratio = [Q, Q] } or { pst = '
        '"DETECTOR", source = "SOURCE" }'),
        'measure.d.ratio: found ["ledger.escaped"], expected two quantities, [above, below]',
    ),
    "unknown quantities": (
        a_sweep(WALL, measure={"a": "detectors.sensr.power", "b": "ledger.escapd"}),
        'measure.a: detectors: found "sensr", expected one of "sensor" (did you mean "sensor"?)',
        'measure.b: ledger: found "escapd", expected one of "escaped", "roulette.killed"',
    ),
    "a quantity of some points": (
        a_sweep(one("element.sensor.detector.generations", 2, 4),
                measure={"late": "detectors.sensor.ladder[3]"}),
        ("point 0: measure.late: detectors.sensor.ladder[3]: found generation 3, expected one "
        "below 2 (at element.sensor.detector.generations = 2)"),
    ),
    "a map": (
        a_sweep(one("element.sensor.detector.map", [2, 2], [3, 3]),
                measure={"map": "detectors.sensor.map"}),
        "measure.map: detectors.sensor.map: found 4 bins, expected a scalar",
    ),
    "no pst": (
        a_sweep(WALL, measure={"a": {"pst": "sensor"}, "b": {"pst": "sensor", "source": 3}}),
        ('measure.a: found {pst = "sensor"}, expected "detectors.NAME.power", { ratio = [Q, Q] } '
        'or { pst = "DETECTOR", source = "SOURCE" } (a PST names its source)'),
        'measure.b: found {pst = "sensor", source = 3}, expected "detectors.NAME.power"',
    ),
    "pst of what is not there": (
        a_sweep(WALL, measure={"a": {"pst": "sensr", "source": "sun"},
                               "b": {"pst": "sensor", "source": "son"},
                               "c": {"pst": "tube", "source": "sun"}}),
        ('measure.a: element: found "sensr", expected one of "tube", "sensor" (did you mean '
        '"sensor"?)'),
        'measure.b: source: found "son", expected one of "sun" (did you mean "sun"?)',
        'measure.c: detectors: found "tube", expected one of "sensor"',
    ),
}  # fmt: skip


@pytest.fixture
def nothing_runs(monkeypatch):
    def runs(*args, **kwargs):
        raise AssertionError("a point was run")

    monkeypatch.setattr(sweeping, "go_on", runs)


@pytest.mark.usefixtures("nothing_runs")
@pytest.mark.parametrize("what", list(BAD))
def test_bad_file(what, tmp_path, capsys, monkeypatch):
    tables, *lines = BAD[what]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.json").write_text(json.dumps(tables), encoding="utf-8")
    assert main(["sweep", "bad.json", "--out", "out"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    found = said.err.splitlines()
    assert len(found) == len(lines), said.err
    for line, expected in zip(found, lines, strict=True):
        own = "" if expected.startswith("tubes.toml") else "bad.json: "
        assert line.startswith(own + expected), f"\n{line}\n{own + expected}"
    assert not (tmp_path / "out").exists()
    # the same in Python
    if isinstance(tables, dict):
        with pytest.raises((pz.SceneError, pz.ArgumentError)) as error:
            pz.sweep(tables)
        assert len(str(error.value).splitlines()) == len(lines)


@pytest.mark.usefixtures("nothing_runs")
@pytest.mark.parametrize(
    ("source", "why"),
    [
        ({"kind": "isotropic-point"}, "the light of others has no cross-section"),
        ({"kind": "lambertian-disk", "axis": "-z", "radius": 0.1}, r"with a beam \(collimated-di"),
    ],
)
def test_a_pst_needs_a_beam(source, why):
    own = {"name": "sun", "flux": 1.0, "position": [0.0, 0.0, 0.3], **source}
    with pytest.raises(pz.SceneError, match=why):
        pz.sweep({**a_sweep(WALL), "scene": {**TUBE, "source": [own]}})


def test_beams():
    beams = {kind for kind, cls in SOURCES.items() if cls.is_beam}
    assert beams == {"collimated-disk"}
    sun = {"name": "sun", "flux": 2.0, "position": [0, 0, 1], "axis": "-z", "radius": 0.5}
    for divergence in (0.0, 0.2665):
        beam = pz.CollimatedDisk(**sun, divergence_deg=divergence)
        assert beam.beam_area == pytest.approx(0.25 * math.pi, rel=1e-15)
        assert beam.flux / beam.beam_area == beam.irradiance
    assert pz.LambertianDisk(**sun).beam_area is None


@pytest.mark.usefixtures("nothing_runs")
def test_a_pst_needs_a_source_alone_and_a_detector_with_an_irradiance():
    lamp = {"name": "lamp", "kind": "isotropic-point", "flux": 1.0, "position": [0, 0, 0.1]}
    with pytest.raises(pz.SceneError, match='beside "lamp", expected it alone'):
        pz.sweep({**a_sweep(WALL), "scene": {**TUBE, "source": [*TUBE["source"], lamp]}})
    cone = {"name": "sensor", "kind": "cone", "entrance_radius": 0.02, "exit_radius": 0.0,
            "length": 0.02, "position": [0, 0, 0], "axis": "-z",
            "surface": {"kind": "absorber"}, "detector": {}}  # fmt: skip
    with pytest.raises(pz.SceneError, match="expected a detector with an irradiance"):
        pz.sweep({**a_sweep(WALL), "scene": {**TUBE, "element": [TUBE["element"][0], cone]}})


def test_bad_toml(tmp_path, capsys):
    file = tmp_path / "bad.toml"
    file.write_text("schema = \n", encoding="utf-8")
    assert main(["sweep", str(file)]) == 2
    assert "line 1" in capsys.readouterr().err
    file.write_text('[measure]\na = "x"\na = "y"\n', encoding="utf-8")
    assert main(["sweep", str(file)]) == 2
    assert "found a syntax error" in capsys.readouterr().err
    assert main(["sweep", str(tmp_path / "none.toml")]) == 2
    assert "expected a sweep file in TOML or JSON" in capsys.readouterr().err
    (tmp_path / "twice.json").write_text('{"schema": "a", "schema": "b"}', encoding="utf-8")
    assert main(["sweep", str(tmp_path / "twice.json")]) == 2
    assert "the key more than once" in capsys.readouterr().err


def test_dates_are_no_numbers(tmp_path, capsys):
    file = tmp_path / "bad.toml"
    file.write_text(
        'schema = "photizon-sweep/1"\nscene = "box-room"\n'
        '[[vary]]\npath = "source.downlight.flux"\nvalues = [2026-01-01, 2026-01-02, inf, nan]\n'
        '[[vary]]\npath = "run.seed"\nlinspace = [2026-01-01, 1, 3]\n',
        encoding="utf-8",
    )
    assert main(["sweep", str(file)]) == 2
    assert "vary[1].linspace: found [2026-01-01, 1, 3], expected" in capsys.readouterr().err
    file.write_text(file.read_text("utf-8").replace("2026-01-01, 1, 3", "1, 2, 2"), "utf-8")
    assert main(["sweep", str(file)]) == 2
    found = capsys.readouterr().err.splitlines()
    assert "point 0: source[0].flux: found 2026-01-01, expected a positive power" in found[0]
    assert "Traceback" not in "".join(found)


def test_a_scene_stands_beside_its_sweep(tmp_path, monkeypatch):
    pz.load(TUBE).save(tmp_path / "tube.toml")
    (tmp_path / "sweep.json").write_text(
        json.dumps({**a_sweep(), "scene": "tube.toml"}), encoding="utf-8"
    )
    monkeypatch.chdir("/")
    assert read_sweep(tmp_path / "sweep.json").scene == pz.load(TUBE)


@pytest.mark.parametrize(
    ("table", "values"),
    [
        ({"linspace": [0, 60, 61]}, list(range(61))),
        ({"linspace": [0, 1, 11]}, [0, *(n / 10 for n in range(1, 10)), 1]),
        ({"linspace": [0.1, 0.5, 5]}, [0.1, 0.2, 0.3, 0.4, 0.5]),
        ({"linspace": [3, -3, 4]}, [3, 1, -1, -3]),
        ({"logspace": [1e-3, 1, 4]}, [0.001, 0.01, 0.1, 1.0]),
        ({"logspace": [1, 1024, 11]}, [2.0**n for n in range(11)]),
        ({"logspace": [1, 2, 3]}, [1.0, 2.0**0.5, 2.0]),
    ],
)
def test_steps(table, values):
    (axis,) = read_sweep(a_sweep({"path": "source.sun.position[0]", **table})).axes
    assert list(axis.values) == values
    assert all(type(a) is type(b) for a, b in zip(axis.values, values, strict=True))


def test_steps_are_the_doubles_next_to_the_exact_ones():
    (axis,) = read_sweep(a_sweep({"path": FLUX, "logspace": [0.5, 80, 60]})).axes
    assert (axis.values[0], axis.values[-1]) == (0.5, 80.0)
    for n, value in enumerate(axis.values):
        # (v/0.5)^59 = 160^n; the neighbours of v are further from it
        apart = [
            abs((Decimal(v) / Decimal("0.5")) ** 59 - Decimal(160) ** n)
            for v in (value, value * (1 + 2**-52), value * (1 - 2**-52))
        ]
        assert apart[0] == min(apart)


def test_units_and_names():
    axes = read_sweep(a_sweep(ANGLE, WALL, one(FLUX, 1, 2))).axes
    assert [axis.label for axis in axes] == [
        "angle, deg", "element.tube.surface.reflectance", "source.sun.flux, W",
    ]  # fmt: skip


def test_it_reads_back():
    plan = read_sweep(a_sweep(ANGLE, {**WALL, "values": [0.5, 0.6]}, title="t", notes="n\nm"))
    again = read_sweep(json.loads(json.dumps(plan.to_dict())))
    assert again.to_dict() == plan.to_dict()
    assert [again.values(n) for n in range(len(again))] == [
        plan.values(n) for n in range(len(plan))
    ]
