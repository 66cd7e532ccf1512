"""What all coatings share."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple, Self

import numpy as np

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.device_kinds import DeviceKind
from photizon_cl.scene.rows import NO_ROW, Row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

__all__ = ["HEAD", "WHOLE", "Coating", "Meeting", "whole"]

WHOLE: Final = 1.0 - 2.0**-52
"""What two parts come to that leave nothing: 0.7 and 0.3 are rounded, and so is their sum."""


class Meeting(NamedTuple):
    """How rays meet a coated face: arrays of one shape, and the indices of the two sides.

    `sine` and `cosine` are those of the angle of incidence, `square` is cos² of the angle behind
    the face by Snell's law, negative beyond the critical angle.
    """

    sine: Array
    cosine: Array
    square: Array
    before: float
    behind: float
    inside: bool


@dataclass(frozen=True)
class Coating(DeviceKind):
    """What a border of two media reflects and lets pass, in place of Fresnel's formulas.

    Directions remain those of the law of reflection and of Snell's law. 1 − R − T is absorbed by
    the element; beyond the critical angle T is 0.
    """

    label: ClassVar[str] = "coating"
    kind: ClassVar[str] = ""
    row: ClassVar[Row] = NO_ROW
    """Columns in its surface's row of the material table, behind the surface's own."""
    polarises: ClassVar[bool] = False
    """Whether it does another thing to light along s than to light along p."""
    reads: ClassVar[Row] = NO_ROW
    """Numbers of each of its nodes, of one that has some."""

    @property
    @abstractmethod
    def lossless(self) -> bool:
        """Whether R + T is 1 at every angle and wavelength: then nothing is absorbed."""

    def at(self, nm: float | None) -> Self:
        """Return it with numbers in place of tables over wavelength."""
        return self

    def packed(self, indices: tuple[float, float], nm: float | None) -> dict[str, float]:
        """Return the values of its row's columns by name.

        Parameters
        ----------
        indices : tuple of float
            Refractive indices behind the surface's normal and on the other side.
        nm : float or None
            Wavelength in nanometres; None without a spectrum.
        """
        return {}

    @property
    def nodes(self) -> Sequence[Sequence[float]]:
        """What the kernel reads of each of its nodes or layers, of one that has some."""
        return ()

    def waves(self, nm: float) -> float:
        """Return how many wavelengths of its own light it is thick; 0 where that does not count."""
        return 0.0

    def idle(self, nm: float) -> tuple[str, float] | None:
        """Return path and thickness in nanometres of what of it is too thin to act; else None."""
        return None

    @abstractmethod
    def parts(self, met: Meeting, nm: float | None) -> tuple[Array, Array]:
        """Return reflectance and transmittance below the critical angle, and beyond it."""

    def powers(
        self,
        angle_deg: ArrayLike,
        index: float,
        index_outside: float = 1.0,
        *,
        nm: float | None = None,
        inside: bool = False,
    ) -> tuple[Array, Array]:
        """Return the reflectance and the transmittance for unpolarised light.

        Parameters
        ----------
        angle_deg : array_like
            Angle of incidence in degrees, from 0 to 90, in the medium that light comes from.
        index, index_outside : float
            Refractive indices behind the surface's normal and on the other side.
        nm : float, optional
            Wavelength in nanometres, where it depends on it.
        inside : bool, optional
            Whether light comes from behind the normal.

        Returns
        -------
        reflectance, transmittance : ndarray
            Of the shape of `angle_deg`; 1 less both is absorbed.

        Raises
        ------
        ArgumentError
            Where an angle is none, or there is no wavelength and it depends on that.
        """
        return self.at(nm).parts(meeting(angle_deg, index, index_outside, inside=inside), nm)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return derived quantities: name → (value, unit)."""
        return {}


def meeting(angle_deg: ArrayLike, index: float, index_outside: float, *, inside: bool) -> Meeting:
    """Return how rays meet a face, see `Coating.powers`."""
    try:
        angle = np.asarray(angle_deg, np.float64)
    except (TypeError, ValueError):
        angle = np.array(np.nan)
    if not ((angle >= 0.0) & (angle <= 90.0)).all():
        raise ArgumentError(
            f"angle_deg: found {show(angle_deg)}, expected angles in degrees, from 0 to 90"
        )
    if not (_is_index(index) and _is_index(index_outside)):
        found = show([index, index_outside])
        raise ArgumentError(f"index: found {found}, expected refractive indices, above 0")
    before, behind = (index, index_outside) if inside else (index_outside, index)
    # both ends exactly
    sine = np.where(angle == 90.0, 1.0, np.sin(np.radians(angle)))
    cosine = np.where(angle == 90.0, 0.0, np.cos(np.radians(angle)))
    ratio = before / behind
    straight = (behind - before) * (behind + before) / (behind * behind) + (ratio * cosine) ** 2
    square = np.where(ratio > 1.4, 1.0 - (ratio * sine) ** 2, straight)
    return Meeting(sine, cosine, square, before, behind, inside)


def _is_index(value: object) -> bool:
    return isinstance(value, Real) and 0.0 < float(value) < math.inf


def whole(reflectance: float, transmittance: float) -> bool:
    """Say whether two parts leave nothing to be absorbed, but for how they were rounded."""
    return reflectance + transmittance >= WHOLE


HEAD: Final = Row(
    "COATING",
    ("kind", "", "number of the kind in the program"),
    ("nodes", "", "where in the geometry table its nodes or layers stand"),
    ("count", "", "their number"),
)
"""What is told of every coating in the table of codes, in integers."""
