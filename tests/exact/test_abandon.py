"""What an engine held before is in no tally: waves that were given up, slots that were empty."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.engine import PLAN, compiled, open_device

from hostcode.errors import Abandoned
from hostcode.run.wavefront import Engine
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.scene.files import load

pytestmark = pytest.mark.usefixtures("built_quickly")


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


@pytest.mark.parametrize("copies", [0, 2])
def test_slots_without_a_batch_are_left_alone(copies: int) -> None:
    """Whatever was in the memory of tallies: few batches, then more, have a new engine's bits."""
    import pyopencl as cl

    tables = compiled("box-room", rays_per_batch=256).tables
    plan = PLAN.with_(wave_rays=8 * 256, tally_copies=copies)
    want = [tally.cells.tobytes() for tally in Engine(open_device(), tables, plan).run(0, 12)]
    engine = Engine(open_device(), tables, plan)
    assert (engine.batches_at_once, engine.sizes.copies) == (8, copies)
    queue, rest = engine.device.queue, np.full(1, 7, np.int64)
    for buffer in (engine._tally, engine._tally_copies)[: 1 + (copies > 0)]:
        cl.enqueue_fill_buffer(queue, buffer, rest, 0, buffer.size)
    found = [*engine.run(0, 2), *engine.run(2, 1), *engine.run(3, 8), *engine.run(11, 1)]
    assert [tally.cells.tobytes() for tally in found] == want

    cl.enqueue_fill_buffer(queue, engine._tally, rest, 0, engine._tally.size)
    list(engine.run(0, 2))
    held = np.empty(engine._tally.size // 8, np.int64)
    cl.enqueue_copy(queue, held, engine._tally)
    assert (held[3 * held.size // 8 :] == 7).all()
