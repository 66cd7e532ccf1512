"""A transparent medium."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.described import Described
from photizon_cl.scene.exponential import exponential, fused
from photizon_cl.scene.parameters import LARGEST, number, refractive_index, unique_name

if TYPE_CHECKING:
    from collections.abc import Mapping

_THICKNESS = 0.01
"""Length in metres of which the internal transmittance is told, as catalogues of glass do."""


@dataclass(frozen=True)
class Medium(Described):
    """What a transparent body is made of, or what lies around it.

    The weight of a ray falls by exp(−αs) along a way s in it (Beer and Lambert), and what it loses
    is booked to the ledger's row ``absorbed_in.NAME``. A surface names the medium on each of its
    sides, a source the one that it stands in; ``vacuum``, of index 1 and without absorption, is
    always there.

    Parameters
    ----------
    name : str
        Unique among the media of the scene, and not ``vacuum``.
    index : float
        Refractive index, from 0.001 to 1000.
    absorption_per_m : float, optional
        Natural (Napierian) absorption coefficient α in 1/m, from 0 to 1e150.
    """

    label: ClassVar[str] = "medium"
    kind: ClassVar[str] = "medium"
    foreseen: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            key: "what depends on wavelength is not there yet: give index, a number"
            for key in ("dispersion", "glass")
        }
    )

    name: str = field(metadata=unique_name("unique among the media"))
    index: float = field(metadata=refractive_index("refractive index"))
    absorption_per_m: float = field(
        default=0.0,
        metadata=number(
            "an absorption coefficient per metre, a number from 0 to 1e150",
            0.0,
            LARGEST,
            "natural (Napierian) absorption coefficient",
            "1/m",
        ),
    )

    def transmittance(self, length: float) -> float:
        """Return the part of the power that a way of some length leaves, exp(−αs).

        Parameters
        ----------
        length : float
            s in metres, not negative; infinite for all the way.

        Returns
        -------
        float
            With the kernels' own exponential: the bits are those of a trace in double precision.

        Raises
        ------
        ArgumentError
            Where the length is negative, or no number.
        """
        given: object = length
        if isinstance(given, bool) or not isinstance(given, Real) or not float(given) >= 0.0:
            raise ArgumentError(
                f'medium "{self.name}": a way is {show(length)} long, expected a length in metres '
                "that is not negative; it may be infinite"
            )
        length = float(length)
        if not self.absorption_per_m:
            return 1.0
        product = self.absorption_per_m * length
        rest = 0.0
        if math.isfinite(product):
            rest = fused(self.absorption_per_m, length, -product)
        return exponential(-product, -rest)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return how far light comes in it, and what of it a centimetre leaves."""
        if not self.absorption_per_m:
            return {}
        return {
            "1/e depth": (1.0 / self.absorption_per_m, "m"),
            "internal transmittance of 10 mm": (self.transmittance(_THICKNESS), ""),
        }
