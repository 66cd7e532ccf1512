"""How numbers stand on a page: digits that their error supports, typographic signs."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from markupsafe import Markup, escape

from photizon_cl.result.text import with_error

if TYPE_CHECKING:
    from photizon_cl.result.ledger import Estimate

__all__ = ["amount", "brief", "integer", "number", "pair", "percent", "plain_amount", "share"]

_EXPONENT: Final = re.compile(r"^(.*)e([+-]?)0*(\d+)$")
_UNKNOWN: Final = "–"


def number(text: str) -> Markup:
    """Return a number's text as markup, ``-1.5e-07`` as −1.5 × 10 with a raised −7."""
    found = _EXPONENT.match(text)
    if found is None:
        return escape(text.replace("-", "−"))
    mantissa, sign, power = found.groups()
    raised = ("−" if sign == "-" else "") + power
    return Markup("{} × 10<sup>{}</sup>").format(mantissa.replace("-", "−"), raised)


def pair(value: float, sigma: float | None) -> tuple[Markup, Markup]:
    """Return a value and its σ with the digits that σ supports; a dash where σ is not known."""
    text, error = with_error(value, sigma)
    return number(text), number(_UNKNOWN if sigma is None else error)


def brief(value: float, sigma: float | None, unit: str) -> Markup:
    """Return ``value ± σ unit`` for running text; without the σ where it is not known or 0."""
    text, error = pair(value, sigma)
    if not sigma:
        return Markup("{} {}").format(text, unit)
    if "<sup>" in text or "<sup>" in error:
        return Markup("({} ± {}) {}").format(text, error, unit)
    return Markup("{} ± {} {}").format(text, error, unit)


def amount(value: float, digits: int = 4) -> Markup:
    """Return a number with so many significant digits."""
    return number(f"{value:.{digits}g}")


def plain_amount(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits as plain text, for alternative texts."""
    return f"{value:.{digits}g}".replace("-", "−")


def percent(part: float | None, digits: int = 3) -> str:
    """Return a part of 1 in percent with so many significant digits."""
    return _UNKNOWN if part is None else f"{100.0 * part:.{digits}g} %".replace("-", "−")


def share(row: Estimate, whole: float) -> Markup:
    """Return a row's part of the whole in percent, with the digits that its σ supports."""
    scale = 100.0 / whole
    sigma = None if row.sigma is None else row.sigma * scale
    return Markup("{} %").format(pair(row.value * scale, sigma)[0])


def integer(value: int) -> str:
    """Return a whole number with its digits in threes."""
    return f"{value:,}"
