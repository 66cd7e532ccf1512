"""How the description classes declare their parameters, and how values are checked against them.

A parameter is a dataclass field whose metadata says what it accepts::

    @dataclass(frozen=True, kw_only=True)
    class Disk(Element):
        radius: float = field(metadata=positive_length("radius"))

The same declarations serve construction in Python (`photizon_cl.scene.described`) and the file
reader (`photizon_cl.scene.reader`), which goes on after a bad value so that one pass reports
everything.

Numbers: booleans and strings are not numbers; integers are accepted where a number is wanted;
NaN and infinities are refused, and so are magnitudes whose squares overflow or vanish in fp64.
A negative zero is read as zero.
"""

from __future__ import annotations

import math
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Sequence
from decimal import Decimal
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import Problem, show

if TYPE_CHECKING:
    from fractions import Fraction

BAD: Final = object()
"""What `Parameter.read` returns for a value that was refused."""

SMALLEST: Final = 1e-150
LARGEST: Final = 1e150
"""Range of lengths and powers: beyond it, squares leave the range of fp64."""

NAME_LENGTH: Final = 64
METADATA_KEY = "photizon_cl"


class Parameter(ABC):
    """What a value must be.

    Parameters
    ----------
    meaning : str
        What the parameter is, for documentation.
    unit : str
        Its unit, empty for pure numbers.
    """

    silent: bool = False
    """Whether it is written and shown only where it is another than its default."""
    needs_spectrum: bool = False
    """Whether the scene must have ``[spectrum]`` where it is given."""

    def __init__(self, meaning: str = "", unit: str = "") -> None:
        self.meaning = meaning
        self.unit = unit

    @property
    @abstractmethod
    def expected(self) -> str:
        """What is accepted, as a phrase that follows "expected"."""

    @abstractmethod
    def read(self, value: object, path: str, problems: list[Problem]) -> Any:
        """Return the canonical value, or add to `problems` and return `BAD`."""

    def refuse(self, value: object, path: str, problems: list[Problem], hint: str = "") -> Any:
        """Add the problem of a refused value and return `BAD`."""
        problems.append(Problem(path, show(value), self.expected, hint=hint))
        return BAD


class Number(Parameter):
    """A finite real number in an interval, read as a float."""

    def __init__(
        self,
        expected: str,
        low: float,
        high: float,
        *,
        open_low: bool = False,
        open_high: bool = False,
        meaning: str = "",
        unit: str = "",
        hint: str = "",
    ) -> None:
        super().__init__(meaning, unit)
        self._expected = expected
        self._low, self._high = low, high
        self._open_low, self._open_high = open_low, open_high
        self._hint = hint

    @property
    def expected(self) -> str:  # noqa: D102
        return self._expected

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, bool) or not isinstance(value, Real):
            return self.refuse(value, path, problems, _not_a_number(value))
        try:
            number = float(value) + 0.0  # the sum turns -0.0 into 0.0
        except OverflowError:
            return self.refuse(value, path, problems, "too large for a double")
        if not math.isfinite(number):
            return self.refuse(value, path, problems, "it must be finite")
        if number < self._low or (self._open_low and number == self._low):
            return self.refuse(value, path, problems, self._hint)
        if number > self._high or (self._open_high and number == self._high):
            return self.refuse(value, path, problems, self._hint)
        return number


class NumberOrWord(Number):
    """A number in an interval, or one word."""

    def __init__(self, word: str, expected: str, low: float, high: float, **more: Any) -> None:
        super().__init__(f'{expected}, or "{word}"', low, high, **more)
        self._word = word

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        return value if value == self._word else super().read(value, path, problems)


class SignedRadius(Parameter):
    """A radius of curvature: a length of either sign, or infinity, which JSON writes as "inf"."""

    @property
    def expected(self) -> str:  # noqa: D102
        return (
            "a radius in metres, from 1e-150 to 1e150, negative where the face is concave, or inf "
            "where it is flat"
        )

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, str) and value == "inf":
            return math.inf
        if isinstance(value, bool) or not isinstance(value, Real):
            return self.refuse(value, path, problems, _not_a_number(value))
        try:
            radius = float(value)
        except OverflowError:
            return self.refuse(value, path, problems, "too large for a double")
        if radius == math.inf or SMALLEST <= abs(radius) <= LARGEST:
            return radius
        hint = {-math.inf: "a flat face is inf, without a sign", 0.0: "a flat face is inf"}
        return self.refuse(value, path, problems, hint.get(radius, ""))


class Integer(Parameter):
    """An integer in a closed range."""

    def __init__(self, low: int, high: int, high_text: str = "", *, meaning: str = "") -> None:
        super().__init__(meaning)
        self._low, self._high = low, high
        self._expected = f"an integer from {low} to {high_text or high}"

    @property
    def expected(self) -> str:  # noqa: D102
        return self._expected

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, bool) or not isinstance(value, Integral):
            hint = _not_a_number(value)
            if isinstance(value, float) and value.is_integer() and abs(value) < 2.0**63:
                hint = f"write {int(value)}, without a decimal point or exponent"
            return self.refuse(value, path, problems, hint)
        number = int(value)
        if not self._low <= number <= self._high:
            return self.refuse(value, path, problems)
        return number


class Array(Parameter):
    """A fixed number of values of one kind, read as a tuple."""

    def __init__(
        self, expected: str, item: Parameter, count: int, *, meaning: str = "", unit: str = ""
    ) -> None:
        super().__init__(meaning, unit)
        self._expected = expected
        self._item = item
        self._count = count

    @property
    def expected(self) -> str:  # noqa: D102
        return self._expected

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        to_list = getattr(value, "tolist", None)  # a numpy array
        listed = to_list() if callable(to_list) else value
        if isinstance(listed, str | bytes) or not isinstance(listed, Sequence):
            return self.refuse(value, path, problems)
        if len(listed) != self._count:
            return self.refuse(
                value, path, problems, f"it has {len(listed)} of {self._count} values"
            )
        items = [self._item.read(item, f"{path}[{i}]", problems) for i, item in enumerate(listed)]
        return BAD if any(item is BAD for item in items) else tuple(items)


class Choice(Parameter):
    """One of a few words."""

    def __init__(self, options: Sequence[str], *, meaning: str = "") -> None:
        super().__init__(meaning)
        self._options = tuple(options)

    @property
    def expected(self) -> str:  # noqa: D102
        return "one of " + " ".join(show(option) for option in self._options)

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if isinstance(value, str) and value in self._options:
            return str(value)
        return self.refuse(value, path, problems)


class Flag(Parameter):
    """True or false."""

    silent = True

    @property
    def expected(self) -> str:  # noqa: D102
        return "true or false"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        # numpy's booleans are no bool, and 0 and 1 are numbers
        if not isinstance(value, bool) and type(value).__name__ not in ("bool", "bool_"):
            hint = "without quotes" if value in ("true", "false") else ""
            return self.refuse(value, path, problems, hint)
        return bool(value)


class Words(Parameter):
    """A list of different words, in any order, kept sorted."""

    @property
    def expected(self) -> str:  # noqa: D102
        return "a list of different words"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if not isinstance(value, list | tuple):
            return self.refuse(value, path, problems)
        if not all(isinstance(word, str) and word.isprintable() and word for word in value):
            return self.refuse(value, path, problems, "write each in quotes")
        if len(set(value)) < len(value):
            return self.refuse(value, path, problems, "one stands in it twice")
        return tuple(sorted(map(str, value)))


class Names(Words):
    """A list of different words that keeps its order, with one at least."""

    @property
    def expected(self) -> str:  # noqa: D102
        return "a list of one or more different names"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        listed = [value] if isinstance(value, str) else value
        if isinstance(listed, list | tuple) and not listed:
            return self.refuse(value, path, problems, "it is empty")
        known = super().read(listed, path, problems)
        return BAD if known is BAD else tuple(map(str, listed))  # type: ignore[call-overload]


class Numbers(Parameter):
    """A list of numbers of one kind, of any length, read as a tuple."""

    def __init__(self, expected: str, item: Parameter, *, meaning: str = "") -> None:
        super().__init__(meaning)
        self._expected = expected
        self._item = item

    @property
    def expected(self) -> str:  # noqa: D102
        return self._expected

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        to_list = getattr(value, "tolist", None)  # a numpy array
        listed = to_list() if callable(to_list) else value
        if isinstance(listed, str | bytes) or not isinstance(listed, Sequence):
            return self.refuse(value, path, problems)
        items = [self._item.read(item, f"{path}[{i}]", problems) for i, item in enumerate(listed)]
        return BAD if any(item is BAD for item in items) else tuple(items)


class Name(Parameter):
    """A name: one printable line of at most 64 characters, in Unicode normal form C.

    Slashes and a leading dot are refused because names become variables of the result file and
    parts of file names.
    """

    @property
    def expected(self) -> str:  # noqa: D102
        return f"a name of 1 to {NAME_LENGTH} printable characters"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if not isinstance(value, str):
            return self.refuse(value, path, problems, "write it in quotes")
        name = unicodedata.normalize("NFC", str(value))
        hint = ""
        if not name:
            hint = "it is empty"
        elif len(name) > NAME_LENGTH:
            hint = f"it has {len(name)} characters"
        elif not name.isprintable():
            hint = "it holds a control or unprintable character"
        elif name != name.strip():
            hint = "it begins or ends with a space"
        elif "/" in name or "\\" in name or name.startswith("."):
            hint = "slashes and a leading dot are refused, as names become parts of file names"
        return self.refuse(value, path, problems, hint) if hint else name


class Text(Parameter):
    """Free text without control characters other than tab and line breaks."""

    @property
    def expected(self) -> str:  # noqa: D102
        return "text"

    def read(self, value: object, path: str, problems: list[Problem]) -> Any:  # noqa: D102
        if not isinstance(value, str):
            return self.refuse(value, path, problems, "write it in quotes")
        # Cc: control, Cs: lone surrogates, which no file can hold.
        if any(unicodedata.category(c) in ("Cc", "Cs") and c not in "\t\n\r" for c in value):
            return self.refuse(value, path, problems, "it holds a control character")
        return str(value)


def about(value: Fraction) -> str:
    """Return a number, beyond the range of doubles too, as text with three digits."""
    return f"about {Decimal(value.numerator) / Decimal(value.denominator):.2e}"


def _not_a_number(value: object) -> str:
    if isinstance(value, bool):
        return "a boolean is not a number"
    if isinstance(value, str):
        return (
            "write the number without quotes" if _looks_numeric(value) else "text is not a number"
        )
    return ""


def _looks_numeric(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
