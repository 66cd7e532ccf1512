"""Engines broken on purpose: for each defect the gate that exists for it must fail.

A mutant is another text at named points of the kernels. Each gate passes on the engine as it is
(the tests in ``exact`` and ``statistical`` say so; it is asserted here once a gate) and fails on
its mutants, which stand in a table for each topic. Here is what holds of all tables together.
"""

from __future__ import annotations

import re

import pytest
from mutants.tables import ALL
from oracles import gates, random_gates

from hostcode import templates
from hostcode.assets import kernels_dir

pytestmark = pytest.mark.usefixtures("built_quickly")


def test_every_point_has_a_mutant_and_stands_in_its_own_file(points: frozenset[str]) -> None:
    assert {name for mutant in ALL for name in mutant.points} == points
    for path in kernels_dir().rglob("*.mako"):
        text = path.read_text(encoding="utf-8")
        stems = {name.split(".")[0] for name in re.findall(r'point\("([\w.]+)"', text)}
        assert stems <= {path.stem}


def test_production_renders_what_stands_there() -> None:
    assert templates.MUTATIONS == {}
    assert templates.point("mirror.weight", "w") == "w"


def test_the_engine_is_whole_again_after_a_mutant() -> None:
    random_gates.counter_layout()
    gates.first_named_is_hit()
