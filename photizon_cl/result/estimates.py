"""What accumulated batches say: ledger, detectors, far field, their errors, and the summary.

Everything here follows from a compiled scene, its exact tally and how that came about; no device
and no file is touched. Views take `Estimates`; what a person holds is `photizon_cl.run.result`'s
`Result`, which can also go on, be kept and show itself.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from photizon_cl.checks.advisories import advisories
from photizon_cl.compile.layout import MOST_ABSORBING
from photizon_cl.compile.quantities import quantity_of, scalars
from photizon_cl.errors import ArgumentError, ResultError
from photizon_cl.result.advisories import run_advisories
from photizon_cl.result.batch_values import MOST_VALUES
from photizon_cl.result.checks import Checks, Scalar
from photizon_cl.result.engine import engine_digest
from photizon_cl.result.far_field import FarFieldResult, far_field_summary
from photizon_cl.result.ledger import Ledger, watts
from photizon_cl.result.maps import DetectorResult
from photizon_cl.result.stopping import Goal, achieved_sigma, relative_sigma
from photizon_cl.result.tallies import EffectTally, effect_tallies
from photizon_cl.scene.names import Table
from photizon_cl.scene.spectrum import Spectrum
from photizon_cl.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from photizon_cl.compile.compiled import CompiledScene
    from photizon_cl.compile.layout import Quantity
    from photizon_cl.result.forecast import Forecast
    from photizon_cl.result.pilot import Pilot
    from photizon_cl.result.statistics import Accumulator
    from photizon_cl.result.trails import Trails
    from photizon_cl.scene.model import Scene

__all__ = ["RESULT_SCHEMA", "Estimates", "RunInfo"]

RESULT_SCHEMA: Final = "photizon-result/1"


@dataclass(frozen=True)
class RunInfo:
    """How a result came about.

    Parameters
    ----------
    device : str
        Label of the device; with an executor, that of the last worker heard.
    precision : str
        What the kernels computed in: ``fp64``, ``mixed`` or ``fp32``.
    interactions : int
        Surface interactions of the batches in the result. Where the last wave made more batches
        than the goal needed, its share by number of batches.
    seconds : float
        Time on the host's clock, over all calls, without building programs.
    build_seconds : float
        Time that the device's compiler took, over all calls.
    worst_closure : int
        Largest |closure| of a batch, in units of 2^-95 launched weights.
    goal : Goal
        What the run was to reach.
    history : tuple of (int, float, float or None)
        Batches, seconds and σ achieved (None where there is none) as the run went on.
    version, engine : str
        Version of photizon_cl, and digest of the sources that fix the bits, that made the batches;
        empty where an earlier version wrote the result.
    stopped : str
        What ended the last call: ``target``, ``batches``, ``time``, ``interrupt`` or ``memory`` (no
        room for more rays that wait, or more sums); empty while it goes on, and in results of
        earlier versions.
    pilot : Pilot or None
        What a pilot found, traced where power reached the generation cap; None where none was.
    forecast : Forecast or None
        How long the run would take, told from its first batches; None where it ended with them.
    trails : Trails or None
        Steps of the strongest paths to detectors; None where none were looked for.
    portable : bool
        Whether every device that was used promises these bits, as all do in double precision.
    """

    device: str = ""
    precision: str = "fp64"
    interactions: int = 0
    seconds: float = 0.0
    build_seconds: float = 0.0
    worst_closure: int = 0
    goal: Goal = field(default_factory=Goal)
    history: tuple[tuple[int, float, float | None], ...] = ()
    stopped: str = ""
    pilot: Pilot | None = None
    forecast: Forecast | None = None
    trails: Trails | None = None
    portable: bool = True
    version: str = __version__
    engine: str = field(default_factory=engine_digest)


class Estimates:
    """What accumulated batches say. Immutable, once nobody adds to the tally.

    Parameters
    ----------
    compiled : CompiledScene
        The scene as run, and what the tally's cells mean.
    tally : Accumulator
        Exact totals of all batches.
    info : RunInfo
        Device, time, interactions.
    """

    def __init__(self, compiled: CompiledScene, tally: Accumulator, info: RunInfo) -> None:
        self.compiled, self.tally, self.info = compiled, tally, info

    # -- what was run --------------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        """The scene as run."""
        return self.compiled.scene

    @property
    def batches(self) -> int:
        """Batches in the result."""
        return self.tally.batches

    @property
    def rays(self) -> int:
        """Rays launched."""
        return self.tally.batches * self.scene.run.rays_per_batch

    @property
    def stream(self) -> tuple[str, str]:
        """What fixes the bits of every batch, but the engine: the scene's digest, and the mode."""
        return self.scene.digest(), self.info.precision

    @property
    def tally_digest(self) -> str:
        """``sha256:…`` over the exact tallies of all batches in order.

        Two runs agree bit for bit exactly when their digests do.
        """
        return self.tally.digest

    # -- what came out -------------------------------------------------------------------------

    @cached_property
    def ledger(self) -> Ledger:
        """Where the power went, in watts."""
        return Ledger.of(self.compiled, self.tally, self.info.worst_closure)

    @cached_property
    def detectors(self) -> Mapping[str, DetectorResult]:
        """What each detector shows, by the name of its element."""
        elements = self.scene.element
        return Table(
            "detectors",
            (
                (
                    elements[d.element].name,
                    DetectorResult.of(self.compiled, self.tally, d, number, self.info.trails),
                )
                for number, d in enumerate(self.compiled.layout.detectors)
            ),
            frozenset(elements.names),
            "that element has none; detector = {} in the scene gives it one",
        )

    @cached_property
    def tallies(self) -> Mapping[str, EffectTally]:
        """What effects count in cells of their own: by effect, then by what each cell is.

        Values with their σ, mostly in watts (`EffectTally.unit`), and counts.
        """
        return effect_tallies(self.compiled, self.tally)

    @cached_property
    def counts(self) -> Mapping[str, int]:
        """Numbers that effects count and the summary tells, over all batches, by name.

        ``media_mismatches``, for one, where the scene has media.
        """
        groups = [group for group in self.compiled.layout.groups if group.counted_as]
        return Table(
            "counts",
            ((g.counted_as, int(self.tally.counts(g.first, g.size).sum())) for g in groups),
        )

    @cached_property
    def far_field(self) -> FarFieldResult | None:
        """Intensity of what escaped, in W/sr; None where the scene has no far field."""
        if self.scene.far_field is None:
            return None
        return FarFieldResult.of(self.compiled, self.tally, self.scene.far_field)

    # -- by name -------------------------------------------------------------------------------

    def quantity(self, name: str) -> Scalar:
        """Return a scalar by its name: value, σ, count, and the checks of that σ.

        Parameters
        ----------
        name : str
            For example ``detectors.floor.power``, ``detectors.floor.ladder[2]``,
            ``ledger.escaped``, ``ledger.absorbed."wall -x"``; see `quantity_names`.

        Raises
        ------
        ArgumentError
            Where there is no such quantity, or it has many bins.
        """
        found = self._scalar(name)
        cell, layout = found.first, self.compiled.layout
        sigma = self.tally.standard_error(cell, 1)[0] * self.compiled.unit_power
        return Scalar.of(
            found.name,
            self.checks.get(found.name),
            watts(self.compiled, self.tally.exact(cell), self.batches),
            float(sigma) if self.batches > 1 else None,
            # the device counts arrivals at detectors alone
            int(self.tally.counts(cell, 1)[0]) if layout.counts_arrivals(cell) else None,
        )

    @cached_property
    def checks(self) -> dict[str, Checks]:
        """Checks of every scalar that has some, by name."""
        layout, kept, found = self.compiled.layout, self.tally.batch_values, {}
        splits = self.scene.splits()
        for quantity in self._scalars.values():
            values = kept.of(quantity.first)
            if values is not None:
                count = None
                if layout.counts_arrivals(quantity.first):
                    count = int(self.tally.counts(quantity.first, 1)[0])
                    # of rays that split, many arrivals are of one ray
                    count = min(count, self.rays) if splits else count
                checks = Checks.of(values, count, self.compiled.heaviest)
                if checks is not None:
                    found[quantity.name] = checks
        return found

    def batch_values(self, name: str) -> NDArray[np.float64]:
        """Return what each batch gave of a scalar, in watts, shape (batches,), in order.

        Their mean is the quantity's value and their standard deviation (n − 1) over √n its σ, both
        to rounding.

        Parameters
        ----------
        name : str
            As `quantity` takes it.

        Raises
        ------
        ArgumentError
            Where there is no such quantity, or it has many bins.
        ResultError
            Where single batches were not kept: by earlier versions, in very long runs, and of what
            single elements absorb where they are very many.
        """
        found = self.tally.batch_values.of(self._scalar(name).first)
        if found is None:
            raise ResultError(f"{name}: {self._why_not_kept(name)}")
        found *= self.compiled.unit_power
        found.flags.writeable = False
        return found

    @property
    def quantity_names(self) -> list[str]:
        """Names of all scalars: what the ledger has, then the detectors."""
        return list(self._scalars)

    def is_scalar(self, name: str) -> bool:
        """Say whether a quantity is a single number, and not many bins."""
        return not self._quantity(name).bins

    @property
    def unreached(self) -> list[str]:
        """Quantities of ``target_on`` that have no relative σ, as nothing came there."""
        watched = self.compiled.layout.watched
        return [q.name for q in watched if relative_sigma(q, self.tally) is None]

    @property
    def most_kept(self) -> int:
        """Batches up to which each one's values are kept."""
        return MOST_VALUES // max(len(self.tally.batch_values.cells), 1)

    @cached_property
    def _scalars(self) -> dict[str, Quantity]:
        return {q.name: q for q in scalars(self.scene, self.compiled.layout)}

    def _quantity(self, name: str) -> Quantity:
        found = self._scalars.get(name)
        return found or quantity_of(name, self.scene, self.compiled.layout)

    def _scalar(self, name: str) -> Quantity:
        found = self._quantity(name)
        if found.bins:
            raise ArgumentError(
                f"{name}: found {found.bins} bins, expected a scalar: as a whole it is a target "
                "(target_on) only; its arrays are in result.detectors and result.far_field"
            )
        return found

    def _why_not_kept(self, name: str) -> str:
        if self.tally.batch_values.kept:
            return (
                f"of more than {MOST_ABSORBING} elements what each absorbs is not kept batch by "
                "batch; a detector on it keeps its power"
            )
        return (
            f"single batches were not kept: that is done for up to {self.most_kept} batches of it, "
            "and not by earlier versions; run it with more rays a batch"
        )

    @property
    def sigma_is(self) -> str:
        """What `achieved_sigma` is, in three words."""
        asked = self.scene.run.target_on or ()
        # of one map or far field it is the median over its bins
        largest = len(asked) > 1 or any(map(self.is_scalar, asked))
        return "largest relative σ" if largest else "median relative σ"

    @cached_property
    def achieved_sigma(self) -> float | None:
        """Relative standard error to be judged by, see `photizon_cl.result.stopping`."""
        return achieved_sigma(self.compiled.layout, self.tally)

    @cached_property
    def history(self) -> NDArray[np.void]:
        """How σ fell: a row for waves in order, thinned where there are many.

        Fields ``batches`` (int64), ``rays`` (int64), ``seconds`` (float64, on the host's clock) and
        ``sigma`` (float64, the `achieved_sigma` then; NaN where there was none).
        """
        rows = np.array(
            [
                (b, b * self.scene.run.rays_per_batch, t, np.nan if s is None else s)
                for b, t, s in self.info.history
            ],
            dtype=[("batches", "i8"), ("rays", "i8"), ("seconds", "f8"), ("sigma", "f8")],
        )
        rows.flags.writeable = False
        return rows

    @property
    def target_sigma(self) -> float:
        """The one that was asked for, or that of the scene."""
        return self.scene.run.target_sigma

    @property
    def converged(self) -> bool:
        """Whether the achieved σ meets the target."""
        return self.achieved_sigma is not None and self.achieved_sigma <= self.target_sigma

    @cached_property
    def lit_fraction(self) -> float | None:
        """Part of the map bins (of all maps, those with an area) with at least 10 arrivals.

        None where the scene has no map.
        """
        maps = [d.map for d in self.detectors.values() if d.map is not None]
        bins = sum(int(np.count_nonzero(~m.masked)) for m in maps)
        return sum(int(np.count_nonzero(m.lit)) for m in maps) / bins if bins else None

    @cached_property
    def least_lit(self) -> tuple[str, float, int] | None:
        """Map with the least part of its bins lit: element, that part, and how many maps there are.

        None where the scene has no map. Of several maps a fine one would hide a coarse one in
        `lit_fraction`, which is over all of them.
        """
        maps = [(d.map.lit_fraction, name) for name, d in self.detectors.items() if d.map]
        return (*min(maps)[::-1], len(maps)) if maps else None

    @cached_property
    def advisories(self) -> tuple[str, ...]:
        """What deserves a second look: of the run, then of the scene."""
        return (*run_advisories(self), *advisories(self.scene, self.info.precision))

    def summary(self) -> dict[str, Any]:
        """Return the summary as plain values that JSON can hold.

        Powers are in watts; a σ is None with a single batch, ``lit_fraction`` without a map.
        """
        run, info = self.scene.run, self.info
        return {
            "schema": RESULT_SCHEMA,
            "scene": self.scene.name,
            "scene_digest": self.scene.digest(),
            "seed": run.seed,
            "device": info.device,
            "precision": info.precision,
            "batches": self.batches,
            "rays_per_batch": run.rays_per_batch,
            "rays": self.rays,
            "interactions": info.interactions,
            "seconds": info.seconds,
            "build_seconds": info.build_seconds,
            "forecast": None if info.forecast is None else info.forecast.summary(),
            "converged": self.converged,
            "target_sigma": self.target_sigma,
            "achieved_sigma": self.achieved_sigma,
            "lit_fraction": self.lit_fraction,
            "stopped": info.stopped or None,
            "tally_digest": self.tally_digest,
            **self._spectrum_summary(),
            "ledger": self.ledger.summary(),
            **self.counts,
            "detectors": {name: d.summary() for name, d in self.detectors.items()},
            **far_field_summary(self),
            **self._tallies_summary(),
            "checks": {name: checks.summary() for name, checks in self.checks.items()},
            "advisories": list(self.advisories),
        }

    def _spectrum_summary(self) -> dict[str, Any]:
        """Return what the members of every list ``by_wavelength`` are, as the scene has them."""
        spectrum = self.scene.spectrum
        return {} if spectrum is None else {Spectrum.label: spectrum.to_table()}

    def _tallies_summary(self) -> dict[str, Any]:
        if not self.tallies:
            return {}
        shown = {
            effect: {label: estimate.summary() for label, estimate in cells.items()}
            for effect, cells in self.tallies.items()
        }
        units = {effect: cells.unit for effect, cells in self.tallies.items() if cells.unit != "W"}
        return {"tallies": shown, **({"tally_units": units} if units else {})}
