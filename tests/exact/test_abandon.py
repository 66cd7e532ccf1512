"""A wave that is given up leaves nothing behind."""

from __future__ import annotations

import pytest
from oracles.engine import PLAN, open_device

from hostcode.errors import Abandoned
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.files import load


@pytest.mark.parametrize("copies", [0, 2])
def test_an_engine_is_as_new_after_a_wave_that_was_given_up(copies: int) -> None:
    scene = load("ghost-ladder")
    tables = compile_scene(scene, scene.run).tables
    plan = PLAN.with_(max_bounces=64, tally_copies=copies)
    fresh = [tally.cells.tobytes() for tally in Engine(open_device(), tables, plan).run(0, 1)]
    engine = Engine(open_device(), tables, plan)
    engine.give_up = lambda: True
    with pytest.raises(Abandoned):
        list(engine.run(0, 1))
    engine.give_up = None
    assert [tally.cells.tobytes() for tally in engine.run(0, 1)] == fresh
