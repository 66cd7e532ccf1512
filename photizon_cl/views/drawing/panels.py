"""Where the sections of a scene stand on a page: to one scale, and filling the room they have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from photizon_cl.views.drawing.view import Box

    Place = tuple[float, float, float, float]
    """Left, bottom, width and height in inches."""

__all__ = ["Arrangement", "arrange"]

_LEFT: Final = 0.66  # of a panel, for its ticks and label
_TOP: Final = 0.27
_BOTTOM: Final = 0.46
_RIGHT: Final = 0.12
_LONGER: Final = 1.3
"""A scene so many times longer in z than across lies on its side, as on an optical bench."""
_CELL: Final = 1.5  # inches that a panel's title needs at least, with the gap behind it
_LAST: Final = 1.65  # and that of the last one, behind which there is none, and the key
_LONG: Final = 2.25  # and those of titles that say that a panel is not to scale
_ACROSS: Final = 0.13  # part of the width that the larger dimension across a long scene gets
_THIN: Final = 0.35  # and any dimension


@dataclass(frozen=True)
class Arrangement:
    """Three sections on a page, and what is left beside or below them.

    Parameters
    ----------
    views : tuple of (int, int)
        World axes of each panel: to the right and up.
    places : tuple of Place
        The panels' axes, from the lower left corner of all.
    rest : Place
        Room for a key or for a view in space.
    height : float
        Inches in all.
    lying : bool
        Whether z runs to the right.
    scales : tuple of float, of 3
        Inches on paper of a metre along x, y and z; one number three times, unless a dimension
        would be too thin to be read.
    """

    views: tuple[tuple[int, int], ...]
    places: tuple[Place, ...]
    rest: Place
    height: float
    lying: bool
    scales: tuple[float, float, float]

    @property
    def width(self) -> float:
        """Inches that panels and rest take."""
        left, _, last, _ = self.places[2]
        least = _LAST if self.to_scale(*self.views[2]) else _LONG
        return max(left + max(last, least), self.rest[0] + self.rest[2]) + _RIGHT

    def to_scale(self, h: int, v: int) -> bool:
        """Say whether a panel has one scale along both axes."""
        return abs(self.scales[h] / self.scales[v] - 1.0) < 1e-9


def arrange(box: Box, width: float, tallest: float, *, space: float = 0.0) -> Arrangement:
    """Arrange the sections of what a box shows.

    Parameters
    ----------
    box : Box
        What is shown.
    width, tallest : float
        Inches that there are.
    space : float, optional
        Inches that a view in space needs in both directions, beside the third section; with 0 the
        sections of a scene that does not lie stand in a row, and the rest is a strip below.
    """
    x, y, z = (float(d) for d in box.extent)
    lying = z > _LONGER * max(x, y)
    views = ((2, 0), (2, 1), (0, 1)) if lying else ((0, 2), (1, 2), (0, 1))
    row = not (lying or space)

    def made(scale: float) -> Arrangement:
        scales = _scales((x, y, z), scale, _ACROSS * width if lying else 0.0)
        sizes = [(box.extent[h] * scales[h], box.extent[v] * scales[v]) for h, v in views]
        place = _row if row else _corner
        places, rest, height = place([(float(w), float(h)) for w, h in sizes], width, space)
        return Arrangement(views, tuple(places), rest, height, lying, scales)

    def fits(scale: float) -> bool:
        found = made(scale)
        return found.width <= width and found.height <= tallest

    return made(_largest(fits, width / max(x, y, z)))


def _largest(fits: Callable[[float], bool], high: float) -> float:
    """Return the largest scale that fits, below one that does not."""
    low = 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low or high


def _scales(
    extent: tuple[float, float, float], scale: float, least: float
) -> tuple[float, float, float]:
    # Across a long scene there is one scale, so that its own section is true.
    across = max(scale, least / max(extent[:2]))
    x, y, z = (max(s, _THIN / d) for s, d in zip((across, across, scale), extent, strict=True))
    return x, y, z


def _row(
    sizes: list[tuple[float, float]], width: float, _: float
) -> tuple[list[Place], Place, float]:
    """Place three panels side by side, their tops in line, and a strip below them."""
    tallest = max(h for _, h in sizes)
    places, left = [], _LEFT
    for w, h in sizes:
        places.append((left, _BOTTOM + tallest - h, w, h))
        left += max(w, _CELL - 0.3) + _LEFT + _RIGHT
    return places, (_LEFT, 0.0, width - _LEFT - 2.0 * _RIGHT, 0.0), _BOTTOM + tallest + _TOP


def _corner(
    sizes: list[tuple[float, float]], _: float, space: float
) -> tuple[list[Place], Place, float]:
    """Place two panels in a column and the third beside the first, with the rest below it."""
    (w1, h1), (w2, h2), (w3, h3) = sizes
    first = max(h1, h3)
    second = max(h2, space - _BOTTOM - _TOP)
    low = _BOTTOM + second + _TOP + _BOTTOM
    column = _LEFT + max(w1, w2, _CELL) + _RIGHT + _LEFT
    places = [
        (_LEFT, low + first - h1, w1, h1),
        (_LEFT, _BOTTOM + second - h2, w2, h2),
        (column, low + first - h3, w3, h3),
    ]
    beside = max(w3, _LAST, space - _LEFT)
    # Below the third section, which may be less tall than the first.
    rest = (column, 0.0, beside, low + first - h3 - _BOTTOM)
    return places, rest, low + first + _TOP
