"""What all scatter models share."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from photizon_cl.errors import Problem, SceneError, show
from photizon_cl.scene.described import Known, parameters_of
from photizon_cl.scene.device_kinds import DeviceKind
from photizon_cl.scene.rows import Row
from photizon_cl.scene.scatters.total import Pieces, greatest, pieces_of, total_at

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from photizon_cl.scene.scatters.total import Array

__all__ = ["HEAD", "NARROWEST", "ROUNDING", "Scatter", "scatter_problems"]

NARROWEST: Final = 1e-9
"""Width of a lobe at least, in direction cosines: unit directions are told apart to 1e-16."""
ROUNDING: Final = 1e-8
"""How far a TIS may be from the integral, in parts of the greatest one: not refused for that."""


@dataclass(frozen=True)
class Scatter(DeviceKind):
    """What a surface scatters about the specular ray: a BSDF in 1/sr of Δ = |β − β₀|.

    β and β₀ are the projections of the unit directions of the scattered and of the specular ray on
    the surface's tangent plane. The total integrated scatter TIS(θ) = ∫ BSDF cos θ_s dΩ is that
    over the hemisphere, ∫∫ BSDF d²β over |β| ≤ 1; nothing is normalised anew where a part of the
    lobe lies beyond the horizon.
    """

    label: ClassVar[str] = "scatter"
    kind: ClassVar[str] = ""
    row: ClassVar[Row]
    """Columns of its row, in the geometry table."""

    @abstractmethod
    def bsdf_of(self, delta: Array) -> Array:
        """Return the BSDF in 1/sr of an array of Δ > 0, the same bits on every machine."""

    @property
    @abstractmethod
    def width(self) -> float:
        """Δ within which it may be taken as constant up to a factor of a few."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Values of Δ where it is not smooth, ascending."""
        return ()

    @property
    def sharpness(self) -> int:
        """Pieces of an octave of Δ in each of which it is smooth."""
        return 4

    @property
    def falls(self) -> bool:
        """Whether it nowhere grows with Δ: then TIS is greatest at normal incidence."""
        return True

    def within(self, radius: Array) -> Array | None:
        """Return ∫ BSDF(s) s ds from 0 to a radius, where there is a closed form."""
        return None

    @abstractmethod
    def packed(self) -> dict[str, float]:
        """Return the values of its row's columns by name."""

    @property
    def nodes(self) -> list[list[float]]:
        """What the kernel reads of each of its nodes, of one that has some."""
        return []

    def refusal(self) -> str:
        """Say why it cannot be sampled; empty where it can."""
        return ""

    def bsdf(self, delta: ArrayLike) -> NDArray[np.float64]:
        """Return the BSDF in 1/sr.

        Parameters
        ----------
        delta : array_like
            Δ = |β − β₀|, from 0 to 2.
        """
        tiny = 2.0**-500
        return self.bsdf_of(np.maximum(np.asarray(delta, np.float64), tiny))

    def total(self, angle_deg: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the total integrated scatter TIS(θ), by the table that the kernels read.

        Parameters
        ----------
        angle_deg : array_like
            Angle of the specular ray from the normal in degrees, 0 to 90.

        Notes
        -----
        Within 1e-8 of the greatest TIS.
        """
        cosine = np.cos(np.radians(np.asarray(angle_deg, np.float64)))
        sine = np.sin(np.radians(np.asarray(angle_deg, np.float64)))
        return self.pieces(np.clip(cosine * cosine / (1.0 + sine), 0.0, 1.0))

    @property
    def pieces(self) -> Pieces:
        """TIS as a function of 1 − |β₀|, in pieces that are polynomials."""
        return pieces_of(self)

    def greatest_tis(self) -> tuple[float, float]:
        """Return the greatest TIS, and the angle in degrees at which it is found."""
        return _greatest(self)

    def derived(self) -> dict[str, tuple[float, str]]:
        """Return the TIS at normal incidence and towards grazing."""
        at = self.total([0.0, 60.0])
        return {
            "TIS at normal incidence": (float(at[0]), ""),
            "TIS at 60 deg": (float(at[1]), ""),
        }


@lru_cache(maxsize=256)
def _greatest(model: Scatter) -> tuple[float, float]:
    """Return what `greatest_tis` does; scenes that are changed are checked anew."""
    if model.falls:
        return float(total_at(model, np.array([1.0]))[0]), 0.0
    return greatest(model)


HEAD: Final = Row(
    "SCATTER",
    ("model", "", "number of the model in the program"),
    ("row", "", "where in the geometry table its row stands"),
    ("pieces", "", "number of the pieces of TIS(1 − |β₀|)"),
    ("edges", "", "where in the geometry table their lower edges stand"),
    ("term_place", "", "where there what each is made of stands"),
    ("nodes", "", "where there its nodes stand, of one that has some"),
    ("node_count", "", "their number"),
)
"""What is told of every lobe in the table of codes, in integers."""


def scatter_problems(known: Known, most: float, limit: str, why: str) -> list[Problem]:
    """Return the problems of a surface's scatter with what may leave it.

    Parameters
    ----------
    known : Known
        The surface.
    most : float
        What may scatter at most, at any angle.
    limit : str
        That, in words: "the reflectance, 0.9".
    why : str
        What would be wrong with more.
    """
    found = known.get("scatter")
    if not isinstance(found, Known) or not issubclass(found.cls, Scatter) or not found.kind:
        return []
    names = parameters_of(found.cls)
    if not found.values.keys() >= names.keys():
        return []
    try:
        made = found.cls(**{name: found.get(name) for name in names})
    except SceneError:  # told already
        return []
    refused = made.refusal()
    if refused:
        what = "a BSDF that falls with Δ, or grows slowly"
        return [Problem("scatter", show(made.to_table()), what, hint=refused)]
    tis, angle = made.greatest_tis()
    if tis <= most * (1.0 + ROUNDING):
        return []
    value = f"a TIS of {tis:.6g} at {angle:.3g} deg"
    return [Problem("scatter", value, f"at most {limit}", hint=why)]
