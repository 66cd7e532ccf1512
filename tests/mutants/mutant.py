"""What a mutant is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


@dataclass(frozen=True)
class Mutant:
    """A defect: what stands at some points of the kernels, and the gate that must notice.

    `long`: whether it is slow whatever else its gate catches: many programs, or a long run.
    """

    name: str
    points: Mapping[str, str | int]
    gate: Callable[[], object]
    long: bool = False
