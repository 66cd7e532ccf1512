"""What every effect, filter and kind must hold: neither lanes nor what is compiled in change a bit.

Effects are forced on, one after another and all at once, over a scene of every kind, and over two
that need next to none of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from contract import (
    ALL_EFFECTS,
    ROWS,
    WIDE,
    every_effect,
    every_kind,
    everything,
    followed,
    named,
    of_kind,
    same_cells,
    traced,
)
from oracles.engine import compiled

from hostcode.assets import kernels_dir
from hostcode.program.source import program_source
from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.compile.layout import CellGroup
from photizon_cl.scene.files import load
from photizon_cl.scene.registry import FILTERS

# the scene of everything, thrice; tests/exact has the same bits of optimised code
pytestmark = pytest.mark.usefixtures("built_quickly")

ASKED = "it was asked for"
PLAIN = ("box-room", "element-sphere")
"""Scenes that need few effects and bounce often: flat walls with edges, and a ball with a port."""


# -- lanes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("lanes", [WIDE, pytest.param(16, marks=pytest.mark.slow)])
def test_lanes_change_no_bit_of_a_scene_of_everything(lanes):
    narrow, broad = traced("everything", 1), traced("everything", lanes)
    layout = narrow.compiled.layout
    names = [e.name for e in everything().element] + [row.name for row in layout.rows]
    different = [
        name for n, name in enumerate(names)
        if narrow.cells[n].tolist() != broad.cells[n].tolist()
    ]  # fmt: skip
    assert not different  # says where, before the digest says that
    assert narrow.digest == broad.digest
    assert narrow.interactions == broad.interactions
    assert {f"{group}.{kind}" for group, kind in ROWS} <= narrow.compiled.effects


@every_kind
def test_each_kind_has_its_part_in_that_scene(group, kind):
    """Light comes from every source and meets every element and surface: else no bits compare."""
    if group == "source":
        found = traced("everything", 1).compiled
        assert found.rays_of_source[found.scene.source.index(of_kind(found.scene, group, kind))] > 0
        return
    met = followed()
    things = everything().element
    of = {
        "element": lambda e: e.kind,
        "surface": lambda e: e.surface.kind,
        "scatter": lambda e: e.surface.lobe.kind if e.surface.lobe is not None else "",
        "coating": lambda e: e.surface.coat.kind if e.surface.coat is not None else "",
    }[group]
    wanted = {n for n, e in enumerate(things) if kind == of(e)}
    assert wanted & set(met.element.tolist())


@every_effect
def test_lanes_change_no_bit_of_an_effect(effect):
    """Those that the scene of everything does without are forced on, on a plain scene."""
    plain, name, force = traced("everything", 1), "everything", frozenset()
    if effect.name not in plain.compiled.effects:
        name, force = PLAIN[0], ALL_EFFECTS
    narrow, broad = traced(name, 1, force), traced(name, WIDE, force)
    assert effect.name in narrow.compiled.effects
    assert narrow.digest == broad.digest
    assert same_cells(narrow, traced(name, 1))


@pytest.mark.parametrize("kind", FILTERS)
def test_a_filter_loses_no_arrival_at_any_width(kind):
    cls = FILTERS[kind]
    assert (kernels_dir() / "filters" / f"{cls.kernel}.mako").is_file()
    assert cls.what
    narrow, broad = traced("everything", 1), traced("everything", WIDE)
    used = 0
    for detector in narrow.compiled.layout.detectors:
        for tally in detector.tallies:
            own = [f for f in tally.filters if isinstance(f, cls)]
            if not own:
                continue
            cells = slice(tally.first, tally.first + tally.size)
            assert narrow.cells[cells].tobytes() == broad.cells[cells].tobytes()
            assert narrow.amount(tally.first, tally.size) == narrow.amount(detector.power)
            assert narrow.count(tally.first, tally.size) == narrow.count(detector.power)
            used += np.count_nonzero(narrow.cells[cells, 3]) > 1
            for f in own:
                assert len(f.axis.edges) == f.bins + 1
                assert (np.diff(f.axis.edges) > 0.0).all()
    assert used


# -- forced on -------------------------------------------------------------------------------------


def forced_on(name, force):
    """Assert that effects that are forced on change no bit; return those that were added.

    What they count in cells of their own is left aside.
    """
    plain = traced(name, 1)
    made = compiled(plain.compiled.scene, force)
    asked = {effect for effect, why in made.reasons.items() if why == ASKED}
    scene, run = plain.compiled.scene, plain.compiled.settings
    may = {e.name for e in EFFECTS if e.needed(scene, run) is None and e.possible(scene)}
    assert asked == may & force
    if not asked:  # the very same program
        assert made.tables.spec == plain.compiled.tables.spec
        return asked
    found = traced(name, 1, frozenset(asked))
    assert found.compiled.tables.spec != plain.compiled.tables.spec
    assert same_cells(found, plain)
    assert found.interactions == plain.interactions
    return asked


ALONE = ("acceleration", "contact", "coincidence", "choice")
"""Effects that others lean on, forced on by themselves; all of them together are below."""


# all at once in a scene of everything below
@pytest.mark.parametrize("name", [pytest.param("everything", marks=pytest.mark.slow), PLAIN[0]])
@pytest.mark.parametrize(
    "effect",
    [
        pytest.param(e, id=e.name, marks=() if e.name in ALONE else pytest.mark.slow)
        for e in EFFECTS
    ],
)
def test_an_effect_that_is_forced_on_changes_no_bit(effect, name):
    forced_on(name, frozenset({effect.name}))


@pytest.mark.parametrize("name", [pytest.param("everything", marks=pytest.mark.slow), *PLAIN])
def test_all_effects_that_are_forced_on_change_no_bit(name):
    assert forced_on(name, ALL_EFFECTS)


def test_every_effect_is_on_somewhere_and_forced_where_it_can_be():
    scenes = [named(name) for name in PLAIN]
    could = {
        e.name for e in EFFECTS for s in scenes if e.needed(s, s.run) is None and e.possible(s)
    }
    asked = {effect for name in PLAIN for effect in forced_on(name, ALL_EFFECTS)}
    assert asked == could
    assert asked | traced("everything", 1).compiled.effects >= ALL_EFFECTS


@every_effect
def test_an_effect_says_why_and_leaves_nothing_where_it_is_not_needed(effect):
    bare = load("cosine-fourth")
    lamp = replace(bare, element=(replace(bare.element[0], detector=None),), far_field=None)
    assert effect.needed(lamp, lamp.run) is None
    assert effect.what
    assert effect.costs
    made = compiled(lamp)
    assert effect.name not in made.effects
    text = program_source(made.tables.spec.for_device(4, ("wave",)))
    forced = compiled(lamp, frozenset({effect.name}))
    if effect.name in forced.effects:
        assert forced.reasons[effect.name] == ASKED
        for part in forced.tables.spec.parts:
            for _, template in part.templates:
                assert f'"kernels/{template}.mako"' not in text
            for field in part.ray:
                assert f" {field.name};" not in text


@pytest.mark.parametrize("labels", [("a",), ("a", "a")])
def test_no_cell_of_an_effect_has_the_label_of_another(labels):
    with pytest.raises(ValueError, match="give each cell a label of its own"):
        CellGroup("bounces", 0, (2,), labels)
