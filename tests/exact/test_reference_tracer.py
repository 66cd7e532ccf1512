"""The engine against the plain reference tracer, ray by ray: the same seed, the same tallies.

The draws are keyed by ray, path and decision, so that the reference follows the engine's very rays.
Sums agree to 1e-9 of the emitted power and every count agrees exactly.
"""

from __future__ import annotations

import pytest
from oracles import gates

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


@pytest.mark.parametrize(
    "number", [n if n > 1 else pytest.param(n, marks=pytest.mark.slow) for n in range(12)]
)
def test_random_scenes_agree_with_the_reference(number: int) -> None:
    # a few are turned anyhow, each with a program of its own
    gates.reference_agrees(number, rays=300, alike=number > 2)


@pytest.mark.parametrize("number", range(30, 34))
def test_so_they_do_through_the_tree_of_boxes(number: int) -> None:
    gates.reference_agrees(number, rays=300, force=gates.ONE_PROGRAM | {"acceleration"}, alike=True)


@pytest.mark.parametrize("name", gates.PRESETS)
def test_presets_agree_with_the_reference(name: str) -> None:
    gates.preset_agrees(name)


def test_a_batch_beyond_2_to_the_32_rays_agrees_with_the_reference() -> None:
    gates.preset_agrees("cosine-fourth", first=2**33)
