"""The ideal specular reflector."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import Problem, show
from photizon_cl.scene.parameters import fraction
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import scatter_problems
from photizon_cl.scene.surfaces.base import Surface, scattering

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters import Scatter


@dataclass(frozen=True)
class Mirror(Surface):
    """A specular surface with one reflectance for every angle, reflecting on both sides.

    With n the unit normal, a direction d leaves as d − 2(d·n)n and its weight is multiplied by
    the reflectance; 1 − ρ of it is absorbed by the element. No draw is made. With a `scatter` the
    reflectance is all that leaves: TIS(θ) of the weight is scattered about that direction, and
    ρ − TIS(θ) goes on in it. A field is reflected as by an ideal conductor, where the run carries
    polarisation.

    Parameters
    ----------
    reflectance : float
        ρ in [0, 1].
    scatter : Scatter, optional
        What is scattered, at no angle more than ρ.
    """

    kind: ClassVar[str] = "mirror"
    kernel: ClassVar[str] = "mirror"
    does: ClassVar[str] = "specular reflection"
    costs: ClassVar[str] = "a few multiplications an interaction"
    row: ClassVar[Row] = Row("MIRROR", ("reflectance", "", "part of the weight that goes on"))
    absorbs: ClassVar[bool] = True
    reflects: ClassVar[bool] = True
    colour: ClassVar[str] = "#0072b2"
    label_text: ClassVar[str] = "mirror"

    reflectance: float = field(
        metadata=fraction("part of the power that is reflected", "the rest, 1 − ρ, is absorbed")
    )

    scatter: Scatter | None = field(
        default=None, metadata=scattering("what of the reflectance is scattered")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that no more is scattered than leaves."""
        most = known.get("reflectance")
        if most is None:
            return []
        why = "the reflectance is all that leaves, and what scatters is a part of it"
        return scatter_problems(known, most, f"the reflectance, {show(most)}", why)

    def packed(self) -> dict[str, float]:
        """Return the reflectance."""
        return {"reflectance": self.reflectance}

    @property
    def absorptance(self) -> float:
        """Part of each arrival that the element absorbs, 1 − ρ."""
        return 1.0 - self.reflectance

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the absorptance, and what scatters."""
        return {"absorptance": (self.absorptance, ""), **self.scattered}
