"""What is compiled for a scene and why; what it would cost to have more in it, or less."""

from __future__ import annotations

import dataclasses
import json

import pytest

import photizon_cl as pz
from hostcode.device import kept_kernels
from hostcode.program.parts import EffectParts
from hostcode.program.plan import ExecutionPlan
from hostcode.run.wavefront import Engine
from photizon_cl.cli.main import main
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.compile.effects.shares import Shares
from photizon_cl.compile.effects.table import EFFECT_ROWS, EFFECTS
from photizon_cl.result.effects import Effects, Price, ProgramCost, Ratio
from photizon_cl.scene.presets import preset_names
from photizon_cl.studies import effects as listing
from photizon_cl.studies import pricing

pytestmark = pytest.mark.usefixtures("built_quickly")

NARROW = ExecutionPlan(lanes=1, items=8, wave_rays=1 << 16, refill=1, stack_rays=64)
"""One lane builds fastest."""


NONE = frozenset()


def small(name="box-room", **more):
    return pz.load(name).replace({"run.rays_per_batch": 256, **more})


# -- what is said without measuring ----------------------------------------------------------------


@pytest.mark.parametrize("name", preset_names())
def test_every_effect_and_kind_is_told_once_as_it_is_compiled(name):
    scene = pz.load(name)
    compiled = compile_scene(scene, scene.run)
    found = pz.effects(scene)
    assert [row.name for row in found] == list(EFFECT_ROWS)
    assert set(found.in_use) == compiled.effects
    by_name = {effect.name: effect for effect in EFFECTS}
    for row in found:
        told = EFFECT_ROWS[row.name]
        assert (row.group, row.what, row.costs) == (told.group, told.what, told.costs)
        assert row.in_use == (row.name in compiled.reasons)
        assert row.because == compiled.reasons.get(row.name, row.because)
        assert row.because
        assert row.price is None
        assert row.unmeasured
        if row.optional:  # else it would not be: the compiler does what is said
            effect = frozenset({row.name})
            force, without = (frozenset(), effect) if row.in_use else (effect, frozenset())
            other = compile_scene(scene, scene.run, force, without)
            assert other.effects == compiled.effects ^ effect
        elif not row.in_use and row.name in by_name:
            assert not by_name[row.name].possible(scene)


@pytest.mark.parametrize("effect", EFFECTS, ids=[e.name for e in EFFECTS])
def test_an_effect_says_why_it_is_left_out(effect):
    bare = pz.load("cosine-fourth")
    plate = dataclasses.replace(bare.element[0], detector=None)
    lamp = dataclasses.replace(bare, element=(plate,), far_field=None)
    assert effect.needed(lamp, lamp.run) is None
    said = effect.absent(lamp, lamp.run)
    assert said
    assert "\n" not in said
    assert not said.endswith(".")
    assert pz.effects(lamp)[effect.name].because == said


def test_what_roulette_says_follows_from_the_floor():
    row = pz.effects(small("ghost-ladder", **{"run.roulette_floor": "auto"}))["roulette"]
    assert (row.in_use, row.because) == (True, "roulette_floor is 1e-09, as rays split")
    off = pz.effects(small("ghost-ladder", **{"run.roulette_floor": 0.0}))["roulette"]
    assert (off.in_use, off.because) == (False, "roulette_floor is 0")
    assert pz.effects(small())["roulette"].because == "roulette_floor is 0, as no ray splits"


def test_what_was_asked_for_can_be_left_out_again():
    scene = small(**{"run.effects": ["tilt"]})
    row = pz.effects(scene)["tilt"]
    assert (row.in_use, row.because, row.optional) == (True, "it was asked for", True)
    assert not pz.effects(scene)["detector"].optional


def test_it_is_found_by_name_and_survives_json():
    found = pz.effects("box-room")
    assert found["tilt"].because == "nothing is turned off the axes"
    with pytest.raises(pz.UnknownNameError, match=r'effects: found "titl", expected one of .*tilt'):
        found["titl"]
    summary = json.loads(json.dumps(found.summary(), allow_nan=False))
    assert summary == found.summary()
    assert summary["schema"] == "photizon-effects/1"
    assert [row["name"] for row in summary["effects"]] == list(EFFECT_ROWS)
    assert (summary["device"], summary["own"], summary["programs"]) == (None, None, [])
    assert summary["same_bits"] is None


def test_the_command_prints_every_row(capsys):
    assert main(["effects", "box-room", "--set", "run.roulette_floor=0.1"]) == 0
    said = capsys.readouterr().out
    assert max(map(len, said.splitlines())) <= 80
    words = said.replace(",", " ").split()
    for name in EFFECT_ROWS:
        assert name in words or name.partition(".")[2] in words
    assert "roulette_floor is 0.1" in said
    assert "no element has an opening; it cannot be forced on here" in said.replace("\n", " ")


def test_the_command_prints_json_and_nothing_else(capsys):
    assert main(["effects", "box-room", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == pz.effects("box-room").summary()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing"], "nothing"),
        (["box-room", "--set", "element.nothing.radius=2"], "element.nothing.radius"),
        (["box-room", "--set", 'run.target_on=["far_field"]'], "far_field"),
        (["box-room", "--max-seconds", "3"], "--max-seconds: found no --measure beside it"),
        (["box-room", "--device", "cpu"], "--device: found no --measure beside it"),
        (["box-room", "--measure", "--max-seconds", "0"], "max_seconds: found 0"),
        (["box-room", "--measure", "--device", "no such"], "device: "),
    ],
)
def test_bad_input_is_one_message(arguments, said, capsys):
    assert main(["effects", *arguments]) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert "Traceback" not in captured.err
    assert captured.out == ""


def test_what_is_for_measuring_is_refused_without():
    with pytest.raises(pz.ArgumentError, match=r'device: found "cpu", expected none without'):
        pz.effects("box-room", device="cpu")
    with pytest.raises(pz.ArgumentError, match=r"max_seconds: found 3, expected none without"):
        pz.effects("box-room", max_seconds=3)


# -- measured --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def quick():
    """Have programs come from where they are kept, and rounds be short."""
    real = pricing.make_engine

    def kept(device, tables, plan, *, anew):
        assert anew  # what is measured is a program of which nothing was kept
        return real(device, tables, plan)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pricing, "ROUND_SECONDS", 0.01)
        patch.setattr(pricing, "make_engine", kept)
        yield


SPHERE = small("integrating-sphere")


@pytest.fixture(scope="module")
def bench(quick):
    """Measure programs beside that of the integrating sphere."""
    own = compile_scene(SPHERE, SPHERE.run)
    return pricing.Pricing(own, 6, plan=NARROW, max_seconds=600.0, rounds=3)


def test_what_is_optional_has_a_price_and_changes_no_bit(bench, monkeypatch):
    """One that the scene does without is forced on, one that it has is left out."""
    monkeypatch.setattr(listing, "larger_programs", lambda scene: [])
    monkeypatch.setattr(listing, "Pricing", lambda *args, **more: bench)
    monkeypatch.setattr(bench, "build_again", lambda: None)
    real = listing._row

    def few(name, own):
        row = real(name, own)
        return (
            row if name in ("far-field", "roulette") else dataclasses.replace(row, optional=False)
        )

    monkeypatch.setattr(listing, "_row", few)
    watching = SPHERE.replace({"run.target_on": ["far_field"]})  # which is left out below
    found = pz.effects(watching, measure=True, plan=NARROW)
    assert {row.name for row in found if row.price} == {"far-field", "roulette"}
    assert (found["far-field"].in_use, found["roulette"].in_use) == (True, False)
    for row in (found["far-field"], found["roulette"]):
        price = row.price
        assert price.same_bits
        assert row.unmeasured == ""
        assert price.slowdown.rounds == 3
        assert price.slowdown.low <= price.slowdown.median <= price.slowdown.high
        assert price.more.source_bytes > price.less.source_bytes > 10_000
        for cost in (price.more, price.less):
            assert cost.build_seconds >= 0.0
            assert cost.interactions_per_s > 1e3
            assert cost.binary_bytes is None or cost.binary_bytes > 1000
    assert found["far-field"].price.more.source_bytes == found.own.source_bytes
    assert found["roulette"].price.less.source_bytes == found.own.source_bytes
    assert found.same_bits is True
    assert found.device == bench.label
    summary = json.loads(json.dumps(found.summary(), allow_nan=False))
    assert summary == found.summary()
    assert summary["effects"][list(EFFECT_ROWS).index("far-field")]["price"]["same_bits"] is True


def test_a_broken_effect_is_noticed(bench, monkeypatch):
    hook = (("survive", "p->w *= splat(0.5);"),)
    monkeypatch.setattr(Shares, "parts", lambda self, draft: EffectParts(hooks=hook))
    pair = bench.measure(compile_scene(SPHERE, SPHERE.run, force=frozenset({"shares"})))
    assert not pair.price().same_bits


def test_cells_of_one_program_alone_are_left_aside():
    """What an effect counts in cells of its own is no difference, and moves the cells behind."""
    made = [compile_scene(SPHERE, SPHERE.run, without=w).layout for w in (NONE, {"far-field"})]
    assert made[0].interactions != made[1].interactions
    assert made[0].pieces.keys() - made[1].pieces.keys() == {"effect far-field"}
    assert made[1].pieces.keys() <= made[0].pieces.keys()
    for layout in made:
        cells = sorted(k for first, n in layout.pieces.values() for k in range(first, first + n))
        assert cells == list(range(layout.n_cells))


def test_kinds_that_no_object_is_change_no_bit(bench):
    force = frozenset(name for name, row in EFFECT_ROWS.items() if row.group == "surface")
    made = compile_scene(SPHERE, SPHERE.run, force=force)
    assert made.effects >= force
    assert made.tables.spec.splits  # as a surface among them does
    pair = bench.measure(made)
    assert pair.price().same_bits
    assert pair.price().more.source_bytes > pair.price().less.source_bytes


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box-room", "ghost-ladder", "integrating-sphere"])
def test_a_program_that_is_made_for_all_scenes_changes_no_bit(quick, name):
    scene = small(name)
    programs = listing.larger_programs(scene)
    own = compile_scene(scene, scene.run)
    made = pricing.Pricing(own, len(programs), plan=NARROW, max_seconds=600.0, rounds=2)
    for program in programs:
        assert made.measure(program.compiled).same_bits, program.name


def test_what_there_is_no_time_for_says_so(bench, monkeypatch):
    own = bench.own.compiled
    monkeypatch.setattr(bench, "_ends", bench.started)
    assert bench.measure(own) == "the 600 s were over (max_seconds)"
    with pytest.raises(pz.RunError, match=r"longer than 1e-06 s \(max_seconds\); give it more"):
        pricing.Pricing(own, 1, plan=NARROW, max_seconds=1e-6)


def test_larger_programs_say_what_is_in_them():
    scene = small()
    own = compile_scene(scene, scene.run).effects
    made = {program.name: program for program in listing.larger_programs(scene)}
    every = made[listing.EVERYTHING]
    optional = {row.name for row in pz.effects(scene) if row.optional}
    kinds = {name for name, row in EFFECT_ROWS.items() if row.group != "effect"}
    assert set(made[listing.EVERY_EFFECT].adds) == optional
    assert set(every.adds) == optional | kinds - own
    spec = every.compiled.tables.spec
    assert not any(x.single for x in (*spec.classes, *spec.surfaces))
    assert spec.n_elements == 0
    spared = listing.larger_programs(scene, [listing.EVERYTHING], frozenset({"acceleration"}))
    assert [program.name for program in spared] == ["every effect and kind but acceleration"]
    assert "acceleration" not in spared[0].compiled.effects
    unmade = compile_scene(scene, scene.run, force=frozenset())
    assert unmade.tables.spec == compile_scene(scene, scene.run).tables.spec


def test_nothing_that_is_kept_is_used_or_changed(device, monkeypatch):
    scene = small()
    tables = compile_scene(scene, scene.run).tables
    usual = Engine(device, tables, NARROW)
    folders = kept_kernels._folders()

    def touched(*args):
        raise AssertionError(args)

    for name in ("_usable", "_write"):  # what reads from what is kept, and what writes there
        monkeypatch.setattr(kept_kernels, name, touched)
    anew = Engine(device, tables, NARROW, anew=True)
    assert anew.program.source == usual.program.source
    assert anew.program.built is not usual.program.built
    assert anew.program.kept == ""
    if device.record.is_pocl:  # the compiler worked
        assert len(kept_kernels._folders() - folders) == len(anew._programs)
    assert Engine(device, tables, NARROW).program is usual.program
    for a, b in zip(anew.run(0, 2), usual.run(0, 2), strict=True):
        assert a.cells.tobytes() == b.cells.tobytes()


def made_up(same_bits):
    cost = ProgramCost(3.0e7, 1.5, 100_000, None)
    price = Price(cost, cost, Ratio.of([1.1, 1.2, 1.3]), same_bits)
    found = pz.effects("box-room")
    rows = tuple(
        dataclasses.replace(row, price=price if row.name == "tilt" else None) for row in found
    )
    program = listing.ProgramUse(listing.EVERYTHING, ("tilt",), None, "the 3 s were over")
    return Effects("box-room", rows, (program,), "a device", cost, 3.0)


@pytest.mark.parametrize("same_bits", [True, False])
def test_the_command_says_prices_and_what_differs(same_bits, monkeypatch, capsys):
    monkeypatch.setattr(listing, "effects", lambda *args, **more: made_up(same_bits))
    status = main(["effects", "box-room", "--measure", "--max-seconds", "3"])
    said = capsys.readouterr()
    assert max(map(len, said.out.splitlines())) <= 80
    assert "1.200  1.150-1.250" in said.out
    assert "every effect and kind: not measured, the 3 s were over" in said.out
    assert status == (0 if same_bits else 1)
    assert ("tilt: other bits" in said.err) != same_bits
    assert ("none changed a bit" in said.out) == same_bits
