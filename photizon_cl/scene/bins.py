"""The bins of an irradiance map, as the element that has it declares them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from photizon_cl.scene.edges import azimuth_edges, even_edges

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

__all__ = ["MapAxis", "MapBins", "across", "azimuth", "polar_cosine"]


@dataclass(frozen=True, eq=False, kw_only=True)
class MapAxis:
    """One axis of a map.

    Parameters
    ----------
    name : str
        In arrays and files, for example ``cos_theta``.
    units : str
        ``m``, ``rad`` or ``1``.
    edges : ndarray, shape (n + 1,), float64
        Edges of the bins, ascending.
    symbol : str
        In figures and tables, for example ``cos θ``.
    text : str
        What it is, for a file's attributes.
    said : str
        What stands before a value in a sentence, for example ``cosine``.
    about : str
        What a figure adds to the symbol and the unit; may be empty.
    on_device : callable
        Gives the edges as the element's ``bin`` function in ``kernels/elements`` wants them.
    """

    name: str
    units: str
    edges: NDArray[np.float64]
    symbol: str
    text: str
    said: str
    about: str = ""
    on_device: Callable[[], list[float]]


@dataclass(frozen=True, eq=False, kw_only=True)
class MapBins:
    """The bins of a map.

    Parameters
    ----------
    x, y : MapAxis
        Along the columns and along the rows.
    area_of : callable
        Gives the exact areas, shape (ny, nx), in m²; 0 where a bin has none. Asked only once, and
        where areas are needed: a fine map's take time.
    rims : tuple of float
        Radii in metres of circles around the middle that bound what is mapped, for figures.
    """

    x: MapAxis
    y: MapAxis
    area_of: Callable[[], NDArray[np.float64]]
    rims: tuple[float, ...] = ()

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """Exact area of each bin in m², shape (ny, nx); 0 where it has none."""
        return self.area_of()


def across(name: str, half: float, n: int) -> MapAxis:
    """Return n equal bins from −half to half metres along a local axis, ``u`` or ``v``."""
    return MapAxis(
        name=name,
        units="m",
        edges=half * ((2 * np.arange(n + 1) - n) / n),
        symbol=name,
        text=f"local {name}",
        said=f"{name} =",
        on_device=partial(even_edges, -half, half, n),
    )


def azimuth(n: int) -> MapAxis:
    """Return n equal bins of the angle about the local axis, from u towards v.

    The device has the cosine and the sine of each edge.
    """
    return MapAxis(
        name="phi",
        units="rad",
        edges=2.0 * np.pi * np.arange(n + 1) / n,
        symbol="φ",
        text="azimuth about the axis, from u towards v",
        said="azimuth",
        about="about the axis from u towards v",
        on_device=partial(azimuth_edges, n),
    )


def polar_cosine(radius: float, n: int) -> MapAxis:
    """Return n equal bins of the cosine of the angle from the local axis, ascending from −1.

    The device has the height in metres on a ball of a radius.
    """
    return MapAxis(
        name="cos_theta",
        units="1",
        edges=(2 * np.arange(n + 1) - n) / n,
        symbol="cos θ",
        text="cosine of the angle from the axis",
        said="cosine",
        about="from the axis",
        on_device=partial(even_edges, -radius, radius, n),
    )
