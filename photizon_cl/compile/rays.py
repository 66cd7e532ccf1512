"""How a batch's rays are divided among the sources, and what each weighs."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

from photizon_cl.errors import ArgumentError

if TYPE_CHECKING:
    from photizon_cl.scene.model import Scene

__all__ = ["LEAST_WEIGHT", "check_weights", "ray_weights", "share_rays"]

LEAST_WEIGHT: Final = 1e-14
"""Least weight of a launched ray beside the heaviest; then good to 1e-15 in the tally."""


def share_rays(scene: Scene, rays_per_batch: int) -> tuple[int, ...]:
    """Divide a batch among the sources: each gets a fixed number of rays, at least one.

    A fixed division launches exactly the sources' flux in every batch (stratification); the
    weight of a source's rays is its flux over their number, so every estimate stays unbiased.
    """
    n = len(scene.source)
    if rays_per_batch < n:
        raise ArgumentError(
            f"rays_per_batch {rays_per_batch}: the scene {scene.name!r} has {n} sources and each "
            f"launches at least one ray in a batch; set rays_per_batch to {n} or more"
        )
    shares = [Fraction(s.flux if s.share is None else s.share) for s in scene.source]
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
    """Return the watts of the heaviest rays, and each source's rays' weight relative to those."""
    power = [s.flux / n for s, n in zip(scene.source, rays, strict=True)]
    unit_power = max(power)
    return unit_power, [p / unit_power for p in power]


def check_weights(scene: Scene, weights: list[float]) -> None:
    """Refuse rays so weak beside others that the tally's unit, 2^-95, would round them."""
    for source, weight in zip(scene.source, weights, strict=True):
        if weight < LEAST_WEIGHT:
            raise ArgumentError(
                f"source {source.name!r}: its rays carry {weight:.3g} of the power of the heaviest "
                f"ones, and the tally counts in units of 2^-95 of those (at least {LEAST_WEIGHT:g} "
                "is needed): give the sources shares that even this out, or trace them apart"
            )
