"""A coating of which two numbers are known."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from photizon_cl.errors import Problem, show
from photizon_cl.scene.coatings.base import Coating, whole
from photizon_cl.scene.curves import (
    INTERPOLATED,
    Curve,
    at_wavelength,
    bounded_fraction,
    number_of,
)
from photizon_cl.scene.rows import Row

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from photizon_cl.scene.coatings.base import Array, Meeting
    from photizon_cl.scene.described import Known


@dataclass(frozen=True)
class FixedCoating(Coating):
    """One reflectance and one transmittance for every angle, the same from both sides.

    1 − R − T is absorbed by the element. Beyond the critical angle what would be transmitted is
    reflected: R + T.

    Parameters
    ----------
    reflectance : float or Curve
        R in [0, 1]; a table over wavelength in a scene that has a spectrum, which it must cover.
    transmittance : float or Curve
        T likewise; R + T is at most 1.
    """

    kind: ClassVar[str] = "fixed"
    kernel: ClassVar[str] = "fixed"
    does: ClassVar[str] = "one reflectance and one transmittance"
    costs: ClassVar[str] = "a few multiplications an interaction"
    row: ClassVar[Row] = Row(
        "FIXED_COATING",
        ("reflectance", "", "part that is reflected"),
        ("transmittance", "", "part that passes"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType(
        {"reflectance": 0.005, "transmittance": 0.99}
    )

    reflectance: float | Curve = field(
        metadata=bounded_fraction("part of the power that is reflected")
    )
    transmittance: float | Curve = field(
        metadata=bounded_fraction("part that passes", "the rest, 1 − R − T, is absorbed")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that no more leaves than arrives."""
        reflectance, transmittance = known.get("reflectance"), known.get("transmittance")
        if reflectance is None or transmittance is None:
            return []
        for nm, r, t in _pairs(reflectance, transmittance):
            if r + t > 1.0 + (2.0**-52 if nm is None else INTERPOLATED):
                at = "" if nm is None else f" at {nm:.9g} nm"
                hint = f"reflectance + transmittance are {r + t:.9g}{at}, and at most 1"
                expected = f"a number from 0 to {1.0 - r:.9g}{at}, as {show(r)} is reflected"
                return [Problem("transmittance", show(t), expected, hint=hint)]
        return []

    @property
    def lossless(self) -> bool:
        """Whether R + T is 1."""
        return all(whole(r, t) for _, r, t in _pairs(self.reflectance, self.transmittance))

    def at(self, nm: float | None) -> Self:
        """Return it with numbers in place of tables over wavelength."""
        both = (self.reflectance, self.transmittance)
        if not any(isinstance(value, Curve) for value in both):
            return self
        reflectance, transmittance = (at_wavelength(value, nm) for value in both)
        # between nodes rounding may give a little more
        return self.unchecked(
            reflectance=reflectance, transmittance=min(transmittance, 1.0 - reflectance)
        )

    def packed(self, indices: tuple[float, float], nm: float | None) -> dict[str, float]:
        """Return the two numbers."""
        return {
            "reflectance": number_of(self.reflectance),
            "transmittance": number_of(self.transmittance),
        }

    def parts(self, met: Meeting, nm: float | None) -> tuple[Array, Array]:
        """Return reflectance and transmittance."""
        r, t = number_of(self.reflectance), number_of(self.transmittance)
        total = met.square <= 0.0
        return np.where(total, min(r + t, 1.0), r), np.where(total, 0.0, t)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return what is absorbed, where that is a number."""
        if isinstance(self.reflectance, Curve) or isinstance(self.transmittance, Curve):
            return {}
        lost = 0.0 if self.lossless else 1.0 - self.reflectance - self.transmittance
        return {"absorptance": (lost, "")}


def _pairs(
    reflectance: float | Curve, transmittance: float | Curve
) -> Iterator[tuple[float | None, float, float]]:
    """Give wavelength, R and T wherever one of the two has a node, within both tables."""
    tables = [v for v in (reflectance, transmittance) if isinstance(v, Curve)]
    if not tables:
        yield None, number_of(reflectance), number_of(transmittance)
        return
    low, high = max(v.wavelength_nm[0] for v in tables), min(v.wavelength_nm[-1] for v in tables)
    for nm in sorted({nm for v in tables for nm in v.wavelength_nm if low <= nm <= high}):
        yield nm, at_wavelength(reflectance, nm), at_wavelength(transmittance, nm)
