"""What depends on wavelength as kernels have it: numbers by line, polynomials in pieces of bands.

Of single lines every number is tabulated as it is. A band is cut into pieces, at the nodes of
tables and finer where a formula asks for it, and in each a number is a polynomial of the place in
it, from 0 at its beginning to 1 at its end. What is linear there is taken as that, exactly at both
ends; all else is interpolated at six nodes and held to its own values between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError
from photizon_cl.scene.media.names import VACUUM
from photizon_cl.scene.spectral import curves_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from photizon_cl.scene.elements import Element
    from photizon_cl.scene.media.medium import Medium
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.surfaces import Surface

    Numbers = Callable[[float | None], Sequence[float]]
    """What some numbers are at a wavelength in nanometres; at None where there is none."""

__all__ = ["BOUND", "DEGREE", "MOST_NODES", "MOST_PIECES", "Grid", "Indices", "numbers_of"]

DEGREE: Final = 5
"""Of the polynomials in a piece of a band."""
BOUND: Final = 2.0**-43
"""How far a polynomial may be from what it stands for, over the larger of that and 1."""
MOST_PIECES: Final = 8192
"""Pieces that formulas may ask for, beside those that end where tables have a node."""
MOST_NODES: Final = 32768
"""Edges of bands and nodes of tables within them: three of the longest tables at least."""
_NODES: Final = (
    0.0, 0.0954915028125263, 0.3454915028125263, 0.6545084971874737, 0.9045084971874737, 1.0
)  # fmt: skip
"""(1 − cos(kπ/5))/2: where a smooth function is best interpolated, with both ends (Chebyshev)."""
_BETWEEN: Final = tuple(0.5 * (a + b) for a, b in pairwise(_NODES))


@dataclass(frozen=True)
class Grid:
    """The wavelengths at which a scene's numbers are tabulated.

    Parameters
    ----------
    samples : tuple of float or None
        Wavelengths in nanometres of lines, a single None without any; empty where there are bands.
    edges : tuple of float
        Edges of the pieces of bands, in nanometres, ascending.
    first : tuple of int
        Number of the first piece of each band, and behind them how many pieces there are.
    """

    samples: tuple[float | None, ...] = ()
    edges: tuple[float, ...] = ()
    first: tuple[int, ...] = ()

    @classmethod
    def of(cls, scene: Scene) -> Grid:
        """Return that of a scene.

        Raises
        ------
        ArgumentError
            Where something depends on wavelength so strongly that too many pieces would be needed,
            or tables have too many nodes.
        """
        spectrum = scene.spectrum
        if spectrum is None or spectrum.edges_nm is None:
            return cls(scene.wavelengths)
        bands, numbers = spectrum.edges_nm, _varying(scene)
        nodes = sorted({nm for nm in _nodes(scene) if bands[0] < nm < bands[-1]} | set(bands))
        if len(nodes) > MOST_NODES:
            raise _too_many(scene, len(nodes))
        edges, first, halved, begins = [nodes[0]], [], 0, set(bands)
        for a, b in pairwise(nodes):
            if a in begins:
                first.append(len(edges) - 1)
            for end in _pieces(numbers, a, b):
                edges.append(end)
                halved += end < b
                if halved >= MOST_PIECES:
                    raise ArgumentError(
                        f"spectrum: between {a:.9g} and {b:.9g} nm something changes so fast with "
                        f"wavelength that more than {MOST_PIECES} pieces would be needed: leave "
                        "out the surroundings of a resonance, or give lines"
                    )
        return cls((), tuple(edges), (*first, len(edges) - 1))

    @property
    def degree(self) -> int:
        """Of the polynomials: 0 of lines, which have numbers."""
        return DEGREE if self.edges else 0

    @property
    def n(self) -> int:
        """How many lines or pieces there are."""
        return len(self.samples) or len(self.edges) - 1

    @property
    def most(self) -> int:
        """Pieces of a band at most."""
        return max((b - a for a, b in pairwise(self.first)), default=1)

    def rows(self, numbers: Numbers) -> Iterator[tuple[float, ...]]:
        """Give the rows of some numbers: one of each line, those of its coefficients of a piece."""
        for nm in self.samples:
            yield tuple(numbers(nm))
        for a, b in pairwise(self.edges):
            columns = _fitted(numbers, a, b)[0]
            # what has no numbers has rows all the same, as places in the table are counted in them
            yield from zip(*columns, strict=True) if columns else ((),) * (self.degree + 1)


def _varying(scene: Scene) -> list[Numbers]:
    """Return the numbers of the surfaces that depend on wavelength by more than tables."""
    glasses = {medium.name for medium in scene.medium if medium.index is None}
    found: dict[Surface, Numbers] = {}
    indices = Indices(scene)
    for element in scene.element:
        for surface in element.surfaces:
            if surface.media is not None and glasses.intersection(surface.media):
                found[surface] = numbers_of(scene, surface, indices=indices)
    return list(found.values())


class Indices:
    """Refractive indices of a scene's media, each computed once at a wavelength."""

    def __init__(self, scene: Scene) -> None:
        self._media = {medium.name: medium for medium in scene.medium}
        self._known: dict[tuple[str, float | None], float] = {}

    def of(self, names: Iterable[str], nm: float | None) -> dict[str, float]:
        """Return those of some media by name, the vacuum's too, at a wavelength in nanometres."""
        found = {}
        for name in names:
            index = self._known.get((name, nm))
            if index is None:
                index = 1.0 if name == VACUUM else self._media[name].index_at(nm)
                self._known[name, nm] = index
            found[name] = index
        return found


def numbers_of(
    scene: Scene, surface: Surface, own: int = 0, *, indices: Indices | None = None
) -> Numbers:
    """Return what a surface's row has over wavelength, and behind it what its coating's has.

    Parameters
    ----------
    scene : Scene
        The scene.
    surface : Surface
        One of its surfaces.
    own : int
        Where in the row the coating's columns begin at least.
    indices : Indices, optional
        Of the scene, where several surfaces share what is known of its media.
    """
    known, media = indices or Indices(scene), surface.media or ()

    def numbers(nm: float | None) -> list[float]:
        optics = surface.among(known.of(media, nm)).at(nm)
        row, coat = optics.row.pack(optics.packed()), optics.coat
        if coat is None or optics.indices is None:
            return row
        blank = [0.0] * (own - len(row))
        return [*row, *blank, *coat.row.pack(coat.packed(optics.indices, nm))]

    return numbers


def _nodes(scene: Scene) -> Iterator[float]:
    """Give the wavelengths at which tables bend."""
    for _, nodes in _tables(scene):
        yield from nodes


def _tables(scene: Scene) -> Iterator[tuple[str, Sequence[float]]]:
    """Give what each table over wavelength is called, and its nodes."""
    things: tuple[Medium | Element, ...] = (*scene.medium, *scene.element)
    for thing in things:
        for path, table in curves_of(thing):
            yield f'{thing.label} "{thing.name}": {path}', getattr(table, "wavelength_nm", ())


def _too_many(scene: Scene, n: int) -> ArgumentError:
    """Return the refusal of tables that have too many nodes together, with the longest one."""
    name, nodes = max(_tables(scene), key=lambda table: len(table[1]))
    return ArgumentError(
        "spectrum: bands are cut at every node of a table, and their edges and those nodes come "
        f"to {n}, more than {MOST_NODES}: give tables fewer nodes, or the same ones, or give lines "
        f"(the longest one, of {name}, has {len(nodes)})"
    )


def _pieces(numbers: list[Numbers], a: float, b: float) -> Iterator[float]:
    """Give the ends of pieces of an interval in which all of some numbers are polynomials."""
    waiting = [(a, b)]
    while waiting:
        low, high = waiting.pop()
        middle = 0.5 * (low + high)
        if not low < middle < high or all(_fitted(each, low, high)[1] for each in numbers):
            yield high
        else:
            waiting += [(middle, high), (low, middle)]


def _fitted(numbers: Numbers, a: float, b: float) -> tuple[list[list[float]], bool]:
    """Return the coefficients of each number, and whether all are within `BOUND`."""
    at = [list(numbers(_place(a, b, t))) for t in _NODES]
    columns = [_coefficients(column) for column in zip(*at, strict=True)]
    if all(not any(c[1:]) for c in columns):
        return columns, True
    good = True
    for t in _BETWEEN:
        for value, c in zip(numbers(_place(a, b, t)), columns, strict=True):
            found = 0.0
            for coefficient in reversed(c):
                found = found * t + coefficient
            good &= abs(found - value) <= BOUND * max(1.0, abs(value))
    return columns, good


def _place(a: float, b: float, t: float) -> float:
    return b if t == 1.0 else a + t * (b - a)


def _coefficients(values: Sequence[float]) -> list[float]:
    """Return the coefficients of the polynomial through the values at the nodes, lowest first."""
    first = values[0]
    rise = [value - first for value in values]
    slack = 0.125 * BOUND * max(1.0, *map(abs, values))
    if all(abs(r - t * rise[-1]) <= slack for t, r in zip(_NODES, rise, strict=True)):
        return [first, rise[-1]] + [0.0] * (DEGREE - 1)
    return [
        first,
        *(math.fsum(w * r for w, r in zip(row, rise, strict=True)) for row in _weights()[1:]),
    ]


@cache
def _weights() -> tuple[tuple[float, ...], ...]:
    """Return the inverse of the nodes' Vandermonde matrix, each number rounded once."""
    n = DEGREE + 1
    nodes = [Fraction(t) for t in _NODES]
    columns = []
    for k in range(n):  # Lagrange's polynomials
        poly = [Fraction(1)]
        for j, t in enumerate(nodes):
            if j != k:
                scale = 1 / (nodes[k] - t)
                shifted = [Fraction(0), *poly]
                poly = [
                    scale * (s - t * p) for s, p in zip(shifted, [*poly, Fraction(0)], strict=True)
                ]
        columns.append(poly)
    return tuple(tuple(float(columns[k][j]) for k in range(n)) for j in range(n))
