"""Numbers over wavelength: what a surface reflects, what a medium absorbs."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import TYPE_CHECKING, Any, ClassVar, Final

from photizon_cl.errors import ArgumentError, Problem, show
from photizon_cl.scene.declarations import declare, fractions
from photizon_cl.scene.described import REQUIRED, Accepts, Described
from photizon_cl.scene.number_lists import Ascending, lengths_agree
from photizon_cl.scene.parameters import BAD, LARGEST, Number, Numbers
from photizon_cl.scene.whole import read_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.described import Known
    from photizon_cl.scene.parameters import Parameter

__all__ = [
    "INTERPOLATED",
    "LONGEST_NM",
    "SHORTEST_NM",
    "AbsorptionCurve",
    "BoundedCurve",
    "Curve",
    "NumberOrCurve",
    "OverWavelength",
    "ascending_nm",
    "at_wavelength",
    "bounded_fraction",
    "fraction_or_curve",
    "interpolated",
    "nodes",
    "number_of",
    "wavelength",
]

SHORTEST_NM: Final = 1e-3
LONGEST_NM: Final = 1e9
"""Range of wavelengths in nanometres: from gamma rays to radio."""
INTERPOLATED: Final = 2.0**-49
"""How much more the sum of two parts may be where one is interpolated: each is within 6·2^-53 of
what is between its nodes (three roundings to the place, one each of rise, product and sum), the sum
within 13·2^-53."""
_MOST_NODES: Final = 10_000
_LEAST_STEP: Final = 5e-324
"""Two different doubles are further apart: no wavelengths are too close to be told apart."""


def wavelength(nm: object, owner: str) -> float:
    """Return a wavelength in nanometres as a float.

    Parameters
    ----------
    nm : object
        What was given as one.
    owner : str
        What is asked about it, for the message: ``medium "bk7"``.

    Raises
    ------
    ArgumentError
        Where it is none, from 0.001 to 1e9 nm.
    """
    if type(nm) is float and SHORTEST_NM <= nm <= LONGEST_NM:
        return nm
    number = isinstance(nm, Real) and not isinstance(nm, bool)
    if not (number and SHORTEST_NM <= nm <= LONGEST_NM):  # type: ignore[operator]
        raise ArgumentError(
            f"{owner}: found the wavelength {show(nm)}, expected a number of nanometres, from "
            f"{SHORTEST_NM:g} to {LONGEST_NM:g}"
        )
    return float(nm)  # type: ignore[arg-type]


def ascending_nm(what: str, meaning: str, *, least: int, most: int) -> dict[str, Parameter]:
    """Declare a list of ascending wavelengths in nanometres."""
    return declare(
        Ascending(
            what,
            SHORTEST_NM,
            LONGEST_NM,
            least=least,
            most=most,
            closest=_LEAST_STEP,
            meaning=meaning,
            unit="nm",
        )
    )


def nodes() -> dict[str, Parameter]:
    """Declare the wavelengths at which a table has values."""
    what = "wavelengths in nanometres"
    return ascending_nm(what, "where it has values", least=2, most=_MOST_NODES)


def interpolated(wavelengths: Sequence[float], values: Sequence[float], nm: float) -> float:
    """Return a table's value: exact at a node, linear between two, that of the end outside.

    Parameters
    ----------
    wavelengths, values : sequence of float
        Nodes, ascending, and what there is at each.
    nm : float
        Wavelength in nanometres.
    """
    k = bisect_right(wavelengths, nm)
    if k == 0:
        return values[0]
    if k == len(wavelengths) or wavelengths[k - 1] == nm:
        return values[k - 1]
    a, b = wavelengths[k - 1], wavelengths[k]
    return values[k - 1] + (nm - a) / (b - a) * (values[k] - values[k - 1])


@dataclass(frozen=True)
class OverWavelength(Described):
    """What depends on wavelength, and so needs the scene's ``[spectrum]``."""

    one_value: ClassVar[bool] = True
    over_wavelength: ClassVar[bool] = True

    def __str__(self) -> str:
        return show(self.to_table())


@dataclass(frozen=True)
class _Table(OverWavelength):
    """Values at ascending wavelengths, linear between them and constant outside."""

    wavelength_nm: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=nodes()
    )

    @property
    def values(self) -> tuple[float, ...]:
        """What there is at each wavelength."""
        raise NotImplementedError

    @property
    def least(self) -> tuple[float, float]:
        """The first wavelength in nanometres at which it is least, and what it is there."""
        value, nm = min(zip(self.values, self.wavelength_nm, strict=True))
        return nm, value

    def at(self, nm: float) -> float:
        """Return the value at a wavelength in nanometres.

        Raises
        ------
        ArgumentError
            Where that is none, from 0.001 to 1e9 nm.
        """
        return interpolated(self.wavelength_nm, self.values, wavelength(nm, f"the {self.label}"))

    def __str__(self) -> str:
        low, high = min(self.values), max(self.values)
        first, last = self.wavelength_nm[0], self.wavelength_nm[-1]
        return f"{low:.9g} … {high:.9g} over {first:.9g} … {last:.9g} nm"


@dataclass(frozen=True)
class Curve(_Table):
    """A part of the power over wavelength, linear between its nodes and constant outside.

    Parameters
    ----------
    wavelength_nm : sequence of float
        Nodes in nanometres, ascending, two at least.
    value : sequence of float
        A number in [0, 1] at each.
    """

    label: ClassVar[str] = "curve"

    value: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED, metadata=fractions("wavelength", "what it is there")
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is a value for each wavelength."""
        return lengths_agree(known, "wavelength_nm", "wavelength", "value")

    @property
    def values(self) -> tuple[float, ...]:
        """What there is at each wavelength."""
        return self.value


@dataclass(frozen=True)
class BoundedCurve(Curve):
    """The same of something that is refused outside its table: a coating."""

    @property
    def domain(self) -> tuple[float, float]:
        """Wavelengths in nanometres between which it is known."""
        return self.wavelength_nm[0], self.wavelength_nm[-1]

    def at(self, nm: float) -> float:
        """Return the value at a wavelength in nanometres.

        Raises
        ------
        ArgumentError
            Where that is none, or outside the table.
        """
        low, high = self.domain
        nm = wavelength(nm, "the coating's table")
        if not low <= nm <= high:
            raise ArgumentError(
                f"the coating's table: found the wavelength {show(nm)}, expected one from "
                f"{low:.9g} to {high:.9g} nm, where it is given; it is not extrapolated"
            )
        return super().at(nm)


@dataclass(frozen=True)
class AbsorptionCurve(_Table):
    """An absorption coefficient over wavelength, linear between its nodes and constant outside.

    Parameters
    ----------
    wavelength_nm : sequence of float
        Nodes in nanometres, ascending, two at least.
    per_m : sequence of float
        Natural (Napierian) absorption coefficient in 1/m at each, from 0 to 1e150.
    """

    label: ClassVar[str] = "absorption"

    per_m: Accepts[Sequence[float], tuple[float, ...]] = field(
        default=REQUIRED,
        metadata=declare(
            Numbers(
                "a list of absorption coefficients per metre, one for each wavelength",
                Number("a number from 0 to 1e150", 0.0, LARGEST),
                meaning="what it is there, in 1/m",
            )
        ),
    )

    @classmethod
    def cross_check(cls, known: Known) -> list[Problem]:
        """Check that there is a value for each wavelength."""
        return lengths_agree(known, "wavelength_nm", "wavelength", "per_m")

    @property
    def values(self) -> tuple[float, ...]:
        """What there is at each wavelength."""
        return self.per_m


class NumberOrCurve(Number):
    """A number in an interval, or a table of such over wavelength.

    Parameters
    ----------
    base : type of OverWavelength
        Of the table.
    form : str
        The table as a file has it.
    expected, low, high, **more
        As `Number` takes them.
    """

    def __init__(
        self,
        base: type[_Table],
        form: str,
        expected: str,
        low: float,
        high: float,
        **more: Any,
    ) -> None:
        super().__init__(expected, low, high, **more)
        self.base, self._form = base, form

    @property
    def expected(self) -> str:  # noqa: D102
        return f"{self._expected}, or {self._form}"

    def refuse(self, value: object, path: str, problems: list[Problem], hint: str = "") -> Any:
        """Add the problem of a refused value and return `BAD`: of a number, what numbers may be."""
        expected = self._expected if isinstance(value, int | float) else self.expected
        problems.append(Problem(path, show(value), expected, hint=hint))
        return BAD

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, self.base):
            return value
        if isinstance(value, Mapping):
            return read_whole(self.base, value, path, problems, "a table over wavelength")
        return super().read(value, path, problems)


def fraction_or_curve(meaning: str, hint: str = "") -> dict[str, Parameter]:
    """Declare a number in [0, 1], or a table of such over wavelength."""
    form = "{ wavelength_nm = [..], value = [..] }"
    return declare(
        NumberOrCurve(Curve, form, "a number in [0, 1]", 0.0, 1.0, meaning=meaning, hint=hint)
    )


class BoundedFraction(NumberOrCurve):
    """A number in [0, 1], or a table of such over wavelength that is refused outside."""

    def __init__(self, meaning: str, hint: str = "") -> None:
        form = "{ wavelength_nm = [..], value = [..] }"
        super().__init__(
            BoundedCurve, form, "a number in [0, 1]", 0.0, 1.0, meaning=meaning, hint=hint
        )

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        if type(value) is Curve:
            return BoundedCurve(value.wavelength_nm, value.value)
        return super().read(value, path, problems)


def bounded_fraction(meaning: str, hint: str = "") -> dict[str, Parameter]:
    """Declare a number in [0, 1], or a table over wavelength that is refused outside."""
    return declare(BoundedFraction(meaning, hint))


def number_of(value: float | Curve) -> float:
    """Return a number that may be a table over wavelength.

    Raises
    ------
    ArgumentError
        Where it is one: `Surface.at` gives numbers.
    """
    if isinstance(value, Curve):
        raise ArgumentError(
            "found a table over wavelength, expected a number: Surface.at(nm) has those of a "
            "wavelength, scene.optics_at(nm)[surface] as well"
        )
    return value


def at_wavelength(value: Any, nm: float | None) -> Any:
    """Return a number for one that may be a table over wavelength.

    Raises
    ------
    ArgumentError
        Where it is one, and there is no wavelength, or it has no value there.
    """
    if not isinstance(value, _Table):
        return value
    if nm is None:
        raise ArgumentError(
            f"the {value.label}: found no wavelength, expected one, as it depends on it: nm, in "
            "nanometres"
        )
    return value.at(nm)
