"""A sequential trace of meridional rays through conic faces, in long doubles.

Written from the textbook (W. T. Welford, Aberrations of Optical Systems, § 4); shares nothing with
the product: transfer to each face by Newton's method on its sag, Snell's law there. Optiland 0.6.3
gives the same heights behind the doublet of tests/exact/test_lens.py to 3e-17 m (compared once).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

Long = np.longdouble
_STEPS: Final = 60


@dataclass(frozen=True)
class Surface:
    """A face of a system along z, light going up it.

    radius is positive where the centre of curvature is at larger z (the usual sign), infinite for a
    plane; index is what follows it.
    """

    vertex: float
    radius: float
    index: float
    conic: float = 0.0


def _sag(face: Surface, y: np.longdouble) -> tuple[np.longdouble, np.longdouble]:
    """Return a face's height over its vertex and its slope."""
    if np.isinf(face.radius):
        return Long(0), Long(0)
    c, kappa = 1 / Long(face.radius), 1 + Long(face.conic)
    root = np.sqrt(1 - kappa * c * c * y * y)
    return c * y * y / (1 + root), c * y / root


def meridional(
    faces: list[Surface], height: float, slope: float = 0.0, start: float = 0.0, index: float = 1.0
) -> tuple[np.longdouble, np.longdouble, np.longdouble, np.longdouble]:
    """Trace a ray from a height on the plane z = start; return y, z and direction at the end."""
    y, z = Long(height), Long(start)
    length = np.sqrt(1 + Long(slope) ** 2)
    dy, dz = Long(slope) / length, 1 / length
    before = Long(index)
    for face in faces:
        t = (Long(face.vertex) - z) / dz
        for _ in range(_STEPS):
            sag, rise = _sag(face, y + t * dy)
            t -= (z + t * dz - face.vertex - sag) / (dz - rise * dy)
        y, z = y + t * dy, z + t * dz
        _, rise = _sag(face, y)
        norm = np.sqrt(1 + rise * rise)
        ny, nz = rise / norm, -1 / norm  # against the light
        ratio = before / Long(face.index)
        cosine = -(dy * ny + dz * nz)
        after = np.sqrt(1 - ratio * ratio * (1 - cosine * cosine))
        dy, dz = (ratio * d + (ratio * cosine - after) * n for d, n in ((dy, ny), (dz, nz)))
        before = Long(face.index)
    return y, z, dy, dz
