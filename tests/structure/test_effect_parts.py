"""What an effect brings and there is no place for is told, and whose a refused statement is."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from oracles.engine import PLAN, compiled, open_device, scene_of
from oracles.scenes import BLACK, beam, wall

import photizon_cl as pz
from hostcode.assets import kernels_dir
from hostcode.errors import HostError, KernelBuildError
from hostcode.program.build import build
from hostcode.program.fields import EndingField, HitField, RayField
from hostcode.program.parts import EffectParts
from hostcode.program.source import HOOKS, PLACES, RECORDS, program_source

if TYPE_CHECKING:
    from hostcode.program.spec import ProgramSpec


def spec(*parts: EffectParts) -> ProgramSpec:
    scene = scene_of([beam((0, 0, 1), "-z", 0.1)], [{**wall((0, 0, 0), "+z"), **BLACK}])
    made = compiled(scene).tables.spec.for_device(PLAN.lanes, ("wave",))
    return replace(made, parts=made.parts + parts)


def program_with(place: str, parts: EffectParts) -> ProgramSpec:
    """Return the program in which a place stands: that of a wave, or that counts its records."""
    if place != "arrival":
        return spec(parts)
    black = {**wall((0, 0, 0), "+z"), **BLACK, "detector": {}}
    made = compiled(scene_of([beam((0, 0, 1), "-z", 0.1)], [black])).tables.spec
    made = made.for_device(PLAN.lanes, ("wave",))
    return replace(made, parts=(*made.parts, parts)).for_tally()


@pytest.mark.parametrize(
    ("brought", "told"),
    [
        (
            {"templates": (("serch", "effects/mine"),)},
            'effect mine: place of the template effects/mine: found "serch", expected one of',
        ),
        (
            {"hooks": (("bounce", "count(met);"),)},
            'effect mine: place of the hook count(met);: found "bounce", expected one of travel',
        ),
        (
            {"records": ("arrival",)},
            'effect mine: what is recorded: found "arrival", expected one of arrivals, escapes',
        ),
        (
            {"ray": (RayField("age", "reel", "splat(0.0)", "s"),)},
            'effect mine: type of the ray\'s age: found "reel", expected one of real, weight,',
        ),
        (
            {"hit": (HitField("u", "word", "m"),)},
            'effect mine: type of the hit\'s u: found "word", expected one of real, long, mask',
        ),
        (
            {"ending": (EndingField("age", "long", "p->age", "s"),)},
            'effect mine: type of the ending\'s age: found "long", expected one of real, weight,',
        ),
        (
            {"launch": (("first", "int", "cell"),)},
            'effect mine: type of the launch\'s first: found "int", expected one of ulong, double',
        ),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_mistyped_place_or_type_is_told(brought: dict[str, Any], told: str) -> None:
    for name, begins in (("mine", told), ("", told.replace("effect mine", "an effect"))):
        with pytest.raises(HostError) as caught:
            program_source(spec(EffectParts(effect=name, **brought)))
        assert str(caught.value).startswith(begins)


def test_the_places_are_those_of_the_templates() -> None:
    text = "".join(path.read_text("utf-8") for path in (kernels_dir() / "lib").glob("*.mako"))
    assert sorted(re.findall(r'hooks\["(\w+)"\]', text)) == sorted(HOOKS)
    assert set(re.findall(r'"(\w+)" in recorded', text)) == set(RECORDS)
    told = (kernels_dir() / "lib" / "interaction.mako").read_text("utf-8")
    assert re.findall(r"^##   (\w+) ", told, re.MULTILINE) == list(HOOKS)
    plain = spec()
    for place in PLACES:
        more = spec(EffectParts(templates=((place, "lib/cap"),)))
        if place == "tally":
            assert program_source(more.for_tally()) != program_source(plain.for_tally())
            assert program_source(more) == program_source(plain)
        else:
            assert program_source(more) != program_source(plain)
            assert more.for_tally() == plain.for_tally()


@pytest.mark.parametrize("place", HOOKS)
def test_a_statement_that_is_refused_is_told_with_its_effect(place: str) -> None:
    parts = EffectParts(effect="far-mine", hooks=((place, "no_such_thing(p);"),))
    with pytest.raises(KernelBuildError) as caught:
        build(open_device(), program_with(place, parts))
    error = caught.value
    assert (error.template, error.line) == (f"hook {place} of far-mine", 1)
    assert "no_such_thing" in error.message
    assert error.excerpt.startswith("> no_such_thing(p);\n")


def test_what_stands_behind_a_statement_has_its_own_lines() -> None:
    for place in HOOKS:
        plain = program_source(program_with(place, EffectParts())).splitlines()
        parts = EffectParts(effect="mine", hooks=((place, "(void)p;"), (place, "(void)h;")))
        more = program_source(program_with(place, parts)).splitlines()
        added = [
            line for line in more if "of mine" in line or line in ("    (void)p;", "    (void)h;")
        ]
        assert added == [
            f'#line 1 "hook {place} of mine"', "    (void)p;",
            f'#line 1 "hook {place} of mine"', "    (void)h;",
        ]  # fmt: skip
        at = more.index("    (void)h;")
        assert re.fullmatch(r'#line \d+ "kernels/lib/\w+\.mako"', more[at + 1])
        left = [line for line in more if line not in added]
        # a line of the template's own before each
        assert [line for line in left if line not in plain] in ([], [more[at - 2]] * 2)


def test_compiled_parts_have_their_effects_names() -> None:
    made = compiled(pz.load("ghost-ladder"), roulette_floor=1e-6)
    names = [part.effect for part in made.tables.spec.parts]
    assert all(names)
    assert "roulette" in names
    assert '#line 1 "hook survive of roulette"\n    roulette(' in program_source(
        made.tables.spec.for_device(4, ("wave",))
    )


def test_scenes_that_count_alike_share_the_program_that_counts() -> None:
    """Whatever their elements, surfaces and sources."""
    specs = [
        compiled(pz.load(name)).tables.spec.for_device(4, ("wave",), private_tallies=True)
        for name in ("cpc-concentrator", "box-room")
    ]
    assert len({program_source(one) for one in specs}) == 2
    assert len({program_source(one.for_tally()) for one in specs}) == 1
    assert len({one.for_tally() for one in specs}) == 1
