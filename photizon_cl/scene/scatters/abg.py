"""The ABg model."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from photizon_cl.errors import Problem, show
from photizon_cl.scene.declarations import number
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import NARROWEST, Scatter
from photizon_cl.scene.scatters.functions import power_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.scatters.total import Array


_WIDEST: Final = 1e18
"""Half-width from which on it is told no more: single precision holds it, and its square."""


@dataclass(frozen=True)
class AbgScatter(Scatter):
    """The ABg model, A/(B + Δ^g): flat in the middle, then falling by a power.

    A/B is the BSDF at the specular direction, B^(1/g) the Δ at which it has fallen to half, g the
    slope behind that in a plot of logarithms. What polished surfaces scatter falls with g between 1
    and 3.

    Parameters
    ----------
    A : float
        A in 1/sr, not negative.
    B : float
        B, positive; B^(1/g) is at least 1e-9.
    g : float
        g, from 0.01 to 10.

    Notes
    -----
    For g = 2 the total is πA log((1 − b² + B + √((1 − b² + B)² + 4Bb²))/(2B)), b = sin θ. B is that
    of the catalogues: R. N. Pfisterer, Approximated Scatter Models for Stray Light Analysis, Optics
    and Photonics News 22 (10), 16 (2011).
    """

    kind: ClassVar[str] = "abg"
    kernel: ClassVar[str] = "abg"
    does: ClassVar[str] = "scatter that falls by a power of Δ"
    costs: ClassVar[str] = (
        "two random blocks, two logarithms and exponentials for each that is tried"
    )
    row: ClassVar[Row] = Row(
        "ABG",
        ("height", "1/sr", "A/B"),
        ("half", "", "B^(1/g), Δ of half the height"),
        ("slope", "", "g"),
        ("fall", "", "1/B where that is no more than 1"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"A": 1e-3, "B": 1e-2, "g": 2.0})

    A: float = field(
        metadata=number("a number from 0 to 1e12", 0.0, 1e12, "A of A/(B + Δ^g)", "1/sr")
    )
    B: float = field(
        metadata=number("a positive number, from 1e-90 to 1e12", 1e-90, 1e12, "B of A/(B + Δ^g)")
    )
    g: float = field(metadata=number("a number from 0.01 to 10", 0.01, 10.0, "g of A/(B + Δ^g)"))

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that directions can tell the lobe's middle from a point."""
        b, g = known.get("B"), known.get("g")
        if b is None or g is None or math.log(b) >= g * math.log(NARROWEST):
            return []
        hint = f"B^(1/g), the lobe's width, is at least {NARROWEST:g}; below that it is specular"
        return [Problem("B", show(b), f"at least {NARROWEST:g}^g", hint=hint)]

    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0."""
        return self.A / (self.B + power_of(delta, self.g))

    @property
    def width(self) -> float:
        """Δ at which the BSDF has fallen to half."""
        return float(power_of(np.array([self.B]), 1.0 / self.g)[0])

    @property
    def sharpness(self) -> int:
        """Pieces of an octave."""
        return max(super().sharpness, math.ceil(self.g))

    def packed(self) -> dict[str, float]:
        """Return height, half-width and slope."""
        return {
            "height": self.A / self.B,
            "half": min(self.width, _WIDEST),
            "slope": self.g,
            "fall": 1.0 / max(self.B, 1.0),
        }
