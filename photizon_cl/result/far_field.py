"""What the far field shows: intensity by direction, with errors and counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from photizon_cl.result.maps import closed
from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.scene.frames import direction_words, sincos_deg

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.scene.far_field import FarField

__all__ = ["FarFieldResult", "far_field_summary"]


@dataclass(frozen=True, eq=False, repr=False)
class FarFieldResult:
    """What escaped, by direction. Columns ascend in φ from 0.

    Rows ascend in cos θ from −1, or, where `bins` has edges in θ, in θ.

    Parameters
    ----------
    intensity : ndarray, shape (rows, n_phi), float64
        W/sr: power of the bin over its solid angle.
    sigma : ndarray, shape (rows, n_phi), float64
        Standard error of the intensity in W/sr; NaN with a single batch.
    count : ndarray, shape (rows, n_phi), int64
        Rays.
    solid_angle : float or ndarray, shape (rows, 1)
        Of every bin, in sr; where rows are bins in θ, of those of each row. Intensity times it is
        power.
    mu_edges, theta_edges : ndarray, shape (rows + 1,)
        Edges of the rows: cos θ, and θ in radians.
    phi_edges : ndarray, shape (n_phi + 1,)
        Edges of the columns: φ in radians.
    bins : FarField
        What the bins are.
    """

    intensity: NDArray[np.float64]
    sigma: NDArray[np.float64]
    count: NDArray[np.int64]
    solid_angle: float | NDArray[np.float64]
    mu_edges: NDArray[np.float64]
    theta_edges: NDArray[np.float64]
    phi_edges: NDArray[np.float64]
    bins: FarField

    def __repr__(self) -> str:
        lit = self.intensity[~self.hatched]
        shown = f"{lit.min():.4g} … {lit.max():.4g} W/sr over " if lit.size else ""
        rows, columns = self.count.shape
        return f"<FarFieldResult {rows} × {columns}: {shown}{lit.size} lit bins>"

    @property
    def hatched(self) -> NDArray[np.bool_]:
        """Bins with fewer than 10 rays, shape (rows, n_phi)."""
        return self.count < LIT_COUNT

    @property
    def by_theta(self) -> bool:
        """Whether rows ascend in θ; else in cos θ."""
        return self.bins.by_theta

    @property
    def whole(self) -> bool:
        """Whether every direction is in a bin; else what leaves outside them is only escaped."""
        return self.bins.whole

    @property
    def axis_words(self) -> tuple[str, str, str]:
        """Directions between which φ runs, and the one from which θ does, as people write them."""
        world = "world " if not any(self.bins.tilt_deg) else ""
        u, v, axis = (f"{world}{direction_words(row)}" for row in self.bins.frame)
        return u, v, axis

    @property
    def power(self) -> float:
        """Power in all bins, in watts."""
        return float((self.intensity * self.solid_angle).sum())

    @property
    def median_sigma(self) -> float | None:
        """Median relative standard error of the lit bins; None with a single batch or none lit."""
        lit = ~self.hatched
        if not lit.any() or np.isnan(self.sigma).all():
            return None
        return float(np.median(self.sigma[lit] / self.intensity[lit]))

    def curve(self) -> list[dict[str, Any]]:
        """Return the rows of the first column as the summary holds them."""
        known = not np.isnan(self.sigma).any()
        edges, sigma = self.bins.edges_deg, self.sigma[:, 0]
        return [
            {
                "theta_deg": [edges[j], edges[j + 1]],
                "value": float(self.intensity[j, 0]),
                "sigma": float(sigma[j]) if known else None,
                "count": int(self.count[j, 0]),
            }
            for j in range(len(sigma))
        ]

    @classmethod
    def of(cls, compiled: CompiledScene, tally: Accumulator, bins: FarField) -> FarFieldResult:
        """Return the far field after the batches of `tally`."""
        first = compiled.layout.far_field
        rows, n_phi = shape = bins.rows, bins.n_phi
        n = rows * n_phi
        each = np.array(bins.solid_angles)[:, np.newaxis]
        solid = each if bins.by_theta else bins.solid_angles[0]
        intensity = tally.mean(first, n).reshape(shape)
        sigma = tally.standard_error(first, n).reshape(shape)
        for values in (intensity, sigma):  # in place: they may take half a gigabyte each
            values *= compiled.unit_power / solid
        count = tally.counts(first, n).reshape(shape).copy()
        if bins.by_theta:
            mu = np.array([sincos_deg(angle)[1] for angle in bins.edges_deg])
            theta = np.radians(bins.edges_deg)
        else:
            mu = (2 * np.arange(rows + 1) - rows) / rows
            theta = np.arccos(mu)
        closed(intensity, sigma, count, each)
        phi = 2.0 * np.pi * np.arange(n_phi + 1) / n_phi
        return cls(intensity, sigma, count, solid, mu, theta, phi, bins)


def far_field_summary(result: Estimates) -> dict[str, Any]:
    """Return what the summary says of the far field; nothing where there is none.

    Where it is one curve over θ this has its rows; other bins are in the file.
    """
    bins = result.scene.far_field
    if bins is None:
        return {}
    rows = {"n_theta" if bins.by_theta else "n_mu": bins.rows, "n_phi": bins.n_phi}
    said: dict[str, Any] = {**rows, "hatched_below": LIT_COUNT}
    if bins.by_theta and bins.n_phi == 1 and result.far_field is not None:
        said["intensity"] = result.far_field.curve()
    return {"far_field": said}
