"""The ideal absorber."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.scene.scatters.base import scatter_problems
from photizon_cl.scene.surfaces.base import Surface, scattering

if TYPE_CHECKING:
    from photizon_cl.errors import Problem
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters import Scatter


@dataclass(frozen=True)
class Absorber(Surface):
    """A black surface: the whole weight of every arrival ends here, from either side.

    It can carry a detector. It makes no draw. With a `scatter`, as of black paint, TIS(θ) of the
    weight goes on, about the direction in which a mirror would send it, and the rest ends here; it
    carries no detector then.

    Parameters
    ----------
    scatter : Scatter, optional
        What is scattered.
    """

    kind: ClassVar[str] = "absorber"
    kernel: ClassVar[str] = "absorber"
    does: ClassVar[str] = "ends what arrives"
    costs: ClassVar[str] = "one tally event a path"
    absorbs: ClassVar[bool] = True
    carries_detector: ClassVar[bool] = True
    label_text: ClassVar[str] = "absorber"

    scatter: Scatter | None = field(
        default=None, metadata=scattering("what does not end here: black paint")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that no more is scattered than arrives."""
        return scatter_problems(known, 1.0, "1", "more would be scattered than arrives")

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return what scatters."""
        return self.scattered
