"""What of a scene and its paths a drawing shows: the box, the scale, and rays clipped to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.geometry.outlines import edges
from photizon_cl.result.paths import ENDINGS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.result.paths import Paths
    from photizon_cl.scene.model import Scene

__all__ = [
    "FAINTEST",
    "Box",
    "ShownRays",
    "bounding_box",
    "no_rays",
    "shown_rays",
]

FAINTEST: Final = 1e-6
"""Weight relative to the heaviest launched ray below which a segment is not drawn."""
_LEAVES: Final = 2.0**-40
"""Part of its length by which a segment that leaves may have been rounded."""
_MARGIN: Final = 0.07


@dataclass(frozen=True, eq=False)
class Box:
    """The part of space that is shown.

    Parameters
    ----------
    low, high : ndarray, shape (3,), float64
        Its corners in metres.
    centre : ndarray, shape (3,), float64
        Centre of the scene in metres; the sections go through it.
    scale : float
        Units of `unit` in a metre.
    unit : str
        Length with an SI prefix in which the scene has one to three digits.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    centre: NDArray[np.float64]
    scale: float
    unit: str

    @property
    def extent(self) -> NDArray[np.float64]:
        """Its edges in metres."""
        return np.asarray(self.high - self.low)


def bounding_box(scene: Scene) -> Box:
    """Return a box around every element and source, with a margin for what escapes."""
    solid = [line for element in scene.element for line in edges(element)]
    lamps = [line for source in scene.source for line in source.outline()]
    every = np.vstack(solid + lamps)
    body = np.vstack(solid or lamps)
    low, high = every.min(axis=0), every.max(axis=0)
    extent = high - low
    size = float(extent.max()) or 1.0
    # Room for what escapes; less across a scene that is long and thin, which it would drown.
    margin = np.where(extent > 0.04 * size, np.minimum(0.3 * extent, _MARGIN * size), 0.05 * size)
    units = ((1e-3, "km"), (1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
    scale, unit = next(((s, u) for s, u in units if size * s >= 1.0), units[-1])
    centre = 0.5 * (body.min(axis=0) + body.max(axis=0))
    return Box(low - margin, high + margin, centre, scale, unit)


@dataclass(frozen=True, eq=False)
class ShownRays:
    """Segments that are drawn, strongest last.

    Parameters
    ----------
    start, end : ndarray, shape (n, 3), float64
        In metres, clipped to the box.
    weight, generation : ndarray, shape (n,)
        See `photizon_cl.Paths`.
    faint : int
        Segments that are left out because they carry less than `FAINTEST`.
    """

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    weight: NDArray[np.float64]
    generation: NDArray[np.int64]
    faint: int


def no_rays() -> ShownRays:
    """Return no segments, for a scene that is drawn by itself."""
    none = np.empty((0, 3))
    return ShownRays(none, none, np.empty(0), np.empty(0, np.int64), 0)


def shown_rays(found: Paths, box: Box) -> ShownRays:
    """Return the segments to draw; those that meet nothing go on to the edge of the box."""
    start, end = found.start, found.end.copy()
    out = found.element < 0
    own = (end - start)[out]
    way = _way_out(start[out], own, box)
    # what is absorbed on its way to a face is drawn no further than to that; on its way out it is
    # as long as all that leave are
    length = np.linalg.norm(own, axis=1)
    ends = found.ending[out] == ENDINGS.index("absorbed")
    ends &= length < (1.0 - _LEAVES) * found.escape_length
    ends &= length < np.linalg.norm(way, axis=1)
    end[out] = start[out] + np.where(ends[:, np.newaxis], own, way)
    strong = found.weight >= FAINTEST
    order = np.flatnonzero(strong)[np.argsort(found.weight[strong], kind="stable")]
    return ShownRays(
        start[order],
        end[order],
        found.weight[order],
        found.generation[order],
        int(np.count_nonzero(~strong)),
    )


def _way_out(
    start: NDArray[np.float64], along: NDArray[np.float64], box: Box
) -> NDArray[np.float64]:
    """Return what leads from a point inside the box to its edge."""
    with np.errstate(divide="ignore", invalid="ignore"):
        to_faces = np.maximum((box.low - start) / along, (box.high - start) / along)
    steps = np.where(along != 0.0, to_faces, np.inf).min(axis=1, initial=np.inf)
    return np.asarray(along * np.maximum(steps, 0.0)[:, np.newaxis])
