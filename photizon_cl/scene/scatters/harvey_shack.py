"""The Harvey–Shack model."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.declarations import number
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.base import NARROWEST, Scatter
from photizon_cl.scene.scatters.functions import power_of
from photizon_cl.scene.scatters.total import total_at

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.scatters.total import Array


@dataclass(frozen=True)
class HarveyShackScatter(Scatter):
    """The Harvey–Shack model, b0 (1 + (Δ/L)²)^(S/2).

    b0 is the BSDF at the specular direction, L the shoulder behind which it falls, S the slope
    there in a plot of logarithms. `from_roughness` makes one of a surface's roughness.

    Parameters
    ----------
    b0 : float
        b0 in 1/sr, not negative.
    L : float
        L, from 1e-9 to 1000.
    S : float
        S, negative, from −100.

    Notes
    -----
    J. E. Harvey, Light-Scattering Characteristics of Optical Surfaces, thesis, University of
    Arizona (1976): what a surface scatters depends on Δ alone.
    """

    kind: ClassVar[str] = "harvey-shack"
    kernel: ClassVar[str] = "harvey_shack"
    does: ClassVar[str] = "scatter of polished surfaces, with a shoulder and a slope"
    costs: ClassVar[str] = "a random block, a logarithm and two powers for each that is tried"
    row: ClassVar[Row] = Row(
        "SHACK",
        ("height", "1/sr", "b0"),
        ("shoulder", "", "L"),
        ("power", "", "S/2"),
    )
    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"b0": 2.0, "L": 0.01, "S": -1.5})

    b0: float = field(
        metadata=number(
            "a number from 0 to 1e18", 0.0, 1e18, "BSDF at the specular direction", "1/sr"
        )
    )
    L: float = field(
        metadata=number(f"a number from {NARROWEST:g} to 1000", NARROWEST, 1e3, "Δ of the shoulder")
    )
    S: float = field(
        metadata=number(
            "a negative number, from -100", -100.0, 0.0, "slope behind it", open_high=True
        )
    )

    @classmethod
    def from_roughness(
        cls,
        rms: float,
        wavelength_nm: float,
        *,
        L: float,  # noqa: N803  # as the field calls them
        S: float,  # noqa: N803
        reflectance: float = 1.0,
    ) -> HarveyShackScatter:
        """Return the scatter of a surface of some roughness.

        Its TIS at normal incidence is R (4πσ/λ)², that of a smooth reflecting surface
        (H. E. Bennett and J. O. Porteus, J. Opt. Soc. Am. 51, 123, 1961).

        Parameters
        ----------
        rms : float
            RMS roughness σ in metres, of spatial frequencies below 1/λ.
        wavelength_nm : float
            λ in nanometres.
        L, S : float
            As of the class. Of a surface whose autocorrelation length is ℓ, L = λ/(2πℓ).
        reflectance : float, optional
            R of the surface.

        Raises
        ------
        ArgumentError
            Where the roughness is not small beside the wavelength: 4πσ < λ/2 is asked for.
        """
        phase = 4.0 * math.pi * rms / (1e-9 * wavelength_nm)
        if not 0.0 <= phase < 0.5:
            raise ArgumentError(
                f"rms: found {show(rms)}, expected a roughness with 4 pi rms < wavelength/2, which "
                "is where a surface is smooth"
            )
        plain = cls(b0=1.0, L=L, S=S)
        tis = reflectance * phase * phase
        return cls(b0=tis / float(total_at(plain, np.array([1.0]))[0]), L=L, S=S)

    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0."""
        x = delta / self.L
        return self.b0 * power_of(1.0 + x * x, 0.5 * self.S)

    @property
    def width(self) -> float:
        """Δ within which it falls by a factor of a few."""
        return self.L / math.sqrt(max(-self.S, 1.0))

    def packed(self) -> dict[str, float]:
        """Return height, shoulder and half the slope."""
        return {"height": self.b0, "shoulder": self.L, "power": 0.5 * self.S}
