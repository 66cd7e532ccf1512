"""What a run does not claim, said for the run at hand."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup

from photizon_cl.result.statistics import LIT_COUNT
from photizon_cl.views.report.numbers import amount, brief, integer, percent, share
from photizon_cl.views.report.story import judged_by

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.result.estimates import Estimates

__all__ = ["claims"]

_MOST_NAMES: Final = 5
_DARK: Final = 3.0  # arrivals that are expected at most, at 95 %, where none was seen


def claims(result: Estimates) -> list[Markup]:
    """Return one statement for each thing that the result does not say."""
    return [
        *_statistics(result),
        *_counts(result),
        *_dark(result),
        *_bias(result),
        *_physics(result),
    ]


def _statistics(result: Estimates) -> Iterator[Markup]:
    yield Markup(
        "<strong>Statistical error only.</strong> σ says how well the question was computed, not "
        "how well it was asked: dimensions, reflectances and the flux of the sources are taken "
        "as exact, and an input that is wrong by 5 % leaves an answer that is wrong at any σ."
    )
    n = result.batches
    if n == 1:
        yield Markup(
            "<strong>No error at all here.</strong> σ comes from the scatter between batches; this "
            "is a single batch, so every σ is unknown (null in the files) and not zero."
        )
        return
    uncertainty = percent(1.0 / sqrt(2.0 * (n - 1)), 2)
    yield Markup(
        "<strong>σ is an estimate.</strong> From {} batches it is itself uncertain by about {}. "
        "About two values in three lie within one σ of the truth, 95 % within two, where the "
        "noise is normal; rare bright arrivals make it less so."
    ).format(integer(n), uncertainty)
    if result.achieved_sigma is not None:
        yield Markup(
            "<strong>The achieved σ is a median</strong> over {}: half of those are known less "
            "well than it says."
        ).format(judged_by(result))
    if not result.converged:
        yield Markup(
            "<strong>The target was not met</strong>; the values stand with the σ that they have."
        )
    elif result.info.goal.batches is None and result.info.goal.target is not None:
        yield Markup(
            "<strong>The run stopped when its own σ met the target</strong>, which makes the σ "
            "that it shows slightly too small on average; a fixed number of batches does not."
        )


def _counts(result: Estimates) -> Iterator[Markup]:
    hatched = sum(
        int(np.count_nonzero(d.map.hatched)) for d in result.detectors.values() if d.map is not None
    )
    if result.far_field is not None:
        hatched += int(np.count_nonzero(result.far_field.hatched))
    if hatched:
        bins = "1 bin has" if hatched == 1 else f"{integer(hatched)} bins have"
        yield Markup(
            "<strong>{} fewer than {} arrivals.</strong> Figures hatch them; their values are in "
            "<code>result.nc</code>, with a σ that means little. Nothing is smoothed, and nothing "
            "is said of structure inside a bin."
        ).format(bins, LIT_COUNT)
    elif result.far_field is not None or result.lit_fraction is not None:
        yield Markup(
            "<strong>A bin holds its mean.</strong> Nothing is smoothed, and nothing is said of "
            "structure inside a bin."
        )


def _dark(result: Estimates) -> Iterator[Markup]:
    dark = [name for name, d in result.detectors.items() if d.power.count == 0]
    if not dark:
        return
    names = ", ".join(dark[:_MOST_NAMES])
    if len(dark) > _MOST_NAMES:
        names += f" and {len(dark) - _MOST_NAMES} others"
    bound = _DARK * result.compiled.unit_power / result.batches
    yield Markup(
        "<strong>0 ± 0 is no proof of darkness.</strong> No ray arrived at {}; with as many rays "
        "as were launched that says, at 95 % confidence, less than {} W each."
    ).format(names, amount(bound, 2))


def _bias(result: Estimates) -> Iterator[Markup]:
    ledger = result.ledger
    capped = ledger.depth_capped
    if capped.value > 0.0:
        yield Markup(
            "<strong>Rays were cut at the generation cap of {}.</strong> {}, {} of what was "
            "emitted, was still under way: every other row, detector and bin may be too low, all "
            "together by no more than that."
        ).format(
            integer(result.scene.run.generation_cap),
            brief(capped.value, capped.sigma, "W"),
            share(capped, ledger.emitted.value),
        )
    else:
        yield Markup(
            "<strong>No bias from the generation cap:</strong> no ray of this run reached it."
        )
    if "roulette" in result.compiled.effects:
        balance = ledger.roulette.balance
        yield Markup(
            "<strong>Roulette ended weak rays by chance.</strong> That leaves every mean unbiased "
            "and adds noise; its balance, {}, scatters about zero and is a row of the ledger."
        ).format(brief(balance.value, balance.sigma, "W"))


def _physics(result: Estimates) -> Iterator[Markup]:
    yield Markup(
        "<strong>Incoherent geometrical optics.</strong> Rays carry power and no phase: no "
        "interference, no diffraction. Where features are of the size of a wavelength the answer "
        "is wrong, and no error bar says so."
    )
    surfaces = [s for element in result.scene.element for s in element.surfaces]
    refracts = any(surface.refracts for surface in surfaces)
    spectrum, polarised = result.scene.spectrum, result.scene.run.polarisation
    lacks = [] if polarised else ["no polarisation"]
    constants = "One set of optical constants holds for the whole run."
    if spectrum is None:
        lacks.insert(0, "no spectrum")
    else:
        beside = "nothing between them" if spectrum.edges_nm is None else "nothing beside them"
        constants = f"Light is of {spectrum.about}, and of {beside}."
    light = "by the polarisation of what comes" if polarised else "as for unpolarised light"
    glass = f" Glass reflects and refracts {light}" if refracts else ""
    coated = any(surface.refracts and surface.coat is not None for surface in surfaces)
    if coated:
        films = any(surface.coat is not None and surface.coat.polarises for surface in surfaces)
        alone = ", within which alone films interfere" if films else ""
        glass += f", coated faces as their coatings say{alone}"
    inside = Markup()
    absorbing = [medium.name for medium in result.scene.medium if medium.absorbs]
    if absorbing:
        glass += "." if glass else ""
        inside = Markup(
            " What lies in {} absorbs by Beer and Lambert's law and scatters nothing."
        ).format(", ".join(absorbing))
    else:
        lacks.append("no bulk absorption")
        nothing = "; but for those it absorbs nothing." if coated else " and absorbs nothing."
        glass += nothing if glass else ""
    without = ", ".join(lacks).capitalize() or "Media by their constants"
    yield Markup("<strong>{}.</strong> {}{}{}").format(without, constants, glass, inside)
    lobes = any(surface.lobe is not None for surface in surfaces)
    missing = (
        "but for their scatter without roughness or dust"
        if lobes
        else ("without measured scatter, roughness or dust")
    )
    yield Markup(
        "<strong>Ideal surfaces and exact shapes.</strong> {}, {}; shapes without tolerances or "
        "mounts."
    ).format(_surfaces(result), missing)
    if result.detectors:
        yield Markup(
            "<strong>Detectors count one side</strong> and all angles of incidence alike; the "
            "absorbed rows of the ledger count both sides."
        )


def _surfaces(result: Estimates) -> str:
    """Return what the scene's surfaces are, as the beginning of a sentence."""
    labels = dict.fromkeys(s.label_text for e in result.scene.element for s in e.surfaces)
    *rest, last = labels or ["no surface"]
    text = f"{', '.join(rest)} and {last}" if rest else last
    return text[:1].upper() + text[1:]
