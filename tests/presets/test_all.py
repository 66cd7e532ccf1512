"""What holds for every preset; the others have gates of their own elsewhere."""

from __future__ import annotations

import pytest

import photizon_cl as pz
from photizon_cl.scene.presets import preset_names, presets

pytestmark = pytest.mark.usefixtures("one_lane")

NEW = (
    "cpc-concentrator", "plano-convex-condenser", "baffled-tube", "square-lightpipe", "cassegrain",
    "baffled-telescope", "absorbing-cuvette", "aspheric-condenser",
    "scattering-mirror", "dispersing-prism", "coated-window", "polariscope",
)  # fmt: skip


def test_there_are_seventeen_each_with_an_anchor():
    assert len(preset_names()) == len(presets()) == 17
    assert all(any(c.isdigit() for c in entry.anchor) for entry in presets().values())


@pytest.mark.slow  # bits are stored of all, tests/benchmarks/test_harness.py
@pytest.mark.parametrize("name", NEW)
def test_ledgers_close(name):
    result = pz.trace(name, batches=2, rays_per_batch=2048)
    assert abs(result.ledger.closure) <= 1e-15 * result.ledger.emitted.value
