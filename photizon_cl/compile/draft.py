"""A scene under compilation: what effects ask, and the tables that they add to."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from hostcode.program.parts import TallyForm
from hostcode.program.precision import FP64
from photizon_cl.compile.grid import Grid
from photizon_cl.geometry.neighbours import Neighbours
from photizon_cl.geometry.placing import recentred
from photizon_cl.geometry.wedges import edge_factors

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np
    from numpy.typing import NDArray

    from hostcode.program.parts import ElementClass, Strides
    from hostcode.program.precision import Precision
    from photizon_cl.compile.layout import TallyLayout
    from photizon_cl.compile.rays import Beam
    from photizon_cl.scene.coatings import Coating
    from photizon_cl.scene.filters.base import Filter
    from photizon_cl.scene.frames import Vec3
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.scatters import Scatter
    from photizon_cl.scene.settings import RunSettings
    from photizon_cl.scene.surfaces import Surface

__all__ = ["Draft"]


@dataclass(eq=False)
class Draft:
    """A scene under compilation.

    Parameters
    ----------
    scene, settings
        What is compiled.
    layout : TallyLayout
        What the cells mean.
    shift : tuple of float
        Taken off every position, in metres.
    all_tilted : bool
        Whether every element is taken as turned off the axes.
    note_words : int
        Words of notes that a ray has at least, where it has any.
    weights_differ : bool
        Whether rays remember the weight with which they were launched.
    coincident : frozenset of int
        Numbers of the elements whose faces may lie in those of others.
    precision : Precision
        What the kernels compute in.
    materials : dict of Surface to int
        Where in the material table the row of each surface begins.
    surface_numbers : dict of str to int
        Number of each surface kind, by its kernel.
    scatters : tuple of type
        Classes of the scatter models that are compiled in, by name.
    coatings : tuple of type
        Classes of the coatings that are compiled in, by name.
    beams : tuple of Beam
        What each row of the source table is.
    grid : Grid
        By what numbers that depend on wavelength are tabulated.
    """

    scene: Scene
    settings: RunSettings
    layout: TallyLayout
    shift: Vec3
    all_tilted: bool = False
    note_words: int = 0
    weights_differ: bool = False
    coincident: frozenset[int] = frozenset()
    precision: Precision = FP64
    # the tables, filled in this order
    classes: tuple[ElementClass, ...] = ()
    strides: Strides | None = None
    geometry: NDArray[np.float64] | None = None
    element_codes: list[int] = field(default_factory=list)
    material_of: list[int] = field(default_factory=list)
    materials: dict[Surface, int] = field(default_factory=dict)
    surface_numbers: dict[str, int] = field(default_factory=dict)
    scatters: tuple[type[Scatter], ...] = ()
    coatings: tuple[type[Coating], ...] = ()
    beams: tuple[Beam, ...] = ()
    grid: Grid = field(default_factory=lambda: Grid((None,)))
    codes: list[int] = field(default_factory=list)
    detector_numbers: list[float] = field(default_factory=list)
    edges: list[float] = field(default_factory=list)
    launch: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def near(self) -> Neighbours:
        """Which elements are near each other."""
        placed = recentred(self.scene, self.shift, self.precision.roundoff)
        return Neighbours(placed.element, self.precision.roundoff)

    @cached_property
    def at_edges(self) -> NDArray[np.float64]:
        """Factors of the elements' rounding bounds at their edges, see `edge_factors`."""
        return edge_factors(self.near)

    @cached_property
    def forms(self) -> tuple[TallyForm, ...]:
        """The different forms of the detectors' tallies."""
        found = {self._form(t.filters) for d in self.layout.detectors for t in d.tallies}
        return tuple(sorted(found, key=lambda form: form.filters))

    def form_of(self, filters: tuple[Filter, ...]) -> int:
        """Return the number of a tally's form."""
        return self.forms.index(self._form(filters))

    @staticmethod
    def _form(filters: tuple[Filter, ...]) -> TallyForm:
        return TallyForm(tuple((f.kernel, f.option) for f in filters))

    def add_codes(self, values: Iterable[int]) -> int:
        """Add integers to the table of codes; return where they begin."""
        first = len(self.codes)
        self.codes += values
        return first

    def add_edges(self, values: Iterable[float]) -> int:
        """Add edges of bins; return where they begin."""
        first = len(self.edges)
        self.edges += values
        return first
