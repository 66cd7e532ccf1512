"""The wavelengths of a scene's light."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import Problem, show
from photizon_cl.scene.curves import ascending_nm
from photizon_cl.scene.declarations import declare
from photizon_cl.scene.described import ABSENT, REQUIRED, Accepts, Described
from photizon_cl.scene.parameters import BAD, LARGEST, Number, Numbers

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.parameters import Parameter

__all__ = ["MOST_LINES", "Spectrum", "relative_powers"]

MOST_LINES: Final = 1024
"""Lines or bands: every row of the ledger has a cell for each."""


class RelativePowers(Numbers):
    """What parts of its power a source sends out at each wavelength."""

    needs_spectrum = True

    def __init__(self, meaning: str) -> None:
        super().__init__(
            "a list of relative powers, numbers from 0 to 1e150, not all of them 0",
            Number("a relative power, a number from 0 to 1e150", 0.0, LARGEST),
            meaning=meaning,
        )

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        powers = super().read(value, path, problems)
        if powers is BAD or any(powers):
            return powers
        return self.refuse(value, path, problems, "no power would be left" if powers else "")


def relative_powers(meaning: str) -> dict[str, Parameter]:
    """Declare the relative powers of a spectrum's lines or bands."""
    return declare(RelativePowers(meaning))


_WAYS: Final = ("wavelengths_nm", "edges_nm")


@dataclass(frozen=True)
class Spectrum(Described):
    """The wavelengths at which a scene is traced: single lines, or bands.

    Every ray is of one line or band; in a band it has a wavelength of its own, uniform per nm.
    Sources share their rays among them (`Source.spectrum`); indices of media, absorption and
    reflectances may depend on wavelength; every row of the ledger is known by line or band as well,
    and a detector's power where it asks for it.

    Parameters
    ----------
    wavelengths_nm : sequence of float, optional
        Wavelengths of lines in nanometres, ascending.
    edges_nm : sequence of float, optional
        Instead: edges of bands in nanometres, ascending; two at least, and one more than bands.
    """

    label: ClassVar[str] = "spectrum"
    sample: ClassVar[Mapping[str, Any]] = MappingProxyType(
        {"wavelengths_nm": [486.1, 587.6, 656.3]}
    )
    usual: ClassVar[Mapping[str, Any]] = MappingProxyType({"wavelengths_nm": REQUIRED})
    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {way: tuple(other for other in _WAYS if other != way) for way in _WAYS}
    )

    wavelengths_nm: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT,
        metadata=ascending_nm(
            "wavelengths in nanometres",
            "wavelengths of lines; or edges_nm",
            least=1,
            most=MOST_LINES,
        ),
    )
    edges_nm: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT,
        metadata=ascending_nm(
            "edges of bands in nanometres",
            "instead of wavelengths_nm: edges of bands",
            least=2,
            most=MOST_LINES + 1,
        ),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """See that there are lines, or bands."""
        given = [way for way in _WAYS if way not in known.values or known.get(way) is not None]
        if len(given) == 1:  # what was refused was given
            return []
        if given:
            hint = "give lines or bands"
            found = known.get("edges_nm")
            shown = show(list(found)) if found is not None else "edges as well"
            return [Problem("edges_nm", shown, "nothing beside wavelengths_nm", hint=hint)]
        hint = "[spectrum] requires the key wavelengths_nm, or edges_nm"
        expected = "ascending wavelengths in nanometres"
        return [Problem("wavelengths_nm", "nothing", expected, hint=hint)]

    @property
    def n(self) -> int:
        """Number of lines or bands."""
        return len(self.middles_nm)

    @cached_property
    def middles_nm(self) -> tuple[float, ...]:
        """A wavelength in nanometres for each: that of a line, the middle of a band."""
        if self.edges_nm is not None:
            edges = self.edges_nm
            return tuple(0.5 * (a + b) for a, b in pairwise(edges))
        return self.wavelengths_nm or ()

    @property
    def lines_nm(self) -> tuple[tuple[float, ...], ...]:
        """What tells each from others: the wavelength of a line, both edges of a band."""
        if self.edges_nm is not None:
            return tuple(pairwise(self.edges_nm))
        return tuple((nm,) for nm in self.middles_nm)

    @property
    def ends_nm(self) -> tuple[float, float]:
        """The shortest and the longest wavelength in nanometres that there may be."""
        all_of_it = self.edges_nm or self.middles_nm
        return all_of_it[0], all_of_it[-1]

    @property
    def reference(self) -> int:
        """The number of the one of which a single value is told, where one must stand for all."""
        return self.n // 2

    @property
    def names(self) -> tuple[str, ...]:
        """What each is called, for people."""
        if self.edges_nm is not None:
            edges = self.edges_nm
            return tuple(f"{a:.9g} – {b:.9g} nm" for a, b in pairwise(edges))
        return tuple(f"{nm:.9g} nm" for nm in self.middles_nm)

    @property
    def word(self) -> str:
        """What one of them is: a line or a band."""
        return "line" if self.edges_nm is None else "band"

    @property
    def about(self) -> str:
        """All of it in a few words."""
        first, last = self.ends_nm
        if self.n == 1 and self.edges_nm is None:
            return f"one line, {first:.9g} nm"
        number = "one band" if self.n == 1 else f"{self.n} {self.word}s"
        return f"{number}, {first:.9g} … {last:.9g} nm"
