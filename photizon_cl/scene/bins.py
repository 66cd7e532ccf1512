"""The bins of an irradiance map, as the element that has it declares them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from photizon_cl.scene.filters.base import Filter

__all__ = ["MapBins"]


@dataclass(frozen=True, eq=False, kw_only=True)
class MapBins:
    """The bins of a map.

    Parameters
    ----------
    x, y : Filter
        What divides arrivals along the columns and along the rows.
    area_of : callable
        Gives the exact areas, shape (ny, nx), in m²; 0 where a bin has none. Asked only once, and
        where areas are needed: a fine map's take time.
    rims : tuple of float
        Radii in metres of circles around the middle that bound what is mapped, for figures.
    """

    x: Filter
    y: Filter
    area_of: Callable[[], NDArray[np.float64]]
    rims: tuple[float, ...] = ()

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """Exact area of each bin in m², shape (ny, nx); 0 where it has none. For reading only."""
        areas = self.area_of().view()
        areas.flags.writeable = False  # equal ones may be one number in memory
        return areas
