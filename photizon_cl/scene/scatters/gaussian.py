"""The Gaussian lobe."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.declarations import fraction, number
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import NARROWEST, Scatter
from photizon_cl.scene.scatters.functions import exp_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.scatters.total import Array


@dataclass(frozen=True)
class GaussianScatter(Scatter):
    """A Gaussian lobe, tis/(2πσ²) exp(−Δ²/2σ²): haze, ground glass, a rolled sheet.

    Where all of the lobe is above the horizon `tis` is what it scatters; else that is less.

    Parameters
    ----------
    sigma : float
        σ of Δ in each of two directions, from 1e-9 to 1000.
    tis : float
        What the whole lobe holds, in [0, 1].
    """

    kind: ClassVar[str] = "gaussian"
    kernel: ClassVar[str] = "gaussian"
    does: ClassVar[str] = "scatter into a Gaussian lobe"
    costs: ClassVar[str] = "a random block, a logarithm and an exponential for each that is tried"
    row: ClassVar[Row] = Row(
        "GAUSS",
        ("height", "1/sr", "tis/(2 pi sigma^2)"),
        ("sigma", "", "of Delta in each direction"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"sigma": 0.05, "tis": 0.2})

    sigma: float = field(
        metadata=number(
            f"a number from {NARROWEST:g} to 1000",
            NARROWEST,
            1e3,
            "standard deviation of Δ in each of two directions",
        )
    )
    tis: float = field(metadata=fraction("what the whole lobe holds"))

    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0."""
        x = delta / self.sigma
        height = self.packed()["height"]
        return np.where(x < 37.0, height * exp_of(-0.5 * x * x), 0.0)

    def within(self, radius: Array) -> Array:
        """Return ∫ BSDF(s) s ds from 0 to a radius, tis/2π (1 − exp(−r²/2σ²))."""
        x = radius / self.sigma
        y = 0.5 * x * x
        # of small y a series: 1 and the exponential are nearly equal there
        few = y * (1.0 - y * (0.5 - y * (1.0 / 6.0 - y * (1.0 / 24.0 - y * (1.0 / 120.0)))))
        return self.tis / (2.0 * math.pi) * np.where(y < 1e-3, few, 1.0 - exp_of(-y))

    @property
    def width(self) -> float:
        """Standard deviation."""
        return self.sigma

    def packed(self) -> dict[str, float]:
        """Return height and width."""
        height = self.tis / (2.0 * math.pi * self.sigma * self.sigma)
        return {"height": height, "sigma": self.sigma}
