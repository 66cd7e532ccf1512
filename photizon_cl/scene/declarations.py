"""How description classes declare their parameters: each function returns a field's metadata.

What a value must be, and how it is read, is in `photizon_cl.scene.parameters`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.scene.frames import AXES
from photizon_cl.scene.parameters import (
    LARGEST,
    METADATA_KEY,
    SMALLEST,
    Array,
    Choice,
    Flag,
    Integer,
    Name,
    Names,
    Number,
    NumberOrWord,
    Numbers,
    Parameter,
    SignedRadius,
    Text,
    Words,
)

if TYPE_CHECKING:
    from collections.abc import Sequence


def declare(parameter: Parameter) -> dict[str, Parameter]:
    """Return the field metadata that declares `parameter`."""
    return {METADATA_KEY: parameter}


def positive_length(meaning: str) -> dict[str, Parameter]:
    """Declare a positive length in metres."""
    text = "a positive length in metres, from 1e-150 to 1e150"
    return declare(Number(text, SMALLEST, LARGEST, meaning=meaning, unit="m"))


def signed_radius(meaning: str) -> dict[str, Parameter]:
    """Declare a radius of curvature in metres, of either sign or infinite."""
    return declare(SignedRadius(meaning, "m"))


def positive_power(meaning: str) -> dict[str, Parameter]:
    """Declare a positive power in watts."""
    text = "a positive power in watts, from 1e-150 to 1e150"
    return declare(Number(text, SMALLEST, LARGEST, meaning=meaning, unit="W"))


def positive_number(meaning: str) -> dict[str, Parameter]:
    """Declare a positive pure number."""
    text = "a positive number, from 1e-150 to 1e150"
    return declare(Number(text, SMALLEST, LARGEST, meaning=meaning))


def fraction(meaning: str, hint: str = "") -> dict[str, Parameter]:
    """Declare a number in [0, 1]."""
    return declare(Number("a number in [0, 1]", 0.0, 1.0, meaning=meaning, hint=hint))


def fractions(each: str, meaning: str) -> dict[str, Parameter]:
    """Declare a list of numbers from 0 to 1, one for each of what ``each`` names."""
    item = Number("a number in [0, 1]", 0.0, 1.0)
    return declare(
        Numbers(f"a list of numbers in [0, 1], one for each {each}", item, meaning=meaning)
    )


def fraction_or(word: str, meaning: str, hint: str = "") -> dict[str, Parameter]:
    """Declare a number in [0, 1], or a word."""
    return declare(NumberOrWord(word, "a number in [0, 1]", 0.0, 1.0, meaning=meaning, hint=hint))


def refractive_index(meaning: str) -> dict[str, Parameter]:
    """Declare a refractive index, 0.001 to 1000."""
    text = "a refractive index, a number from 0.001 to 1000"
    return declare(Number(text, 1e-3, 1e3, meaning=meaning))


def number(
    expected: str,
    low: float,
    high: float,
    meaning: str,
    unit: str = "",
    *,
    open_low: bool = False,
    open_high: bool = False,
) -> dict[str, Parameter]:
    """Declare a number in an interval; ``open_low`` and ``open_high`` leave an end out."""
    return declare(
        Number(
            expected, low, high, open_low=open_low, open_high=open_high, meaning=meaning, unit=unit
        )
    )


def integer(low: int, high: int, meaning: str, high_text: str = "") -> dict[str, Parameter]:
    """Declare an integer in a closed range."""
    return declare(Integer(low, high, high_text, meaning=meaning))


def integers(low: int, high: int, names: str, meaning: str) -> dict[str, Parameter]:
    """Declare a pair of integers, each in a closed range."""
    text = f"two integers {names}, each from {low} to {high}"
    return declare(Array(text, Integer(low, high), 2, meaning=meaning))


def point(meaning: str) -> dict[str, Parameter]:
    """Declare a point in the world, in metres."""
    item = Number("a coordinate in metres, from -1e150 to 1e150", -LARGEST, LARGEST)
    return declare(
        Array("three coordinates [x, y, z] in metres", item, 3, meaning=meaning, unit="m")
    )


def tilt() -> dict[str, Parameter]:
    """Declare the two tilt angles, in degrees."""
    item = Number("an angle in degrees, from -360 to 360", -360.0, 360.0)
    text = "two angles [a, b] in degrees"
    return declare(Array(text, item, 2, meaning="turns about the untilted u, then v", unit="deg"))


def signed_axis(meaning: str) -> dict[str, Parameter]:
    """Declare one of the six signed coordinate axes."""
    return declare(Choice(AXES, meaning=meaning))


def choice(options: Sequence[str], meaning: str) -> dict[str, Parameter]:
    """Declare one of a few words."""
    return declare(Choice(options, meaning=meaning))


def flag(meaning: str) -> dict[str, Parameter]:
    """Declare true or false."""
    return declare(Flag(meaning))


def spectral_flag(meaning: str) -> dict[str, Parameter]:
    """Declare true or false, where true needs the scene's ``[spectrum]``."""
    parameter = Flag(meaning)
    parameter.needs_spectrum = True
    return declare(parameter)


def words(meaning: str) -> dict[str, Parameter]:
    """Declare a list of different words."""
    return declare(Words(meaning))


def names(meaning: str) -> dict[str, Parameter]:
    """Declare a list of different names, in an order that matters."""
    return declare(Names(meaning))


def shares(meaning: str) -> dict[str, Parameter]:
    """Declare a list of positive numbers of which only the ratios count."""
    item = Number("a positive number, from 1e-9 to 1e9", 1e-9, 1e9)
    return declare(Numbers("a list of positive numbers, one for each name", item, meaning=meaning))


def unique_name(meaning: str) -> dict[str, Parameter]:
    """Declare a name."""
    return declare(Name(meaning))


def free_text(meaning: str) -> dict[str, Parameter]:
    """Declare free text."""
    return declare(Text(meaning))
