"""Where scattered rays are sent more often than their surfaces send them."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import names, number, shares
from photizon_cl.scene.described import ABSENT, REQUIRED, Accepts, Described

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known

__all__ = ["MOST_TARGETS", "Importance", "targets_of"]

MOST_TARGETS: Final = 256
"""Targets: the density of each is asked for at every scattering."""


@dataclass(frozen=True, kw_only=True)
class Importance(Described):
    """The ``[importance]`` table: scattered rays are sent towards some elements more often.

    With the chance `fraction` a scattered ray is sent to a point of a target instead of where its
    surface would send it, and it is weighted by the surface's density over that of the mixture:
    every expectation stays what it is (E. Veach, Robust Monte Carlo Methods for Light Transport
    Simulation, thesis, Stanford 1997, 9.2.4: one-sample multiple importance sampling).

    Parameters
    ----------
    toward : tuple of str
        Names of the elements, in any order: a detector, or what scatters towards it.
    fraction : float
        Share of the scattered rays, in [0, 1). 0 sends none.
    weights : tuple of float, optional
        How that share is divided among the elements; by default equally.
    """

    label: ClassVar[str] = "importance"

    toward: Accepts[Sequence[str], tuple[str, ...]] = field(
        default=REQUIRED, metadata=names("elements that scattered rays are sent towards")
    )
    fraction: float = field(
        default=0.5,
        metadata=number(
            "a number from 0 up to but not including 1",
            0.0,
            1.0,
            "share of the scattered rays that are sent there",
            open_high=True,
        ),
    )
    weights: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT, metadata=shares("how that share is divided among them, by default equally")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is a weight for each name, and that there are not too many."""
        toward, weights = known.get("toward"), known.get("weights")
        problems = []
        if toward is not None and len(toward) > MOST_TARGETS:
            hint = "each costs time at every scattering; take what scatters to the detector itself"
            expected = f"at most {MOST_TARGETS} names"
            problems.append(Problem("toward", f"{len(toward)} names", expected, hint=hint))
        if toward is None or weights is None or len(toward) == len(weights):
            return problems
        n = len(toward)
        expected = f"{n} numbers, one for each name in toward" if n > 1 else "one number"
        return [*problems, Problem("weights", f"{len(weights)} of them", expected)]

    @property
    def shares(self) -> dict[str, float]:
        """Part of what is sent towards targets that each element gets, by its name; sums to 1."""
        weights = self.weights or (1.0,) * len(self.toward)
        total = sum(weights)
        return {name: weight / total for name, weight in zip(self.toward, weights, strict=True)}


def targets_of(known: Known | None, elements: Sequence[Known | None]) -> list[Problem]:
    """Return the problems of the elements that a scene's importance names.

    Parameters
    ----------
    known : Known or None
        The table's good values; None without one.
    elements : sequence of Known or None
        The scene's elements; None where an entry could not be read at all.
    """
    listed = [element.get("name") for element in elements if element]
    there = [name for name in listed if name is not None]
    if known is None or len(there) < len(elements):  # one whose name is not known may be meant
        return []
    problems = []
    for i, name in enumerate(known.get("toward") or ()):
        if name in there:
            continue
        near = difflib.get_close_matches(name, there, 1)
        hint = f"did you mean {show(near[0])}?" if near else ""
        some = ", ".join(map(show, there[:12])) + (" …" if len(there) > 12 else "")
        expected = f"the name of an element: {some}" if there else "elements in the scene"
        problems.append(Problem(f"importance.toward[{i}]", show(name), expected, hint=hint))
    return problems
