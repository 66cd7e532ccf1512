"""How the refractive index of a medium depends on wavelength."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import ArgumentError, Problem, counted, show
from photizon_cl.scene.curves import (
    OverWavelength,
    ascending_nm,
    interpolated,
    nodes,
    wavelength,
)
from photizon_cl.scene.declarations import declare, number
from photizon_cl.scene.described import ABSENT, REQUIRED, Accepts, parameters_of
from photizon_cl.scene.number_lists import Ascending, lengths_agree
from photizon_cl.scene.parameters import LARGEST, Integer, Number, Numbers, Parameter
from photizon_cl.scene.whole import read_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known

__all__ = [
    "DISPERSIONS",
    "Cauchy",
    "Dispersion",
    "IndexTable",
    "Polynomial",
    "Sellmeier",
    "dispersion",
]

LEAST_INDEX: Final = 1e-3
MOST_INDEX: Final = 1e3
_MOST_POWER: Final = 20


@dataclass(frozen=True)
class Dispersion(OverWavelength):
    """A refractive index over wavelength, relative to what it was measured against, as it stands.

    What is computed uses sums, products, quotients and square roots alone, each rounded once as
    IEEE 754 says: it is the same on every machine.
    """

    label: ClassVar[str] = "dispersion"

    @property
    def domain(self) -> tuple[float, float] | None:
        """First and last wavelength in nanometres at which it is known; None where at all."""
        ends = getattr(self, "range_nm", None)
        return None if ends is None else (ends[0], ends[1])

    @property
    def resonances_nm(self) -> tuple[float, ...]:
        """Wavelengths in nanometres at which it has no value, as it grows without bound."""
        return ()

    def at(self, nm: float) -> float:
        """Return the index at a wavelength in nanometres.

        Raises
        ------
        ArgumentError
            Where that is none, or it has no index there: outside of a table or a range, at a
            resonance, or where a formula gives less than 0.001 or more than 1000.
        """
        return self.index_for(nm, f"the dispersion {show(self.kind)}")

    def index_for(self, nm: float, owner: str) -> float:
        """Return `at`, with what has it as the subject of a message: ``medium "bk7"``."""
        nm = wavelength(nm, owner)
        index, fault = self._judged(nm)
        if not fault:
            return index
        where = "at which there is an index"
        if self.domain is not None:
            where = f"from {self.domain[0]:.9g} to {self.domain[1]:.9g} nm, where it has an index"
        raise ArgumentError(
            f"{owner}: found the wavelength {show(nm)}, expected one {where} ({fault})"
        )

    def fault(self, nm: float) -> str:
        """Return why it has no index that can be used at a wavelength, empty where it has one."""
        return self._judged(nm)[1]

    def _judged(self, nm: float) -> tuple[float, str]:
        """Return what it gives at a wavelength, and why that cannot be used, empty where it can."""
        if self.domain is not None and not self.domain[0] <= nm <= self.domain[1]:
            return math.nan, "it has none there"
        index = self._given(nm)
        if LEAST_INDEX <= index <= MOST_INDEX:
            return index, ""
        return index, "it gives none there" if math.isnan(index) else f"it gives {index:.6g} there"

    def _given(self, nm: float) -> float:
        """Return what it gives at a wavelength in nanometres, NaN where nothing."""
        raise NotImplementedError

    def __str__(self) -> str:
        return self.kind


def _known_range() -> dict[str, Parameter]:
    return ascending_nm(
        "wavelengths in nanometres", "between which it is known; outside it is refused",
        least=2, most=2,
    )  # fmt: skip


def _coefficients(what: str) -> dict[str, Parameter]:
    item = Number("a finite number", -LARGEST, LARGEST)
    return declare(Numbers("a list of 1 to 8 numbers", item, meaning=what))


@dataclass(frozen=True)
class Sellmeier(Dispersion):
    """n² = 1 + Σ B λ²/(λ² − C), with λ in micrometres.

    W. Sellmeier, Annalen der Physik 219, 272 (1871); three terms as catalogues of glass have them.

    Parameters
    ----------
    B : sequence of float
        Strengths of the terms, without unit.
    C_um2 : sequence of float
        Squares of their wavelengths, in µm².
    range_nm : tuple of float, optional
        Shortest and longest wavelength in nanometres at which it is known.
    """

    kind: ClassVar[str] = "sellmeier"

    B: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=_coefficients("strengths of the terms")
    )
    C_um2: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=_coefficients("squares of their wavelengths, in µm²")
    )
    range_nm: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT, metadata=_known_range()
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there are one to eight terms, each with both numbers."""
        b, c = known.get("B"), known.get("C_um2")
        problems = [
            Problem(item, f"{len(values)} of them", "1 to 8 numbers")
            for item, values in (("B", b), ("C_um2", c))
            if values is not None and not 1 <= len(values) <= 8
        ]
        if not problems and b is not None and c is not None and len(b) != len(c):
            expected = f"{counted(len(b), 'number')}, one for each of B"
            problems.append(Problem("C_um2", f"{len(c)} of them", expected))
        return problems

    @property
    def resonances_nm(self) -> tuple[float, ...]:
        """Wavelengths in nanometres of the terms, where n² grows without bound."""
        terms = zip(self.B, self.C_um2, strict=True)
        return tuple(1000.0 * math.sqrt(c) for b, c in terms if b != 0.0 and c > 0.0)

    def _given(self, nm: float) -> float:
        um = nm / 1000.0
        square, total = um * um, 1.0
        for b, c in zip(self.B, self.C_um2, strict=True):
            if square == c:
                return math.nan
            total += b * square / (square - c)
        return math.sqrt(total) if 0.0 <= total < math.inf else math.nan


@dataclass(frozen=True)
class Cauchy(Dispersion):
    """n = A + B/λ² + C/λ⁴, with λ in micrometres.

    Parameters
    ----------
    A : float
        The index at long wavelengths.
    B_um2, C_um4 : float, optional
        Coefficients in µm² and µm⁴.
    range_nm : tuple of float, optional
        Shortest and longest wavelength in nanometres at which it is known.
    """

    kind: ClassVar[str] = "cauchy"

    A: float = field(metadata=number("a finite number", -LARGEST, LARGEST, "index at long λ"))
    B_um2: float = field(
        default=0.0, metadata=number("a finite number", -LARGEST, LARGEST, "of 1/λ²", "µm²")
    )
    C_um4: float = field(
        default=0.0, metadata=number("a finite number", -LARGEST, LARGEST, "of 1/λ⁴", "µm⁴")
    )
    range_nm: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT, metadata=_known_range()
    )

    def _given(self, nm: float) -> float:
        um = nm / 1000.0
        square = um * um
        return self.A + (self.B_um2 + self.C_um4 / square) / square


@dataclass(frozen=True)
class Polynomial(Dispersion):
    """n² = Σ c λ^p, with λ in micrometres.

    The form of many catalogues: c₀ + c₁ λ² + c₂ λ⁻² + c₃ λ⁻⁴ + …

    Parameters
    ----------
    coefficients : sequence of float
        c of each term, in µm^(−p).
    powers : sequence of int
        p of each term, from −20 to 20.
    range_nm : tuple of float, optional
        Shortest and longest wavelength in nanometres at which it is known.
    """

    kind: ClassVar[str] = "polynomial"

    coefficients: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED,
        metadata=declare(
            Numbers(
                "a list of 1 to 16 numbers",
                Number("a finite number", -LARGEST, LARGEST),
                meaning="of the terms, in µm^(−p)",
            )
        ),
    )
    powers: Accepts[Sequence[int], tuple[int, ...]] = field(
        default=REQUIRED,
        metadata=declare(
            Numbers(
                "a list of integers, one for each coefficient",
                Integer(-_MOST_POWER, _MOST_POWER),
                meaning="p of each term",
            )
        ),
    )
    range_nm: Accepts[Sequence[float] | None, tuple[float, ...] | None] = field(
        default=ABSENT, metadata=_known_range()
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there are terms, each with both numbers."""
        c, p = known.get("coefficients"), known.get("powers")
        if c is not None and not 1 <= len(c) <= 16:
            return [Problem("coefficients", f"{len(c)} of them", "1 to 16 numbers")]
        if c is None or p is None or len(c) == len(p):
            return []
        expected = f"{counted(len(c), 'integer')}, one for each coefficient"
        return [Problem("powers", f"{len(p)} of them", expected)]

    def _given(self, nm: float) -> float:
        um = nm / 1000.0
        total = 0.0
        for c, p in zip(self.coefficients, self.powers, strict=True):
            power = 1.0
            for _ in range(abs(p)):  # products alone, which are the same everywhere
                power *= um
            total += c * power if p >= 0 else c / power
        return math.sqrt(total) if 0.0 <= total < math.inf else math.nan


@dataclass(frozen=True)
class IndexTable(Dispersion):
    """An index at ascending wavelengths, linear between them; outside there is none.

    Parameters
    ----------
    wavelength_nm : sequence of float
        Nodes in nanometres, two at least.
    index : sequence of float
        The index at each, from 0.001 to 1000.
    """

    kind: ClassVar[str] = "table"

    wavelength_nm: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=nodes()
    )
    index: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED,
        metadata=declare(
            Numbers(
                "a list of refractive indices, one for each wavelength",
                Number("a refractive index, a number from 0.001 to 1000", LEAST_INDEX, MOST_INDEX),
                meaning="what it is there",
            )
        ),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is an index for each wavelength."""
        return lengths_agree(known, "wavelength_nm", "wavelength", "index")

    @property
    def domain(self) -> tuple[float, float] | None:
        """First and last wavelength in nanometres."""
        return self.wavelength_nm[0], self.wavelength_nm[-1]

    def _given(self, nm: float) -> float:
        return interpolated(self.wavelength_nm, self.index, nm)


DISPERSIONS: Final[dict[str, type[Dispersion]]] = {
    cls.kind: cls for cls in (Sellmeier, Cauchy, IndexTable, Polynomial)
}
"""The forms by the kind that a file names."""


class DispersionParameter(Parameter):
    """One of the forms, as an object or as a table of a file."""

    @property
    def expected(self) -> str:
        *most, last = (_form(cls) for cls in DISPERSIONS.values())
        return f"{', '.join(most)} or {last}"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        if isinstance(value, Dispersion):
            return value
        if isinstance(value, Mapping):
            return read_whole(DISPERSIONS, value, path, problems, "the dispersion")
        return self.refuse(value, path, problems)


def _form(cls: type[Dispersion]) -> str:
    """Return one of the forms as a table of a file, with its keys."""
    keys = (
        f"{name} = [..]" if isinstance(parameter, Numbers | Ascending) else name
        for name, parameter in parameters_of(cls).items()
    )
    return f"{{ {', '.join((f'kind = {show(cls.kind)}', *keys))} }}"


def dispersion(meaning: str) -> dict[str, Parameter]:
    """Declare how an index depends on wavelength."""
    return declare(DispersionParameter(meaning))
