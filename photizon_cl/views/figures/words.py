"""Words and numbers on figures: text that fits its room, and units with SI prefixes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath
from matplotlib.ticker import FuncFormatter

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["escaped", "fitted", "inches", "parts_of", "percent", "powered", "prefixed",
           "scaled", "wrapped"]  # fmt: skip


def escaped(text: str) -> str:
    """Return text that matplotlib shows as it is, dollar signs included."""
    return text.replace("$", r"\$")


def inches(text: str, size: float, weight: str = "normal") -> float:
    """Return how wide a line of text is."""
    font = FontProperties(family="DejaVu Sans", size=size, weight=weight)
    across = TextToPath().get_text_width_height_descent(text, font, ismath=False)[0]
    return 1.03 * float(across) / 72.0  # hinting on a screen makes text a little wider


def fitted(text: str, size: float, width: float, weight: str = "normal") -> str:
    """Return text cut so that it takes at most `width` inches on one line."""
    text = " ".join(text.split())
    if inches(text, size, weight) <= width:
        return text
    keep, cut = 0, len(text)
    while cut - keep > 1:
        middle = (keep + cut) // 2
        if inches(text[:middle] + "…", size, weight) <= width:
            keep = middle
        else:
            cut = middle
    return text[:keep].rstrip() + "…"


def wrapped(text: str, size: float, width: float, weight: str, most: int) -> list[str]:
    """Return text in at most `most` lines of at most `width` inches."""
    words = text.split()
    lines: list[str] = []
    while words and len(lines) < most - 1:
        n = len(words)
        while n > 1 and inches(" ".join(words[:n]), size, weight) > width:
            n -= 1
        lines.append(fitted(" ".join(words[:n]), size, width, weight))
        words = words[n:]
    return [*lines, fitted(" ".join(words), size, width, weight)] if words else lines


_PREFIXES: Final = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor and the unit in which `largest` has one to three digits.

    Parameters
    ----------
    largest : float
        In `unit`; where nothing fits, the unit itself is returned.
    unit : str
        An SI unit without a prefix.
    """
    if not 0.0 < largest < math.inf:
        return 1.0, unit
    # 0.9995 of a unit is still said in that unit, as axes that end there have round ticks.
    power = 3 * math.floor(math.log10(largest * 1.0005) / 3.0)
    if power not in _PREFIXES:
        return 1.0, unit
    return 10.0**-power, _PREFIXES[power] + unit


_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def powered(largest: float, unit: str) -> tuple[float, str]:
    """Return a power of 1000 and the unit behind it, so that `largest` is read easily.

    Powers and what is made of them stay in one unit on every figure and table of a page, whatever
    their size; lengths have prefixes instead, see `prefixed`.

    Parameters
    ----------
    largest : float
        In `unit`; from 0.01 to below 10⁴, and where it is no number, the factor is 1.
    unit : str
        An SI unit without a prefix.
    """
    if not 0.0 < largest < math.inf or 0.0099995 <= largest < 9999.5:
        return 1.0, unit
    power = 3 * math.floor(math.log10(largest * 1.0005) / 3.0)
    if not -300 < power < 300:
        return 1.0, unit
    return 10.0**-power, f"10{str(power).translate(_RAISED)} {unit}"


def scaled(factor: float) -> FuncFormatter:
    """Return a formatter that multiplies ticks, so that what is plotted stays in SI units."""
    return FuncFormatter(lambda value, _: f"{value * factor:.6g}".replace("-", "−"))


def parts_of(whole: float) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Return what a second axis in parts of a whole is made with: there and back."""
    return (lambda x: x / whole), (lambda x: x * whole)


def percent(part: float) -> str:
    """Return a relative standard error in percent, with three digits."""
    return f"{100.0 * part:.3g} %"
