"""What accuracy costs in time: one row for each setting of a study, and what follows from them.

The figure of merit is 1/(σ² t) with the relative σ of the study's quantity after t seconds (MCNP's
definition): it does not depend on how long was traced, and the inverse ratio of two is the ratio of
the times to the same σ. A setting's bias is its difference from the reference setting; where both
have the same random numbers, batch is held against batch, and its σ is that of the differences
(common random numbers; Glasserman, Monte Carlo Methods in Financial Engineering, 2003, § 4.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from photizon_cl.scene.names import unknown_name

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["COST_SCHEMA", "ROUNDING", "TARGETS", "CostSetting", "CostStudy", "TargetTime"]

COST_SCHEMA: Final = "photizon-cost/1"
TARGETS: Final = (0.05, 0.02, 0.01, 0.005)
"""Relative standard errors that the seconds to are told of."""
_SHOWS: Final = 4.0
"""Standard errors from which on a bias is taken as one: one in 16 000 by chance."""
_FEWEST: Final = 16
"""Batches that a bias must be of."""
ROUNDING: Final = 2.0**-40
"""Part of a value below which differences are taken as rounding, and no scatter."""


def _students(z: float, free: int) -> float:
    """Return what Student's t exceeds as rarely as a normal number exceeds `z`.

    Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5; for 15 degrees and 4 of z
    right to 1 %.
    """
    z3, z5, z7 = z**3, z**5, z**7
    return (
        z
        + (z3 + z) / (4.0 * free)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * free**2)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * free**3)
    )


@dataclass(frozen=True)
class TargetTime:
    """Seconds to a relative standard error.

    Parameters
    ----------
    target : float
        In (0, 1].
    predicted_seconds : float or None
        From half of the batches that it took, or from all where it was not reached; None where
        nothing has a σ.
    measured_seconds : float or None
        When it was reached; None where the study ended before.
    """

    target: float
    predicted_seconds: float | None
    measured_seconds: float | None

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "target": self.target,
            "predicted_seconds": self.predicted_seconds,
            "measured_seconds": self.measured_seconds,
        }


@dataclass(frozen=True)
class CostSetting:
    """One setting of a study, and what it gave.

    Parameters
    ----------
    name : str
        Short and different for each.
    knob : str
        What was changed.
    value : str, int, float or bool
        To what.
    written : str
        How a user asks for it; empty where only a study can.
    batches, rays : int
        Traced.
    seconds : float
        Of tracing, without building the program.
    pace_error : float
        Relative standard error of the seconds a batch takes, by the turns that the setting had: a
        machine that others use is not steady.
    build_seconds : float
        That the program took; next to nothing where it was kept from before.
    interactions_per_s : float
        Interactions a second of tracing.
    estimate : float
        The quantity in watts.
    sigma : float or None
        Its standard error; None where fewer than two batches tell. Of a map or far field, whose sum
        is `estimate`, the median relative one over the lit bins, times that.
    bias, bias_sigma : float or None
        Its difference from the reference setting in watts, and that one's standard error.
    paired : bool
        Whether batch was held against batch for it.
    bias_batches : int
        Of each of both that it is of.
    closure : float
        The worst batch's, in parts of the emitted power.
    targets : tuple of TargetTime
        Seconds to each of `TARGETS`.
    points : tuple of (float, float)
        Seconds, and the relative σ that was known by then, as tracing went on.
    """

    name: str
    knob: str
    value: str | int | float | bool
    written: str
    batches: int
    rays: int
    seconds: float
    pace_error: float
    build_seconds: float
    interactions_per_s: float
    estimate: float
    sigma: float | None
    bias: float | None
    bias_sigma: float | None
    paired: bool
    bias_batches: int
    closure: float
    targets: tuple[TargetTime, ...]
    points: tuple[tuple[float, float], ...]

    @property
    def relative_sigma(self) -> float | None:
        """σ over the value; None where either says nothing."""
        if self.sigma is None or self.estimate == 0.0:
            return None
        return self.sigma / abs(self.estimate)

    @property
    def figure_of_merit(self) -> float | None:
        """1/(σ_rel² seconds), in 1/s; None where nothing scatters but by rounding."""
        sigma = self.relative_sigma
        if sigma is None or sigma <= ROUNDING or self.seconds <= 0.0:
            return None
        return 1.0 / (sigma * sigma * self.seconds)

    @property
    def merit_error(self) -> float:
        """Relative standard error of the figure of merit: of an estimated σ², and of the pace."""
        return math.hypot(math.sqrt(2.0 / max(self.batches - 1, 1)), self.pace_error)

    @property
    def relative_bias(self) -> float | None:
        """Bias over the value that it is a bias of."""
        if self.bias is None or self.estimate == self.bias:
            return None
        return self.bias / abs(self.estimate - self.bias)

    @property
    def is_biased(self) -> bool:
        """Whether a bias shows: beyond four of its standard errors, and beyond rounding.

        Of few batches σ is not well known itself: so many of Student's, with the same chance. Of
        fewer than 16 nothing is said.
        """
        if self.bias is None or self.bias_sigma is None or self.bias_batches < _FEWEST:
            return False
        limit = _students(_SHOWS, self.bias_batches - 1) * self.bias_sigma
        return abs(self.bias) > max(limit, ROUNDING * abs(self.estimate))

    @property
    def relative_bias_sigma(self) -> float | None:
        """Standard error of `relative_bias`, of the bias alone."""
        if self.bias is None or self.bias_sigma is None or self.estimate == self.bias:
            return None
        return self.bias_sigma / abs(self.estimate - self.bias)

    def seconds_to(self, target: float) -> float | None:
        """Return the seconds to a target: measured where it was reached, else predicted."""
        found = next(t for t in self.targets if t.target == target)
        return found.predicted_seconds if found.measured_seconds is None else found.measured_seconds

    def summary(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "name": self.name,
            "knob": self.knob,
            "value": self.value,
            "written": self.written,
            "seconds": self.seconds,
            "pace_error": self.pace_error,
            "build_seconds": self.build_seconds,
            "batches": self.batches,
            "rays": self.rays,
            "interactions_per_s": self.interactions_per_s,
            "estimate": self.estimate,
            "sigma": self.sigma,
            "relative_sigma": self.relative_sigma,
            "bias": self.bias,
            "bias_sigma": self.bias_sigma,
            "paired": self.paired,
            "bias_batches": self.bias_batches,
            "biased": self.is_biased,
            "closure": self.closure,
            "figure_of_merit": self.figure_of_merit,
            "targets": [target.summary() for target in self.targets],
            "points": [list(point) for point in self.points],
        }


@dataclass(frozen=True)
class CostStudy:
    """What a scene's settings trade of truth and time on a device.

    Iterating gives a `CostSetting` for each row; ``study["roulette 0.1"]`` gives one.

    Parameters
    ----------
    scene : str
        Its name.
    scene_digest : str
        Of the scene as it stands.
    device : str
        Where.
    quantity : str
        What σ and bias are of.
    given : str
        Name of the setting that the scene has as it stands.
    reference : str
        Name of the setting that biases are against.
    rays_per_batch, seed : int
        Of all settings but those that say otherwise.
    seconds : float
        That the study took, with building.
    settings : tuple of CostSetting
        The rows.
    left_out : tuple of (str, str)
        Settings without a row, and why.
    advice : tuple of str
        What follows.
    """

    scene: str
    scene_digest: str
    device: str
    quantity: str
    given: str
    reference: str
    rays_per_batch: int
    seed: int
    seconds: float
    settings: tuple[CostSetting, ...]
    left_out: tuple[tuple[str, str], ...]
    advice: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[CostSetting]:
        return iter(self.settings)

    def __len__(self) -> int:
        return len(self.settings)

    def __getitem__(self, name: str) -> CostSetting:
        found = next((row for row in self.settings if row.name == name), None)
        if found is None:
            raise unknown_name("cost study", name, [row.name for row in self.settings])
        return found

    @property
    def is_certain(self) -> bool:
        """Whether the scene as it stands gives the same in every batch, but for rounding."""
        sigma = self[self.given].relative_sigma
        return sigma is not None and sigma <= ROUNDING

    def gain(self, row: CostSetting) -> tuple[float, float] | None:
        """Return how many times as soon a setting reaches a σ as the scene as it stands, and ± σ.

        None where one of both has no scatter.
        """
        given = self[self.given]
        if row.figure_of_merit is None or given.figure_of_merit is None:
            return None
        ratio = row.figure_of_merit / given.figure_of_merit
        return ratio, ratio * math.hypot(row.merit_error, given.merit_error)

    def summary(self) -> dict[str, Any]:
        """Return the study as plain values that JSON can hold."""
        return {
            "schema": COST_SCHEMA,
            "scene": self.scene,
            "scene_digest": self.scene_digest,
            "device": self.device,
            "quantity": self.quantity,
            "given": self.given,
            "reference": self.reference,
            "rays_per_batch": self.rays_per_batch,
            "seed": self.seed,
            "seconds": self.seconds,
            "settings": [row.summary() for row in self.settings],
            "left_out": [{"name": name, "why": why} for name, why in self.left_out],
            "advice": list(self.advice),
        }
