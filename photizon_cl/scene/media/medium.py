"""A transparent medium."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from photizon_cl.errors import ArgumentError, Problem, show
from photizon_cl.scene.curves import AbsorptionCurve, NumberOrCurve, at_wavelength, wavelength
from photizon_cl.scene.declarations import declare, refractive_index, unique_name
from photizon_cl.scene.described import REQUIRED, Described, parameters_of
from photizon_cl.scene.exponential import exponential, fused
from photizon_cl.scene.media.catalogue import glass_name, known_glass
from photizon_cl.scene.media.dispersion import Dispersion, dispersion
from photizon_cl.scene.parameters import LARGEST

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.described import Known

_WAYS = ("index", "dispersion", "glass")
"""How the index is told: by one of these; by a glass also with its dispersion, as it was found."""
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
    index : float, optional
        Refractive index, from 0.001 to 1000.
    absorption_per_m : float or AbsorptionCurve, optional
        Natural (Napierian) absorption coefficient α in 1/m, from 0 to 1e150; a table over
        wavelength in a scene that has a spectrum.
    dispersion : Sellmeier, Cauchy or IndexTable, optional
        Instead of `index`: how it depends on wavelength, in a scene that has a spectrum.
    glass : str, optional
        Instead of both: name of a glass of a catalogue, whose dispersion is then there and is
        written beside it, so that a scene and its results do without the catalogue. Given with a
        dispersion it is a name alone.
    """

    label: ClassVar[str] = "medium"
    kind: ClassVar[str] = "medium"
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {way: tuple(other for other in _WAYS if other != way) for way in _WAYS}
    )
    usual: ClassVar[Mapping[str, object]] = MappingProxyType({"index": REQUIRED})
    sample: ClassVar[Mapping[str, object]] = MappingProxyType({"index": 1.5168})

    name: str = field(metadata=unique_name("unique among the media"))
    index: float | None = field(
        default=None, metadata=refractive_index("refractive index; or dispersion, or glass")
    )
    absorption_per_m: float | AbsorptionCurve = field(
        default=0.0,
        metadata=declare(
            NumberOrCurve(
                AbsorptionCurve,
                "{ wavelength_nm = [..], per_m = [..] }",
                "an absorption coefficient per metre, a number from 0 to 1e150",
                0.0,
                LARGEST,
                meaning="natural (Napierian) absorption coefficient",
                unit="1/m",
            )
        ),
    )
    dispersion: Dispersion | None = field(
        default=None, metadata=dispersion("instead of index: how that depends on wavelength")
    )
    glass: str | None = field(
        default=None, metadata=glass_name("instead of both: name of a glass of a catalogue")
    )

    def __post_init__(self) -> None:
        """Check every value; a glass without a dispersion gets that of the catalogue."""
        super().__post_init__()
        if self.glass is not None and self.dispersion is None:
            found = known_glass(self.glass)
            assert not isinstance(found, Problem)  # as it was checked
            object.__setattr__(self, "dispersion", found)

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """See that the index is told, and in one way."""
        given = [way for way in _WAYS if way not in known.values or known.get(way) is not None]
        if given == ["dispersion", "glass"]:
            return []
        if len(given) == 1:  # one that was refused was given
            glass = known.get("glass")
            found = None if glass is None else known_glass(glass)
            return [found] if isinstance(found, Problem) else []
        if given:
            hint = f"give one of {', '.join(_WAYS)}"
            return [
                Problem(way, show(str(known.get(way))), f"nothing beside {given[0]}", hint=hint)
                for way in given[1:]
                if known.get(way) is not None
            ]
        hint = "the medium requires the key index, or dispersion or glass"
        return [Problem("index", "nothing", parameters_of(cls)["index"].expected, hint=hint)]

    def index_at(self, nm: float | None) -> float:
        """Return the refractive index at a wavelength in nanometres; None where it has just one.

        Raises
        ------
        ArgumentError
            Where what is given is no wavelength, where the index depends on it and none is given,
            and where there is no index at it, as outside of a table or the range of a formula.
        """
        if self.index is not None:
            if nm is not None:
                wavelength(nm, self._called)
            return self.index
        if self.dispersion is None or nm is None:
            raise ArgumentError(
                f"{self._called}: found no wavelength, expected one, as its index depends on "
                "wavelength: nm, in nanometres"
            )
        return self.dispersion.index_for(nm, self._called)

    @property
    def _called(self) -> str:
        return f'medium "{self.name}"'

    def absorption_at(self, nm: float | None) -> float:
        """Return the absorption coefficient at a wavelength in nanometres, in 1/m.

        Raises
        ------
        ArgumentError
            Where what is given is no wavelength, or it depends on it and none is given.
        """
        if nm is not None:
            nm = wavelength(nm, self._called)
        elif isinstance(self.absorption_per_m, AbsorptionCurve):
            raise ArgumentError(
                f"{self._called}: found no wavelength, expected one, as its absorption depends on "
                "it: nm, in nanometres"
            )
        return float(at_wavelength(self.absorption_per_m, nm))

    @property
    def most_absorption(self) -> float:
        """The largest absorption coefficient at any wavelength, in 1/m."""
        alpha = self.absorption_per_m
        return max(alpha.per_m) if isinstance(alpha, AbsorptionCurve) else alpha

    @property
    def absorbs(self) -> bool:
        """Whether it absorbs at any wavelength."""
        return self.most_absorption > 0.0

    def absorbing(self, nm: float | None) -> tuple[float]:
        """Return `absorption_at` as what kernels have of a medium."""
        return (self.absorption_at(nm),)

    def transmittance(self, length: float, nm: float | None = None) -> float:
        """Return the part of the power that a way of some length leaves, exp(−αs).

        Parameters
        ----------
        length : float
            s in metres, not negative; infinite for all the way.
        nm : float, optional
            Wavelength in nanometres, where the absorption depends on it.

        Returns
        -------
        float
            With the kernels' own exponential: the bits are those of a trace in double precision.

        Raises
        ------
        ArgumentError
            Where the length is negative, or no number; where `nm` is no wavelength, or the
            absorption depends on it and none is given.
        """
        given: object = length
        if isinstance(given, bool) or not isinstance(given, Real) or not float(given) >= 0.0:
            raise ArgumentError(
                f"{self._called}: a way is {show(length)} long, expected a length in metres that "
                "is not negative; it may be infinite"
            )
        length = float(length)
        alpha = self.absorption_at(nm)
        if not alpha:
            return 1.0
        product = alpha * length
        rest = 0.0
        if math.isfinite(product):
            rest = fused(alpha, length, -product)
        return exponential(-product, -rest)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return how far light comes in it, and what of it a centimetre leaves.

        Nothing where it does not absorb, and where that depends on wavelength.
        """
        if isinstance(self.absorption_per_m, AbsorptionCurve) or not self.absorption_per_m:
            return {}
        return {
            "1/e depth": (1.0 / self.absorption_per_m, "m"),
            "internal transmittance of 10 mm": (self.transmittance(_THICKNESS), ""),
        }
