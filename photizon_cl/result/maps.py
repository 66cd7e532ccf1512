"""What detectors show: arrays in physical units with errors and counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from photizon_cl.result.ledger import Estimate, watts
from photizon_cl.result.path_table import PathTable
from photizon_cl.result.statistics import LIT_COUNT, known_part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import DetectorCells
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.result.trails import Trails
    from photizon_cl.scene.bins import MapBins

__all__ = ["DetectorResult", "IrradianceMap", "Rung", "closed"]


class Rung(Estimate):
    """One entry of a power-per-generation ladder.

    Parameters
    ----------
    generation : int
        Surface interactions before the arrival; the last entry collects all higher ones.
    value, sigma : float, float or None
        Power and its standard error in watts.
    count : int
        Arrivals.
    """

    __slots__ = ("_generation",)
    _generation: int

    def __new__(
        cls,
        generation: int,
        value: float,
        sigma: float | None,
        count: int,
        by_wavelength: Sequence[Estimate] = (),
    ) -> Self:
        """Make an entry."""
        made = super().__new__(cls, value, sigma, count, by_wavelength)
        made._generation = generation
        return made

    @property
    def generation(self) -> int:
        """Surface interactions before the arrival."""
        return self._generation

    @property
    def count(self) -> int:
        """Arrivals."""
        return self._count or 0

    def summary(self) -> dict[str, Any]:
        """Return the entry as the summary holds it."""
        return {"generation": self.generation, **super().summary()}

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self._generation, *super().__getnewargs__()

    def __repr__(self) -> str:
        return f"Rung(generation={self.generation}, {super().__repr__()[5:]}"


@dataclass(frozen=True, eq=False, repr=False)
class IrradianceMap:
    """An irradiance map. Rows ascend in v (or cos θ, or w), columns in u (or φ).

    Parameters
    ----------
    irradiance : ndarray, shape (ny, nx), float64
        W/m²: power of the bin over its exact area; NaN where the bin has none, infinite where it
        leaves the range of doubles.
    sigma : ndarray, shape (ny, nx), float64
        Standard error of the irradiance in W/m²; NaN with a single batch and where masked.
    count : ndarray, shape (ny, nx), int64
        Arrivals.
    area : ndarray, shape (ny, nx), float64
        m²; 0 where the bin lies wholly outside a disk or in a sphere's port; on a cylinder the same
        for all bins. For reading only, as equal areas are one number in memory: ``area.copy()``
        gives an array to be changed.
    bins : MapBins
        What the bins are.
    by_wavelength : tuple of IrradianceMap
        The same of each line or band of the spectrum; empty where that is not told.
    """

    irradiance: NDArray[np.float64]
    sigma: NDArray[np.float64]
    count: NDArray[np.int64]
    area: NDArray[np.float64]
    bins: MapBins
    by_wavelength: tuple[IrradianceMap, ...] = ()

    def __repr__(self) -> str:
        lit = self.irradiance[self.lit]
        shown = f"{lit.min():.4g} … {lit.max():.4g} W/m² over " if lit.size else ""
        ny, nx = self.count.shape
        return f"<IrradianceMap {nx} × {ny}: {shown}{lit.size} lit bins>"

    @property
    def x_edges(self) -> NDArray[np.float64]:
        """Edges of the columns, shape (nx + 1,): u in metres, or φ in radians."""
        return self.bins.x.axis.edges

    @property
    def y_edges(self) -> NDArray[np.float64]:
        """Edges of the rows, shape (ny + 1,): v in metres, cos θ, or w in metres on a cylinder."""
        return self.bins.y.axis.edges

    @property
    def x_name(self) -> str:
        """What the columns run in, ``u`` or ``phi``."""
        return self.bins.x.axis.name

    @property
    def y_name(self) -> str:
        """What the rows run in, ``v``, ``cos_theta``, or ``w`` on a cylinder."""
        return self.bins.y.axis.name

    @property
    def x_units(self) -> str:
        """Unit of the columns' edges: ``m``, ``rad`` or ``1``."""
        return self.bins.x.axis.units

    @property
    def y_units(self) -> str:
        """Unit of the rows' edges: ``m``, ``rad`` or ``1``."""
        return self.bins.y.axis.units

    @property
    def masked(self) -> NDArray[np.bool_]:
        """Bins without any area, shape (ny, nx)."""
        return np.equal(self.area, 0.0)

    @property
    def hatched(self) -> NDArray[np.bool_]:
        """Bins with fewer than 10 arrivals, shape (ny, nx): values are there, with poor errors."""
        return (self.count < LIT_COUNT) & ~self.masked

    @property
    def lit(self) -> NDArray[np.bool_]:
        """Bins with at least 10 arrivals, shape (ny, nx)."""
        return (self.count >= LIT_COUNT) & ~self.masked

    @property
    def lit_fraction(self) -> float:
        """Part of the bins with an area that have at least 10 arrivals."""
        return float(self.lit.sum() / max((~self.masked).sum(), 1))

    @property
    def known_fraction(self) -> float:
        """Part of the bins that rays reach that have 10 arrivals; 1 where none is reached."""
        return known_part(self.count[~self.masked])

    @property
    def slivers(self) -> NDArray[np.bool_]:
        """Bins of less than three quarters of the largest one's area, shape (ny, nx).

        A rim or a port cuts them. Their values are right, and scatter more than those of whole
        bins: extremes and scales of colour are taken from the others.
        """
        small = self.area < 0.75 * self.area.max(initial=0.0)
        return np.asarray(~self.masked & small)

    @property
    def decisive(self) -> NDArray[np.bool_]:
        """Bins that extremes are taken from, shape (ny, nx): lit, slivers only if no other is."""
        whole = self.lit & ~self.slivers
        return whole if whole.any() else self.lit

    @property
    def median_sigma(self) -> float | None:
        """Median relative standard error of the lit bins; None with a single batch or none lit."""
        lit = self.lit
        if not lit.any() or np.isnan(self.sigma[lit]).any():
            return None
        return float(np.median(self.sigma[lit] / self.irradiance[lit]))

    def summary(self) -> dict[str, Any]:
        """Return what the summary says of the map."""
        ny, nx = self.count.shape
        return {"nx": nx, "ny": ny, "hatched_below": LIT_COUNT}

    @classmethod
    def of(cls, compiled: CompiledScene, tally: Accumulator, d: DetectorCells) -> IrradianceMap:
        """Return the map of a detector that has one."""
        bins = compiled.scene.element[d.element].map_bins(d.nx, d.ny)
        lines = tuple(
            cls._of(compiled, tally, d, d.by_wavelength("map", k), bins)
            for k in range(d.wavelengths)
        )
        return cls._of(compiled, tally, d, d.map, bins, lines)

    @classmethod
    def _of(
        cls,
        compiled: CompiledScene,
        tally: Accumulator,
        d: DetectorCells,
        first: int,
        bins: MapBins,
        by_wavelength: tuple[IrradianceMap, ...] = (),
    ) -> IrradianceMap:
        """Return the map whose cells begin at one of the tally's."""
        shape = (d.ny, d.nx)
        n = d.nx * d.ny
        area = bins.areas
        none = np.equal(area, 0.0)
        irradiance = tally.mean(first, n).reshape(shape)
        sigma = tally.standard_error(first, n).reshape(shape)
        # the largest power on the least bin is infinite, and where there is no area it is nothing
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            for values in (irradiance, sigma):  # in place: they may take half a gigabyte each
                values *= compiled.unit_power
                values /= area
                values[none] = np.nan
        count = tally.counts(first, n).reshape(shape).copy()
        closed(irradiance, sigma, count)
        return cls(irradiance, sigma, count, area, bins, by_wavelength)


def closed(*arrays: NDArray[Any]) -> None:
    """Let nobody write into what a result says: its files and digests would say something else."""
    for array in arrays:
        array.flags.writeable = False


@dataclass(frozen=True, eq=False, repr=False)
class DetectorResult:
    """What a detector shows.

    Parameters
    ----------
    power : Estimate
        W, with the count of arrivals.
    ladder : tuple of Rung or None
        Power per generation, where asked for.
    map : IrradianceMap or None
        Where asked for.
    paths : PathTable or None
        Where asked for.
    """

    power: Estimate
    ladder: tuple[Rung, ...] | None
    map: IrradianceMap | None
    paths: PathTable | None = None

    def __repr__(self) -> str:
        parts = [f"{self.power} W", f"{self.power.count} arrivals"]
        if self.by_wavelength:
            parts.append(f"{len(self.by_wavelength)} wavelengths")
        if self.ladder is not None:
            parts.append(f"{len(self.ladder)} generations")
        if self.map is not None:
            parts.append(f"map {self.map.count.shape[1]} × {self.map.count.shape[0]}")
        if self.paths is not None:
            parts.append(f"{len(self.paths)} paths")
        return f"<DetectorResult {', '.join(parts)}>"

    @property
    def by_wavelength(self) -> tuple[Estimate, ...]:
        """Its power of each line or band, in W; empty where the scene does not keep them apart."""
        return self.power.by_wavelength

    def summary(self) -> dict[str, Any]:
        """Return what the summary says of the detector."""
        out: dict[str, Any] = {"power": self.power.summary()}
        if self.ladder is not None:
            out["ladder"] = [rung.summary() for rung in self.ladder]
        if self.map is not None:
            out["map"] = self.map.summary()
        if self.paths is not None:
            out["paths"] = self.paths.summary()
        return out

    @classmethod
    def of(
        cls,
        compiled: CompiledScene,
        tally: Accumulator,
        d: DetectorCells,
        number: int,
        trails: Trails | None,
    ) -> DetectorResult:
        """Return what the detector of a number shows after the batches of `tally`."""

        def estimates(name: str, first: int, n: int) -> list[Estimate]:
            lines = [cells(d.by_wavelength(name, line), n) for line in range(d.wavelengths)]
            whole = cells(first, n)
            return [
                Estimate(e.value, e.sigma, e.count, [line[k] for line in lines])
                for k, e in enumerate(whole)
            ]

        def cells(first: int, n: int) -> list[Estimate]:
            errors = tally.standard_error(first, n) * compiled.unit_power
            counts = tally.counts(first, n)
            known = tally.batches > 1
            return [
                Estimate(
                    watts(compiled, tally.exact(first + k), tally.batches),
                    float(errors[k]) if known else None,
                    int(counts[k]),
                )
                for k in range(n)
            ]

        ladder = None
        if d.n_generations:
            ladder = tuple(
                Rung(g, e.value, e.sigma, e.count or 0, e.by_wavelength)
                for g, e in enumerate(estimates("ladder", d.ladder, d.n_generations))
            )
        power = estimates("power", d.power, 1)[0]
        found = IrradianceMap.of(compiled, tally, d) if d.nx else None
        table = PathTable.of(compiled, tally, d, number, trails) if d.paths else None
        return cls(power, ladder, found, table)
