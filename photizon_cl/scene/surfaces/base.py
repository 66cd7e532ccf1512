"""What all surfaces share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Self

from photizon_cl.scene.coatings import Coating
from photizon_cl.scene.curves import OverWavelength, at_wavelength
from photizon_cl.scene.declarations import declare
from photizon_cl.scene.described import Nested, parameters_of
from photizon_cl.scene.device_kinds import DeviceKind
from photizon_cl.scene.rows import NO_ROW, Row
from photizon_cl.scene.scatters import Scatter

if TYPE_CHECKING:
    from collections.abc import Mapping

    from photizon_cl.scene.parameters import Parameter


@dataclass(frozen=True)
class Surface(DeviceKind):
    """The one optical property of an element: what a ray that hits it does."""

    label: ClassVar[str] = "surface"
    kind: ClassVar[str] = ""
    row: ClassVar[Row] = NO_ROW
    """Columns of its row in the material table."""
    absorbs: ClassVar[bool] = True
    """Whether the element takes what does not go on; else everything goes on."""
    counts: ClassVar[bool] = True
    """Whether meeting it is an interaction; else a ray passes as if nothing were there."""
    reflects: ClassVar[bool] = False
    """Whether light may turn back to the side that it came from."""
    transmits: ClassVar[bool] = False
    """Whether light may go on to the other side."""
    refracts: ClassVar[bool] = False
    """Whether it is the border of two media."""
    splits: ClassVar[bool] = False
    """Whether a ray may go on as two."""
    reciprocal: ClassVar[bool] = True
    """Whether as much goes from one direction into another as back (Helmholtz)."""
    draws: ClassVar[bool] = False
    """Whether it draws random numbers."""
    scatters: ClassVar[bool] = False
    """Whether a ray goes on in a direction drawn from a density, which its kernel then gives."""
    polarises: ClassVar[bool] = False
    """Whether how much it sends on depends on how the light is polarised that comes."""
    carries_detector: ClassVar[bool] = False
    """Whether what arrives may be counted."""
    colour: ClassVar[str] = "#000000"
    """In drawings; safe for colour-blind readers (Okabe and Ito, Color Universal Design, 2008)."""
    label_text: ClassVar[str] = ""
    """In the legends of drawings."""

    def packed(self) -> dict[str, float]:
        """Return the values of its row's columns by name."""
        return {}

    @property
    def lobe(self) -> Scatter | None:
        """What it scatters about its specular rays, or where they would be; None where nothing."""
        return getattr(self, "scatter", None)

    @property
    def coat(self) -> Coating | None:
        """What says how much it reflects and lets pass by angle; None where it says so itself."""
        return getattr(self, "coating", None)

    @property
    def scattered(self) -> dict[str, tuple[float, str]]:
        """Derived quantities of what it scatters."""
        return self.lobe.derived() if self.lobe is not None else {}

    @property
    def branches(self) -> bool:
        """Whether a ray may go on as two: since it splits, or a part of it scatters."""
        return self.splits or (self.lobe is not None and (self.reflects or self.transmits))

    @property
    def diffuse_reflectance(self) -> float | None:
        """Part of the power that leaves it with equal radiance everywhere, where all else ends."""
        return None

    @property
    def indices(self) -> tuple[float, float] | None:
        """Refractive indices behind its normal and on the other side, where it refracts."""
        return None

    @property
    def media(self) -> tuple[str, str] | None:
        """Names of the media behind its normal and on the other side, where it names some."""
        return None

    def among(self, index_of: Mapping[str, float]) -> Surface:
        """Return it with numbers in place of the names of media, as kernels and checks take it.

        Parameters
        ----------
        index_of : mapping of str to float
            Refractive indices of the scene's media by name, the vacuum's among them.
        """
        return self

    def at(self, nm: float | None) -> Self:
        """Return it with numbers in place of tables over wavelength, as kernels and checks take it.

        Parameters
        ----------
        nm : float or None
            Wavelength in nanometres; None where there are no tables.
        """
        values = {item: getattr(self, item) for item in parameters_of(type(self))}
        tables = {item: v for item, v in values.items() if isinstance(v, OverWavelength)}
        if not tables:
            return self
        return self.unchecked(**{item: at_wavelength(v, nm) for item, v in tables.items()})

    def advice(self) -> list[str]:
        """Return what is valid and yet probably not meant, as what follows its element's name."""
        return []

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""
        return {}


def scattering(meaning: str) -> dict[str, Parameter]:
    """Declare what a surface scatters about its specular rays."""
    return declare(Nested(Scatter, "the", meaning=meaning))


def coated(meaning: str) -> dict[str, Parameter]:
    """Declare what a border of two media reflects and lets pass instead of what it would bare."""
    return declare(Nested(Coating, "the", meaning=meaning))
