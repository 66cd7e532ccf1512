"""Engines broken in polarised light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from mutants.tables import catches, of_topic

if TYPE_CHECKING:
    from collections.abc import Callable

    from mutants.mutant import Mutant

# a program a mutant; what a gate sees of it no optimiser decides
pytestmark = pytest.mark.usefixtures("built_quickly")


@pytest.mark.parametrize("mutant", of_topic("polarisation"))
def test_gate_catches(mutant: Mutant, engine: Callable[[Mutant], None]) -> None:
    catches(mutant, engine)
