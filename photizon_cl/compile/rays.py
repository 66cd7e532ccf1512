"""How a batch's rays are divided among the sources, and what each weighs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError
from photizon_cl.scene.settings import MAX_RAYS_PER_BATCH

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = [
    "LEAST_WEIGHT",
    "Beam",
    "beams_of",
    "check_weights",
    "ray_weights",
    "rays_of_sources",
    "share_rays",
]

LEAST_WEIGHT: Final = 1e-14
"""Least weight of a launched ray beside the heaviest; then good to 1e-15 in the tally."""


@dataclass(frozen=True)
class Beam:
    """The rays of a source that are of one line or band of the spectrum; all of them without one.

    Parameters
    ----------
    source : int
        Number of the source.
    line : int
        Number of the line, 0 without a spectrum.
    part : Fraction
        Of the source's power.
    """

    source: int
    line: int
    part: Fraction


def beams_of(scene: Scene) -> tuple[Beam, ...]:
    """Return what a scene's rays are divided among: sources in order, and lines that have power."""
    found = []
    for number, source in enumerate(scene.source):
        powers = source.spectrum or (1.0,) * len(scene.wavelengths)
        total = sum(map(Fraction, powers))
        found += [
            Beam(number, line, Fraction(power) / total)
            for line, power in enumerate(powers)
            if power
        ]
    return tuple(found)


def share_rays(scene: Scene, rays_per_batch: int) -> tuple[int, ...]:
    """Divide a batch among the beams: each gets a fixed number of rays, at least one.

    A fixed division launches exactly the beams' power in every batch (stratification); the
    weight of a beam's rays is its power over their number, so every estimate stays unbiased.
    """
    beams = beams_of(scene)
    n = len(beams)
    if rays_per_batch < n:
        what = f"{n} sources and each"
        if scene.spectrum is not None:
            what = f"{n} {scene.spectrum.word}s of sources that have power and each"
        raise ArgumentError(
            f"rays_per_batch {rays_per_batch}: the scene {scene.name!r} has {what} "
            f"launches at least one ray in a batch; set rays_per_batch to {n} or more"
        )
    whole = [Fraction(s.flux if s.share is None else s.share) for s in scene.source]
    shares = [whole[beam.source] * beam.part for beam in beams]
    total = sum(shares)
    free = rays_per_batch - n
    exact = [free * share / total for share in shares]
    given = [1 + int(x) for x in exact]
    # largest remainders take what rounding down left, the source named first where they are equal
    order = sorted(range(n), key=lambda i: (-(exact[i] - int(exact[i])), i))
    for i in order[: rays_per_batch - sum(given)]:
        given[i] += 1
    return tuple(given)


def ray_weights(scene: Scene, rays: tuple[int, ...]) -> tuple[float, list[float]]:
    """Return the watts of the heaviest rays, and each beam's rays' weight relative to those."""
    flux = [Fraction(source.flux) for source in scene.source]
    # rounded once, as the quotient of two doubles is
    power = [
        float(flux[beam.source] * beam.part / n)
        for beam, n in zip(beams_of(scene), rays, strict=True)
    ]
    unit_power = max(power)
    return unit_power, [p / unit_power for p in power]


def rays_of_sources(scene: Scene, rays: tuple[int, ...]) -> tuple[int, ...]:
    """Return how many rays each source launches, given those of each beam."""
    total = [0] * len(scene.source)
    for beam, n in zip(beams_of(scene), rays, strict=True):
        total[beam.source] += n
    return tuple(total)


def check_weights(scene: Scene, weights: list[float], rays_per_batch: int) -> None:
    """Refuse rays so weak beside others that the tally's unit, 2^-95, would round them.

    Parameters
    ----------
    scene : Scene
        The scene.
    weights : list of float
        Of each beam's rays, relative to the heaviest.
    rays_per_batch : int
        Rays among which they were shared.

    Raises
    ------
    ArgumentError
        Of the first such beam, with what can be done about it.
    """
    beams = beams_of(scene)
    for beam, weight in zip(beams, weights, strict=True):
        if weight >= LEAST_WEIGHT:
            continue
        of, then = "", "give the sources shares that even this out, or trace them apart"
        if scene.spectrum is not None:
            of = f" of {scene.spectrum.names[beam.line]}"
            strong = [w for b, w in zip(beams, weights, strict=True) if b.source == beam.source]
            if max(strong) >= LEAST_WEIGHT:  # no share changes how its lines compare
                then = _for_a_line(scene, beam, weight, rays_per_batch)
        raise ArgumentError(
            f"source {scene.source[beam.source].name!r}: its rays{of} carry {weight:.3g} of the "
            "power of the heaviest ones, and the tally counts in units of 2^-95 of those (at least "
            f"{LEAST_WEIGHT:g} is needed): {then}"
        )


def _for_a_line(scene: Scene, beam: Beam, weight: float, rays_per_batch: int) -> str:
    """Say what helps a line that is too weak beside others of its own source."""
    assert scene.spectrum is not None
    word = scene.spectrum.word
    text = f"leave that {word} out, a 0 in spectrum[{beam.line}] of the source, or trace it apart"
    # such a line has one ray, and the more others there are the less they weigh
    needed = 2.0 * rays_per_batch * (LEAST_WEIGHT / max(weight, LEAST_WEIGHT / MAX_RAYS_PER_BATCH))
    if needed <= MAX_RAYS_PER_BATCH:
        rays = math.ceil(needed)
        if min(ray_weights(scene, share_rays(scene, rays))[1]) >= LEAST_WEIGHT:
            text += f", or launch more rays in a batch: run.rays_per_batch = {rays} is enough"
    return text
