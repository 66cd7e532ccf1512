"""The detector that an element can carry where light ends on its surface or passes it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final

from photizon_cl.scene.declarations import choice, integer, integers, spectral_flag
from photizon_cl.scene.described import ABSENT, Accepts, Described
from photizon_cl.scene.filters.generation import Generation
from photizon_cl.scene.filters.wavelength import Wavelength

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photizon_cl.scene.elements.base import Element
    from photizon_cl.scene.filters.base import Filter
    from photizon_cl.scene.spectrum import Spectrum

SIDES: Final = ("front", "back", "inside", "outside")
MAX_BINS: Final = 8192
MAX_GENERATIONS: Final = 4096
MAX_PATHS: Final = 1_000_000
BY_WAVELENGTH: Final = " by wavelength"
"""How the names of tallies end that divide arrivals by wavelength besides."""


@dataclass(frozen=True, kw_only=True)
class Detector(Described):
    """A one-sided detector: total power, and on request an irradiance map and a generation ladder.

    It counts the arrivals on one side of an absorber, where they end, or of a surface that light
    passes. The ledger's absorbed row counts both sides whatever the detector does. ``Detector()``
    is a power bucket.

    Parameters
    ----------
    map : tuple of int, optional
        ``(nx, ny)`` bins of the irradiance map (W/m², power over the exact area of the bin), each
        1 … 8192: along u and v on a rectangle; along u and v over the bounding square on a disk;
        in φ from u towards v, and in cos θ about the axis on a sphere or along it on a cylinder.
    generations : int, optional
        G entries of the ladder, 1 … 4096. Entry g is the power (W) that arrived after g surface
        interactions; the last one collects g ≥ G − 1.
    paths : int, optional
        N, 1 … 10⁶: every arrival's sequence of faces and events is counted, and the path table
        keeps the N strongest and one row for the rest.
    wavelengths : bool
        Whether power, ladder and map are told for each line or band of the scene's
        ``[spectrum]`` too.
    side : str, optional
        ``"front"`` (arrivals against the normal) or ``"back"`` (along it) of a flat element,
        ``"inside"`` or ``"outside"`` of a curved one; None takes the element's default.
    """

    label: ClassVar[str] = "detector"
    kind: ClassVar[str] = "detector"
    kernel: ClassVar[str] = "detector"

    map: Accepts[Sequence[int] | None, tuple[int, int] | None] = field(
        default=ABSENT, metadata=integers(1, MAX_BINS, "[nx, ny]", "bins of the irradiance map")
    )
    generations: int | None = field(
        default=None, metadata=integer(1, MAX_GENERATIONS, "entries of the generation ladder")
    )
    paths: int | None = field(
        default=None, metadata=integer(1, MAX_PATHS, "rows of the path table")
    )
    wavelengths: bool = field(
        default=False,
        metadata=spectral_flag("whether all but the path table is told by wavelength too"),
    )
    side: str | None = field(default=None, metadata=choice(SIDES, "side that is counted"))

    def tallies(
        self, element: Element, spectrum: Spectrum | None = None
    ) -> list[tuple[str, tuple[Filter, ...]]]:
        """Return name and filters of each tally that it divides arrivals by on an element.

        What is told by wavelength, given the scene's `spectrum`, has a tally of its own beside the
        one over all: of the same filters and that of wavelength behind them.
        """
        found: list[tuple[str, tuple[Filter, ...]]] = []
        if self.generations is not None:
            found.append(("ladder", (Generation(self.generations),)))
        if self.map is not None:
            bins = element.map_bins(*self.map)
            found.append(("map", (bins.x, bins.y)))
        if self.wavelengths and spectrum is not None:
            by = Wavelength(spectrum.n)
            found += [(f"{name}{BY_WAVELENGTH}", (*filters, by)) for name, filters in found]
            found.append((f"power{BY_WAVELENGTH}", (by,)))
        return found
