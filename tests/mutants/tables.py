"""The mutants by topic, which of them are slow, and what is asked of each."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import pytest
from mutants import (
    draws_table,
    faces_table,
    media_table,
    polarisation_table,
    scattering_table,
    surfaces_table,
    tallies_table,
)

from hostcode.errors import HostError, KernelBuildError

if TYPE_CHECKING:
    from collections.abc import Callable

    from _pytest.mark.structures import ParameterSet
    from mutants.mutant import Mutant

TOPICS = {
    "draws": draws_table.MUTANTS,
    "surfaces": surfaces_table.MUTANTS,
    "faces": faces_table.MUTANTS,
    "tallies": tallies_table.MUTANTS,
    "scattering": scattering_table.MUTANTS,
    "polarisation": polarisation_table.MUTANTS,
    "media": media_table.MUTANTS,
}
ALL = tuple(mutant for mutants in TOPICS.values() for mutant in mutants)


def of_topic(topic: str) -> list[ParameterSet]:
    """Give a topic's mutants; those are slow whose gate has caught another one, of any topic."""
    seen: set[object] = set()
    found = []
    for mutant in ALL:
        again = mutant.gate in seen or mutant.long
        seen.add(mutant.gate)
        if mutant in TOPICS[topic]:
            marks = [pytest.mark.slow] if again else []
            found.append(pytest.param(mutant, id=mutant.name, marks=marks))
    return found


@cache
def passes_when_healthy(gate: Callable[[], object]) -> None:
    """Run a gate on the engine as it is, once however many mutants it is for."""
    gate()


def catches(mutant: Mutant, engine: Callable[[Mutant], None]) -> None:
    """See the gate catch its mutant, or the host before it; what is no program is no mutant."""
    passes_when_healthy(mutant.gate)
    engine(mutant)
    with pytest.raises((AssertionError, HostError)) as caught:
        mutant.gate()
    assert not isinstance(caught.value, KernelBuildError)
