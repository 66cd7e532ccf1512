"""What a finished run shows and deserves a second look."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.compile.effects.table import EFFECTS
from photizon_cl.errors import show
from photizon_cl.result.pilot import NEGLIGIBLE, UNTOLD
from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.result.stopping import LEAST_BATCHES
from photizon_cl.result.text import lit_percent
from photizon_cl.scene.elements.base import OTHER_SIDE
from photizon_cl.scene.parameter_paths import quoted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.scene.elements import Element

__all__ = ["run_advisories"]

_LIT: Final = 0.5  # part of the map bins that should be lit
_FAR: Final = 2.0
"""Times the target that a detector's relative σ may be where another quantity met it."""
_WORST: Final = 3
"""Detectors that are named of many of which the same is to be said."""
_EQUAL: Final = 4.0
"""Times as many arrivals as equal ones would have this σ, from which on few of them make a bin."""
_FEW_BINS: Final = 0.01  # part of the lit bins of which that is chance
_TALLY_UNIT: Final = 2.0**-95
_FAINT: Final = 1e6 * _TALLY_UNIT
"""Mean weight of arrivals, of 1 when launched, below which the tally's unit is more than 10^-6."""
_MANY: Final = 10**7  # batches that are written with a power of ten


def run_advisories(result: Estimates) -> list[str]:
    """Return one sentence for each thing that a run's outcome gives reason for."""
    return [
        *_elsewhere(result),
        *_of_effects(result),
        *_short(result),
        *_left_behind(result),
        *_unbelievable(result),
        *_missed(result),
        *_dark_detectors(result),
        *_capped(result),
        *_unlit(result),
        *_heavy(result),
        *_faint(result),
    ]


def _elsewhere(result: Estimates) -> Iterator[str]:
    if not result.info.portable:
        yield (
            f"in {result.info.precision} this device does not promise the bits of others: its "
            "single precision rounds quotients and roots, or numbers near 0, in its own way "
            "(`photizon devices` says which); its errors are as small, its digest is its own"
        )


def _of_effects(result: Estimates) -> Iterator[str]:
    """Give what effects have to say of what they counted."""
    layout, tally = result.compiled.layout, result.tally
    for effect in EFFECTS:
        group = layout.group(effect.name)
        if group is not None and group.counted_as:
            counts = tally.counts(group.first, group.size)
            yield from effect.advice(result.scene, counts.tolist())


def _short(result: Estimates) -> Iterator[str]:
    if result.converged:
        return
    target, achieved = result.target_sigma, result.achieved_sigma
    if achieved is not None:
        if result.info.goal.target is not None:  # else a number of batches was asked for
            yield (
                f"the target was not met: the {result.sigma_is} is {achieved:.3g} and {target:.3g} "
                f"was asked for; {_needed(result, achieved / target)}"
            )
    elif result.batches < 2:
        yield "a single batch has no standard error: run at least two, better 8 or more"
    elif result.scene.run.target_on:
        yield (
            f"the target of {target:.3g} was not met: nothing came to "
            f"{', '.join(result.unreached)}; look where the light goes in the ledger"
        )
    else:
        yield (
            f"no bin, detector or row gathered enough for a relative σ, so the target of "
            f"{target:.3g} says nothing; look where the light goes in the ledger"
        )
    if 1 < result.batches < LEAST_BATCHES:
        yield f"σ from {result.batches} batches is itself uncertain; run {LEAST_BATCHES} or more"


def _needed(result: Estimates, above: float) -> str:
    """Say how many batches should do; σ falls with their square root."""
    batches = max(math.ceil(result.batches * above * above), LEAST_BATCHES)
    digits = 10 ** max(len(str(batches)) - 2, 0)
    batches = -(-batches // digits) * digits
    many = f"{batches:.1e}" if batches >= _MANY else str(batches)
    return (
        f"about {many} batches in all should reach it: go on with `photizon resume` or "
        "Result.refine, with a max_seconds that allows it"
    )


def _left_behind(result: Estimates) -> Iterator[str]:
    """Find detectors that stand far above a target that was met on something else."""
    if not result.converged or result.info.goal.target is None or result.scene.run.target_on:
        return
    found = []
    for name, detector in result.detectors.items():
        power = detector.power
        # where it reads nothing from behind, that is told
        dark = not power.count and not result.ledger.absorbed[name].value
        if power.sigma is not None and (power.value or dark):
            relative = power.sigma / abs(power.value) if power.value else math.inf
            if relative > _FAR * result.target_sigma:
                found.append((relative, name))
    found.sort(key=lambda row: -row[0])
    for relative, name in found[:_WORST]:
        known = f"is known to {100.0 * relative:.2g} % alone"
        if relative == math.inf:
            most = 3.0 * result.ledger.emitted.value / result.rays
            known = f"is 0, nothing having arrived, which of {result.rays} rays says little (where "
            known += f"all are alike, that it is below {most:.1g} W in 95 of 100 cases)"
        yield (
            f"the target of {result.target_sigma:.3g} was met by the median, and the power of "
            f"{show(name)} {known}: name what must meet it, "
            f"target_on = ['detectors.{quoted(name)}.power']"
        )
    if len(found) > _WORST:
        yield f"{len(found) - _WORST} more detectors stand as far from the target"


def _unbelievable(result: Estimates) -> Iterator[str]:
    """Find errors that the batches give no reason to believe, of what the run is about.

    Where its target was met, any check that fails is told.
    """
    if result.batches < LEAST_BATCHES:  # which is told
        return
    if not result.tally.batch_values.kept:
        yield (
            f"single batches were not kept, as in runs of more than {result.most_kept} of them and "
            "by earlier versions, so that its standard errors cannot be checked"
        )
        return
    met = result.converged and result.info.goal.target is not None
    watched = result.scene.run.target_on or [
        f"detectors.{quoted(name)}.power" for name in result.detectors
    ]
    found = []
    for name in watched:
        if result.is_scalar(name):
            quantity = result.quantity(name)
            checks = quantity.checks
            if checks is None:
                continue
            if not (checks.believable and (not met or all(checks.good.values()))):
                text = f"the σ of {quantity.name}, {quantity} W, {checks.reason()}"
                found.append((checks.relative_sigma, text))
    found.sort(key=lambda row: -row[0])
    yield from (text for _, text in found[:_WORST])
    if len(found) > _WORST:
        yield f"{len(found) - _WORST} more have a σ of which that is so"


def _missed(result: Estimates) -> Iterator[str]:
    if result.scene.element and result.batches and not result.info.interactions:
        taken = [f'"{name}"' for name, row in result.ledger.absorbed_in.items() if row.value > 0.0]
        went = "all of the power escapes"
        if taken:
            went = f"what does not escape is absorbed in {' and '.join(taken)}"
        yield (
            f"not one ray met an element: {went}; see where the sources stand and shine, with "
            "`photizon show` for example"
        )


def _faint(result: Estimates) -> Iterator[str]:
    """Tell detectors whose arrivals weigh so little that the tally's unit decides what they add."""
    found = []
    for name, detector in result.detectors.items():
        power, count = detector.power.value, detector.power.count
        weight = power * result.batches / (count * result.compiled.unit_power) if count else 1.0
        if weight < _FAINT:
            found.append((weight, name))
    for weight, name in sorted(found)[:_WORST]:
        yield (
            f'what arrives at the detector on "{name}" has {weight:.1e} of the weight that it was '
            f"launched with, on average, and is counted in units of {_TALLY_UNIT:.1e}: its "
            "power is good to that only, whatever its σ says"
        )


def _dark_detectors(result: Estimates) -> Iterator[str]:
    elements = {e.name: e for e in result.scene.element}
    for name, detector in result.detectors.items():
        absorbed = result.ledger.absorbed[name].value
        if detector.power.count == 0 and absorbed > 0.0:
            yield (
                f'the detector on "{name}" reads exactly nothing while the element absorbs '
                f"{absorbed:.4g} W: the light arrives from behind; {_turn(elements[name])}"
            )


def _turn(element: Element) -> str:
    side = element.detector_side or element.default_side
    return f'set its side to "{OTHER_SIDE[side]}" (it is "{side}")'


def _capped(result: Estimates) -> Iterator[str]:
    part = result.ledger.depth_capped.value / result.ledger.emitted.value
    if part > NEGLIGIBLE:
        pilot = result.info.pilot
        yield (
            f"{part:.2e} of the emitted power was still under way at the generation cap of "
            f"{result.scene.run.generation_cap} and went to the depth-capped row; "
            + (f"{UNTOLD}: `photizon check` tells which" if pilot is None else pilot.remedy())
        )


def _unlit(result: Estimates) -> Iterator[str]:
    """Find maps in which most of what is lit is known badly; what stays dark is no fault."""
    if result.scene.run.target_on:  # which is judged by something else
        return
    for name, detector in result.detectors.items():
        if detector.map is None or detector.map.known_fraction >= _LIT:
            continue
        yield (
            f"only {lit_percent(detector.map.known_fraction)} of the bins of {show(name)} that any "
            "ray reaches carry at least 10, and σ is the median over those alone; run longer or "
            "take coarser bins"
        )


def _heavy(result: Estimates) -> Iterator[str]:
    """Find maps and far fields with bins that a few heavy rays make: σ is then not known either.

    n arrivals of one weight have a relative σ of 1/sqrt(n). Where it is twice that and more, and n
    would have to be below what a bin is hatched for, most of what came there does not count. From 8
    batches of equal arrivals chance gives that in one bin of 5000 (χ² of 7 degrees of freedom).
    """
    if result.batches < LEAST_BATCHES:  # which is told
        return
    fields = [
        (f"the map of {show(name)}", found.map.irradiance, found.map.sigma, found.map.count)
        for name, found in result.detectors.items()
        if found.map is not None
    ]
    far = result.far_field
    if far is not None:
        fields.append(("the far field", far.intensity, far.sigma, far.count))
    for what, value, sigma, count in fields:
        lit = (count >= LIT_COUNT) & np.isfinite(value) & (value > 0.0)
        square = np.square(sigma[lit] / value[lit])
        heavy = int(np.sum((square * LIT_COUNT > 1.0) & (square * count[lit] > _EQUAL)))
        if heavy > _FEW_BINS * square.size:
            yield (
                f"in {heavy} of the {square.size} lit bins of {what} a few heavy rays make the "
                f"value: σ is more than {100.0 / math.sqrt(LIT_COUNT):.0f} % of it although many "
                "came, and it is not known well itself, so that the value may be far off; run "
                "longer, or take bins that are larger"
            )
