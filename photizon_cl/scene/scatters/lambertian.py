"""Scatter that is the same in every direction."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.scene.declarations import fraction
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import Scatter

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.scatters.total import Array


@dataclass(frozen=True)
class LambertianScatter(Scatter):
    """Ideal diffuse scatter, tis/π in every direction and for every angle of incidence.

    Parameters
    ----------
    tis : float
        What is scattered, in [0, 1].
    """

    kind: ClassVar[str] = "lambertian"
    kernel: ClassVar[str] = "lambertian"
    does: ClassVar[str] = "diffuse scatter"
    costs: ClassVar[str] = "a random block, sine and cosine"
    row: ClassVar[Row] = Row("DIFFUSE", ("height", "1/sr", "tis/pi"))
    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"tis": 0.05})

    tis: float = field(metadata=fraction("what is scattered"))

    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0."""
        return np.full_like(delta, self.tis / math.pi)

    def within(self, radius: Array) -> Array:
        """Return ∫ BSDF(s) s ds from 0 to a radius."""
        return self.tis / (2.0 * math.pi) * (radius * radius)

    @property
    def width(self) -> float:
        """All of the disc."""
        return 1.0

    def packed(self) -> dict[str, float]:
        """Return the height."""
        return {"height": self.tis / math.pi}
