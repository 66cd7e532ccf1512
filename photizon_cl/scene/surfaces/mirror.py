"""The ideal specular reflector."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.errors import Problem, SceneError, show
from photizon_cl.scene.angles import AngleCurve, fraction_over
from photizon_cl.scene.coatings.table import TableCoating
from photizon_cl.scene.curves import Curve, number_of
from photizon_cl.scene.described import parameters_of
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import ROUNDING, scatter_problems
from photizon_cl.scene.surfaces.base import Surface, scattering

if TYPE_CHECKING:
    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters import Scatter


@dataclass(frozen=True)
class Mirror(Surface):
    """A specular surface, reflecting on both sides.

    With n the unit normal, a direction d leaves as d − 2(d·n)n and its weight is multiplied by
    the reflectance; 1 − ρ of it is absorbed by the element. No draw is made. With a `scatter` the
    reflectance is all that leaves: TIS(θ) of the weight is scattered about that direction, and
    ρ − TIS(θ) goes on in it. A field is reflected as by an ideal conductor, where the run carries
    polarisation.

    Parameters
    ----------
    reflectance : float, Curve or AngleCurve
        ρ in [0, 1]; a table over wavelength in a scene that has a spectrum; a table over the angle
        of incidence.
    scatter : Scatter, optional
        What is scattered, at no angle and no wavelength more than ρ.
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

    reflectance: float | Curve | AngleCurve = field(
        metadata=fraction_over(
            "part of the power that is reflected", "the rest, 1 − ρ, is absorbed"
        )
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
        at = ""
        if isinstance(most, AngleCurve):
            return _by_angle(known, most)
        if isinstance(most, Curve):  # the lobe is the same at every wavelength
            nm, most = most.least
            at = f" at {nm:.9g} nm, where it is least"
        why = "the reflectance is all that leaves, and what scatters is a part of it"
        return scatter_problems(known, most, f"the reflectance, {show(most)}{at}", why)

    def packed(self) -> dict[str, float]:
        """Return the reflectance; of a table over angle, which stands elsewhere, its first."""
        value = self.reflectance
        return {
            "reflectance": value.value[0] if isinstance(value, AngleCurve) else number_of(value)
        }

    @cached_property
    def coat(self) -> TableCoating | None:
        """Its table over angle, as that of a coating that lets nothing pass."""
        if not isinstance(self.reflectance, AngleCurve):
            return None
        angle, value = self.reflectance.extended
        return TableCoating(angle, value, (0.0,) * len(value))

    def advice(self) -> list[str]:
        """Say where its table over angle ends before angles do."""
        if not isinstance(self.reflectance, AngleCurve):
            return []
        angle = self.reflectance.angle_deg
        text = f"has a reflectance from {angle[0]:.9g} to {angle[-1]:.9g} deg: "
        ends = [
            f"{where} it is taken as at {at:.9g} deg"
            for where, at, more in (
                ("below", angle[0], angle[0] > 0.0), ("beyond", angle[-1], angle[-1] < 90.0)
            )
            if more
        ]  # fmt: skip
        return [text + " and ".join(ends)] if ends else []

    @property
    def absorptance(self) -> float | None:
        """Part of each arrival that the element absorbs, 1 − ρ; None where that is a table."""
        table = isinstance(self.reflectance, Curve | AngleCurve)
        return None if table else 1.0 - self.reflectance  # type: ignore[operator]

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the absorptance, where it is a number, and what scatters."""
        plain = {} if self.absorptance is None else {"absorptance": (self.absorptance, "")}
        return plain | self.scattered


def _by_angle(known: Known, most: AngleCurve) -> list[Problem]:
    """Return the problem of a lobe that scatters more at some angle than is reflected there."""
    problems = scatter_problems(known, 1.0, "1", "more would be scattered than arrives")
    scatter = known.get("scatter")
    if problems or scatter is None:
        return problems
    names = parameters_of(scatter.cls)
    if not scatter.values.keys() >= names.keys():
        return []
    try:
        lobe = scatter.cls(**{name: scatter.get(name) for name in names})
    except SceneError:  # told already
        return []
    angle = np.union1d(np.linspace(0.0, 90.0, 361), most.angle_deg)
    over = lobe.total(angle) - np.interp(angle, *most.extended) * (1.0 + ROUNDING)
    worst = int(np.argmax(over))
    if over[worst] <= 0.0:
        return []
    there = float(np.interp(angle[worst], *most.extended))
    value = f"a TIS of {float(lobe.total(angle[worst])):.6g} at {angle[worst]:.3g} deg"
    why = "the reflectance is all that leaves, and what scatters is a part of it"
    return [Problem("scatter", value, f"at most the reflectance there, {there:.6g}", hint=why)]
